"""What an insertion moved: grain boundaries onto the crack, and crack facets onto grain boundaries."""

import numpy as np

from craftmesh.insertion.cut import CutSurface
from craftmesh.insertion.sheet import Sheet
from craftmesh.surface.distances import distances_and_sides
from craftmesh.types import CRACK, Surface

ROUNDING = 1e-6  # of the least length: points that are off by less have not moved
SHARES = np.array([[1, 1, 1], [1.5, 1.5, 0], [0, 1.5, 1.5], [1.5, 0, 1.5]]) / 3  # of corners: where to look


def moved(before: CutSurface, after: Surface, sheet: Sheet, least: float) -> dict[str, int | float]:
    """Return numbers for the report: what is off its given place, and by how much at most in model units.

    Points of boundaries that moved within the given boundary are not counted. least: the least length.
    """
    on_crack = after.kind == CRACK
    shared = on_crack & (after.sides[:, 0] != after.sides[:, 1]) & ~_among(before, after, least)
    boundary = after.facets[~on_crack | shared]
    rows = np.unique(boundary)
    given = {tuple(row) for row in before.points.tolist()}
    rows = rows[[tuple(row) not in given for row in after.points[rows].tolist()]]
    near = before.facets[np.isfinite(before.psi[before.facets]).any(axis=1)]
    off = np.zeros(len(after.points))
    if len(rows):
        off[rows] = distances_and_sides(after.points[rows], before.points, near)[0]
    is_moved = off > ROUNDING * least
    places = np.einsum("sk,mkx->msx", SHARES, after.points[after.facets[shared]]).reshape(-1, 3)
    height = np.abs(sheet.offset(places)) / np.linalg.norm(sheet.gradient(places), axis=1)
    return {
        "boundary_points_moved": int(is_moved.sum()),
        "boundary_facets_moved": int(is_moved[boundary].any(axis=1).sum()),
        "boundary_moved_most": float(off.max(initial=0.0)),
        "crack_facets_on_grain_boundaries": int(shared.sum()),
        "crack_moved_most": float(height.max(initial=0.0)),
    }


def unmoved(facets: int) -> dict[str, int | float]:
    """Return the same numbers of a crack of so many facets that are those of grain boundaries as given."""
    return {
        "boundary_points_moved": 0,
        "boundary_facets_moved": 0,
        "boundary_moved_most": 0.0,
        "crack_facets_on_grain_boundaries": facets,
        "crack_moved_most": 0.0,
    }


def _among(before: CutSurface, after: Surface, least: float) -> np.ndarray:
    """Tell which facets (m,) of `after` lie on crack facets that were there before."""
    known = before.facets[before.kind == CRACK]
    if not len(known):
        return np.zeros(len(after.facets), bool)
    centres = after.points[after.facets].mean(axis=1)
    return distances_and_sides(centres, before.points, known)[0] <= ROUNDING * least
