"""No facet turns past another round a common edge: against the order of angles, on three facets."""

import numpy as np
import pytest
from few_facets import prepared, sheet
from hypothesis import given, settings
from hypothesis import strategies as st
from unchanged import OPEN

from craftmesh import Surface
from craftmesh.gradation.kernels.codes import DONE, INTERSECTION
from craftmesh.gradation.kernels.guards import refusal
from craftmesh.gradation.kernels.order_guard import breaks_order
from craftmesh.gradation.kernels.star import star_at

# The facets on the edge 0 1 run along it but for the second; grain 3 is under z = 0, 1 is in front of the
# facet that leans, 2 behind it. A crack facet leans within grain 1.
FACETS = [[0, 1, 2], [1, 0, 3], [0, 1, 4]]
BOUNDARY = [(3, 1), (3, 2), (1, 2)]
CRACK = [(3, 1), (3, 1), (1, 1)]
ANGLES = st.floats(1.0, 179.0)


def at_angle(degrees: float) -> np.ndarray:
    return np.array([0.5, np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])


def leaning(degrees: float, sides: list, turned: bool) -> Surface:
    points = np.array([[0, 0, 0], [1, 0, 0], at_angle(0), at_angle(180), at_angle(degrees)])
    facets = FACETS if not turned else [*FACETS[:2], FACETS[2][::-1]]
    sides = sides if not turned else [*sides[:2], sides[2][::-1]]
    return sheet(facets, sides, points=points)


def moved(surface: Surface, place: np.ndarray):
    """Return the state, and its star with the leaning facet's own corner at a place."""
    state, (mesh, grid) = prepared(surface)
    star = star_at(mesh, 4)
    state.mesh.points[star.tip] = place
    return mesh, grid, star


@settings(deadline=None, max_examples=60)
@given(ANGLES, ANGLES, st.booleans(), st.booleans(), st.sampled_from([BOUNDARY, CRACK]))
def test_a_facet_may_lean_as_far_as_its_neighbours(before, after, below, turned, sides):
    surface = leaning(before, sides, turned)
    mesh, _, star = moved(surface, at_angle(-after if below else after))
    assert breaks_order(mesh, star) == below


@settings(deadline=None, max_examples=20)
@given(ANGLES, ANGLES)
def test_what_is_out_of_order_may_be_so(before, after):
    surface = leaning(-before, BOUNDARY, False)
    mesh, _, star = moved(surface, at_angle(-after))
    assert not breaks_order(mesh, star)


@pytest.mark.parametrize("degrees, answer", [(60.0, DONE), (-60.0, INTERSECTION)])
def test_a_move_past_a_neighbour_is_refused(degrees, answer):
    mesh, grid, star = moved(leaning(30.0, CRACK, False), at_angle(degrees))
    assert refusal(mesh, grid, OPEN, star, -np.inf) == answer
