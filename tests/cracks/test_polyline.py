"""Polylines by arc length: places, directions and feet, against shapely and the circle."""

import numpy as np
import pytest
import shapely

from craftmesh.cracks import polyline as module
from craftmesh.cracks.polyline import feet, polyline


def circle(count: int) -> np.ndarray:
    turn = np.linspace(0, 2 * np.pi, count + 1)
    points = 3 * np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    points[-1] = points[0]
    return points


@pytest.mark.parametrize("at_once", [1, 40, 2_000_000])
def test_feet_are_those_of_shapely(at_once, monkeypatch):
    monkeypatch.setattr(module, "AT_ONCE", at_once)
    rng = np.random.default_rng(4)
    flat, away = rng.uniform(-3, 3, (12, 2)), rng.uniform(-4, 4, (200, 2))
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0][:2]
    height = rng.uniform(-1, 1, 200)
    arcs, distances = feet(polyline(flat @ turn), away @ turn + height[:, None] * np.cross(*turn))
    known, places = shapely.LineString(flat), shapely.points(away)
    assert arcs == pytest.approx(shapely.line_locate_point(known, places))
    assert distances == pytest.approx(np.hypot(shapely.distance(known, places), height))


def test_places_lie_at_their_arc_lengths_and_go_round_a_closed_line():
    rng = np.random.default_rng(5)
    points = rng.uniform(-3, 3, (9, 2))
    arc = rng.uniform(0, 20, 50)
    for is_closed in (False, True):
        given = np.concatenate([points, points[:1]]) if is_closed else points
        line, known = polyline(given), shapely.LineString(given)
        assert line.closed == is_closed and line.length == pytest.approx(known.length)
        round_once = arc % known.length if is_closed else arc
        places = shapely.get_coordinates(shapely.line_interpolate_point(known, round_once))
        assert line.at(arc) == pytest.approx(places)
    assert line.at(arc - 3 * line.length) == pytest.approx(line.at(arc))


def test_repeated_points_are_left_out_and_a_way_there_and_back_is_closed():
    points = np.array([[0, 0, 0], [0, 0, 0], [3, 4, 0], [3, 4, 0], [3, 4, 0], [3, 4, 2]], float)
    line = polyline(points)
    assert np.array_equal(line.points, points[[0, 2, 5]]) and line.arc.tolist() == [0, 5, 7]
    assert not line.closed and not polyline(points[:3]).closed
    assert polyline(points[[0, 2, 0]]).closed


def test_directions_are_square_to_the_radius_of_a_circle_and_those_of_the_end_edges():
    points = circle(30)
    for line in (polyline(points), polyline(points[3:20])):
        tangents = line.tangents()
        assert np.linalg.norm(tangents, axis=1) == pytest.approx(np.ones(len(tangents)))
        inner = slice(None) if line.closed else slice(1, -1)
        around = np.cross([0, 0, 1 / 3], line.points)
        assert tangents[inner] == pytest.approx(around[inner], abs=1e-12)
        if not line.closed:
            edges = np.diff(line.points, axis=0)[[0, -1]]
            size = np.linalg.norm(edges, axis=1, keepdims=True)
            assert tangents[[0, -1]] == pytest.approx(edges / size)
