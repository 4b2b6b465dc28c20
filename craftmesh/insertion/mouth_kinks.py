"""Where creases of a crack pass faces of the box its mouth has kinks: points of the surface go there."""

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from craftmesh.insertion.creases import creases_of
from craftmesh.insertion.cut import CutSurface
from craftmesh.insertion.guarded_move import settled
from craftmesh.insertion.options import InsertOptions
from craftmesh.insertion.sheet import Sheet
from craftmesh.insertion.snap import classes


def onto_mouth_kinks(surface: CutSurface, sheet: Sheet, least: float, options: InsertOptions) -> CutSurface:
    """Move the point of a face of the box next to each kink of the crack's mouth there onto that.

    Points within one patch alone move, by less than their local size, and count as on the crack then. A
    narrow mouth that lies within one facet at its kink is cut off there otherwise. least: the least length.
    """
    ends = creases_of(sheet, least).ends
    junctions, planes = classes(surface)
    usable = np.isfinite(surface.psi) & (junctions.degree == 0) & (planes.sum(axis=1) == 1)
    rows, targets = [np.zeros(0, np.int64)], [np.zeros((0, 3))]
    for axis in range(3):
        for bound in np.unique(surface.points[usable & planes[:, axis], axis]):
            on = np.flatnonzero(usable & planes[:, axis] & (surface.points[:, axis] == bound))
            kinks = _passing(ends, axis, bound)
            if len(kinks):
                away, nearest = cKDTree(surface.points[on]).query(kinks)
                close = away < surface.size[on[nearest]]
                rows.append(on[nearest[close]])
                targets.append(kinks[close])
    moving, first = np.unique(np.concatenate(rows), return_index=True)
    surface, left = settled(surface, moving, np.concatenate(targets)[first], options)
    psi = surface.psi.copy()
    psi[moving[~np.isin(moving, left)]] = 0.0
    return replace(surface, psi=psi)


def _passing(ends: np.ndarray, axis: int, bound: float) -> np.ndarray:
    """Return the places (k, 3) at which creases, given by their ends (n, 2, 3), pass a plane of the box."""
    off = ends[:, :, axis] - bound
    passing = off[:, 0] * off[:, 1] < 0
    start, end, off = ends[passing, 0], ends[passing, 1], off[passing]
    places: np.ndarray = start + (off[:, 0] / (off[:, 0] - off[:, 1]))[:, None] * (end - start)
    places[:, axis] = bound
    return places
