"""A growing crack through Snakemake whose second and third meshes are renewed."""

import json

import numpy as np
import pytest

from craftmesh.io.stage_npz import read_map
from craftmesh.io.vtk import read_tets

CASES = "case\tmicrostructure\tcrack\tincrements\tgrowth\ntiny\tsynthetic\ttilted\t3\tgrow\n"
CONFIG = """
cases: cases.tsv
chunks: 1
generate: {shape: [20, 20, 20], grains: 3}
sizing: {l0: 1.5, l_min: 0.8, l_max: 3.0, r0: 2.0, r1: 4.0}
cracks:
  tilted: {centre: [10.0, 10.0, 10.2], normal: [0.0, 0.4, 1.0], radius: 2.6}
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
        assert len(stays) == told["elements_kept"]
        assert number > 1 or len(stays) > 0.1 * len(old.tets)
        assert np.array_equal(new.points[new.tets[elements[stays]]], old.points[old.tets[stays]])


def test_nothing_runs_again_and_one_increment_alone_gives_the_same_bytes(finished):
    assert "Nothing to be done" in finished.snakemake("--cores", "2", "--dry-run").text
    before = finished.made
    run = finished.snakemake("--cores", "2", "-f", "results/tiny/001/volume.vtu")
    assert run.status == 0 and run.jobs == {"renew": 1, "total": 1}, run.text
    assert finished.made == before
