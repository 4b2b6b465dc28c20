"""No operation makes a gap narrower than its limit and than what was there: against plain arithmetic."""

import numpy as np
import pytest
from few_facets import fan, prepared, sheet
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from random_cases import random_case
from unchanged import OPEN, frozen

from craftmesh import Surface, gradate
from craftmesh.gradation.cleaning import SHARPEST, collapse_sharpest, loosened
from craftmesh.gradation.kernels.codes import DONE, GAP, INTERSECTION
from craftmesh.gradation.kernels.collapse import collapse_edge
from craftmesh.gradation.kernels.gaps import (
    edge_of_area,
    height_over,
    is_farther,
    is_on_one_side,
    may_overlap,
    unit_normal,
)
from craftmesh.gradation.kernels.guards import refusal
from craftmesh.gradation.kernels.intersections import set_planes
from craftmesh.gradation.kernels.star import star_at
from craftmesh.gradation.kernels.swap import swap_pass
from craftmesh.gradation.passes import LEAST_GAP, Gradation, edges_to_swap, filled_grid, swap_all
from craftmesh.surface.measure import facet_angles

GUARDED = OPEN._replace(gap=LEAST_GAP)
# Of LEAST_GAP: what gaps may end at. Splits put new vertices between facets that are near, and the
# restoring of volumes moves all vertices after the guards.
LEFT = 0.6


def over_facet(vertex: np.ndarray, corners: np.ndarray) -> float:
    """Return a vertex's height over a facet by the edge of an equilateral one; infinite beside it."""
    area = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    normal = area / np.linalg.norm(area)
    arms = corners - (vertex - (vertex - corners[0]) @ normal * normal)
    if any(np.cross(arms[k], arms[k - 2]) @ normal < 0 for k in range(3)):
        return np.inf
    height = abs((vertex - corners[0]) @ normal)
    return height / np.sqrt(2 * np.linalg.norm(area) / np.sqrt(3))


def of_edges(one: np.ndarray, other: np.ndarray) -> float:
    """Return the distance of edges that cross by the root of the area that they span, else infinity."""
    d, e = one[1] - one[0], other[1] - other[0]
    across = np.cross(d, e)
    s, t, height = np.linalg.solve(np.stack([d, -e, across], axis=1), other[0] - one[0])
    distance = abs(height) * np.linalg.norm(across)
    if not (0 < s < 1 and 0 < t < 1):
        return np.inf
    return distance / np.sqrt(np.linalg.norm(across))


def least_gap(points: np.ndarray, star: np.ndarray, others: np.ndarray) -> float:
    """Return the narrowest gap of point 0 and its facets `star` to the facets `others`."""
    found = [over_facet(points[0], points[f]) for f in others]
    found += [over_facet(points[v], points[f]) for f in star for v in np.unique(others)]
    edges = [points[[f[k - 1], f[k]]] for f in others for k in range(3)]
    found += [of_edges(points[[0, v]], edge) for v in np.unique(star)[1:] for edge in edges]
    return min(found)


@settings(deadline=None, max_examples=80)
@given(st.integers(0, 2**32 - 1), st.integers(4, 7))
def test_a_move_is_refused_where_arithmetic_says_so(seed, count):
    """The hub of a fan moves among loose facets that stand over it."""
    rng = np.random.default_rng(seed)
    alone = fan(count)
    # Their edges are shorter than the fan's, so that all gaps that count are within the guard's reach.
    centre = rng.uniform([-0.6, -0.6, 0.1], [0.6, 0.6, 0.4], (2, 1, 3))
    loose = centre + rng.uniform(-0.35, 0.35, (2, 3, 3)) * [1, 1, 0.3]
    points = np.concatenate([alone.points, loose.reshape(-1, 3)])
    others = count + 1 + np.arange(6).reshape(2, 3)
    sides = [(1, 2)] * count + [(2, 3)] * 2
    surface = sheet([*alone.facets.tolist(), *others.tolist()], sides, points=points)
    state, references = prepared(surface)
    star = star_at(references[0], 0)
    moved = points.copy()
    moved[0] = state.mesh.points[star.tip] = rng.uniform(-0.3, 0.3, 3) * [1, 1, 0.5]
    reason = refusal(*references, GUARDED, star, 0.0)
    assume(reason != INTERSECTION)
    before, after = (least_gap(where, alone.facets, others) for where in (points, moved))
    assert reason == (GAP if after < LEAST_GAP and after < before else DONE)


def under_roof(height: float) -> Surface:
    """A fan round point 0 with a facet of another patch that lies `height` over its hub."""
    roof = [[-0.5, -0.3, height], [0.5, -0.3, height], [0.0, 0.6, height]]
    surface = fan(6)
    facets = [*surface.facets.tolist(), [7, 8, 9]]
    points = np.concatenate([surface.points, roof])
    return sheet(facets, [(1, 2)] * 6 + [(2, 3)], points=points)


def test_a_gap_of_the_input_may_open_and_not_close():
    for height, reason in ((-0.05, DONE), (0.02, GAP), (0.05, GAP)):
        state, references = prepared(under_roof(0.1))
        before = frozen(state)
        star = star_at(references[0], 0)
        state.mesh.points[star.tip] = [0.0, 0.0, height]
        assert refusal(*references, GUARDED, star, 0.0) == reason
        assert refusal(*references, OPEN, star, 0.0) == DONE
        assert frozen(state) == before


def test_a_collapse_makes_no_gap():
    """Point 4 holds a sheet away from a facet that lies 0.05 under the chord of its neighbours."""
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0.5, 0.5, 0.4]]
    points += [[0.2, 0.3, 0.05], [0.8, 0.3, 0.05], [0.5, 0.6, 0.05]]
    facets = [[0, 1, 4], [1, 3, 4], [3, 2, 4], [2, 0, 4], [5, 6, 7]]
    surface = sheet(facets, [(1, 2)] * 4 + [(2, 3)], points=points)
    below = surface.points.copy()
    below[5:, 2] = -0.05
    surface = Surface(below, surface.facets, surface.sides, surface.kind)
    for limits, reason in ((OPEN, DONE), (GUARDED, GAP)):
        _, references = prepared(surface)
        assert collapse_edge(*references, limits, 3, 4) == reason


@pytest.mark.parametrize("depth, left", [(0.06, 0), (0.03, 2)])
def test_sharp_needles_go_at_last_where_gaps_stay_over_a_part_of_the_least(depth, left):
    """Needles at points 3 and 4 hold a sheet a little farther away from a facet that lies under it."""
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0.97, 0.97, 0.04]]
    points += [[0.2, 0.3, -depth], [0.8, 0.3, -depth], [0.5, 0.6, -depth]]
    facets = [[0, 1, 4], [1, 3, 4], [3, 2, 4], [2, 0, 4], [5, 6, 7]]
    surface = sheet(facets, [(1, 2)] * 4 + [(2, 3)], points=points)
    _, references = prepared(surface)
    assert collapse_edge(*references, GUARDED, 3, 4) == GAP
    state, _ = prepared(surface)
    gradation = Gradation(state, filled_grid(state.mesh), {})
    collapse_sharpest(gradation, loosened(GUARDED, 1, 1))
    corners = state.mesh.facets[gradation.living(on_crack=False)]
    assert (facet_angles(state.mesh.points, corners).min(axis=1) < SHARPEST).sum() == left


def test_a_swap_makes_no_gap():
    """Under the ridge 0 1 lies a facet of another patch, just below the edge that would replace it."""
    points = [[-1, 0, 0.0], [1, 0, 0.0], [0, 0.6, -0.5], [0, -0.6, -0.5]]
    points += [[-0.5, 0, -0.53], [0.5, 0.1, -0.53], [0.5, -0.1, -0.53]]
    surface = sheet([[0, 1, 2], [1, 0, 3], [4, 5, 6]], [(1, 2)] * 2 + [(1, 3)], points=points)
    edge = np.array([[0, 1]])
    for limits, count in ((OPEN, 1), (GUARDED, 0)):
        state, references = prepared(surface)
        assert swap_pass(*references, limits, edge, 0)[1] == count
        assert state.scratch.refused[GAP] == 1 - count


def test_facets_on_a_common_edge_make_no_gap():
    """A swap beside a corner of a box: the new edge goes from just above it to the end of its edge."""
    points = [[0, 0, 0], [0, 1, 0], [0, 0.3, 1.2], [0, 0, 0.1], [1, 1, 0], [1, 0, 0]]
    facets = [[0, 1, 2], [0, 2, 3], [1, 0, 4], [4, 0, 5]]
    surface = sheet(facets, [(1, 2)] * 2 + [(1, 3)] * 2, points=points)
    assert of_edges(surface.points[[1, 3]], surface.points[[0, 4]]) < LEAST_GAP
    state, references = prepared(surface)
    assert swap_pass(*references, GUARDED, np.array([[0, 2]]), 0)[1] == 1
    assert state.scratch.refused[GAP] == 0


def narrow_gaps(surface: Surface, share: float) -> int:
    """Return how many vertices stand over facets that they are not joined to, nearer than the share."""
    facets, count = surface.facets, 0
    centres = surface.points[facets].mean(axis=1)
    reach = np.linalg.norm(surface.points[facets] - centres[:, None], axis=2).max(axis=1) * (1 + share)
    rims = [set(facets[(facets == v).any(axis=1)].ravel().tolist()) for v in range(len(surface.points))]
    for f, corners in enumerate(facets.tolist()):
        near = np.flatnonzero(np.linalg.norm(surface.points - centres[f], axis=1) < reach[f])
        joined = set(corners) | {v for v in near.tolist() if len(rims[v] & set(corners)) > 1}
        places = surface.points[corners]
        count += sum(over_facet(surface.points[v], places) < share for v in near if v not in joined)
    return count


@pytest.mark.sampled(3)
@pytest.mark.parametrize("seed", [3, 8, 21])
def test_a_gradated_surface_has_no_narrow_gap_without_one_in_the_input(seed):
    case = random_case(seed)
    after, report = gradate(case.surface, case.sizing, case.options)
    assert narrow_gaps(after, LEFT * LEAST_GAP) <= narrow_gaps(case.surface, LEAST_GAP)
    assert "gap" in report["refusals"]


@settings(deadline=None, max_examples=200)
@given(st.integers(0, 2**32 - 1), st.integers(0, 1), st.floats(0.01, 0.5))
def test_quick_looks_say_no_more_than_the_whole_one(seed, shared, reach):
    """What lies on one side of a facet cannot overlap it, what is farther is not within the share."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(-1, 1, (6, 3)) * [1, 1, rng.choice([0.1, 1.0])]
    facets, planes = np.array([[0, 1, 2], [0 if shared else 3, 4, 5]]), np.empty((4, 5))
    set_planes(points, facets[0], planes)
    normal = unit_normal(points, 0, 1, 2)
    one_side = is_on_one_side(points, normal, facets[0], facets[1], reach)
    heights = np.array([height_over(points, planes, 0, v) for v in facets[1][shared:]])
    assert one_side == ((heights > reach).all() or (heights < -reach).all())
    assert not (one_side and may_overlap(points, planes, 0, 1, 2, facets, 1, reach))
    width = abs(height_over(points, planes, 0, 4)) / edge_of_area(points, 0, 1, 2)
    assert is_farther(points, 0, 1, 2, 4, reach) == (width > reach)


def test_later_swaps_look_at_facets_that_have_changed_alone():
    surface = fan(7, hub=(0.1, 0.05, 0.0))
    gradation = Gradation(prepared(surface)[0], filled_grid(prepared(surface)[0].mesh), {})
    limits = OPEN._replace(cosine=0.5)
    swap_all(gradation, limits)
    assert not len(edges_to_swap(gradation, gradation.swapped.limits))
    assert len(edges_to_swap(gradation, limits._replace(cosine=0.4))) == 7
    gradation.mesh.points[3] *= 1.1
    around = {tuple(edge) for edge in edges_to_swap(gradation, gradation.swapped.limits).tolist()}
    assert around == {(0, 2), (0, 3), (0, 4), (2, 3), (3, 4)}
