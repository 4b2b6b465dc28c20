"""How far a step of a crack's front goes, by the crack's size, and the load cycles that it takes."""

import math
from typing import NamedTuple

import numpy as np
import scipy

from craftmesh.cracks.polyline import polyline
from craftmesh.growth.options import MOST, GrowthOptions
from craftmesh.surface.dividing import bisected
from craftmesh.types import Crack

ROOT = 0.5  # K of a crack under a load that stays goes with the root of its size
# Of itself: how far the crack's size may be off, and of a front's length: the spacing of places on it.
TOLERANCE = 1e-3
# Of a front's length: in a step of it K along the front, by Paris' law with m = 3, loses the longest
# difference that a front can have, half a wave, but for 1 / e: 2 / (pi m) (see `relaxation`).
OF_FRONT = 0.2


class Counted(NamedTuple):
    """A front, and the cycles to it: what the next one's are counted from.

    size: of the crack; step: how far the front goes on from here; rate: da/dN, the median of the points
    that go on; power: d ln(da/dN) / d ln(K) there; error: of K, as a share. cycles, doubt: from the first
    front to this one, and how far off that may be; ahead, ahead_doubt: of the step to come.
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


def growth_to(last: Counted | None, rate: float, power: float) -> float:
    """Return d ln(da/dN) / d ln(size) on the way from the last front to one with that rate.

    Where no front is known before, K goes with the root of the size.
    """
    if last is None:
        return ROOT * power
    return math.log(rate / last.rate) / math.log1p(last.step / last.size)


def counted(
    last: Counted | None, size: float, step: float, rate: float, power: float, error: float
) -> Counted:
    """Return the cycles to a front and those of its step, from what is known of it and of the last one.

    Between two fronts da/dN goes with a power of the crack's size, as it does of a penny, an edge and a
    through crack; in the step to come the power is that of the step before. In doubt are the way between
    two fronts, against one along which ln(da/dN) goes evenly; K's own errors, which may all have one sign;
    and the whole change of K in the step to come. A front whose rate is 0 goes no step.
    """
    cycles, doubt = _reached(last, rate, power * error) if last is not None else (0.0, 0.0)
    ahead = ahead_doubt = 0.0
    if rate > 0:
        ahead = cycles_over(step, size, rate, growth_to(last, rate, power))
        ahead_doubt = abs(ahead - step / rate) + ahead * power * error
    return Counted(size, step, rate, power, error, cycles, doubt, ahead, ahead_doubt)


def _reached(last: Counted, rate: float, error: float) -> tuple[float, float]:
    """Return the cycles to a front with that rate and error of it, as a share, and their doubt.

    To a front that does not go on any more they are those that were foreseen.
    """
    if not rate > 0:
        return last.cycles + last.ahead, last.doubt + last.ahead_doubt
    found = cycles_over(last.step, last.size, last.rate, growth_to(last, rate, last.power))
    change = math.log(rate / last.rate)
    even = last.step / last.rate * (-math.expm1(-change) / change if change else 1.0)
    way = abs(even / found - 1)
    return last.cycles + found, last.doubt + found * (way + (last.power * last.error + error) / 2)


def cycles_over(step: float, size: float, rate: float, growth: float) -> float:
    """Return the cycles of a step from a crack of that size: da/dN is `rate`, and goes with size^growth."""
    stretch, left = math.log1p(step / size), 1 - growth
    return size / rate * (math.expm1(left * stretch) / left if left else stretch)


def crack_size(crack: Crack, box: np.ndarray) -> float:
    """Return the crack's size: the largest distance of a point of it in the box (2, 3) from its fronts.

    That is the radius of a penny and a half penny, the lesser semi-axis of an ellipse, the depth of an edge
    crack, the half width of a through crack. Triangles that may hold a farther point than the farthest
    centre known are split, and again.
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
    """Return the step, over the crack's size, in which K changes by a share: it goes with size^growth.

    Where K changes less than with the root of the size it counts as that.
    """
    return float((1 + change) ** (1 / max(abs(growth), ROOT)) - 1)


def step_length(
    options: GrowthOptions, size: float, front: float, edge: float, growth: float, farthest: float
) -> float:
    """Return how far the front of a crack goes in one step: as the options say, else as K lets it.

    front: length of the shortest front; edge: of its mesh; growth: d ln(K) / d ln(size). A step of its own
    is no longer than OF_FRONT, and no shorter than an edge: that were a kink within one element of the next
    mesh, and K there says little. Steps of 0.8 edges kinked by 53 degrees, and by 58 the same way again,
    where one kink was due. farthest: the largest extension over the median. A step of its own is so short
    that no point goes farther than MOST times what K lets the median go.
    """
    if options.extension is not None:
        return options.extension
    if options.share is not None:
        return options.share * size
    own = min(share_of_size(options.change, growth) * size, OF_FRONT * front)
    return max(own * min(1.0, MOST / farthest), edge)
