"""Length of a growth step, from the crack's size, and the load cycles of the step."""

import math
from typing import NamedTuple

import numpy as np
import scipy

from craftmesh.cracks.polyline import polyline
from craftmesh.growth.options import MOST, GrowthOptions
from craftmesh.surface.facet_subdivision import bisected
from craftmesh.types import Crack

ROOT = 0.5  # exponent of the crack's size in K under a constant load
# Largest relative error of the crack's size, and spacing of sampled points on the fronts, relative to the
# length of the longest front.
TOLERANCE = 1e-3
# Largest step, relative to the front's length. By Paris' law with m = 3, a step of 2 / (pi m) front lengths
# reduces the longest variation of K that a front can have, half a wave, to 1 / e (`relaxation`).
OF_FRONT = 0.2


class CycleCount(NamedTuple):
    """A front and its load cycles, from which the load cycles of the next front are counted.

    size: crack size; step: median extension from here, 0 if the front stays; rate: median da/dN of points
    that extend; power: their median d ln(da/dN) / d ln(K); error: relative error of Delta K. cycles, doubt:
    load cycles from the first front to this one, and their estimated error; ahead, ahead_doubt: the same
    for the next step. growth: d ln(da/dN) / d ln(crack size) over the next step. increment: number of this
    front's step, from 0.
    """

    size: float
    step: float
    rate: float
    power: float
    error: float
    cycles: float
    doubt: float
    ahead: float
    ahead_doubt: float
    growth: float
    increment: float = 0

    def laid(self, fraction: float) -> "CycleCount":
        """Return this front with a step, and cycles of it, of which only a `fraction` was laid."""
        step = fraction * self.step
        ahead, doubt = _ahead(step, self.size, self.rate, self.growth, self.power * self.error)
        return self._replace(step=step, ahead=ahead, ahead_doubt=doubt)


def growth_to(last: CycleCount | None, rate: float, power: float) -> float:
    """Return d ln(da/dN) / d ln(crack size) between the last front and the front with da/dN = `rate`.

    Without a last front, or a step from it, it is ROOT * power, because K is taken as proportional to
    size^ROOT; power is d ln(da/dN) / d ln(K).
    """
    if last is None or not last.step:
        return ROOT * power
    return math.log(rate / last.rate) / math.log1p(last.step / last.size)


def increment_after(last: CycleCount | None) -> int:
    """Return the number of the step that follows `last`, 0 if there is none."""
    return 0 if last is None else int(last.increment) + 1


def counted(
    last: CycleCount | None, size: float, step: float, rate: float, power: float, error: float
) -> CycleCount:
    """Return a front with the load cycles to it and of its next step; arguments are fields of CycleCount.

    Between two fronts da/dN is a power of the crack's size, as for penny, edge and through cracks; the next
    step has the exponent of the last one. The doubt (estimated error) of the cycles between two fronts is
    the difference from a path with ln(da/dN) linear in the extension, plus the effect of the errors of K,
    taken as all of one sign. The doubt of the next step has instead of the first part the whole effect of
    the change of K. The next step of a front with rate 0 has no cycles.
    """
    cycles, doubt = _reached(last, rate, power * error) if last is not None else (0.0, 0.0)
    growth = growth_to(last, rate, power) if rate > 0 else 0.0
    ahead = _ahead(step, size, rate, growth, power * error)
    return CycleCount(size, step, rate, power, error, cycles, doubt, *ahead, growth, increment_after(last))


def _ahead(step: float, size: float, rate: float, growth: float, error: float) -> tuple[float, float]:
    """Return the load cycles of the next step and their doubt; error: relative error of the rate."""
    if not rate > 0:
        return 0.0, 0.0
    ahead = cycles_over(step, size, rate, growth)
    return ahead, abs(ahead - step / rate) + ahead * error


def _reached(last: CycleCount, rate: float, error: float) -> tuple[float, float]:
    """Return the load cycles from the first front to the front with da/dN = `rate`, and their doubt.

    error: relative error of the rate. If the rate is 0, they are the cycles predicted at the last front.
    """
    if not rate > 0:
        return last.cycles + last.ahead, last.doubt + last.ahead_doubt
    if not last.step:
        return last.cycles, last.doubt
    found = cycles_over(last.step, last.size, last.rate, growth_to(last, rate, last.power))
    change = math.log(rate / last.rate)
    even = last.step / last.rate * (-math.expm1(-change) / change if change else 1.0)
    way = abs(even / found - 1)
    return last.cycles + found, last.doubt + found * (way + (last.power * last.error + error) / 2)


def cycles_over(step: float, size: float, rate: float, growth: float) -> float:
    """Return the load cycles of a step in which da/dN begins with `rate` and grows as size^growth.

    size: crack size at the start; step: its increase.
    """
    stretch, left = math.log1p(step / size), 1 - growth
    return size / rate * (math.expm1(left * stretch) / left if left else stretch)


def crack_size(crack: Crack, box: np.ndarray) -> float:
    """Return the crack's size: the largest distance of its points in the box (2, 3) from its fronts.

    This is the radius of a penny or half penny, the smaller semi-axis of an ellipse, the depth of an edge
    crack, and the half width of a through crack. The search bisects triangles that may contain a point
    farther away than the farthest centre of a triangle so far, until TOLERANCE is reached. The crack must
    have a front (not checked).
    """
    fronts = [polyline(crack.points[front]) for front in crack.fronts]
    step = TOLERANCE * max(line.length for line in fronts)
    places = [line.at(np.linspace(0, line.length, int(line.length / step) + 2)) for line in fronts]
    front = scipy.spatial.cKDTree(np.concatenate(places))
    farthest = 0.0
    corners = crack.points[crack.triangles]
    while len(corners):
        centre = corners.mean(axis=1)
        off, _ = front.query(centre)
        within = ((centre >= box[0]) & (centre <= box[1])).all(axis=1)
        farthest = max(farthest, off[within].max(initial=0.0))
        reach = np.linalg.norm(corners - centre[:, None], axis=2).max(axis=1)
        further = (off + reach > farthest * (1 + TOLERANCE)) & (reach > TOLERANCE * step)
        corners = bisected(corners[further], box, reach[further].max(initial=0.0))
    return farthest


def share_of_size(change: float, growth: float = ROOT) -> float:
    """Return the step, as a fraction of the crack size, in which K changes by the fraction `change`.

    K is taken as proportional to size^growth; a `growth` smaller than ROOT in magnitude counts as ROOT.
    """
    return float((1 + change) ** (1 / max(abs(growth), ROOT)) - 1)


def step_length(
    options: GrowthOptions, size: float, front: float, edge: float, growth: float, farthest: float
) -> float:
    """Return the median extension of one step: options.extension or options.share, else a step from K.

    size: crack size; front: length of the shortest front; edge: edge length of the fronts; growth:
    d ln(K) / d ln(size); farthest: largest over median extension. A step from K changes K by
    options.change, but is at most OF_FRONT of the front's length, and is shortened so that no point extends
    by more than MOST times that length. It is at least one edge: a shorter step is a kink within one
    element of the next mesh, where K is unreliable. Steps of 0.8 edges kinked by 53 degrees and again by 58
    in the same direction, where one kink was due.
    """
    if options.extension is not None:
        return options.extension
    if options.share is not None:
        return options.share * size
    own = min(share_of_size(options.change, growth) * size, OF_FRONT * front)
    return max(own * min(1.0, MOST / farthest), edge)
