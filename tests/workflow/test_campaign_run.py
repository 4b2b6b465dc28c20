"""A tiny campaign through Snakemake: complete, repeated byte for byte, and rerun only where it must be."""

import os
import shutil
import subprocess
from pathlib import Path

import meshio
import pytest
import yaml
from deck_reader import load_judge

from craftmesh.deck.check_deck import check_deck
from craftmesh.io.vtk import read_tets

ROOT = Path(__file__).resolve().parents[2]
FILES_OF_INCREMENT = {
    "crack.vtp",
    "sizing.npz",
    "surface.vtp",
    "gradated.vtp",
    "volume.vtu",
    "meshing.json",
    "front.csv",
    "model.inp",
    "quality.json",
}
PICTURES = {
    f"pictures/{name}" for name in ("grains.svg", "sizes.svg", "crack.svg", "opened.webp", "scene.json")
}
AFTER_ASSEMBLE = {"inp", "check", "depict", "report", "all"}
AFTER_GRADATE = {"tetrahedralize", "assemble"} | AFTER_ASSEMBLE
AFTER_SIZE = {"stitch", "gradate"} | AFTER_GRADATE


@pytest.fixture(scope="module")
def finished(new_folder):
    folder = new_folder()
    run = folder.snakemake("--cores", "2")
    assert run.status == 0, run.text
    return folder


def test_all_files_are_there(finished):
    results = finished.path / "results"
    for inc in ("000", "001"):
        folder = results / "tiny" / inc
        assert FILES_OF_INCREMENT | PICTURES <= {
            str(path.relative_to(folder)) for path in folder.rglob("*")
        }
        assert (results / "logs" / "tiny" / inc / "gradated.log").is_file()
        assert (results / "benchmarks" / "tiny" / inc / "gradated.tsv").is_file()
    assert "Case tiny" in (results / "report.html").read_text()
    assert (results / "tiny" / "case.json").is_file()
    assert not list(results.rglob(".tmp-*"))


@pytest.mark.parametrize("inc", ["000", "001"])
def test_independent_judge_finds_no_fault_in_the_decks(finished, inc):
    case = finished.path / "results" / "tiny"
    verdict = load_judge(ROOT).judge(case / inc / "model.inp", case / "labels.npz")
    assert verdict["faults"] == [] and verdict["labels_without_set"] == 0
    assert (
        verdict["front_nodes_missed_by_set"] == verdict["front_set_extra"] == verdict["front_branches"] == 0
    )
    # volumes are restored to the voxels' within 5e-4 of each grain; 1e-3 leaves room for its last round
    assert verdict["grain_volume_drift"]["max"] < 1e-3


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX (ccx) is not installed")
def test_calculix_solves_the_deck(finished):
    done = subprocess.run(
        ["ccx", "-i", "model"],
        cwd=finished.path / "results" / "tiny" / "000",
        capture_output=True,
        text=True,
        timeout=300,
        env=os.environ | {"OMP_NUM_THREADS": "1"},
    )
    assert done.returncode == 0 and "*ERROR" not in done.stdout + done.stderr, done.stdout[-2000:]
    assert "Job finished" in done.stdout


def test_rerun_does_nothing(finished):
    run = finished.snakemake("--dry-run", "--config", "chunks=2", "results=results")
    assert run.status == 0 and run.jobs == {} and "Nothing to be done" in run.text


def test_touched_module_reruns_its_stage_and_what_follows_and_one_of_no_stage_nothing(finished, tmp_path):
    project = tmp_path / "project"
    for part in ("craftmesh", "workflow", "profiles"):
        shutil.copytree(ROOT / part, project / part, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "Snakefile", project)
    for module in ("gradation/gradate.py", "campaign/digest.py"):
        with open(project / "craftmesh" / module, "a") as stream:
            stream.write("\n# touched\n")
    run = finished.snakemake("--dry-run", project=project)
    assert run.status == 0, run.text
    assert set(run.jobs) - {"total"} == {"gradate"} | AFTER_GRADATE


def test_changed_option_reruns_its_stage_and_what_follows(finished):
    run = finished.snakemake("--dry-run", "--config", "chunks=1")
    assert set(run.jobs) - {"total"} == AFTER_GRADATE


@pytest.mark.parametrize(
    ("key", "value", "first"),
    [("l_min", 0.8, {"size", "crack"}), ("around_voids", True, {"size"})],
)
def test_changed_sizing_reruns_the_sizing_and_what_follows(finished, tmp_path, key, value, first):
    folder = type(finished)(shutil.copytree(finished.path, tmp_path / "other"))
    config = yaml.safe_load((folder.path / "config.yaml").read_text())
    config["sizing"][key] = value
    (folder.path / "config.yaml").write_text(yaml.safe_dump(config))
    run = folder.snakemake("--dry-run")
    assert run.status == 0, run.text
    assert set(run.jobs) - {"total"} == first | AFTER_SIZE  # crack asks l_min of cracks beside a face
    assert run.jobs["size"] == run.jobs["stitch"] == 2


def test_includes_and_exports_make_their_files_and_rerun_nothing_else(finished, tmp_path):
    folder = type(finished)(shutil.copytree(finished.path, tmp_path / "more"))
    with open(folder.path / "config.yaml", "a") as stream:
        stream.write("exports: [.msh, e]\ninp: {includes: true, quarter_points: true}\n")
    jobs = folder.snakemake("--dry-run").jobs
    assert jobs == {"inp": 2, "export": 6, "report": 1, "all": 1, "total": 10}  # .csv with .msh
    case = folder.path / "results" / "tiny" / "001"
    run = folder.snakemake(
        "--cores", "2", *(f"results/tiny/001/model{end}" for end in ("_mesh.inp", ".msh", ".csv"))
    )
    assert run.status == 0 and run.jobs == {"inp": 1, "export": 2, "total": 3}, run.text
    assert (case / "model.csv").read_text().startswith("grain,phase,w,x,y,z,phi1,Phi,phi2\n1,")
    assert check_deck(case / "model.inp") == []
    corners = read_tets(case / "volume.vtu")
    assert len(meshio.read(case / "model.msh").cells_dict["tetra10"]) == len(corners.tets)
    (case / "model_mesh.inp").unlink()
    assert folder.snakemake("--dry-run").jobs["inp"] == 2


def test_a_column_of_empty_cells_reruns_nothing(finished, tmp_path):
    folder = type(finished)(shutil.copytree(finished.path, tmp_path / "wider"))
    sheet = folder.path / "cases.tsv"
    head, *rows = sheet.read_text().splitlines()
    sheet.write_text("\n".join([head + "\tinp.load", *(row + "\t" for row in rows)]))
    assert folder.snakemake("--dry-run").jobs == {}


def test_one_more_increment_runs_only_that_increment(finished, tmp_path):
    more = shutil.copytree(finished.path, tmp_path / "more")
    sheet = more / "cases.tsv"
    sheet.write_text(sheet.read_text().replace("\t2\n", "\t3\n"))
    run = type(finished)(more).snakemake("--dry-run")
    assert run.jobs["gradate"] == 1 and run.jobs["crack"] == 1 and "remesh" not in run.jobs


def test_second_run_gives_the_same_bytes(finished, new_folder):
    again = new_folder()
    case = Path("results") / "tiny" / "001"
    wanted = (str(case / name) for name in ("model.inp", "quality.json"))
    run = again.snakemake("--cores", "2", *wanted, "--config", "chunks=1")
    assert run.status == 0, run.text
    for name in sorted(FILES_OF_INCREMENT):
        assert (again.path / case / name).read_bytes() == (finished.path / case / name).read_bytes(), name
