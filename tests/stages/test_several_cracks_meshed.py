"""Two cracks from the verb to the mesh: numbered where they are apart, one where they cross."""

import numpy as np
import pytest
from models import voronoi

from craftmesh.assembly.assemble import assemble
from craftmesh.cli import main
from craftmesh.cracks.sheets import sheets
from craftmesh.gradation.gradate import GradateOptions, gradate
from craftmesh.insertion.insert import insert_crack
from craftmesh.io.npz import write_labels
from craftmesh.io.vtk import read_crack
from craftmesh.mesh.check_tets import check_tets
from craftmesh.mesh.front_frames import front_frames
from craftmesh.mesh.second_order import raise_order
from craftmesh.remeshing.remesh import remesh
from craftmesh.sizing.sizing import SizingOptions, sizing_for
from craftmesh.tetrahedra.options import TetrahedralizeOptions
from craftmesh.tetrahedra.tetrahedralize import tetrahedralize

VOXELS = voronoi(3, 6, (16, 14, 14))
SURFACE = remesh(VOXELS)[0]
OUTER = ["--shape", "penny", "--centre", "8.1", "7.3", "7.2", "--radius", "4.5"]
OTHERS = {
    "apart": [
        "--shape",
        "penny",
        "--centre",
        "8.1",
        "0",
        "11",
        "--radius",
        "2.5",
        "--normal",
        "0",
        "0.1",
        "1",
    ],
    "crossing": ["--centre", "8.6", "7", "7.6", "--radius", "3", "--normal", "1", "0.1", "0.05"],
}


def made(folder, name):
    """Return the crack that the verb makes of two."""
    write_labels(folder / "labels.npz", VOXELS)
    words = ["crack", str(folder / "labels.npz"), "-o", str(folder / "crack.vtp")]
    assert main([*words, *OUTER, "--and", *OTHERS[name]]) == 0
    return read_crack(folder / "crack.vtp")


def meshed(crack):
    points = np.concatenate([crack.points[front] for front in crack.fronts])
    sizing = sizing_for(SURFACE, points, SizingOptions(l_min=0.8, l0=1, l_max=2.5, r0=2, r1=5))
    surface, _ = insert_crack(SURFACE, crack, sizing)
    surface, _ = gradate(surface, sizing, GradateOptions(), crack=crack)
    tets, _ = tetrahedralize(surface, sizing, TetrahedralizeOptions(fallback="none"))
    return assemble(surface, tets)


def test_cracks_apart_are_numbered_as_they_were_given(tmp_path):
    crack = made(tmp_path, "apart")
    assert [len(sheet.fronts) for sheet in sheets(crack)] == [1, 1]
    mesh, report = meshed(crack)
    assert check_tets(mesh) == check_tets(raise_order(mesh)) == []
    assert report["cracks"] == report["fronts"] == 2
    areas = [np.pi * 4.5**2, np.pi * 2.5**2 / 2]
    assert report["crack_area"] == pytest.approx(sum(areas), rel=0.01)
    first, second = (mesh.points[mesh.node_sets[f"CRACK_{k}_FRONT"]] for k in (1, 2))
    assert np.abs(np.linalg.norm(first - [8.1, 7.3, 7.2], axis=1) - 4.5).max() < 0.02 * 0.8
    assert np.abs(np.linalg.norm(second - [8.1, 0, 11], axis=1) - 2.5).max() < 0.02 * 0.8
    frames = front_frames(mesh)
    assert sorted({(int(n), int(c)) for n, c in zip(frames.front, frames.closed)}) == [(1, 1), (2, 0)] or (
        sorted({(int(n), int(c)) for n, c in zip(frames.front, frames.closed)}) == [(1, 0), (2, 1)]
    )
    assert sorted(frames.face[frames.end == 1]) == ["YMIN", "YMIN"]


def test_cracks_that_cross_are_one_and_a_front_ends_on_the_other_crack(tmp_path):
    """The second's front passes through the first: two arcs, each with both ends on the first's lips."""
    mesh, report = meshed(made(tmp_path, "crossing"))
    assert check_tets(mesh) == check_tets(raise_order(mesh)) == []
    assert report["cracks"] == 1 and report["fronts"] == 3
    assert report["crack_area"] == pytest.approx(np.pi * (4.5**2 + 3**2), rel=0.01)
    frames = front_frames(mesh)
    assert list(frames.face[frames.end == 1]) == ["CRACK"] * 4
    assert frames.closed.sum() == (frames.front == frames.front[frames.closed == 1][0]).sum()
