"""Moves of a surface's points onto a crack, within the bounds of `surface/guarded_move`."""

from dataclasses import replace

import numpy as np

from craftmesh.insertion.cut import CutSurface
from craftmesh.insertion.options import InsertOptions
from craftmesh.surface.guarded_move import SETTLING, MoveBounds, guarded_move
from craftmesh.types import Surface


def move_onto(
    surface: CutSurface, rows: np.ndarray, targets: np.ndarray, bounds: MoveBounds
) -> tuple[CutSurface, np.ndarray]:
    """Return the surface with points `rows` (k,) moved to `targets` (k, 3), and the ids that were moved.

    A move that would break the bounds, as for a facet that turns too far, is not made.
    """
    with np.errstate(invalid="ignore"):
        near = np.abs(surface.psi) <= 2 * np.nanmax(surface.size)
    near[rows] = True
    band = near[surface.facets].any(axis=1)
    part = Surface(surface.points, surface.facets[band], surface.sides[band], surface.kind[band])
    moved = surface.points.copy()
    moved[rows] = targets
    points, held = guarded_move(part, moved, bounds)
    return replace(surface, points=points), rows[~held[rows]]


def settled(
    surface: CutSurface, rows: np.ndarray, targets: np.ndarray, options: InsertOptions
) -> tuple[CutSurface, np.ndarray]:
    """Return the surface with points `rows` moved to `targets` (k, 3), and the ids that could not move.

    Moves that the usual bounds forbid are tried again with SETTLING, which allows flatter facets and larger
    turns.
    """
    for bounds in (options.bounds, SETTLING):
        surface, moved = move_onto(surface, rows, targets, bounds)
        left = ~np.isin(rows, moved)
        rows, targets = rows[left], targets[left]
        if not len(rows):
            break
    return surface, rows
