"""Sharp wedges and gaps between crack and grain boundary: found as by plain arithmetic, and opened."""

import numpy as np
import pytest
from few_facets import lens
from hypothesis import given, settings
from hypothesis import strategies as st
from structured_box import structured_box

from craftmesh.gradation.narrow_places import (
    FRONT_GAP,
    GAP,
    OPENED,
    SHARP,
    TOLERANCES,
    open_narrow_places,
)
from craftmesh.gradation.passes import Gradation, Limits, filled_grid
from craftmesh.gradation.state import make_state, surface_of
from craftmesh.surface.measure import side_volumes
from craftmesh.surface.wedges import wedges
from craftmesh.types import CRACK, Surface

FREE = Limits(0.75, 1.4, 9.0, 0.0, 0.0, -1.0, 9.0, 0.01, 99.0, False)


def fan(angles, labels, turned):
    """Facets round the edge from 0 to (0, 0, 1) at `angles`; labels[i] lies between i and i + 1."""
    points = [[0, 0, 0], [0, 0, 1]] + [[np.cos(a), np.sin(a), 0.5] for a in np.radians(angles)]
    facets, sides = [], []
    for i in range(len(angles)):
        ahead, behind = labels[i], labels[i - 1]
        facets.append([1, 0, 2 + i] if turned[i] else [0, 1, 2 + i])
        sides.append([ahead, behind] if turned[i] else [behind, ahead])
    return np.array(points, float), np.array(facets), np.array(sides)


@settings(deadline=None, max_examples=50)
@given(st.integers(0, 2**32 - 1))
def test_sectors_of_a_fan_have_their_angles_and_labels(seed):
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 6))
    angles = np.sort(rng.uniform(0, 360, count))
    labels = rng.permutation(count) + 1
    order = rng.permutation(count)
    points, facets, sides = fan(angles, labels, rng.random(count) < 0.5)
    found = wedges(points, facets[order], sides[order], np.array([[0, 1]]))
    gaps = dict(zip(labels.tolist(), (np.roll(angles, -1) - angles) % 360))
    assert dict(zip(found.label.tolist(), found.angle)) == pytest.approx(gaps)
    for label, pair, far in zip(found.label, found.facets, found.far):
        place = int(np.flatnonzero(labels == label)[0])
        assert order[pair].tolist() == [place, (place + 1) % count]
        assert far.tolist() == [2 + place, 2 + (place + 1) % count]


def test_wedges_of_a_cube_are_right_angles_and_only_the_chosen_edges_count():
    surface, _ = structured_box((1, 1, 1), lambda centres: np.ones(len(centres), int))
    edges = np.array([[0, 1]])
    found = wedges(surface.points, surface.facets, surface.sides, edges)
    assert len(found.edge) == 2 and (found.edge == edges).all()
    assert found.angle[found.label == 1] == pytest.approx([90]) or found.angle.tolist() == pytest.approx(
        [180, 180]
    )


def opened(surface, limits=FREE, size=0.5):
    state = make_state(surface, np.full(len(surface.points), size))
    gradation = Gradation(state, filled_grid(state.mesh), {})
    open_narrow_places(gradation, limits)
    return surface_of(gradation.state, surface), gradation.done


def sharpest(surface):
    edges = np.sort(surface.facets[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    found = wedges(surface.points, surface.facets, surface.sides, np.unique(edges, axis=0))
    return found.angle[found.label == 1].min()


def test_a_sharp_wedge_is_opened():
    surface = lens(np.tan(np.radians(12)))
    before = sharpest(surface)
    after, done = opened(surface)
    assert before < 15 and done["wedge_openings"] > 0
    assert sharpest(after) > SHARP - 0.5
    assert len(after.facets) == len(surface.facets)


def test_wedges_that_are_wide_enough_stay():
    surface = lens(np.tan(np.radians(OPENED)))
    after, done = opened(surface)
    assert done == {} and (after.points == surface.points).all()


def test_the_guards_hold_back_the_opening():
    surface = lens(np.tan(np.radians(12)))
    held, done = opened(surface, FREE._replace(distance=1e-6))
    assert done == {} and (held.points == surface.points).all()
    near, _ = opened(surface, FREE._replace(distance=0.05))
    way = np.linalg.norm(near.points - surface.points, axis=1)
    assert 0 < way.max() <= TOLERANCES * 0.05 * 0.5 + 1e-12
    volumes = side_volumes(surface.points, surface.facets, surface.sides)
    drifted, _ = opened(surface, FREE._replace(drift=0.01))
    after = side_volumes(drifted.points, drifted.facets, drifted.sides)
    assert abs(after[1] / volumes[1] - 1) <= 0.01


def test_a_grain_boundary_close_over_the_crack_moves_away():
    surface = lens(0.0)
    half = len(surface.facets) // 2
    upper = surface.facets[half:] + np.where(surface.facets[half:] < 12, 86, 0)
    points = np.concatenate([surface.points, surface.points[:12]])
    points[49:, 2] = 0.05
    facets = np.concatenate([surface.facets[:half], upper])
    sides = np.repeat([[1, 1], [1, 3]], half, axis=0)
    kind = np.repeat([CRACK, 0], half).astype(np.int8)
    after, done = opened(Surface(points, facets, sides, kind))
    on_crack = np.unique(after.facets[after.kind == CRACK])
    above = np.setdiff1d(after.facets, on_crack)
    inside = above[np.linalg.norm(after.points[above, :2], axis=1) < 1.8]
    assert done["gap_openings"] >= len(inside) == 37
    assert after.points[inside, 2].min() == pytest.approx(GAP * 0.5)
    assert (after.points[on_crack, 2] == 0).all()


@pytest.mark.parametrize("turn", [1, -1])
def test_a_facet_close_to_the_crack_front_moves_away(turn):
    tip = [[0, 0, 0], [-1, 0.5, 0], [-1, -0.5, 0]]
    over = [[0.8, 0.7, 0.04], [-1.6, 0, 0.04], [0.8, -0.7, 0.04]]
    points = np.array(tip + over, float)
    facets = np.array([[0, 1, 2], [3, 4, 5][::turn]])
    surface = Surface(points * [1, 1, turn], facets, [[1, 1], [1, 2]], [CRACK, 0])
    after, done = opened(surface)
    a, b, c = after.points[after.facets[1]]
    normal = np.cross(b - a, c - a)
    assert done["front_openings"] > 0
    assert abs(np.dot(a, normal)) / np.linalg.norm(normal) == pytest.approx(FRONT_GAP * 0.5, abs=1e-3)
    assert (after.points[:3] == surface.points[:3]).all()
    assert (after.points[3:, 2] * turn >= 0.04).all()


def test_facets_beside_the_crack_front_stay():
    points = np.array(
        [[0, 0, 0], [-1, 0.5, 0], [-1, -0.5, 0], [0.3, 0.7, 0.04], [0.3, -0.7, 0.04], [1, 0, 0]]
    )
    surface = Surface(points, [[0, 1, 2], [3, 4, 5]], [[1, 1], [1, 2]], [CRACK, 0])
    after, done = opened(surface)
    assert done == {} and (after.points == points).all()


def test_a_boundary_that_goes_on_in_the_plane_of_the_crack_stays_in_it():
    """Beyond the front at x = 0 a boundary goes on; a vertex of another one lies over the crack."""
    points = [
        [0, -0.3, 0],
        [0, 0.3, 0],
        [-0.5, 0, 0],
        [0.15, 0, 0],
        [-0.2, 0, 0.05],
        [-1, 0.4, 0.6],
        [0.6, 0.4, 0.7],
    ]
    facets = [[0, 1, 2], [0, 3, 1], [4, 5, 6]]
    surface = Surface(np.array(points, float), facets, [[1, 1], [1, 2], [1, 3]], [CRACK, 0, 0])
    after, done = opened(surface)
    assert done["gap_openings"] > 0 and after.points[4, 2] > 0.1
    assert (after.points[:4] == surface.points[:4]).all()
