"""The guarded operation: every guard refuses by its own reason, and a refusal leaves the mesh as it was."""

import numpy as np
import pytest
from structured_box import structured_box
from unchanged import INF, OPEN, frozen

from craftmesh.gradation.kernels.guards import attempt, refusal
from craftmesh.gradation.kernels.result_codes import (
    ANGLE,
    DISTANCE,
    DONE,
    INTERSECTION,
    LENGTH,
    NO_NEED,
    NORMAL,
    REFUSALS,
    VOLUME,
    counted,
    is_held,
)
from craftmesh.gradation.kernels.split import split
from craftmesh.gradation.kernels.star import star_at, worst_score
from craftmesh.gradation.passes import filled_grid
from craftmesh.gradation.state import State, make_state
from craftmesh.kernel_structs import by_reference


@pytest.fixture
def state() -> State:
    """Two grains of 6 x 6 x 6 cells, their boundary in x = 3, and targets of one cell."""
    surface, _ = structured_box((6, 6, 6), lambda centres: 1 + (centres[:, 0] > 3))
    return make_state(surface, np.ones(len(surface.points)))


def middle(state: State) -> int:
    """Return the vertex in the middle of the grain boundary."""
    return int(np.flatnonzero((state.mesh.points == 3).all(axis=1))[0])


@pytest.mark.parametrize(
    "limits, step, floor, reason",
    [
        ({}, (0.2, 0.0, 0.0), 0.0, DONE),
        ({"drift": 1e-4}, (0.2, 0.0, 0.0), 0.0, VOLUME),
        ({"cosine": 0.999}, (0.2, 0.0, 0.0), 0.0, NORMAL),
        ({}, (0.0, 0.3, 0.0), 3.0, ANGLE),
        ({"longest": 1.42}, (0.0, 0.3, 0.0), 0.0, LENGTH),
        ({"distance": 0.1}, (0.2, 0.0, 0.0), 0.0, DISTANCE),
        ({"distance": 0.3}, (0.2, 0.0, 0.0), 0.0, DONE),
        ({}, (3.5, 0.0, 0.0), 0.0, INTERSECTION),
    ],
)
def test_each_guard_refuses_by_its_reason_and_writes_nothing(state, limits, step, floor, reason):
    references = by_reference(*state), by_reference(filled_grid(state.mesh))
    v = middle(state)
    before, place = frozen(state), state.mesh.points[v] + step
    star = star_at(references[0], v)
    assert star.moved == 6 and star.vertex == v and star.tip == state.mesh.used[0]
    assert np.array_equal(state.mesh.points[star.tip], state.mesh.points[v])
    state.mesh.points[star.tip] = place
    assert refusal(*references, OPEN._replace(**limits), star, floor, INF) == reason
    assert frozen(state) == before
    assert attempt(*references, OPEN._replace(**limits), star, floor, INF) == reason
    assert np.array_equal(state.mesh.points[v], place) == (reason == DONE)
    assert (frozen(state) == before) == (reason != DONE)


def test_a_commit_books_the_drift_and_leaves_a_witness(state):
    references = by_reference(*state), by_reference(filled_grid(state.mesh))
    v = middle(state)
    star = star_at(references[0], v)
    state.mesh.points[star.tip, 0] += 0.25
    limits = OPEN._replace(drift=0.1, distance=0.5)
    assert attempt(*references, limits, star, worst_score(references[0], star) * 0.1, INF) == DONE
    # A pyramid of the six facets round v, of area 1 / 2 each, and height 0.25.
    assert np.allclose(np.abs(state.guards.drift), 3 * 0.25 / 3)
    assert np.allclose(state.guards.drift.sum(), 0.0)
    assert state.guards.is_witness[v]
    holders = np.flatnonzero(state.guards.witness_first == v)
    assert len(holders) == 1 and v in state.mesh.facets[holders[0]]
    assert np.array_equal(state.guards.home[v], [3.0, 3.0, 3.0])


def test_refusals_are_counted_by_reason():
    refused = np.zeros(len(REFUSALS), np.int64)
    answers = [DONE, ANGLE, ANGLE, DONE, -2, VOLUME]
    assert sum(counted(refused, answer) for answer in answers) == 2
    assert refused[ANGLE] == 2 and refused[VOLUME] == 1 and refused.sum() == 3


def test_planes_of_the_box_hold_one_coordinate_each():
    for plane in range(6):
        assert [bool(is_held(1 << plane, axis)) for axis in range(3)] == [plane // 2 == k for k in range(3)]
    assert not any(is_held(64 | 128, axis) for axis in range(3))


def test_a_split_refuses_poor_halves_and_edges_that_are_gone(state):
    references = by_reference(*state), by_reference(filled_grid(state.mesh))
    v = middle(state)
    b = int(np.flatnonzero((state.mesh.points == (3, 4, 3)).all(axis=1))[0])
    before = frozen(state)
    assert split(*references, OPEN._replace(floor=10.0), v, b, 2.0) == ANGLE
    assert split(*references, OPEN, v, 0, 0.0) == NO_NEED
    assert frozen(state) == before


@pytest.mark.parametrize("step, reason", [(0.0, DONE), (0.2, LENGTH)])
def test_an_edge_may_be_too_long_where_one_before_was_as_long(state, step, reason):
    """Diagonals of cells of 1 are over 1 before and after; a step along one lengthens the other half."""
    references = by_reference(*state), by_reference(filled_grid(state.mesh))
    star = star_at(references[0], middle(state))
    state.mesh.points[star.tip, 1:] += step
    assert refusal(*references, OPEN._replace(longest=1.0), star, 0.0, INF) == reason
