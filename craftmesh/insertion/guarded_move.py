"""Moves of a surface's points that leave it sound: no facet turns, flattens or meets another."""

from dataclasses import replace

import numpy as np

from craftmesh.insertion.cut import CutSurface
from craftmesh.insertion.options import InsertOptions
from craftmesh.surface.kernels.triangle_pairs import intersecting_pairs
from craftmesh.surface.measure import area_vectors, facet_angles

KEPT = 0.999  # of its least angle, that a facet flatter than LEAST_ANGLE usually has to keep
KEPT_AT_LAST = 0.3  # the same where a point has to settle
TURN_AT_LAST = 80.0  # degrees, by which a facet may turn where a point has to settle
LEAST_ANGLE = 4.0  # degrees: a move may not leave a facet below this, unless it was worse before


def guarded_move(
    surface: CutSurface,
    rows: np.ndarray,
    targets: np.ndarray,
    options: InsertOptions,
    kept: float = KEPT,
) -> tuple[np.ndarray, np.ndarray]:
    """Move points `rows` (k,) to `targets` (k, 3) as far as no facet turns, flattens or pierces another.

    kept: the share of its least angle that a facet flatter than LEAST_ANGLE has to keep. Returns the points
    and the rows that were moved. Where a facet objects, its longest move is undone.
    """
    position = np.full(len(surface.points), -1)
    position[rows] = np.arange(len(rows))
    facets = surface.facets[(position[surface.facets] >= 0).any(axis=1)]
    mover = position[facets]
    step = np.linalg.norm(targets - surface.points[rows], axis=1)
    active = np.ones(len(rows), bool)
    before = _shape(surface.points, facets)
    stride = np.array([len(surface.facets), 1])
    known = _pairs(surface, surface.points, rows) @ stride
    while True:
        points = surface.points.copy()
        points[rows[active]] = targets[active]
        bad = mover[_worse(before, _shape(points, facets), options, kept)]
        if not len(bad):
            after = _pairs(surface, points, rows)
            hit = after[~np.isin(after @ stride, known)]
            bad = position[surface.facets[hit.ravel()]]
        undo = _longest(bad, step, active)
        if not len(undo):
            break
        active[undo] = False
    return points, rows[active]


def settled(
    surface: CutSurface, rows: np.ndarray, targets: np.ndarray, options: InsertOptions
) -> tuple[CutSurface, np.ndarray]:
    """Return the surface with the points `rows` at `targets` (k, 3), and the rows left behind.

    Where the usual guard refuses that, flat facets may become flatter and turn farther.
    """
    looser = replace(options, max_turn=max(options.max_turn, TURN_AT_LAST))
    for guard, kept in ((options, KEPT), (looser, KEPT_AT_LAST)):
        points, moved = guarded_move(surface, rows, targets, guard, kept)
        surface = replace(surface, points=points)
        left = ~np.isin(rows, moved)
        rows, targets = rows[left], targets[left]
        if not len(rows):
            break
    return surface, rows


def _longest(movers: np.ndarray, step: np.ndarray, active: np.ndarray) -> np.ndarray:
    """Return, for each row of movers (k, 3), -1 for none, the active one with the longest step."""
    usable = (movers >= 0) & active[movers]
    movers, usable = movers[usable.any(axis=1)], usable[usable.any(axis=1)]
    choice = np.argmax(np.where(usable, step[movers], -1.0), axis=1)
    return np.unique(movers[np.arange(len(movers)), choice])


_Shape = tuple[np.ndarray, np.ndarray]


def _shape(points: np.ndarray, facets: np.ndarray) -> _Shape:
    """Return area vectors (m, 3) and least angles (m,) in degrees."""
    return area_vectors(points, facets), facet_angles(points, facets).min(axis=1)


def _worse(before: _Shape, after: _Shape, options: InsertOptions, kept: float) -> np.ndarray:
    """Tell which facets turned too far or became too flat."""
    cosine = np.einsum("ij,ij->i", before[0], after[0])
    length = np.linalg.norm(before[0], axis=1) * np.linalg.norm(after[0], axis=1)
    turned = cosine < np.cos(np.radians(options.max_turn)) * length
    return turned | (after[1] < np.minimum(LEAST_ANGLE, kept * before[1]))


def _pairs(surface: CutSurface, points: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return the intersecting pairs among the facets near the crack that may meet a moved facet."""
    with np.errstate(invalid="ignore"):
        near = np.abs(surface.psi) <= 2 * np.nanmax(surface.size)
    near[rows] = True
    band = np.flatnonzero(near[surface.facets].any(axis=1))
    return band[intersecting_pairs(points, surface.facets[band])]
