"""Load cycles along the path of a crack, from da/dN at the fronts that were solved."""

import math
from typing import NamedTuple

ROOT = 0.5  # K of a crack under a load that stays goes with the root of its size


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
    way = abs(_even(last.step, last.rate, rate) / found - 1)
    return last.cycles + found, last.doubt + found * (way + (last.power * last.error + error) / 2)


def cycles_over(step: float, size: float, rate: float, growth: float) -> float:
    """Return the cycles of a step from a crack of that size: da/dN is `rate`, and goes with size^growth."""
    stretch, left = math.log1p(step / size), 1 - growth
    return size / rate * (math.expm1(left * stretch) / left if left else stretch)


def _even(step: float, rate: float, reached: float) -> float:
    """Return the cycles of a step along which ln(da/dN) goes evenly from one rate to another."""
    change = math.log(reached / rate)
    return step / rate * (-math.expm1(-change) / change if change else 1.0)
