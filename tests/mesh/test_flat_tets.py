"""Flat elements are counted and named, with the wedge of the grain that forces them where there is one."""

import json

import numpy as np
import pytest

from craftmesh import cli
from craftmesh.io.vtk import write_tets
from craftmesh.mesh.shape_measures import flat_sentence, flat_tets
from craftmesh.types import TetMesh

BASE = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


def mesh_of(points, tets, grain):
    return TetMesh(np.array(points, float), np.array(tets), np.array(grain))


def test_a_lone_flat_element_lies_in_a_wedge_of_its_own():
    found = flat_tets(mesh_of([*BASE, [0.3, 0.3, 0.01]], [[0, 1, 2, 3]], [7]))
    low = np.degrees(np.arctan2(0.01, 0.3))
    assert found["count"] == 1 and found["forced"] == 1
    (place,) = found["places"]
    assert place["grain"] == 7
    assert place["centre"] == pytest.approx([0.325, 0.325, 0.0025])
    assert place["dihedrals"][0] == pytest.approx(low, abs=0.01) and place["dihedrals"][1] > 172
    assert place["wedge"] == pytest.approx(low, abs=0.01)
    assert "grain 7, (0.325, 0.325, 0.0025)" in flat_sentence(found)


def halves(grain):
    """A flat element with a high one of a grain under its base and another on each upper face."""
    points = [*BASE, [0.3, 0.3, 0.01], [0.3, 0.3, -1], [0.3, 0.3, 1]]
    return mesh_of(points, [[0, 1, 2, 3], [0, 2, 1, 4], [0, 1, 3, 5], [1, 2, 3, 5], [2, 0, 3, 5]], grain)


def test_a_flat_element_between_sound_ones_of_its_grain_is_not_forced():
    found = flat_tets(halves([1, 1, 1, 1, 1]))
    assert found["count"] == 1 and found["forced"] == 0
    # at the three edges of its base the grain fills an open wedge; round the other three it is closed
    low = np.degrees(np.arctan2([0.3, 0.4 / np.sqrt(2)], 1)).max()
    assert found["places"][0]["wedge"] == pytest.approx(180 - 2 * low, abs=3)


def test_elements_of_another_grain_do_not_widen_the_wedge():
    found = flat_tets(halves([1, 2, 2, 2, 2]))
    assert found["forced"] == 1 and found["places"][0]["wedge"] < 2


def test_needles_and_caps_of_sound_angles_are_no_flat_elements():
    sound = mesh_of([*BASE, [0.3, 0.3, 0.8]], [[0, 1, 2, 3]], [1])
    assert flat_tets(sound) == {"count": 0, "forced": 0, "places": []}
    assert flat_sentence(flat_tets(sound)) is None


def test_all_are_counted_and_the_flattest_are_named():
    heights = np.linspace(0.001, 0.01, 150)[::-1]
    points = np.concatenate(
        [np.array([*BASE, [0.3, 0.3, h]]) + [2 * i, 0, 0] for i, h in enumerate(heights)]
    )
    found = flat_tets(mesh_of(points, np.arange(600).reshape(-1, 4), np.ones(150)))
    assert found["count"] == 150 and len(found["places"]) == 100
    assert [one["dihedrals"][0] for one in found["places"]] == sorted(
        one["dihedrals"][0] for one in found["places"]
    )


def test_check_warns_of_flat_elements(tmp_path, capsys):
    write_tets(tmp_path / "flat.vtu", halves([1, 1, 1, 1, 1]))
    cli.main(["check", str(tmp_path / "flat.vtu"), "--quality", str(tmp_path / "quality.json")])
    warnings = [line for line in capsys.readouterr().err.splitlines() if "warning" in line]
    assert len(warnings) == 1 and warnings[0].startswith("craftmesh: warning: 1 elements are flat")
    assert json.loads((tmp_path / "quality.json").read_text())["flat"]["count"] == 1
