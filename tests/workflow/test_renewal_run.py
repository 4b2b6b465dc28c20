"""A growing crack through Snakemake whose second and third meshes are renewed."""

import json
import os
import shutil
import signal
import time

import numpy as np
import pytest

from craftmesh.cli import main
from craftmesh.io.stage_npz import read_map
from craftmesh.io.vtk import read_tets

CASES = "case\tmicrostructure\tcrack\tincrements\tgrowth\ntiny\tsynthetic\ttilted\t3\tgrow\n"
CONFIG = """
cases: cases.tsv
chunks: 2
generate: {shape: [24, 24, 24], grains: 3}
sizing: {l0: 1.5, l_min: 0.8, l_max: 3.0, r0: 2.0, r1: 4.0}
cracks:
  tilted: {centre: [12.0, 12.0, 12.2], normal: [0.0, 0.4, 1.0], radius: 2.6}
grow: {extension: 0.5}
renew: {reuse: always}
"""


@pytest.fixture(scope="module")
def finished(new_folder):
    folder = new_folder(CASES, CONFIG)
    run = folder.snakemake("--cores", "2")
    assert run.status == 0, run.text
    return folder


def test_each_mesh_keeps_elements_of_the_one_before(finished):
    case = finished.path / "results" / "tiny"
    assert [(case / inc / "gradated.vtp").exists() for inc in ("000", "001", "002")] == [True, False, False]
    meshes = [read_tets(case / inc / "volume.vtu") for inc in ("000", "001", "002")]
    for number, (old, new) in enumerate(zip(meshes, meshes[1:]), 1):
        told = json.loads((case / f"{number:03d}" / "meshing.json").read_text())["renewed"]
        elements = read_map(case / f"{number:03d}" / "map.npz")["elements"]
        stays = np.flatnonzero(elements >= 0)
        assert len(stays) == told["elements_kept"] == len(new.tets) - len(new.element_sets["NEW"])
        assert (case / f"{number:03d}" / "pictures" / "renewed.svg").exists()
        assert number > 1 or len(stays) > 0.1 * len(old.tets)
        assert np.array_equal(new.points[new.tets[elements[stays]]], old.points[old.tets[stays]])


def test_nothing_runs_again_and_one_increment_alone_gives_the_same_bytes(finished):
    assert "Nothing to be done" in finished.snakemake("--cores", "2", "--dry-run").text
    before = finished.made
    run = finished.snakemake("--cores", "2", "-f", "results/tiny/001/volume.vtu")
    assert run.status == 0 and run.jobs == {"renew": 1, "total": 1}, run.text
    assert finished.made == before


def planned(folder) -> dict[str, int]:
    run = folder.snakemake("--cores", "2", "--dry-run")
    assert run.status == 0, run.text
    return {rule: count for rule, count in run.jobs.items() if rule not in ("total", "all", "report")}


@pytest.fixture
def changed(finished, tmp_path):
    """Return a function that replaces a text of the configuration or case table in a copy."""
    copy = type(finished)(shutil.copytree(finished.path, tmp_path / "copy"))

    def change(name, old, new):
        path = copy.path / name
        assert path.read_text().count(old) == 1
        path.write_text(path.read_text().replace(old, new))
        return copy

    return change


def test_options_of_the_deck_alone_write_decks_alone(changed):
    assert planned(changed("config.yaml", "chunks: 2", "chunks: 2\ninp: {style: parts}")) == {"inp": 3}


def test_options_of_the_renewal_leave_the_first_mesh(changed):
    after = {"renew": 2, "inp": 2, "check": 2, "solve": 2, "fracture": 2, "depict": 2}
    plan = planned(changed("config.yaml", "always}", "always, most_renewed: 0.4}"))
    assert {rule: plan[rule] for rule in after} == after
    assert not {"stitch", "gradate", "tetrahedralize", "assemble"} & plan.keys()


def test_a_cleaned_case_is_planned_and_goes_on_with_another_increment(changed, monkeypatch, capsys):
    folder = changed("cases.tsv", "\t3\t", "\t4\t")
    monkeypatch.chdir(folder.path)
    assert main(["plan", "config.yaml"]) == 0
    assert "case tiny: increments from 001 on are counted with 15 % " in capsys.readouterr().out
    spare = folder.path / "results" / "tiny" / "000" / "gradated.vtp"
    assert main(["clean", str(folder.path / "results")]) == 0
    assert not spare.exists()
    plan = planned(folder)
    assert plan["renew"] == plan["crack"] == plan["size"] == 1
    assert not {"remesh", "stitch", "gradate", "tetrahedralize", "assemble"} & plan.keys()


@pytest.mark.slow
def test_a_renewal_that_is_killed_runs_again_to_the_same_bytes(finished, tmp_path):
    folder = type(finished)(shutil.copytree(finished.path, tmp_path / "copy"))
    results = folder.path / "results"
    log = results / "logs" / "tiny" / "002" / "renewed.log"
    log.unlink()
    shutil.rmtree(results / "tiny" / "002")
    process = folder.start("--cores", "2")
    while process.poll() is None and not log.exists():
        time.sleep(0.01)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    assert not (results / "tiny" / "002" / "volume.vtu").exists()
    assert folder.snakemake("--unlock").status == 0
    run = folder.snakemake("--cores", "2")
    assert run.status == 0, run.text
    assert folder.made == finished.made
