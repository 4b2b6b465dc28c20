"""Measures of elements and grains against shapes that have known ones."""

import json
import re
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from deck_reader import load_judge
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.deck.write_deck import DeckOptions, write_deck
from craftmesh.mesh.quality import drift_sentence, quality
from craftmesh.mesh.second_order import raise_order
from craftmesh.mesh.shape_measures import shape_measures
from craftmesh.mesh.tet_connectivity import EDGE_CORNERS, FACE_CORNERS
from craftmesh.types import TetMesh, Voxels

ROOT = Path(__file__).resolve().parents[2]


def measures(points):
    return shape_measures(np.array(points, float), np.array([[0, 1, 2, 3]]))[0]


def test_regular_tetrahedron():
    volume, aspect, low, high, factor = measures([[1, 1, 1], [-1, 1, -1], [1, -1, -1], [-1, -1, 1]])
    assert volume == pytest.approx(8 / 3) and aspect == pytest.approx(np.sqrt(1.5))
    assert low == pytest.approx(np.degrees(np.arccos(1 / 3))) == high
    assert factor == pytest.approx(1)


def test_corner_of_a_cube():
    volume, aspect, low, high, factor = measures([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    assert volume == pytest.approx(1 / 6) and aspect == pytest.approx(np.sqrt(2) * np.sqrt(3))
    assert low == pytest.approx(np.degrees(np.arccos(1 / np.sqrt(3)))) and high == pytest.approx(90)
    assert factor == pytest.approx((1 / 6) / (8 * np.sqrt(3) / 27 * (np.sqrt(3) / 2) ** 3))


def test_flat_and_inverted_elements():
    assert measures([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])[[1, 4]].tolist() == [np.inf, 0]
    assert measures([[0, 0, 0], [0, 1, 0], [1, 0, 0], [0, 0, 1]])[0] == pytest.approx(-1 / 6)


def random_mesh(count=500):
    points = np.random.default_rng(2).normal(size=(4 * count, 3))
    tets = np.arange(4 * count).reshape(-1, 4)
    volume = shape_measures(points, tets)[:, 0]
    tets[volume < 0] = tets[volume < 0][:, [1, 0, 2, 3]]
    return TetMesh(points, tets, np.ones(count))


def test_the_table_agrees_with_the_judge(tmp_path):
    judge = load_judge(ROOT)
    mesh = random_mesh()
    write_deck(tmp_path / "m.inp", mesh, DeckOptions(element="C3D4", load="none"))
    theirs, ours = judge.judge(tmp_path / "m.inp")["quality"], quality(mesh)
    names = {
        "ar_mean": "ar_mean",
        "ar_under_5_pct": "ar_lt5_pct",
        "dihedral_min": "dihedral_min",
        "dihedral_max": "dihedral_max",
        "poor_dihedral_under_10_pct": "pct_dihedral_lt10",
        "poor_dihedral_over_160_pct": "pct_dihedral_gt160",
        "poor_shape_factor_pct": "pct_sf_lt_0_02",
        "poor_pct": "pct_poor_union",
    }
    # The judge rounds to three to five decimals.
    for mine, other in names.items():
        assert ours[mine] == pytest.approx(theirs[other], abs=1e-3), mine
    assert ours["poor_pct"] > ours["poor_dihedral_under_10_pct"] > 0
    assert sum(ours["histograms"]["aspect_ratio"]["counts"]) == ours["elements"] == 500


def test_drift_of_the_grains_against_voxels():
    def label_of(centres):
        return np.where(centres[:, 0] < 2, 3, 5)

    mesh = assemble(*structured_box((4, 3, 2), label_of, None, (0.5, 0.5, 0.25)))[0]
    labels = np.full((4, 3, 2), 3)
    labels[3:] = 5
    labels[0, 0, 0] = 9
    drift = quality(mesh, Voxels(labels, [0.5, 0.5, 0.25], [0, 0, 0]))["volume_drift"]
    assert drift["by_grain"] == pytest.approx({"3": 12 / 17 - 1, "5": 1.0, "9": -1.0})
    assert drift["grains"] == 3 and drift["worst"] == pytest.approx(1) and drift["without_voxels"] == []
    assert drift["mean"] == pytest.approx((5 / 17 + 2) / 3) and drift["worst_over_500_voxels"] == 0
    labels[labels == 5] = 3
    drift = quality(mesh, Voxels(labels, [0.5, 0.5, 0.25], [0, 0, 0]))["volume_drift"]
    assert drift["without_voxels"] == [5] and drift["worst_grain"] == 9


@pytest.mark.parametrize(
    "drifts, words",
    [
        ({"3": 0.049, "5": -0.05}, None),
        ({"3": 0.01, "5": -0.051}, "1 of 2 grains .* more than 5%: grain 5 by -5.1%$"),
        ({"3": 0.3, "5": -1.0}, "2 of 2 grains .*: grain 5 by -100.0%, grain 3 by .30.0%$"),
    ],
)
def test_grains_off_their_voxels_are_named_the_worst_first(drifts, words):
    sentence = drift_sentence({"grains": len(drifts), "by_grain": drifts})
    assert sentence is None if words is None else re.search(words, sentence)
    assert drift_sentence({}) is None  # without labels nothing is known


def test_crack_and_size_are_the_same_for_either_order():
    crack = plane_crack(2, 2, hexagon((3, 3), 2))
    mesh, _ = assemble(*structured_box((6, 6, 4), lambda c: np.ones(len(c), int), crack))
    linear, second = quality(mesh), quality(raise_order(mesh))
    assert linear["crack_area"] == pytest.approx(24 / 2) == second["crack_area"]
    assert linear["front_length"] == pytest.approx(8 + 4 * np.sqrt(2)) == second["front_length"]
    assert linear["volume"] == pytest.approx(6 * 6 * 4) and linear["elements"] == 6 * 6 * 6 * 4
    assert linear["dof_second_order"] == second["dof"] == 3 * second["nodes"]
    json.dumps(linear, allow_nan=False)


def plain_measures(points, tets):
    """Return the measures (m, 5) of `shape_measures`, by arrays of all faces and edges."""
    corners, opposite = points[tets], np.array([[0, 5], [1, 3], [2, 4]])
    edges = corners[:, EDGE_CORNERS[:, 1]] - corners[:, EDGE_CORNERS[:, 0]]
    length = np.linalg.norm(edges, axis=2)
    a, b, c = corners[:, FACE_CORNERS].transpose(2, 0, 1, 3)
    faces = np.cross(b - a, c - a)
    double = np.linalg.norm(faces, axis=2)
    six_volume = (faces[:, 0] * edges[:, 3]).sum(axis=1)
    size, (one, other) = abs(six_volume), np.array(list(combinations(range(4), 2))).T
    areas = double[:, one] * double[:, other]
    cosines = -(faces[:, one] * faces[:, other]).sum(axis=2)
    cosines = np.where(areas > 0, (cosines / np.where(areas > 0, areas, 1.0)).clip(-1, 1), 1.0)
    x, y, z = (length[:, opposite[:, 0]] * length[:, opposite[:, 1]]).T
    crelle = np.sqrt(np.maximum((x + y + z) * (x + y - z) * (x - y + z) * (-x + y + z), 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        aspect = np.where(size > 0, length.max(axis=1) * double.max(axis=1) / size, np.inf)
        factor = size / 6 / (8 * np.sqrt(3.0) / 27 * (crelle / (4 * size)) ** 3)
    angles = np.degrees(np.arccos([cosines.max(axis=1), cosines.min(axis=1)]))
    return np.column_stack([six_volume / 6, aspect, *angles, np.where(size > 0, factor, 0.0)])


def test_measures_are_those_of_plain_arrays():
    rng = np.random.default_rng(4)
    points = np.vstack([rng.normal(size=(300, 3)), np.eye(3), np.zeros((1, 3)), [[0.5, 0.5, 0]]])
    tets = rng.integers(0, 300, (20000, 4))  # some with a corner twice
    tets = np.vstack([tets, [[300, 301, 302, 303], [300, 301, 304, 303], [300, 304, 301, 302], [303] * 4]])
    found, plain = shape_measures(points, tets), plain_measures(points, tets)
    found[:, 2:4], plain[:, 2:4] = np.cos(np.radians(found[:, 2:4])), np.cos(np.radians(plain[:, 2:4]))
    sound = plain[:, 1] < 100  # the flatter a tet, the more of its volume is rounding
    assert 0 < (~sound).sum() < 2000 and np.isinf(found[-4:, 1]).tolist() == [False, True, True, True]
    assert found[sound] == pytest.approx(plain[sound], rel=1e-12, abs=1e-13)
    assert found[~sound] == pytest.approx(plain[~sound], rel=1e-5, abs=1e-13)
