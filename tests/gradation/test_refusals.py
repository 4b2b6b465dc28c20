"""Edges of surfaces of a few facets that must not change: the reason comes back, the mesh stays."""

from typing import NamedTuple

import numpy as np
import pytest
from few_facets import BOX, double_cone, fan, prepared, sheet, tried
from unchanged import OPEN, frozen

from craftmesh.gradation.kernels.one_pass import COLLAPSE, SWAP, one_pass
from craftmesh.gradation.kernels.result_codes import (
    ANGLE,
    CHORD,
    CONSTRAINT,
    DISTANCE,
    DONE,
    EAR,
    GRAIN_CONTACT,
    INTERSECTION,
    JUNCTION,
    JUNCTION_TRIANGLE,
    LINK,
    NO_NEED,
    NORMAL,
    ON_CRACK,
    ON_FRONT,
)
from craftmesh.gradation.kernels.split import split
from craftmesh.gradation.passes import Gradation, Limits, filled_grid
from craftmesh.gradation.state import make_state
from craftmesh.kernel_structs import by_reference
from craftmesh.types import CRACK, INTERFACE, Surface

INF = float("inf")
# No normal is near enough to another.
STRICT = OPEN._replace(cosine=2.0)

# The edge 0 1 bounds two contacts that go on beside it at 1 only, and facets of grain 3 hang on either end.
CONTACTS = [[0, 1, 2], [1, 8, 2], [1, 0, 3], [1, 3, 9], [0, 4, 5], [1, 6, 7]]
CONTACT_SIDES = [(1, 2), (1, 2), (1, 4), (1, 4), (3, 1), (3, 2)]


class Case(NamedTuple):
    """An edge of a surface, and why it may not collapse where junction points may merge or not."""

    surface: Surface
    edge: tuple[int, int]
    merge_points: bool
    reason: int
    limits: Limits = OPEN


QUAD = [[0, 1, 2], [0, 2, 3]]
# A grain boundary around vertex 0, two vertices of crack facets below it, and two above it.
BOUNDARY = fan(5).facets.tolist()
AROUND = np.concatenate([fan(5).points, [[0.0, 0.9, -0.2], [0, -0.5, -0.2], [-2, 0, 1], [-2, 0, 2]]])
OF_CRACKS = [(1, 2)] * 5 + [(1, 1)] * 2, [INTERFACE] * 5 + [CRACK] * 2
COLLAPSES = {
    "across a patch from line to line": Case(sheet(QUAD), (0, 2), False, JUNCTION),
    "and lines that meet nowhere": Case(sheet(QUAD), (0, 2), True, JUNCTION),
    "across the crack from rim to rim": Case(sheet(QUAD, (1, 1), CRACK), (0, 2), True, JUNCTION),
    "between junction points": Case(
        sheet([[0, 1, 2], [1, 0, 3]], [(1, 2), (1, 3)]), (0, 1), False, JUNCTION
    ),
    "between two planes of the box": Case(BOX, (0, 1), True, CONSTRAINT),
    "under two facets with the same corners": Case(sheet([[0, 1, 2], [1, 0, 2]]), (0, 1), False, LINK),
    "of vertices that no edge joins": Case(sheet(QUAD), (1, 3), False, LINK),
    "of a waist of three edges": Case(double_cone(3), (0, 1), False, LINK),
    "of a tetrahedron": Case(
        sheet([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], (1, 0)), (0, 1), False, LINK
    ),
    "of a facet between lines": Case(sheet([[0, 1, 2]]), (0, 1), False, JUNCTION_TRIANGLE),
    "of one that is no remnant": Case(sheet([[0, 1, 2]]), (0, 1), True, JUNCTION_TRIANGLE),
    "of a crack between junction points": Case(
        sheet(
            [[0, 1, 2], [0, 1, 3], [1, 6, 3], [1, 2, 4], [2, 0, 5]],
            [(1, 1), (1, 2), (1, 2), (1, 3), (1, 4)],
            [CRACK] + [INTERFACE] * 4,
        ),
        (0, 1),
        True,
        JUNCTION_TRIANGLE,
    ),
    "that would make a grain touch itself": Case(
        sheet(CONTACTS, CONTACT_SIDES), (0, 1), True, GRAIN_CONTACT
    ),
    "with that grain at one end only": Case(
        sheet(CONTACTS[:5] + [[4, 6, 7]], CONTACT_SIDES), (0, 1), True, NORMAL, STRICT
    ),
    "from inside the crack onto its front": Case(fan(5, sides=(1, 1), kind=CRACK), (1, 0), False, EAR),
    "that would join crack vertices along the crack": Case(
        sheet([*BOUNDARY, [1, 6, 7], [3, 8, 9]], *OF_CRACKS, AROUND), (1, 0), False, CHORD
    ),
    "that joins them far off the crack": Case(
        sheet([*BOUNDARY, [1, 8, 9], [3, 8, 9]], *OF_CRACKS, AROUND), (1, 0), False, NORMAL, STRICT
    ),
    "that joins them on an edge that is there": Case(
        sheet([*BOUNDARY, [1, 6, 7], [2, 8, 9]], *OF_CRACKS, AROUND), (1, 0), False, NORMAL, STRICT
    ),
    "that leaves a crack of one facet": Case(
        fan(3, sides=(1, 1), kind=CRACK), (1, 0), False, NORMAL, STRICT
    ),
    "that leaves one with a rim at the outside": Case(
        sheet(
            [[0, 1, 2], [0, 2, 3], [0, 3, 1], [2, 1, 4]],
            [(1, 1)] * 3 + [(1, 0)],
            [CRACK] * 3 + [INTERFACE],
            np.concatenate([fan(3).points, [[1.0, 1, 1]]]),
        ),
        (1, 0),
        False,
        EAR,
    ),
}


@pytest.mark.parametrize("case", COLLAPSES.values(), ids=COLLAPSES)
def test_edges_that_may_not_collapse_say_why(case):
    state, references = prepared(case.surface)
    before = frozen(state)
    limits = case.limits._replace(merge_points=case.merge_points)
    assert tried(references, limits, COLLAPSE, case.edge) == case.reason
    assert frozen(state) == before


@pytest.mark.parametrize("case", COLLAPSES.values(), ids=COLLAPSES)
def test_either_end_may_come_first(case):
    _, references = prepared(case.surface)
    a, b = case.edge
    limits = case.limits._replace(merge_points=case.merge_points)
    assert tried(references, limits, COLLAPSE, (b, a)) == case.reason


@pytest.mark.parametrize(
    "room, reason",
    [
        ({"star": 4, "dying": 2, "loose": 8}, DONE),
        ({"star": 1}, LINK),
        ({"dying": 1}, LINK),
        ({"star": 3}, DISTANCE),
        ({"loose": 4}, DISTANCE),
    ],
)
def test_a_collapse_without_the_room_to_check_it_is_refused(room, reason):
    state, references = prepared(double_cone(5), **room)
    # Vertex 3, far from the edge, stands for one that went and left its first place to a facet on the edge.
    state.guards.witness_first[5], state.guards.is_witness[3] = 3, True
    before = frozen(state)
    assert tried(references, OPEN._replace(distance=10.0), COLLAPSE, (0, 1)) == reason
    assert (frozen(state) == before) == (reason != DONE)


RHOMBUS = [[-2, 0, 0], [2, 0, 0], [0, 1, 0], [0, -1, 0]]
BENT = [[-2, 0, 0], [2, 0, 0], [0, 1, 1], [0, -1, 1], [0, 3, 1]]
PAIR = [[2, 0, 1], [3, 1, 0]]
APART = [*RHOMBUS, [-0.5, -0.8, -0.2], [0.5, -0.8, -0.2], [0, -2, 1], [0, -2, 2]]
SWAPS = {
    "free": (sheet(PAIR, points=RHOMBUS), {}, DONE),
    "facets turned against each other": (sheet([[2, 0, 1], [3, 0, 1]], points=RHOMBUS), {}, NO_NEED),
    "two patches": (sheet(PAIR, [(1, 2), (1, 3)], points=RHOMBUS), {}, NO_NEED),
    "new edge there already": (sheet([*PAIR, [2, 3, 4]], points=[*RHOMBUS, [0, 0, 5]]), {}, LINK),
    "from front to front": (sheet(PAIR, (1, 1), CRACK, RHOMBUS), {}, EAR),
    "from crack to crack": (
        sheet(
            [*PAIR, [2, 4, 5], [3, 6, 7]], [(1, 2)] * 2 + [(1, 1)] * 2, [INTERFACE] * 2 + [CRACK] * 2, APART
        ),
        {},
        CHORD,
    ),
    "bent": (sheet(PAIR, points=BENT[:4]), {"distance": 0.5}, DISTANCE),
    "bent crack": (
        sheet([*PAIR, [2, 1, 4], [2, 4, 0]], (1, 1), CRACK, BENT * np.array([1, 1, 0.2])),
        {"distance": 2.0, "crack_distance": 0.1},
        DISTANCE,
    ),
}


@pytest.mark.parametrize("surface, limits, reason", SWAPS.values(), ids=SWAPS)
def test_edges_that_may_not_turn_are_counted_by_reason(surface, limits, reason):
    state, references = prepared(surface)
    before = frozen(state)
    edge = np.array([[0, 1]])
    stopped, done = one_pass(*references, OPEN._replace(**limits), SWAP, edge, 0.0, 0)
    assert (stopped, done) == (1, reason == DONE)
    assert (frozen(state) == before) == (reason != DONE)
    assert state.scratch.refused.sum() == (reason >= 0)
    assert reason < 0 or state.scratch.refused[reason] == 1


def test_a_split_is_refused_without_room_and_where_the_front_is_out_of_reach():
    state, references = prepared(fan(5), dying=1)
    before = frozen(state)
    assert split(*references, OPEN, 0, 1, 0.0) == LINK
    assert frozen(state) == before
    state, references = prepared(fan(5, sides=(1, 1), kind=CRACK))
    assert split(*references, OPEN._replace(floor=INF), 0, 1, 2.0) == ANGLE
    # The front of the input stays behind its vertex, so that the new one leaves the edge for it.
    state.mesh.points[1] += (0.2, 0.0, 0.1)
    before = frozen(state)
    assert split(*references, STRICT, 1, 2, 0.0) == NORMAL
    assert frozen(state) == before


def test_a_split_of_the_front_puts_the_vertex_on_it():
    surface = fan(5, sides=(1, 1), kind=CRACK)
    state, references = prepared(surface)
    gradation = Gradation(state, filled_grid(state.mesh), {})
    gradation.make_room()
    mesh = gradation.mesh
    mesh.points[1] += (0.2, 0.0, 0.1)
    references = by_reference(*gradation.state), by_reference(filled_grid(mesh))
    assert split(*references, OPEN, 1, 2, 0.0) == DONE
    p, q = surface.points[[1, 2]]
    place = mesh.points[6] - p
    assert mesh.used.tolist() == [7, 6] and mesh.flags[6] == ON_CRACK | ON_FRONT and mesh.rank[6] == 1
    assert np.allclose(np.cross(place, q - p), 0.0) and 0 < place @ (q - p) < (q - p) @ (q - p)


@pytest.mark.parametrize("room, corners", [({}, {1, 2, 6}), ({"loose": 4}, {0, 2, 6})])
def test_halves_share_witnesses_where_there_is_room(room, corners):
    state, _ = prepared(fan(5), **room)
    gradation = Gradation(state, filled_grid(state.mesh), {})
    gradation.make_room()
    guards = gradation.state.guards
    # Point 3 stands for a vertex of the rim that left its first place to facet 0 1 2.
    guards.witness_first[0], guards.is_witness[3] = 3, True
    references = by_reference(*gradation.state), by_reference(gradation.grid)
    assert split(*references, OPEN, 0, 1, 0.0) == DONE
    (holder,) = np.flatnonzero(guards.witness_first == 3)
    # With room it goes to the half on the rim; without, it stays with the one that keeps the facet's row.
    assert set(gradation.mesh.facets[holder].tolist()) == corners


def test_a_collapse_near_more_facets_than_a_query_may_find_is_refused():
    state = make_state(double_cone(5), np.ones(7))
    grid = filled_grid(state.mesh)
    grid = grid._replace(candidate=grid.candidate[:1].copy())
    before = frozen(state)
    references = by_reference(*state), by_reference(grid)
    assert tried(references, OPEN, COLLAPSE, (0, 1)) == INTERSECTION
    assert frozen(state) == before
