"""No operation makes a wedge sharper than its limit and than what was there: against plain arithmetic."""

import numpy as np
import pytest
from few_facets import fan, prepared, sheet, tried
from hypothesis import given, settings
from hypothesis import strategies as st
from random_cases import random_case
from unchanged import OPEN, frozen

from craftmesh import Surface, gradate
from craftmesh.gradation.kernels.guards import refusal
from craftmesh.gradation.kernels.one_pass import COLLAPSE, SWAP, one_pass
from craftmesh.gradation.kernels.result_codes import DONE, WEDGE
from craftmesh.gradation.kernels.sheets import no_sheet, set_rows
from craftmesh.gradation.kernels.star import star_at
from craftmesh.gradation.kernels.wedge_guard import sharpens_wedge
from craftmesh.surface.kernels.corner_lists import corner_lists
from craftmesh.surface.kernels.hinges import SHARP_COSINE, SHARP_WEDGE, sharpest_cosines
from craftmesh.surface.wedges import sharp_wedges

GUARDED = OPEN._replace(wedge=SHARP_COSINE)
# Two facets in z = 0 on the edge 0 1, and one of another patch that leans over the first by 30 degrees.
LEANING = [[0, 0, 0], [1, 0, 0], [0.5, 1, 0], [0.5, -1, 0], [0.5, np.cos(np.pi / 6), np.sin(np.pi / 6)]]
WEDGE_FACETS = [[0, 1, 2], [1, 0, 3], [0, 1, 4]]


def leaning(angle: float = 30.0) -> Surface:
    points = np.array(LEANING)
    points[4, 1:] = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    return sheet(WEDGE_FACETS, [(1, 2), (1, 3), (3, 2)], points=points)


def least_angle(points: np.ndarray, facets: np.ndarray) -> float:
    """Return the least angle in degrees between facets on a common edge, by their arms across it."""
    least = 180.0
    for i, f in enumerate(facets):
        for g in facets[:i]:
            shared = [v for v in f if v in g]
            if len(shared) != 2:
                continue
            a, b = points[shared]
            arms = [points[[v for v in h if v not in shared][0]] - a for h in (f, g)]
            along = (b - a) / np.linalg.norm(b - a)
            arms = [arm - (arm @ along) * along for arm in arms]
            cosine = arms[0] @ arms[1] / np.linalg.norm(arms[0]) / np.linalg.norm(arms[1])
            least = min(least, np.degrees(np.arccos(np.clip(cosine, -1, 1))))
    return least


def turned_at_random(rng, facets: np.ndarray) -> np.ndarray:
    return np.array([np.roll(f[:: rng.choice([1, -1])], rng.integers(3)) for f in facets])


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1))
def test_sharpest_cosines_are_those_of_the_arms(seed):
    rng = np.random.default_rng(seed)
    points = rng.uniform(-1, 1, (6, 3))
    corners = np.array([[i, j, k] for i in range(6) for j in range(i) for k in range(j)])
    facets = turned_at_random(rng, rng.permutation(corners)[:6])
    found = sharpest_cosines(points, facets, *corner_lists(facets, len(points)))
    assert max(found.max(), -1.0) == pytest.approx(np.cos(np.radians(least_angle(points, facets))))


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.integers(3, 7), st.integers(0, 4))
def test_a_move_is_refused_where_the_arms_say_so(seed, count, others):
    """The hub of a fan moves; facets of other patches stand on its rim."""
    rng = np.random.default_rng(seed)
    round_hub = fan(count)
    apex = np.concatenate([round_hub.points, rng.uniform(-1, 1, (others, 3))])
    foreign = [[i + 1, (i + 1) % count + 1, count + 1 + i] for i in range(min(others, count))]
    facets = turned_at_random(rng, np.array([*round_hub.facets.tolist(), *foreign]))
    surface = sheet(facets, points=apex[: facets.max() + 1])
    state, (mesh, _) = prepared(surface)
    star = star_at(mesh, 0)
    state.mesh.points[star.tip] = place = rng.uniform(-0.5, 0.5, 3)
    set_rows(mesh, star)
    moved = surface.points.copy()
    moved[0] = place
    # Only the fan's hinges, as the star's own: those of the rim's other facets alone stay what they are.
    after, before = least_angle(moved, facets), least_angle(surface.points, facets)
    for limit in (5.0, 30.0, 90.0):
        wanted = after < limit and after < before
        assert sharpens_wedge(mesh, star, no_sheet(), np.cos(np.radians(limit))) == wanted


def test_a_vertex_beside_a_junction_line_makes_no_sharp_wedge():
    for height, reason in ((0.3, DONE), (0.1, WEDGE)):
        state, references = prepared(leaning())
        before = frozen(state)
        star = star_at(references[0], 4)
        state.mesh.points[star.tip, 2] = height
        assert refusal(*references, GUARDED, star, 0.0, 0.0) == reason
        assert frozen(state) == before


def test_a_sharp_wedge_of_the_input_may_open_and_not_close():
    for angle, reason in ((5.0, DONE), (3.0, WEDGE), (11.0, DONE)):
        state, references = prepared(leaning(4.0))
        turn = np.radians(angle)
        place = np.array([0.5, np.cos(turn), np.sin(turn)])
        star = star_at(references[0], 4)
        state.mesh.points[star.tip] = place
        assert refusal(*references, GUARDED, star, 0.0, 0.0) == reason


def test_a_vertex_folds_no_patch():
    state, references = prepared(fan(6))
    star = star_at(references[0], 0)
    state.mesh.points[star.tip] = [0.0, 0.0, 0.2]
    assert refusal(*references, GUARDED, star, 0.0, 0.0) == DONE
    # High over its rim's middle, every facet stands, and those across from each other face each other.
    state, references = prepared(sheet([[0, 1, 2], [1, 0, 3]], points=LEANING[:4]))
    star = star_at(references[0], 3)
    state.mesh.points[star.tip] = [0.5, 1, 0.1]
    assert refusal(*references, GUARDED, star, 0.0, 0.0) == WEDGE
    assert refusal(*references, OPEN, star, 0.0, 0.0) == DONE


def test_a_collapse_closes_no_wedge():
    """Vertex 3 holds the fan's edge 1 2 away from a facet that lies 2 degrees under its chord."""
    low = [0.5, np.cos(np.radians(2)), -np.sin(np.radians(2))]
    points = [[0, 0, 0], [1, 0, 0], [0.2, 1, 0], [0.8, 1, 0.0], [0.5, 0.5, 0.4], low]
    facets = [[0, 1, 4], [1, 3, 4], [3, 2, 4], [2, 0, 4], [0, 1, 5]]
    surface = sheet(facets, [(1, 2)] * 4 + [(2, 3)], points=points)
    for limits, reason in ((OPEN, DONE), (GUARDED, WEDGE)):
        _, references = prepared(surface)
        assert tried(references, limits, COLLAPSE, (3, 4)) == reason


def test_a_swap_closes_no_wedge():
    """Under the ridge 0 1 lies a facet of another patch, just below the plane of 1, 2 and 3."""
    points = [[-1, 0, 0.0], [1, 0, 0.0], [0, 0.6, -0.5], [0, -0.6, -0.5], [1 / 3, 0, -1 / 3 - 0.02]]
    facets = [[0, 1, 2], [1, 0, 3], [1, 2, 4]]
    surface = sheet(facets, [(1, 2)] * 2 + [(1, 3)], points=points)
    edge = np.array([[0, 1]])
    for limits, count in ((OPEN, 1), (GUARDED, 0)):
        state, references = prepared(surface)
        assert one_pass(*references, limits, SWAP, edge, 0.0, 0)[1] == count
        assert state.scratch.refused[WEDGE] == 1 - count


@pytest.mark.parametrize("seed", [3, 8, 21])
def test_no_wedge_of_a_gradated_surface_is_sharp_without_one_in_the_input(seed):
    case = random_case(seed)
    before = sharp_wedges(case.surface).angle
    after, report = gradate(case.surface, case.sizing, case.options)
    found = sharp_wedges(after)
    assert report["wedges_under_12_degrees"] == [len(before), len(found.angle)]
    assert found.angle.min(initial=SHARP_WEDGE) >= before.min(initial=SHARP_WEDGE) - 1e-6
