"""Front vertices slide along the given front, and front edges that cut its corners do not collapse."""

import numpy as np
import pytest
from few_facets import fan, prepared, tried
from structured_box import structured_box
from unchanged import OPEN

from craftmesh import Sizing, gradate
from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.series import prescribed_crack
from craftmesh.gradation.crack_reference import front_segments
from craftmesh.gradation.kernels.one_pass import COLLAPSE
from craftmesh.gradation.kernels.result_codes import DISTANCE, DONE
from craftmesh.insertion.insert import insert_crack
from craftmesh.sizing.sizing import densify
from craftmesh.surface.front import front_edges
from craftmesh.types import CRACK, Crack

HEXAGON = fan(6, sides=(1, 1), kind=CRACK)


def circle(radius: float, count: int = 720, part: float = 1.0) -> Crack:
    """Return a crack of one triangle that has a circle, or the first part of one, for its front."""
    turn = np.linspace(0, 2 * np.pi * part, count + 1)
    points = radius * np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    front = np.arange(count + 1)
    if part == 1.0:
        points, front[-1] = points[:-1], 0
    return Crack(points, [[0, 1, 2]], (front,))


def test_edges_stay_straight_without_a_crack_and_far_from_its_front():
    edges = HEXAGON.points[front_edges(HEXAGON)]
    assert np.array_equal(front_segments(HEXAGON, None), edges)
    for radius in (0.8, 1.2):
        assert np.array_equal(front_segments(HEXAGON, circle(radius)), edges)


@pytest.mark.parametrize("radius", [1.0, 0.92, 1.08])
def test_edges_are_bent_as_the_front_and_keep_their_ends(radius):
    segments = front_segments(HEXAGON, circle(radius))
    edges = HEXAGON.points[front_edges(HEXAGON)]
    ends = np.unique(np.round(segments.reshape(-1, 3), 9), axis=0)
    assert set(map(tuple, np.round(edges.reshape(-1, 3), 9).tolist())) <= set(map(tuple, ends.tolist()))
    # Eight pieces of 60 degrees each, shifted as a whole where the front is wider or narrower.
    assert len(segments) == 6 * 8
    # A foot on a polygon is half of one of its 720 edges off at most, which shifts the middle by 2e-4.
    middles = np.linalg.norm(segments.reshape(6, 8, 2, 3)[:, 3, 1], axis=1)
    sagitta = radius * (1 - np.cos(np.pi / 6))
    assert middles == pytest.approx(np.cos(np.pi / 6) + sagitta, abs=5e-4)
    if radius == 1.0:
        assert np.abs(np.linalg.norm(segments.reshape(-1, 3), axis=1) - 1).max() < 1e-4


@pytest.mark.parametrize("turned", [1, -1])
def test_bent_edges_have_the_corners_of_a_front_of_few_points(turned):
    """Even pieces cut the corners of the front, and so did what slid there, by up to 0.0016 l_min."""
    given = circle(1.0, count=25)
    (front,) = given.fronts
    segments = front_segments(HEXAGON, Crack(given.points, given.triangles, (front[::turned],)))
    for corner in given.points:
        assert np.linalg.norm(segments - corner, axis=2).min() < 1e-9 + off_the_front(given)
    assert (segments[1:, 0] == segments[:-1, 1]).all(axis=1).sum() >= len(segments) - 6


def off_the_front(given: Crack) -> float:
    """Return how far the farthest corner of the hexagon is off the given front: pieces shift by that."""
    ends = given.points[given.fronts[0]]
    start, step = ends[:-1], np.diff(ends, axis=0)
    off = HEXAGON.points[np.unique(front_edges(HEXAGON))][:, None] - start
    share = np.clip((off * step).sum(axis=2) / (step**2).sum(axis=1), 0, 1)
    return float(np.linalg.norm(off - share[..., None] * step, axis=2).min(axis=1).max())


def test_a_front_that_ends_bends_the_edges_beside_it_alone():
    segments = front_segments(HEXAGON, circle(1.0, part=0.5))
    upper = segments[segments[:, :, 1].mean(axis=1) > 0]
    assert len(upper) == 3 * 8 and len(segments) == 3 * 8 + 3
    assert np.abs(np.linalg.norm(upper.reshape(-1, 3), axis=1) - 1).max() < 1e-4


@pytest.mark.parametrize("bound, reason", [(np.inf, DONE), (0.15, DONE), (0.1, DISTANCE)])
def test_a_collapse_leaves_the_front_no_farther_than_its_bound(bound, reason):
    """Without vertex 2, the front goes 1 - cos(30 degrees) = 0.134 past its place."""
    _, references = prepared(fan(12, sides=(1, 1), kind=CRACK))
    limits = OPEN._replace(distance=9.0, crack_distance=9.0, front_distance=bound)
    assert tried(references, limits, COLLAPSE, (1, 2)) == reason


def test_front_nodes_of_a_small_penny_lie_on_its_circle():
    """The middles of front edges are up to 0.03 l_min off it: vertices go elsewhere."""
    surface, _ = structured_box((10, 10, 10), lambda centres: np.ones(len(centres), int))
    box, centre = np.array([[0.0] * 3, [10.0] * 3]), np.array([5.1, 4.9, 5.05])
    options = CrackOptions(centre=tuple(centre), normal=(0.1, 0.2, 1.0), radius=3.3)
    crack = prescribed_crack(box, options)
    sources = np.concatenate([densify(crack.points[f], 0.1) for f in crack.fronts])
    before, _ = insert_crack(surface, crack, Sizing(0.8, 1.0, 1.0, 2.0, 4.0, 1.0, sources))
    after, _ = gradate(before, Sizing(0.4, 1.0, 2.0, 2.0, 4.0, 1.0, sources), crack=crack)
    nodes = np.unique(front_edges(after))
    off = np.linalg.norm(after.points[nodes] - centre, axis=1) - 3.3
    assert len(nodes) > len(np.unique(front_edges(before)))
    # Pieces of the curve are off it by 5e-4 of an edge, nodes of the insertion by 1e-3.
    assert np.abs(off).max() < 2e-3 * 0.8
