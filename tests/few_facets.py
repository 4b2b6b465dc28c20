"""Surfaces of a few facets, and the state and references that operations on them take."""

import numpy as np
from structured_box import structured_box

from craftmesh.gradation.kernels.one_pass import one_pass
from craftmesh.gradation.kernels.result_codes import DONE, NO_NEED
from craftmesh.gradation.passes import Limits, filled_grid
from craftmesh.gradation.state import State, make_state
from craftmesh.kernel_structs import by_reference
from craftmesh.surface.kernels.facet_measures import shape_of
from craftmesh.types import INTERFACE, Crack, Surface

# A cube of one grain.
BOX = structured_box((1, 1, 1), lambda centres: np.ones(len(centres), int))[0]


def helix(count: int) -> np.ndarray:
    """Return points (count, 3) of which no three lie on a line and no four in a plane."""
    turn = np.arange(count)
    return np.column_stack([np.cos(turn), np.sin(turn), 0.3 * turn])


def facet_shapes(points, facets) -> np.ndarray:
    """Return the quality and the shortest edge (2, m) of facets (m, 3), one by one."""
    return np.array([shape_of(points, *corners) for corners in facets.tolist()]).T


def sheet(facets, sides=(1, 2), kind=INTERFACE, points=None) -> Surface:
    """Return a surface of a few facets; one pair of sides and one kind are those of all."""
    facets = np.array(facets, np.int32)
    sides = np.array(np.broadcast_to(sides, (len(facets), 2)), np.int32)
    kind = np.array(np.broadcast_to(kind, len(facets)), np.uint8)
    points = helix(facets.max() + 1) if points is None else np.array(points, float)
    return Surface(points, facets, sides, kind)


def fan(count: int, hub=(0.0, 0.0, 0.0), **classes) -> Surface:
    """Return facets round point 0 whose rim are points 1 to `count`, on a circle."""
    turn = 2 * np.pi * np.arange(count) / count
    rim = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(count)])
    facets = [[0, i + 1, (i + 1) % count + 1] for i in range(count)]
    return sheet(facets, points=np.concatenate([[hub], rim]), **classes)


def double_cone(count: int) -> Surface:
    """Return a closed surface round a waist of `count` points, the first ones, and two apexes."""
    turn = 2 * np.pi * np.arange(count) / count
    waist = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(count)])
    around = [(i, (i + 1) % count) for i in range(count)]
    facets = [[i, k, count] for i, k in around] + [[k, i, count + 1] for i, k in around]
    return sheet(facets, (1, 0), points=np.concatenate([waist, [[0, 0, 1], [0, 0, -1]]]))


def lens(slope: float) -> Surface:
    """A grain 1 between a disc at z = 0 and a cone over it that falls by `slope` towards the rim."""
    rings, around = np.arange(4), np.arange(12)
    radius, angle = np.meshgrid(2.0 - 0.5 * rings, np.radians(30 * around), indexing="ij")
    flat = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle], axis=-1).reshape(-1, 3)
    flat = np.concatenate([flat, np.zeros((1, 3))])
    outer = (12 * rings[:3, None] + around).ravel()
    after = (12 * rings[:3, None] + (around + 1) % 12).ravel()
    disc = np.concatenate(
        [
            np.stack([outer, after, after + 12], axis=1),
            np.stack([outer, after + 12, outer + 12], axis=1),
            np.stack([36 + around, 36 + (around + 1) % 12, np.full(12, 48)], axis=1),
        ]
    )
    cone = flat[12:] + np.outer(slope * (2.0 - np.linalg.norm(flat[12:], axis=1)), [0, 0, 1])
    facets = np.concatenate([disc, np.where(disc < 12, disc, disc + 37)])
    sides = np.repeat([[2, 1], [1, 3]], len(disc), axis=0)
    return Surface(np.concatenate([flat, cone]), facets, sides, np.zeros(len(facets), np.int8))


def off_centre(**classes) -> Surface:
    """Return a fan whose hub is far from its centre and whose rim's point 1 is far from even."""
    surface = fan(6, hub=(-0.5, 0.2, 0.0), **classes)
    points = surface.points.copy()
    points[1] = 0.2 * points[1] + 0.8 * points[2]
    return Surface(points, surface.facets, surface.sides, surface.kind)


def prepared(surface: Surface, crack: Crack | None = None, **room) -> tuple[State, tuple]:
    """Return the state with targets of one, and the references; `room`: shorter lengths of the scratch."""
    state = make_state(surface, np.ones(len(surface.points)), crack)
    short = {name: getattr(state.scratch, name)[:length].copy() for name, length in room.items()}
    state = State(state.mesh, state.guards, state.scratch._replace(**short))
    return state, (by_reference(*state), by_reference(filled_grid(state.mesh)))


def tried(references: tuple, limits: Limits, operation: int, at: tuple, goal: float = 0.0) -> int:
    """Try an operation of a pass at an edge (a, b) or a vertex (v,); return DONE or why not.

    The pass is a kernel of the product: each operation alone would be compiled for the tests.
    """
    before = references[0].refused.copy()
    _, done = one_pass(*references, limits, operation, np.array([at]), goal, 0)
    reasons = np.flatnonzero(references[0].refused != before).tolist()
    return DONE if done else next(iter(reasons), NO_NEED)
