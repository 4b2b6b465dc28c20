"""A mesher that crashes, hangs or lies costs its own grain only, and says which one."""

import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.errors import CraftmeshError, MeshingError
from craftmesh.mesh.check_tets import check_tets
from craftmesh.tetrahedra.diagnose import diagnose, tetgen_diagnosis
from craftmesh.tetrahedra.grain_surface import GrainSurface, grain_surfaces
from craftmesh.tetrahedra.meshers import load_mesher
from craftmesh.tetrahedra.options import TetrahedralizeOptions
from craftmesh.tetrahedra.tetrahedralize import tetrahedralize


def three_grains():
    """Grains 4, 7, 9 in a row along x: the faulty meshers fail at 7."""
    return structured_box((3, 2, 2), lambda c: np.array([4, 7, 9])[c[:, 0].astype(int)])[0]


def mesh_with(mesher, **options):
    given = {"interior_points": False, "optimise": False, "memory_limit": 4.0, "switches": "pYQ"} | options
    return tetrahedralize(
        three_grains(), None, TetrahedralizeOptions(mesher=f"faulty_meshers:{mesher}", **given)
    )


@pytest.mark.parametrize(
    ("mesher", "reason", "options"),
    [
        ("Crashing", "signal 11", {}),
        ("Hanging", "no answer within 0.5 s", {"time_limit": 0.5}),
        ("Greedy", "memory", {}),
        ("MovingNodes", "moved nodes", {}),
        ("LosingTets", "facets", {}),
        ("OtherSurface", "fac|fill", {}),
    ],
)
def test_a_fault_names_its_grain_and_keeps_the_others(mesher, reason, options):
    with pytest.raises(MeshingError, match=f"grain 7 could not be meshed .*({reason})") as caught:
        mesh_with(mesher, **options)
    error = caught.value
    assert [failure.grain for failure in error.failures] == [7]
    assert [one.grain for one in error.done] == [4, 9]
    tried = error.report["failed"]["7"]["attempts"]
    # each attempt is one rung of the ladder, and no rung is tried twice
    assert len({(one["switches"], one["interior_points"]) for one in tried}) == len(tried) >= 2
    assert "\n" not in str(error)


def test_a_later_attempt_is_taken_and_reported():
    result, report = mesh_with("CrashingAtQuality", switches="pYq1.4AQ")
    assert [one.grain for one in result] == [4, 7, 9]
    (again,) = report["tried_again"].values()
    assert list(report["tried_again"]) == ["7"]
    assert "signal 11" in again[0]["reason"] and again[-1]["reason"] == "meshed"
    assert "q" not in again[-1]["switches"]


def test_an_unknown_mesher_is_refused_and_a_sizing_of_ones_own_taken(capfd):
    with pytest.raises(CraftmeshError, match="nothing_there"):
        load_mesher("nothing_there:Mesher")
    sizing = SimpleNamespace(at=lambda points: np.ones(len(points)))
    assert len(tetrahedralize(three_grains(), sizing, TetrahedralizeOptions())[0]) == 3
    assert capfd.readouterr().out == "", "what TetGen prints"


def pierced_cube() -> GrainSurface:
    """A unit cube with a crack facet that sticks out of one of its sides."""
    cube = grain_surfaces(structured_box((1, 1, 1), lambda c: np.ones(len(c), int))[0])[0]
    points = np.concatenate([cube.points, [[0.5, 0.4, 0.5], [1.5, 0.5, 0.4], [0.6, 0.6, 0.6]]])
    facets = np.concatenate([cube.facets, [[8, 9, 10]]])
    internal = np.arange(len(facets)) == len(cube.facets)
    return GrainSurface(1, np.arange(11), points, facets, internal, 100 + np.arange(len(facets)))


def test_the_facets_at_fault_are_found_in_two_ways():
    surface = pierced_cube()
    failure = diagnose(surface, ({"reason": "it failed"},), np.zeros(0), ask_tetgen=False)
    rows = np.flatnonzero(failure.at_fault)
    assert rows[-1] == 12 and len(rows) >= 2
    # the others are those of the side x = 1 that it goes through
    assert (surface.points[surface.facets[rows[:-1]]][:, :, 0] == 1).all()
    assert failure.facet_ids.tolist() == (100 + rows).tolist()
    assert "grain 1" in failure.sentence() and "112" in failure.sentence()
    # TetGen names those that it could not recover
    named = tetgen_diagnosis(surface)
    assert len(named) and np.isin(named, rows).all()


@pytest.mark.skipif(shutil.which("tetgen") is None, reason="the program tetgen is not installed")
@pytest.mark.parametrize("interior_points", [True, False])
def test_the_program_keeps_surface_holes_crack_and_points(interior_points):
    def label_of(c):
        return np.where((np.abs(c - [1.5, 1.5, 1.5]) < 0.6).all(1), -1, 1)

    crack = plane_crack(2, 3, hexagon((3.0, 3.0), 1.6))
    # coordinates that need all their digits
    surface = structured_box((6, 6, 5), label_of, crack, spacing=(1 / 3, 0.1, np.pi), origin=(-7, 0, 1e3))[
        0
    ]
    options = TetrahedralizeOptions(mesher="tetgen-cli", interior_points=interior_points, optimise=False)
    (grain,), report = tetrahedralize(surface, None, options)
    assert report["tried_again"] == {} and report["holes"] == 1
    assert (report["interior_points"] > 0) == interior_points
    mesh, opened = assemble(surface, [grain])
    assert check_tets(mesh) == [] and opened["crack_facets"] > 0
    assert {tuple(x) for x in surface.points} <= {tuple(x) for x in mesh.points}


def test_a_missing_program_is_one_line_before_any_work(monkeypatch):
    monkeypatch.setenv("PATH", "/nowhere")
    with pytest.raises(CraftmeshError, match="tetgen-cli needs the program 'tetgen'.*install") as caught:
        tetrahedralize(three_grains(), None, TetrahedralizeOptions(mesher="tetgen-cli"))
    assert not isinstance(caught.value, MeshingError)


def test_a_program_that_hangs_dies_with_its_attempt(tmp_path, monkeypatch):
    program = tmp_path / "tetgen"
    program.write_text(f"#!/bin/sh\necho $$ >> {tmp_path}/ids\nexec sleep 600\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")
    with pytest.raises(MeshingError, match="no answer within 1 s"):
        mesh_with_program(time_limit=1)
    started = (tmp_path / "ids").read_text().split()
    assert len(started) >= 2 and not any(map(is_running, started))


def mesh_with_program(**options):
    plain = {"switches": "pYAQ", "interior_points": False, "optimise": False}
    options = TetrahedralizeOptions(mesher="tetgen-cli", **plain, **options)
    return tetrahedralize(three_grains(), None, options, None, [7])


def is_running(process: str) -> bool:
    """Whether the process is there and no zombie, which has no command line left."""
    try:
        return Path(f"/proc/{process}/cmdline").read_bytes() != b""
    except OSError:
        return False
