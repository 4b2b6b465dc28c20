"""Where a crack has a crease, its trace on a boundary has a kink: trace edges get a point there."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from craftmesh.insertion.creases import Creases
from craftmesh.insertion.cut import CutSurface, with_phi
from craftmesh.insertion.front_chain import crossing_at
from craftmesh.insertion.guarded_move import settled
from craftmesh.insertion.options import InsertOptions
from craftmesh.insertion.sheet import Sheet
from craftmesh.insertion.snap import classes
from craftmesh.insertion.traces import FARTHEST, GRAZING, OFF, Splits, edges_in_walls, split_traces
from craftmesh.insertion.wings import lead_round, opened

CONTACT = 0.25  # of the least length: a boundary along the crack moves onto a crease from nearer than this
ROUNDING = 1e-9  # of a crease's length: a place this far past its end is on it
AT_END = 0.1  # of the least length: an end this near a kink moves there, if it is in one boundary
SHORTEST = 0.05  # of the least length: no edge is split nearer than this to its ends
# Of an edge's length: a kink on a face of the box may be this far off it. With 0.3, as in a boundary, which
# may move to it, kinks at 0.31 and 0.56 of long edges were cut off by 0.12 and 0.33 l_min.
FARTHEST_ON_BOX = 1.0


def kink_traces(
    surface: CutSurface, sheet: Sheet, creases: Creases, least: float, options: InsertOptions
) -> CutSurface:
    """Split trace edges inside one boundary where they cross a crease, if they cut its kink off.

    The new point is where boundary and crease meet; where no sound move leads there, there is none. An end
    of the edge that is too near for that moves there itself; where the kink is on an edge beside the trace,
    that is led over it. least: the least target length.
    """
    surface = split_traces(
        _with_ends_on_kinks(surface, sheet, creases, least, options),
        sheet,
        lambda now: _kinks(now, sheet, creases, least),
        lambda now, rows, targets: settled(now, rows, targets, options),
        opened,
    )
    return lead_round(surface, sheet, _kinks(surface, sheet, creases, least), options)


def _with_ends_on_kinks(
    surface: CutSurface, sheet: Sheet, creases: Creases, least: float, options: InsertOptions
) -> CutSurface:
    """Move ends of trace edges, inside one boundary, onto kinks too near to them for a new point."""
    near = _kinks(surface, sheet, creases, least, at_ends=True)
    ends = np.where(near.share < 0.5, *near.edges.T)
    rows, first = np.unique(ends, return_index=True)
    targets = near.targets[first]
    uv = sheet.uv(surface.points[rows])
    free = (classes(surface)[0].degree[rows] == 0) & (surface.front[rows] < 0)
    free &= creases.distance(uv) > ROUNDING * least
    rows, targets = rows[free], targets[free]
    while len(rows):
        result, left = settled(surface, rows, targets, options)
        stuck = crossing_at(result, sheet, np.setdiff1d(rows, left))
        if not len(stuck):
            phi = result.phi.copy()
            phi[rows] = np.nan
            return with_phi(replace(result, phi=phi), sheet)
        kept = ~np.isin(rows, stuck)
        rows, targets = rows[kept], targets[kept]
    return surface


def _kinks(
    surface: CutSurface, sheet: Sheet, creases: Creases, least: float, at_ends: bool = False
) -> Splits:
    """Return the trace edges that have a kink, and the kinks' places.

    at_ends: only kinks nearer than AT_END to an end of their edge, else none nearer than SHORTEST.
    """
    edges, normals, held = edges_in_walls(surface)
    start, step = surface.points[edges[:, 0]], np.diff(surface.points[edges], axis=1)[:, 0]
    length = np.linalg.norm(step, axis=1)
    reach = np.where(held, FARTHEST_ON_BOX, FARTHEST) * length
    edge, crease = creases.near(sheet.uv(start + step / 2), 0.5 * length + reach)
    chords = _Chords(start[edge], step[edge], creases.ends[crease])
    share, move = chords.within(normals[edge])
    straight, shift = chords.straight()
    way, shorter = (np.linalg.norm(x, axis=1) for x in (move, shift))
    with np.errstate(invalid="ignore"):
        way[~((way < reach[edge]) & (share > 0) & (share < 1))] = np.inf
        grazing = ~held[edge] & (shorter < np.minimum(GRAZING * way, CONTACT * least))
    share, move = np.where(grazing, straight, share), np.where(grazing[:, None], shift, move)
    way = np.where(grazing, shorter, way)
    with np.errstate(invalid="ignore"):
        to_end = np.minimum(share, 1 - share) * length[edge]
        good = (way > OFF * least) & np.isfinite(way) & (to_end > 0)
        good &= to_end < AT_END * least if at_ends else to_end > SHORTEST * least
    foot = chords.start + share[:, None] * chords.step
    rows = np.flatnonzero(good)
    far = rows[way[rows] >= FARTHEST * length[edge[rows]]]
    rows = np.setdiff1d(rows, far[~_leads_nearer(sheet, chords.at(far), foot[far], move[far])])
    rows = rows[np.lexsort([-way[rows], edge[rows]])]
    rows = rows[np.unique(edge[rows], return_index=True)[1]]
    return Splits(edges[edge[rows]], share[rows], (foot + move)[rows])


def _leads_nearer(sheet: Sheet, chords: "_Chords", foot: np.ndarray, move: np.ndarray) -> np.ndarray:
    """Tell for which chords the way over a kink, `move` (k, 3) off its foot, is nearer to the crack.

    A kink far off its chord may be another trace's.
    """
    ends = chords.start, chords.start + chords.step
    halves = (np.abs(sheet.offset((end + (foot + move)) / 2)) for end in ends)
    return np.maximum(*halves) < np.abs(sheet.offset(foot))


class _Chords(NamedTuple):
    """Pairs of a chord, start and step (k, 3), and a crease that may pass it, its ends (k, 2, 3)."""

    start: np.ndarray
    step: np.ndarray
    ends: np.ndarray

    def at(self, rows: np.ndarray) -> "_Chords":
        return _Chords(self.start[rows], self.step[rows], self.ends[rows])

    def within(self, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return where the creases pass the chords in planes of the normals (k, 3), as `straight` does."""
        a, b = self.ends[:, 0], self.ends[:, 1]
        with np.errstate(all="ignore"):
            along = _dot(normals, self.start - a) / _dot(normals, b - a)
        place = a + _inside(along)[:, None] * (b - a) - self.start
        across = np.cross(normals, self.step)
        across /= np.maximum(np.linalg.norm(across, axis=1), 1e-300)[:, None]
        beside = _dot(place, across)
        return _dot(place, self.step) / _dot(self.step, self.step), beside[:, None] * across

    def straight(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the share (k,) of the chord that is nearest to the crease, and the way there (k, 3)."""
        a, d = self.ends[:, 0], self.ends[:, 1] - self.ends[:, 0]
        gap, sd = self.start - a, _dot(self.step, d)
        ss, dd = _dot(self.step, self.step), _dot(d, d)
        with np.errstate(all="ignore"):
            along = (_dot(d, gap) * ss - sd * _dot(self.step, gap)) / (ss * dd - sd**2)
        place = a + _inside(along)[:, None] * d - self.start
        share = _dot(place, self.step) / ss
        return share, place - share[:, None] * self.step


def _inside(share: np.ndarray) -> np.ndarray:
    """Return the shares (k,) that lie in a segment, NaN for others."""
    with np.errstate(invalid="ignore"):
        return np.where((share >= -ROUNDING) & (share <= 1 + ROUNDING), share, np.nan)


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("ij,ij->i", a, b)
