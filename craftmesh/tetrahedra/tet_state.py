"""The optimiser's state of a changing mesh: made from points and tetrahedra, and turned back into them."""

from typing import NamedTuple

import numpy as np

from craftmesh.kernel_structs import by_reference
from craftmesh.tetrahedra.kernels.tet_cavity import POINTS, TETS, TetState, block_facets, link_tets

# Length of the state's arrays: this multiple of the mesh's points or tets, plus SPARE rows. Insertions add
# about 1% of the points.
CAPACITY = 1.5
SPARE = 2000
NO_FACETS = np.zeros((0, 3), np.int64)


class Bounds(NamedTuple):
    """Bounds of moves of the first s points of a mesh, the surface points.

    A point stays within reach (s,) of its home (s, 3). It moves along the rows of ways (s, 3, 3), unit
    vectors perpendicular to each other, or 0 for a direction that is not allowed.
    """

    home: np.ndarray
    ways: np.ndarray
    reach: np.ndarray


NO_POINTS = Bounds(np.zeros((0, 3)), np.zeros((0, 3, 3)), np.zeros(0))


def new_state(
    points: np.ndarray,
    tets: np.ndarray,
    frozen: int = 0,
    blocked: np.ndarray = NO_FACETS,
    size: np.ndarray | float = 1.0,
    bounds: Bounds = NO_POINTS,
    label: np.ndarray | int = 0,
) -> TetState:
    """Return a reference to the state of a mesh, with its adjacency and room for new points and tets.

    points (n, 3), tets (m, 4), blocked (k, 3), size (n,): as for `optimise_tets`; the first `frozen` points
    do not move. bounds: of the first points, the surface points; label (m,): the grain of each tet. All
    qualities are inf until they are computed.
    """
    room_points, room_tets = int(CAPACITY * len(points)) + SPARE, int(CAPACITY * len(tets)) + SPARE
    arrays = TetState(
        points=np.zeros((room_points, 3)),
        tets=np.full((room_tets, 4), -1, np.int64),
        neighbours=np.full((room_tets, 4), -1, np.int64),
        tet_of=np.full(room_points, -1, np.int64),
        quality=np.full(room_tets, np.inf),  # so that no pass improves empty rows
        size=np.ones(room_points),
        frozen=np.zeros(room_points, bool),
        counts=np.array([len(points), len(tets), 0, 0], np.int64),
        free=np.zeros(room_tets, np.int64),
        mark=np.zeros(room_tets, np.int64),
        label=np.zeros(room_tets, np.int64),
        **_rows_of(bounds),
    )
    state: TetState = by_reference(arrays)
    state.points[: len(points)], state.tets[: len(tets)], state.size[: len(points)] = points, tets, size
    state.frozen[:frozen], state.label[: len(tets)] = True, label
    link_tets(state.tets, len(tets), len(points), state.neighbours, state.tet_of)
    triples = np.sort(np.asarray(blocked, np.int64).reshape(-1, 3), axis=1)
    triples = np.ascontiguousarray(triples[np.lexsort(triples.T[::-1])])
    block_facets(state.tets, len(tets), state.neighbours, triples)
    return state


def unlinked_state(
    points: np.ndarray,
    tets: np.ndarray,
    size: np.ndarray,
    frozen: np.ndarray,
    quality: np.ndarray,
    bounds: Bounds,
) -> TetState:
    """Return a reference to the state of a mesh without adjacency, for passes that only move points.

    The passes change points (n, 3) and quality (m,) in place; quality must be by their measure. frozen
    (n,): mask of points that stay.
    """
    none = np.zeros(0, np.int64)
    counts = np.array([len(points), len(tets), 0, 0], np.int64)
    links = np.zeros((0, 4), np.int64)
    state: TetState = by_reference(
        TetState(
            points=points,
            tets=tets,
            neighbours=links,
            tet_of=none,
            quality=quality,
            size=size,
            frozen=frozen,
            counts=counts,
            free=none,
            mark=none,
            label=none,
            **_rows_of(bounds),
        )
    )
    return state


def _rows_of(bounds: Bounds) -> dict[str, np.ndarray]:
    """Return home, ways and reach with an added last row, without bounds, for points off the surface."""
    return {
        "home": np.concatenate([bounds.home, np.zeros((1, 3))]),
        "ways": np.concatenate([bounds.ways, np.eye(3)[None]]),
        "reach": np.append(bounds.reach, np.inf),
    }


def mesh_of(state: TetState, frozen: int) -> tuple[np.ndarray, np.ndarray]:
    """Return (points, tets) of a state without dead tets and unused points.

    The first `frozen` points are kept even if unused.
    """
    return without_unused(state.points[: state.counts[POINTS]], live_tets(state), frozen)


def live_tets(state: TetState) -> np.ndarray:
    """Return the live tets (m, 4)."""
    tets = state.tets[: state.counts[TETS]]
    return tets[tets[:, 0] >= 0]


def without_unused(points: np.ndarray, tets: np.ndarray, frozen: int) -> tuple[np.ndarray, np.ndarray]:
    """Return (points, tets) without unused points; the first `frozen` points are kept even if unused."""
    used = np.zeros(len(points), bool)
    used[tets.ravel()] = True
    used[:frozen] = True
    new = np.cumsum(used) - 1
    return points[used], new[tets]
