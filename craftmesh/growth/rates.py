"""Laws of da/dN, for all grains, by phase or by grain, and the crack closure in a cycle."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.growth.front_points import FrontPoints
from craftmesh.growth.options import GrowthOptions
from craftmesh.options import import_user_callable, returned_array

GRAIN = "GRAIN_"
Key = int | str | None


class LoadCycle(NamedTuple):
    """A load cycle at n front points; user-supplied laws get this record.

    driving (n,): driving force, the combination of K_I, K_II and K_III in the unit of K, at the peak (the
    end of the cycle where it is larger); ratio (n,): stress ratio R; delta_k (n,): effective Delta K, with
    closure; angle (n,): kink angle, radians; front: the points, with K at the peak.
    """

    driving: np.ndarray
    ratio: np.ndarray
    delta_k: np.ndarray
    angle: np.ndarray
    front: FrontPoints

    def scaled(self, scale: float) -> "LoadCycle":
        """Return the cycle at `scale` times the loads; the kink angles are not computed again."""
        return self._replace(
            driving=scale * self.driving,
            delta_k=scale * self.delta_k,
            front=self.front.with_k(scale * self.front.k),
        )


def largest(cycles: Sequence[LoadCycle]) -> LoadCycle:
    """Return one load cycle with each point's values from the cycle of largest driving force there."""
    which = np.argmax([one.driving for one in cycles], axis=0)
    row = np.arange(len(which))
    parts = zip(*((one.driving, one.ratio, one.delta_k, one.angle, one.front.k) for one in cycles))
    driving, ratio, delta_k, angle, k = (np.stack(part)[which, row] for part in parts)
    return LoadCycle(driving, ratio, delta_k, angle, cycles[0].front.with_k(k))


class RateLaw(NamedTuple):
    """A law of da/dN.

    rate: function that returns da/dN (n,) of a load cycle, 0 up to the threshold and inf from K_c on;
    has_ratio: True if the law contains the effect of R, so that options.closure must be none.
    """

    rate: Callable[[LoadCycle], np.ndarray]
    has_ratio: bool = False


def paris(coefficient: float, exponent: float, threshold: float = 0.0) -> RateLaw:
    """Return Paris' law da/dN = C Delta K^m, for Delta K above a threshold."""
    return RateLaw(lambda cycle: _power(cycle.delta_k, coefficient, exponent, threshold))


def walker(coefficient: float, exponent: float, gamma: float, threshold: float = 0.0) -> RateLaw:
    """Return Walker's law da/dN = C (Delta K / (1 - R)^(1 - gamma))^m; a negative R counts as 0.

    threshold: of Delta K at R = 0.
    """

    def rate(cycle: LoadCycle) -> np.ndarray:
        at_zero = cycle.driving * (1 - np.maximum(cycle.ratio, 0.0)) ** gamma
        return _power(at_zero, coefficient, exponent, threshold)

    return RateLaw(rate, True)


def forman(coefficient: float, exponent: float, toughness: float, threshold: float = 0.0) -> RateLaw:
    """Return Forman's law da/dN = C Delta K^m / ((1 - R) K_c - Delta K), for Delta K above a threshold.

    A negative R counts as 0; da/dN is inf from K_c on. Raise ValueError for K_c, `toughness`, <= 0.
    """
    if toughness <= 0:
        raise ValueError

    def rate(cycle: LoadCycle) -> np.ndarray:
        opens, left = 1 - np.maximum(cycle.ratio, 0.0), toughness - cycle.driving
        scale = np.where((opens > 0) & (left > 0), opens * left, 1.0)
        found = _power(opens * cycle.driving, coefficient, exponent, threshold) / scale
        return np.where(left > 0, found, np.inf)

    return RateLaw(rate, True)


def nasgro(*constants: float) -> RateLaw:
    """Return the NASGRO equation of long cracks (AFGROW's manual, AFRL-VA-WP-TR-1999-3016).

    constants: C, n, p, q, threshold at R = 0, C_th at R >= 0 and at R < 0, K_c, and Newman's alpha and
    S_max. da/dN = C ((1 - f) K_max)^n (1 - Delta K_th / Delta K)^p / (1 - K_max / K_c)^q with Newman's f
    (`opening_level`), Delta K = (1 - R) K_max, and K_max the driving force. Raise ValueError for constants
    out of bounds.
    """
    c, n, p, q, at_zero, above, below, toughness, alpha, largest = constants
    if not (toughness > 0 and 1 <= alpha <= 3 and 0 < largest < 1):
        raise ValueError
    level = float(opening_level(np.zeros(1), alpha, largest)[0])

    def rate(cycle: LoadCycle) -> np.ndarray:
        ratio = np.minimum(cycle.ratio, 1 - np.finfo(float).eps)
        opens = 1 - opening_level(ratio, alpha, largest)
        power = 1 + np.where(ratio < 0, below, above) * ratio
        threshold = at_zero / (opens / ((1 - level) * (1 - ratio))) ** power
        delta_k = (1 - ratio) * np.maximum(cycle.driving, np.finfo(float).tiny)
        beyond = np.maximum(delta_k - threshold, 0.0) / delta_k
        left = 1 - cycle.driving / toughness
        found = _power(opens * cycle.driving, c, n) * beyond**p * (beyond > 0)
        return np.where(left > 0, found / np.where(left > 0, left, 1.0) ** q, np.inf)

    return RateLaw(rate, True)


def table(*pairs: float) -> RateLaw:
    """Return the law through points, linear in ln(Delta K) and ln(da/dN).

    pairs: Delta K, da/dN, Delta K, da/dN and so on, rising; the first Delta K is the threshold.
    """
    points = _rising(np.reshape(pairs, (-1, 2)))
    return RateLaw(lambda cycle: _through(points, cycle.delta_k))


def table_of_ratios(*triples: float) -> RateLaw:
    """Return the law through points R, Delta K, da/dN, for each R as `table`, with ln(da/dN) linear in R.

    The threshold, the first Delta K of each R, is linear in R too. Beyond the table's R its smallest or
    largest R applies; Delta K of a smaller R is then the range from the smallest R at the same peak.
    """
    rows = np.reshape(triples, (-1, 3))
    ratios = np.unique(rows[:, 0])
    if ratios[-1] >= 1:
        raise ValueError
    curves = [_rising(rows[rows[:, 0] == one][:, 1:]) for one in ratios]

    def rate(cycle: LoadCycle) -> np.ndarray:
        ratio = np.clip(cycle.ratio, ratios[0], ratios[-1])
        delta_k = (1 - np.maximum(cycle.ratio, ratios[0])) * cycle.driving
        threshold = np.interp(ratio, ratios, [points[0, 0] for points in curves])
        logs = [np.log(_through(points, delta_k, beyond=True)) for points in curves]
        upper = np.minimum(np.searchsorted(ratios, ratio, "right"), len(ratios) - 1)
        lower, row = np.maximum(upper - 1, 0), np.arange(len(ratio))
        gap = ratios[upper] - ratios[lower]
        share = (ratio - ratios[lower]) / np.where(gap > 0, gap, 1.0)
        stacked = np.stack(logs)
        found = np.exp((1 - share) * stacked[lower, row] + share * stacked[upper, row])
        return np.where(delta_k > threshold, found, 0.0)

    return RateLaw(rate, True)


def _power(delta_k: np.ndarray, coefficient: float, exponent: float, threshold: float = 0.0) -> np.ndarray:
    """Return da/dN (n,): coefficient times Delta K (n,) to the power exponent, 0 up to the threshold."""
    grows = delta_k > threshold
    return np.where(grows, coefficient * np.where(grows, delta_k, 1.0) ** exponent, 0.0)


def _through(points: np.ndarray, delta_k: np.ndarray, beyond: bool = False) -> np.ndarray:
    """Return the rate (n,) at Delta K (n,), linear in both logarithms between points (k, 2).

    points: Delta K and rate, rising. Beyond the last point the line through the last two goes on. Up to the
    first point the rate is 0 or, with `beyond`, on the line through the first two.
    """
    given, rates = np.log(points.T)
    powers = np.diff(rates) / np.diff(given)
    grows = (delta_k > points[0, 0]) | (beyond & (delta_k > 0))
    at = np.log(np.where(grows, delta_k, points[0, 0]))
    cell = np.clip(np.searchsorted(given, at) - 1, 0, len(powers) - 1)
    tiny = 0.0 if not beyond else np.finfo(float).tiny
    return np.where(grows, np.exp(rates[cell] + powers[cell] * (at - given[cell])), tiny)


def _rising(points: np.ndarray) -> np.ndarray:
    """Return the given points (k, 2), Delta K and da/dN, unchanged.

    Raise ValueError unless there are at least two, and both columns are positive and strictly rising.
    """
    if len(points) < 2 or not (np.diff(points, axis=0, prepend=0.0) > 0).all():
        raise ValueError
    return points


KINDS: dict[str, Callable[..., RateLaw]] = {
    "paris": paris,
    "walker": walker,
    "forman": forman,
    "nasgro": nasgro,
    "table": table,
    "table_of_ratios": table_of_ratios,
}
FORMS = (
    "paris:C,m[,THRESHOLD], walker:C,m,GAMMA[,THRESHOLD], forman:C,m,K_C[,THRESHOLD], "
    "nasgro:C,n,p,q,DELTA_K_0,C_TH,C_TH_BELOW,K_C,ALPHA,SMAX, table:DELTA_K,RATE,..., "
    "table_of_ratios:R,DELTA_K,RATE,... or package.module:function"
)


class LocalRates(NamedTuple):
    """The rate laws of n front points; which (n,): each point's index into `laws`."""

    laws: tuple[RateLaw, ...]
    which: np.ndarray

    def rate(self, cycle: LoadCycle) -> np.ndarray:
        """Return da/dN (n,) of the points in a load cycle; raise CraftmeshError for invalid values."""
        expected = f"{len(self.which)} rates, 0 or above, one per front point"
        rates = [returned_array("grow.rates: a law", law.rate(cycle), expected) for law in self.laws]
        for values in rates:
            if values.shape != self.which.shape or not (values >= 0).all():
                raise CraftmeshError(
                    f"grow.rates: a law returned an invalid array of shape {values.shape}; "
                    f"expected {expected}"
                )
        return np.stack(rates)[self.which, np.arange(len(self.which))]


def laws_of(options: GrowthOptions) -> dict[Key, RateLaw]:
    """Return the options' rate laws by phase, GRAIN_<id>, or None for all grains.

    Without rates and coefficient, C of Paris' law is 1: relative extensions are right, cycles unknown.
    Raise CraftmeshError for invalid laws and for options that contradict them.
    """
    if not options.rates:
        return {None: paris(options.coefficient or 1.0, options.exponent, options.threshold)}
    if options.coefficient or options.threshold:
        raise CraftmeshError(
            "grow.rates is given together with grow.coefficient or grow.threshold; remove the latter, each "
            "law in grow.rates contains its own C and threshold"
        )
    laws = parse_rates(options.rates)
    if options.closure != "none" and any(law.has_ratio for law in laws.values()):
        raise CraftmeshError(
            f"grow.closure is {options.closure!r}, but a law in grow.rates contains the effect of R; set "
            "closure none, or give laws paris, table or your own"
        )
    return laws


def local_rates(laws: Mapping[Key, RateLaw], grain: np.ndarray, phase: np.ndarray) -> LocalRates:
    """Return the laws at points in grains (n,): the grain's law, else its phase's, else the general one.

    phase (n,): by point, 0 if there is none. Raise CraftmeshError for a grain without a law.
    """
    keys = list(laws)
    which = np.zeros(len(grain), int)
    for own, of in np.unique(np.column_stack([grain, phase]), axis=0).tolist():
        found = [key for key in (f"{GRAIN}{own}", of, None) if key in laws]
        if not found:
            raise CraftmeshError(
                f"grow.rates has no law for grain {own} of phase {of}, which the front crosses; add "
                f"{of}=KIND:CONSTANTS or {GRAIN}{own}=KIND:CONSTANTS"
            )
        which[grain == own] = keys.index(found[0])
    return LocalRates(tuple(laws.values()), which)


def parse_rates(texts: Iterable[str]) -> dict[Key, RateLaw]:
    """Return the laws in texts such as "2=paris:1e-12,3", keyed by phase, GRAIN_<id>, or None for all.

    Raise CraftmeshError for a text of another form, and for two laws with one key.
    """
    laws: dict[Key, RateLaw] = {}
    for text in texts:
        place, named, law = text.rpartition("=")
        try:
            of_grain = place.startswith(GRAIN) and place.removeprefix(GRAIN).isdecimal()
            key = None if not named else place if of_grain else int(place)
            found = _law(*law.split(":"))
        except (ValueError, TypeError, KeyError):
            raise CraftmeshError(
                f"grow.rates: {text!r} is not a law; write {FORMS}, with rising positive numbers in "
                f"tables; PHASE= or {GRAIN}<id>= may precede it"
            ) from None
        if key in laws:
            raise CraftmeshError(f"grow.rates: {text!r} is a second law for the same grains; keep one")
        laws[key] = found
    return laws


def _law(kind: str, constants: str) -> RateLaw:
    """Return the law of a kind of KINDS with constants, numbers joined by commas, or a user's function.

    The function is named by `kind`, its module, and `constants`, its name. Raise ValueError, TypeError or
    KeyError if the constants are invalid.
    """
    if kind not in KINDS and constants.isidentifier():
        return RateLaw(import_user_callable("rates", f"{kind}:{constants}", tuple(KINDS)))
    values = [float(value) for value in constants.split(",")]
    positive = "table" in kind or (values[0] > 0 and min(values) >= 0)
    if not positive or not all(map(math.isfinite, values)):
        raise ValueError
    return KINDS[kind](*values)


def open_share(closure: str, stress_ratio: np.ndarray) -> np.ndarray:
    """Return the effective Delta K of cycles with stress ratios R (n,), divided by K at their peak.

    closure none: 1 - R, with R < 0 as 0, because closed crack faces carry compression; open:U: U (1 - R);
    newman:ALPHA,SMAX: 1 - f with the opening function f of J. C. Newman, Int. J. Fract. 24 (1984),
    constraint factor ALPHA, and SMAX = largest stress / flow stress. Raise CraftmeshError for any other
    `closure`.
    """
    kind, _, constants = closure.partition(":")
    try:
        values = [float(value) for value in constants.split(",")] if constants else []
        if kind == "none" and not values:
            return 1 - np.maximum(stress_ratio, 0.0)
        if kind == "open" and len(values) == 1 and 0 < values[0] <= 1:
            return values[0] * (1 - stress_ratio)
        if kind == "newman" and len(values) == 2 and 1 <= values[0] <= 3 and 0 < values[1] < 1:
            return 1 - opening_level(stress_ratio, *values)
    except ValueError:
        pass
    raise CraftmeshError(
        f"grow.closure is {closure!r}; expected none, open:U with 0 < U <= 1, or newman:ALPHA,SMAX with "
        "1 <= ALPHA <= 3 and 0 < SMAX < 1"
    )


def opening_level(ratio: np.ndarray, alpha: float, largest: float) -> np.ndarray:
    """Return Newman's f (n,), the crack opening load divided by the largest load, for stress ratios (n,).

    alpha: constraint factor; largest: largest stress / flow stress.
    """
    a0 = (0.825 - 0.34 * alpha + 0.05 * alpha**2) * math.cos(math.pi / 2 * largest) ** (1 / alpha)
    a1 = (0.415 - 0.071 * alpha) * largest
    a3 = 2 * a0 + a1 - 1
    a2 = 1 - a0 - a1 - a3
    opens = a0 + a1 * ratio
    return np.where(ratio < 0, opens, np.maximum(ratio, opens + a2 * ratio**2 + a3 * ratio**3))
