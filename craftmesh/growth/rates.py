"""Laws of da/dN as a function of Delta K, for all grains, by phase or by grain."""

import math
from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.growth.options import GrowthOptions

PARIS, TABLE, GRAIN = "paris", "table", "GRAIN_"
Key = int | str | None


class RateLaw(NamedTuple):
    """da/dN as a function of Delta K, log-log linear between points; 0 up to the threshold.

    delta_k, rate (k,): the points, ascending; powers (k + 1,): exponents before, between and after the
    points.
    """

    delta_k: np.ndarray
    rate: np.ndarray
    powers: np.ndarray
    threshold: float

    def power_at(self, delta_k: np.ndarray) -> np.ndarray:
        """Return d ln(da/dN) / d ln(Delta K) at Delta K (n,)."""
        return self.powers[np.searchsorted(self.delta_k, delta_k)]

    def rate_at(self, delta_k: np.ndarray) -> np.ndarray:
        """Return da/dN at Delta K (n,)."""
        nearest = np.maximum(np.searchsorted(self.delta_k, delta_k) - 1, 0)
        grows = delta_k > self.threshold
        ratio = np.where(grows, delta_k, 1.0) / self.delta_k[nearest]
        return np.where(grows, self.rate[nearest] * ratio ** self.power_at(delta_k), 0.0)


def paris(coefficient: float, exponent: float, threshold: float = 0.0) -> RateLaw:
    """Return Paris' law da/dN = C Delta K^m, for Delta K above a threshold."""
    return RateLaw(np.ones(1), np.array([coefficient]), np.full(2, exponent), threshold)


def table(delta_k: np.ndarray, rate: np.ndarray) -> RateLaw:
    """Return the law through points; the first is its threshold, the last two set it beyond the last."""
    powers = np.diff(np.log(rate)) / np.diff(np.log(delta_k))
    return RateLaw(delta_k, rate, np.concatenate([powers[:1], powers, powers[-1:]]), float(delta_k[0]))


class LocalRates(NamedTuple):
    """The rate laws of n front points; which (n,): each point's index into `laws`."""

    laws: tuple[RateLaw, ...]
    which: np.ndarray

    def rate(self, delta_k: np.ndarray) -> np.ndarray:
        """Return da/dN (n,) of the points at their Delta K (n,)."""
        return self._own([law.rate_at(delta_k) for law in self.laws])

    def power(self, delta_k: np.ndarray) -> np.ndarray:
        """Return the exponents d ln(da/dN) / d ln(Delta K) (n,) of the points at their Delta K (n,)."""
        return self._own([law.power_at(delta_k) for law in self.laws])

    @property
    def threshold(self) -> np.ndarray:
        """The threshold of Delta K (n,) of each point."""
        return np.array([law.threshold for law in self.laws])[self.which]

    def _own(self, values: list[np.ndarray]) -> np.ndarray:
        return np.stack(values)[self.which, np.arange(len(self.which))]


def laws_of(options: GrowthOptions) -> dict[Key, RateLaw]:
    """Return the laws of the options; raise CraftmeshError if rates come with coefficient or threshold.

    Without rates and coefficient, C of Paris' law is 1: relative extensions are right, cycles unknown.
    """
    if not options.rates:
        return {None: paris(options.coefficient or 1.0, options.exponent, options.threshold)}
    if options.coefficient or options.threshold:
        raise CraftmeshError(
            "grow.rates is given together with grow.coefficient or grow.threshold; remove the latter, each "
            "law in grow.rates contains its own C and threshold"
        )
    return parse_rates(options.rates)


def local_rates(
    laws: Mapping[Key, RateLaw], grain: np.ndarray, phase_of: Mapping[int, int | None]
) -> LocalRates:
    """Return the laws at points in grains (n,): the grain's law, else its phase's, else the general one.

    phase_of: phase by grain. Raise CraftmeshError for a grain without a law.
    """
    keys = list(laws)
    which = np.zeros(len(grain), int)
    for own in np.unique(grain).tolist():
        phase = phase_of.get(own)
        found = [key for key in (f"{GRAIN}{own}", phase, None) if key in laws]
        if not found:
            raise CraftmeshError(
                f"grow.rates has no law for grain {own} of phase {phase}, which the front crosses; add "
                f"{phase}=KIND:CONSTANTS or {GRAIN}{own}=KIND:CONSTANTS"
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
        except (ValueError, TypeError):
            raise CraftmeshError(
                f"grow.rates: {text!r} is not a law; write paris:C,m, paris:C,m,THRESHOLD or table:DELTA_K,"
                f"RATE,... with rising positive numbers; PHASE= or {GRAIN}<id>= may precede it"
            ) from None
        if key in laws:
            raise CraftmeshError(f"grow.rates: {text!r} is a second law for the same grains; keep one")
        laws[key] = found
    return laws


def _law(kind: str, constants: str) -> RateLaw:
    """Return the law of a kind and its constants; raise ValueError or TypeError if they are invalid."""
    values = np.array([float(value) for value in constants.split(",")])
    if not np.isfinite(values).all():
        raise ValueError
    if kind == PARIS and values[0] > 0 and (values[1:] >= 0).all():
        return paris(*values.tolist())
    points, rates = values[::2], values[1::2]
    rises = len(points) > 1 and points[0] > 0 and (np.diff(points) > 0).all()
    if kind == TABLE and len(points) == len(rates) and rises and (np.diff(rates, prepend=0.0) > 0).all():
        return table(points, rates)
    raise ValueError


def open_share(closure: str, stress_ratio: np.ndarray) -> np.ndarray:
    """Return the effective Delta K of cycles with stress ratios R (n,), divided by K at the largest load.

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
