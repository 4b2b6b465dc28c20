"""Given sheets: the plane over which they are a height, orientation, slivers, pieces, parts outside."""

import json
import re

import numpy as np
import pytest
import shapely
from given_cracks import wavy_disc

from craftmesh.cracks.height_parts import best_fit_frame, fold_of, least_steep
from craftmesh.cracks.one_sheet import without_slivers
from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.errors import CraftmeshError
from craftmesh.surface.measure import area_vectors

BOX = np.array([[0.0, 0.0, 0.0], [10.0, 10.0, 10.0]])


def grid(u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (u, v) at the points of a grid and its triangles."""
    uv = np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1).reshape(-1, 2)
    row = np.arange(len(uv)).reshape(len(u), len(v))
    a, b, c, d = (x.ravel() for x in (row[:-1, :-1], row[1:, :-1], row[1:, 1:], row[:-1, 1:]))
    return uv, np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def kinked(length, width, degrees, rows=8) -> tuple[np.ndarray, np.ndarray]:
    """Return a strip along y that turns by an angle about its middle line, by arc length across it."""
    uv, triangles = grid(np.linspace(-width, width, rows + 1), np.linspace(0, length, rows + 1))
    past = np.maximum(uv[:, 0], 0)
    x = np.minimum(uv[:, 0], 0) + past * np.cos(np.radians(degrees))
    return np.stack([x, uv[:, 1], past * np.sin(np.radians(degrees))], axis=1) + 5.0, triangles


def test_a_union_that_fails_on_exact_corners_is_made_on_a_grid(monkeypatch):
    points, triangles = kinked(4.0, 2.0, 40.0)
    folded = np.concatenate([triangles, triangles[:4]])
    found = fold_of(points, triangles), fold_of(points, folded)
    union = shapely.union_all

    def fails(polygons, grid_size=None):
        if grid_size is None:
            raise shapely.GEOSException("side location conflict")
        return union(polygons, grid_size=grid_size)

    monkeypatch.setattr(shapely, "union_all", fails)
    assert (fold_of(points, triangles), fold_of(points, folded)) == found
    assert not found[0] and "overlaps" in found[1]


def test_the_direction_is_the_best_of_many():
    rng = np.random.default_rng(1)
    for _ in range(20):
        normals = rng.normal(size=(30, 3)) * 0.6 + [0.0, 0.0, 1.5]
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        found = (normals @ least_steep(normals)).min()
        trial = rng.normal(size=(20000, 3))
        trial /= np.linalg.norm(trial, axis=1)[:, None]
        assert found >= (trial @ normals.T).min(axis=1).max() - 1e-9


@pytest.mark.parametrize("degrees", [30, 60, 110])
def test_a_narrow_kinked_strip_is_a_height_over_some_plane(degrees):
    points, triangles = kinked(4.0, 0.6, degrees)
    crack = crack_from_triangles(points, triangles, None, BOX)
    normals = area_vectors(crack.points, crack.triangles)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    steepest = np.arccos((normals @ best_fit_frame(crack.points, crack.triangles)[2]).min())
    assert np.degrees(steepest) <= max(45.0, degrees / 2) + 1e-6


def test_triangles_turned_at_random_are_turned_alike():
    points, triangles = wavy_disc(3.0, 0.5)
    turned = triangles.copy()
    rows = np.random.default_rng(0).random(len(triangles)) < 0.4
    turned[rows] = turned[rows][:, ::-1]
    crack = crack_from_triangles(points + 5.0, turned, None, BOX)
    assert (area_vectors(crack.points, crack.triangles)[:, 2] > 0).all()


def test_a_sheet_folded_flat_is_refused_with_its_place_and_one_that_turns_smoothly_is_not():
    points, triangles = kinked(4.0, 2.0, 170)
    with pytest.raises(CraftmeshError, match=r"folded near \[.*stands at 85 degrees"):
        crack_from_triangles(points, triangles, None, BOX)
    uv, triangles = grid(np.linspace(0, 60, 61), np.linspace(2, 8, 7))
    turn = np.clip((uv[:, 0] - 30) / 5, 0, np.pi)  # a smooth half turn, and back over itself
    x = np.minimum(uv[:, 0], 30) + 5 * np.sin(turn) - np.maximum(uv[:, 0] - 30 - 5 * np.pi, 0)
    points = np.stack([x, uv[:, 1], 5 + 5 * (1 - np.cos(turn))], axis=1)
    crack = crack_from_triangles(points + [4.0, 0, 0], triangles, None, BOX)
    assert len(crack.fronts) == 1


def test_slivers_with_normals_of_their_own_are_flipped_away_or_dropped():
    """Three points nearly in a row, as float32 rounding leaves them: in the sheet, and at its rim."""
    points = np.array([[0, 0, 0], [4, 0, 0], [2, 1e-5, 1e-5], [2, 3, 0], [2, -3, 0]], float) + 4.0
    over, sliver, under = [[0, 2, 3], [2, 1, 3]], [0, 1, 2], [1, 0, 4]
    inside = without_slivers(points, np.array([*over, sliver, under]))
    assert {frozenset(row) for row in inside.tolist()} == set(map(frozenset, [*over, [0, 4, 2], [4, 1, 2]]))
    at_rim = without_slivers(points, np.array([*over, sliver]))
    assert np.array_equal(at_rim, over)
    assert len(crack_from_triangles(points, np.array([*over, sliver]), None, BOX).triangles) == 2


def test_two_sheets_in_the_box_are_refused_and_one_outside_is_left_out():
    points, triangles = wavy_disc(2.0, 0.2)
    both = np.concatenate([triangles, triangles + len(points)])
    # a piece is named by the middle of its triangles
    shifts = np.array([[3.0, 4.0, 2.0], [7.0, 6.0, 8.0]])
    middle = points[triangles].mean(axis=(0, 1))
    with pytest.raises(CraftmeshError, match="2 pieces in the box") as caught:
        crack_from_triangles(np.concatenate([points + shift for shift in shifts]), both, None, BOX)
    places = [json.loads(text) for text in re.findall(r"\[[^][]*\]", str(caught.value))]
    # six digits are told
    assert np.allclose(places, middle + shifts, atol=1e-5)
    crack = crack_from_triangles(np.concatenate([points + 3, points + 70]), both, None, BOX)
    assert len(crack.triangles) == len(triangles)


def test_a_moebius_strip_is_refused():
    uv, triangles = grid(np.linspace(0, 2 * np.pi, 41), np.linspace(-1, 1, 3))
    angle, across = uv.T
    far = 3 + across * np.cos(angle / 2)
    points = np.stack([far * np.cos(angle), far * np.sin(angle), across * np.sin(angle / 2)], axis=1) + 5
    with pytest.raises(CraftmeshError, match="only one side"):
        crack_from_triangles(points, triangles, None, BOX)
