"""The optimiser's mesh under change, made from points and tetrahedra, and turned back into them."""

from typing import NamedTuple

import numpy as np

from craftmesh.by_reference import by_reference
from craftmesh.tetrahedra.kernels.tet_cavity import POINTS, TETS, TetState, block_facets, link_tets

# Length of arrays relative to the mesh; insertions add some 1%.
CAPACITY = 1.5
SPARE = 2000
NO_FACETS = np.zeros((0, 3), np.int64)


class Bounds(NamedTuple):
    """Bounds of moves of the first s points of a mesh: from home (s, 3) by at most reach (s,).

    The points move along the rows of ways (s, 3, 3), which are orthonormal or 0.
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

    Arguments are as for `optimise_tets`; bounds: of the first points; label (m,): the grain of each tet.
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
    """Return the mesh without its adjacency, behind a reference, for passes that only move points.

    points (n, 3) and quality (m,), by the measure of the passes, will be changed; frozen (n,): bool.
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
    """Return the bounds as a state has them: the last row is that of all other points."""
    return {
        "home": np.concatenate([bounds.home, np.zeros((1, 3))]),
        "ways": np.concatenate([bounds.ways, np.eye(3)[None]]),
        "reach": np.append(bounds.reach, np.inf),
    }


def mesh_of(state: TetState, frozen: int) -> tuple[np.ndarray, np.ndarray]:
    """Return (points, tets) without dead tets and unused points; the first `frozen` points are kept."""
    return without_unused(state.points[: state.counts[POINTS]], live_tets(state), frozen)


def live_tets(state: TetState) -> np.ndarray:
    """Return the live tets (m, 4)."""
    tets = state.tets[: state.counts[TETS]]
    return tets[tets[:, 0] >= 0]


def without_unused(points: np.ndarray, tets: np.ndarray, frozen: int) -> tuple[np.ndarray, np.ndarray]:
    """Return (points, tets) without unused points; the first `frozen` points are kept."""
    used = np.zeros(len(points), bool)
    used[tets.ravel()] = True
    used[:frozen] = True
    new = np.cumsum(used) - 1
    return points[used], new[tets]
