"""The facets beside trace edges: edges are flipped there so that a kink of the trace finds room."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from craftmesh.insertion.cut import CutSurface, split_edges
from craftmesh.insertion.front_chain import crossing_at
from craftmesh.insertion.guarded_move import settled
from craftmesh.insertion.options import InsertOptions
from craftmesh.insertion.sheet import Sheet
from craftmesh.insertion.traces import Splits
from craftmesh.surface.measure import area_vectors, facet_angles
from craftmesh.surface.patches import box_axis

FLATTEST = 5.0  # degrees: a facet is not made flatter to let a kink in, unless one was before
NARROW = np.sin(np.radians(12.0))  # a kink is given a facet that leaves this angle beside it
FLAT = np.cos(np.radians(15.0))  # two facets that turn by more are a ridge, which stays
OPENINGS = 3  # flips for one kink at most
ROUNDING = 1e-9  # of the local size: a place this near a plane of the box is in it
MARGIN = 0.05  # of an edge beside a trace: nearer to its ends it gets no point for a kink


def opened(surface: CutSurface, kinks: Splits) -> CutSurface:
    """Flip edges beside trace edges so that their kinks lie in facets at them."""
    edges, targets = kinks.edges, kinks.targets
    facets = surface.facets.copy()
    around: dict[int, set[int]] = {int(point): set() for point in np.unique(edges)}
    for row, corner in zip(*np.nonzero(np.isin(facets, edges))):
        around[int(facets[row, corner])].add(int(row))
    wings = Wings(replace(surface, facets=facets), around)
    for (p, q), target in zip(edges.tolist(), targets):
        for _ in range(OPENINGS):
            if not wings.open(p, q, target):
                break
    return replace(surface, facets=facets)


class Wings(NamedTuple):
    """A surface whose facets are flipped in place, and the facets around some of its points."""

    surface: CutSurface
    around: dict[int, set[int]]

    def open(self, p: int, q: int, target: np.ndarray) -> bool:
        """Flip one edge between the edge p-q and the target beside it; say if one was flipped."""
        points, facets = self.surface.points, self.surface.facets
        for row in sorted(self.around[p] & self.around[q]):
            w = int(facets[row].sum()) - p - q
            normal = np.cross(points[q] - points[p], points[w] - points[p])
            beside = np.cross(points[q] - points[p], target - points[p]) @ normal > 0
            if beside and self._room(p, q, w, target) < NARROW:
                return any(self._flip(row, (a, w, b), target) for a, b in ((p, q), (q, p)))
        return False

    def _room(self, p: int, q: int, w: int, target: np.ndarray) -> float:
        """Return the least sine of the angles that p-target and q-target leave to the sides of p, q, w."""
        points = self.surface.points
        normal = np.cross(points[q] - points[p], points[w] - points[p])
        room = []
        for a, b in ((p, q), (q, p)):
            inward, step = np.cross(normal, points[w] - points[a]), target - points[a]
            inward *= np.sign(inward @ (points[b] - points[a])) / np.linalg.norm(inward)
            room.append(float(inward @ step / np.linalg.norm(step)))
        return min(room)

    def _flip(self, row: int, corners: tuple[int, int, int], target: np.ndarray) -> bool:
        """Flip the edge a-w of the facet `row`, corners a, w, b, where that is sound and gives room."""
        (a, w, b), facets = corners, self.surface.facets
        others = [r for r in self.around[a] if r != row and w in facets[r]]
        if len(others) != 1 or self.surface.psi[w] == 0:
            return False
        rows = [row, others[0]]
        x = int(facets[others[0]].sum()) - a - w
        before = facets[rows]
        after = np.stack([np.where(before[0] == w, x, before[0]), np.where(before[1] == a, b, before[1])])
        if not _is_sound(self.surface, rows, after) or self._room(a, b, x, target) <= self._room(
            a, b, w, target
        ):
            return False
        facets[rows] = after
        for point, gained, lost in ((a, row, rows[1]), (w, rows[1], row), (b, rows[1], -1), (x, row, -1)):
            if point in self.around:
                self.around[point] = (self.around[point] | {gained}) - {lost}
        return True


def _is_sound(surface: CutSurface, rows: list[int], after: np.ndarray) -> bool:
    """Tell whether two facets may become `after` (2, 3): of one patch, flat in all, not thin."""
    sides, kind = surface.sides[rows], surface.kind[rows]
    if (sides[0] != sides[1]).any() or kind[0] != kind[1]:
        return False
    facets = np.concatenate([surface.facets[rows], after])
    normal = area_vectors(surface.points, facets)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    angle = facet_angles(surface.points, facets).min(axis=1)
    return bool((normal @ normal[0]).min() > FLAT and angle[2:].min() >= min(FLATTEST, angle[:2].min()))


def lead_round(surface: CutSurface, sheet: Sheet, kinks: Splits, options: InsertOptions) -> CutSurface:
    """Lead trace edges over points of edges beside them where their kinks lie on or near those.

    Such a kink leaves a point of the trace edge itself no room. Where that is unsound nothing changes.
    """
    for edge, target in zip(kinks.edges, kinks.targets):
        led = _led_round(surface, edge, target)
        if led is None:
            continue
        point = np.array([len(surface.points)])
        led, left = settled(led, point, target[None], options)
        if not len(left) and not len(crossing_at(led, sheet, point)):
            surface = led
    return surface


def _led_round(surface: CutSurface, edge: np.ndarray, target: np.ndarray) -> CutSurface | None:
    """Return the surface with a trace edge (2,) led over a new point beside it, None if unsound.

    Where an edge of the box is beside it the point would leave the other face.
    """
    points, facets = surface.points, surface.facets
    p, q = edge.tolist()
    beside, away = -1, -1
    for row in _around(facets, (p, q)):
        w = int(facets[row].sum()) - p - q
        normal = np.cross(points[q] - points[p], points[w] - points[p])
        is_beside = np.cross(points[q] - points[p], target - points[p]) @ normal > 0
        beside, away = (w, away) if is_beside else (beside, w)
    if min(beside, away) < 0:
        return None
    end = min((p, q), key=lambda a: float(_sine(target - points[a], points[beside] - points[a])))
    step = points[beside] - points[end]
    share = float((target - points[end]) @ step / (step @ step))
    rows = _around(facets, (end, beside))
    if len(rows) < 2 or (surface.psi[[away, beside]] == 0).any() or _leaves_box(surface, rows, target):
        return None
    if not MARGIN < share < 1 - MARGIN:
        return None
    foot = points[end] + share * step
    split = split_edges(surface, np.sort([[end, beside]]), foot[None], surface.size[[end]])
    return _flipped(split, (p, q), (len(points), away))


def _leaves_box(surface: CutSurface, rows: list[int], target: np.ndarray) -> bool:
    """Tell whether a place (3,) is off a box plane in which one of the facets lies."""
    axis = box_axis(surface.kind[rows])
    on_box = np.flatnonzero(axis >= 0)
    axis, facets = axis[on_box], surface.facets[np.array(rows)[on_box]]
    off = np.abs(target[axis] - surface.points[facets[:, 0], axis])
    return bool((off > ROUNDING * surface.size[facets[:, 0]]).any())


def _sine(a: np.ndarray, b: np.ndarray) -> float:
    """Return the sine of the angle between two vectors (3,)."""
    return float(np.linalg.norm(np.cross(a, b)) / (np.linalg.norm(a) * np.linalg.norm(b)))


def _around(facets: np.ndarray, corners: tuple[int, ...]) -> list[int]:
    """Return the rows of the facets that have all these corners."""
    found: list[int] = np.flatnonzero(np.isin(facets, corners).sum(axis=1) == len(corners)).tolist()
    return found


def _flipped(surface: CutSurface, edge: tuple[int, int], apices: tuple[int, int]) -> CutSurface | None:
    """Return the surface with an edge between two facets replaced by their apices', None if unsound."""
    (p, q), (v, w) = edge, apices
    facets = surface.facets.copy()
    rows = _around(facets, (p, q, v)) + _around(facets, (p, q, w))
    before = facets[rows]
    after = np.stack([np.where(before[0] == q, w, before[0]), np.where(before[1] == p, v, before[1])])
    if not _is_sound(surface, rows, after):
        return None
    facets[rows] = after
    return replace(surface, facets=facets)
