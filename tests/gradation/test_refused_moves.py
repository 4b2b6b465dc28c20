"""Vertices of small fans that move, or must not: the reason comes back, the mesh stays; passes count it."""

import numpy as np
import pytest
from few_facets import BOX, fan, off_centre, prepared, sheet, tried
from structured_box import structured_box
from unchanged import OPEN, frozen

from craftmesh.gradation.kernels.guards import attempt
from craftmesh.gradation.kernels.one_pass import (
    COLLAPSE,
    EVEN,
    RELAX,
    SLIDE,
    SPLIT,
    SWAP,
    one_pass,
)
from craftmesh.gradation.kernels.result_codes import (
    DISTANCE,
    DONE,
    INTERSECTION,
    LINK,
    NO_NEED,
    NORMAL,
)
from craftmesh.gradation.kernels.star import star_at
from craftmesh.gradation.passes import filled_grid
from craftmesh.gradation.state import make_state
from craftmesh.kernel_structs import by_reference
from craftmesh.types import CRACK, Surface

INF = float("inf")
# No facet keeps a normal so well: every change is refused.
NEVER = {"cosine": 2.0}


def slides(references, limits, v) -> int:
    """Slide `v` where every angle counts as unsound, for fronts too."""
    return tried(references, limits._replace(floor=INF), SLIDE, (v,), INF)


def evens(references, limits, v) -> int:
    return tried(references, limits, EVEN, (v,))


def relaxes(references, limits, v) -> int:
    return tried(references, limits, RELAX, (v,))


def test_front_vertices_stay_where_their_angles_are_sound():
    state, references = prepared(off_centre(sides=(1, 1), kind=CRACK))
    before = frozen(state)
    assert tried(references, OPEN, SLIDE, (1,), INF) == NO_NEED
    assert frozen(state) == before


@pytest.mark.parametrize("classes", [{}, {"sides": (1, 1), "kind": CRACK}], ids=["contact", "crack"])
@pytest.mark.parametrize("operation, v", [(slides, 0), (slides, 1), (evens, 1), (relaxes, 0)])
@pytest.mark.parametrize(
    "room, limits, reason", [({}, {}, DONE), ({"star": 1}, {}, LINK), ({}, NEVER, NORMAL)]
)
def test_vertices_move_where_there_is_room_and_a_guard_allows_it(
    classes, operation, v, room, limits, reason
):
    state, references = prepared(off_centre(**classes), **room)
    before = frozen(state)
    if operation is slides and limits == NEVER:
        reason = NO_NEED  # it looks for places with sound normals alone
    assert operation(references, OPEN._replace(**limits), v) == reason
    assert (frozen(state) == before) == (reason != DONE)


def moved(references, limits, v, place) -> int:
    star = star_at(references[0], v)
    references[0].points[star.tip] = place
    return attempt(*references, limits, star, -INF, 0.0)


@pytest.mark.parametrize("classes, reason", [({}, DONE), ({"sides": (1, 1), "kind": CRACK}, DISTANCE)])
def test_vertices_keep_nearer_to_the_crack_than_to_the_rest(classes, reason):
    state, references = prepared(off_centre(**classes))
    before = frozen(state)
    limits = OPEN._replace(distance=1.0, crack_distance=0.01)
    assert moved(references, limits, 0, (0.3, 0.1, 0.2)) == reason
    assert (frozen(state) == before) == (reason != DONE)


def test_vertices_slide_in_their_box_plane_and_not_where_the_goal_is_reached():
    state, references = prepared(structured_box((2, 2, 2), lambda centres: np.ones(len(centres), int))[0])
    v = int(np.flatnonzero((state.mesh.points == (1, 1, 0)).all(axis=1))[0])
    state.mesh.points[v, :2] += (0.5, 0.4)
    before = frozen(state)
    assert tried(references, OPEN, SLIDE, (v,)) == NO_NEED
    assert slides(references, OPEN._replace(**NEVER), v) == NO_NEED
    assert frozen(state) == before
    assert slides(references, OPEN, v) == DONE
    assert state.mesh.points[v, 2] == 0.0 and frozen(state) != before


TIED = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3], [0, 5, 4], [0, 4, 6], [4, 5, 6], [5, 0, 6]]


@pytest.mark.parametrize(
    "operation, surface, v",
    [
        (slides, BOX, 0),
        (evens, BOX, 0),
        (slides, sheet(TIED, (1, 0)), 0),
        (evens, sheet(TIED, (1, 0)), 0),
        (evens, fan(6), 1),
        (slides, fan(6), 0),
        (relaxes, fan(6), 0),
        (relaxes, sheet([[0, 1, 2]], points=[[0, 0, 0], [1, 0, 0], [3, 0, 0]]), 1),
        # Facets whose normals cancel out leave no plane to slide in.
        (slides, sheet([[0, 1, 2], [0, 2, 1]], points=[[0, 0, 0], [3, 0, 0], [0, 1, 0]]), 0),
    ],
    ids=[
        "box corner",
        "same",
        "tied",
        "same",
        "even already",
        "best already",
        "relaxed already",
        "no area",
        "no plane",
    ],
)
def test_vertices_without_a_better_place_stay(operation, surface, v):
    state, references = prepared(surface)
    before = frozen(state)
    assert operation(references, OPEN, v) == NO_NEED
    assert frozen(state) == before


def test_a_vertex_that_is_gone_does_not_move():
    surface = fan(5)
    spare = np.concatenate([surface.points, [[5.0, 5.0, 5.0]]])
    _, references = prepared(Surface(spare, surface.facets, surface.sides, surface.kind))
    assert slides(references, OPEN, 6) == relaxes(references, OPEN, 6) == NO_NEED


EDGES = np.array([[0, 1], [0, 2], [6, 1]])
OPERATIONS = {
    "collapse": (COLLAPSE, EDGES),
    "split": (SPLIT, EDGES),
    "swap": (SWAP, EDGES),
    "slide": (SLIDE, np.arange(2)[:, None]),
    "even lines": (EVEN, np.arange(2)[:, None]),
    "relax": (RELAX, np.arange(2)[:, None]),
}


@pytest.mark.parametrize("operation, items", OPERATIONS.values(), ids=OPERATIONS)
def test_a_pass_stops_before_the_grid_is_full(operation, items):
    state = make_state(off_centre(), np.ones(7))
    grid = filled_grid(state.mesh)
    grid.used[0] = len(grid.facet)
    before = frozen(state)
    references = by_reference(*state), by_reference(grid)
    assert one_pass(*references, OPEN, operation, items, INF, 0) == (0, 0)
    assert frozen(state) == before


COUNTS = {
    # It looks for places with sound normals alone, and so is not refused.
    "slide": (SLIDE, 0),
    # Point 1 is uneven, and so are its two neighbours; the hub is on no line.
    "even lines": (EVEN, 3),
    # Points of the rim are on a line.
    "relax": (RELAX, 1),
}


@pytest.mark.parametrize("operation, count", COUNTS.values(), ids=COUNTS)
def test_a_pass_counts_what_is_refused(operation, count):
    state, references = prepared(off_centre())
    before = frozen(state)
    vertices = np.arange(7)[:, None]
    assert one_pass(*references, OPEN._replace(**NEVER), operation, vertices, INF, 0) == (7, 0)
    assert frozen(state) == before
    assert state.scratch.refused[NORMAL] == state.scratch.refused.sum() == count


def test_a_vertex_does_not_leave_its_fan():
    state, references = prepared(fan(6))
    before = frozen(state)
    assert moved(references, OPEN, 0, (10.0, 0.1, 0.0)) == INTERSECTION
    assert frozen(state) == before


def test_passes_leave_out_edges_that_are_gone_or_long_enough():
    surface = fan(5)
    spare = np.concatenate([surface.points, [[5.0, 5.0, 5.0]]])
    state, references = prepared(Surface(spare, surface.facets, surface.sides, surface.kind))
    before = frozen(state)
    limits = OPEN._replace(collapse=0.5)
    gone = EDGES[2:], np.array([[6]])
    for operation, items in ((COLLAPSE, EDGES), (SWAP, gone[0]), (SLIDE, gone[1])):
        assert one_pass(*references, limits, operation, items, INF, 0) == (len(items), 0)
    assert frozen(state) == before and not state.scratch.refused.any()
