"""How fast a point of a front extends: da/dN over Delta K, by phase or by grain."""

import math
from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.growth.options import GrowthOptions

PARIS, TABLE, GRAIN = "paris", "table", "GRAIN_"
Key = int | str | None


class RateLaw(NamedTuple):
    """da/dN over Delta K, straight in logarithms between points; nothing grows up to the threshold.

    delta_k, rate (k,) of the points, ascending; powers (k + 1,): before the first, between them, after.
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
    """Return da/dN = C Delta K^m, for Delta K over a threshold."""
    return RateLaw(np.ones(1), np.array([coefficient]), np.full(2, exponent), threshold)


def table(delta_k: np.ndarray, rate: np.ndarray) -> RateLaw:
    """Return the law through points; its threshold is their first, and it goes on after the last."""
    powers = np.diff(np.log(rate)) / np.diff(np.log(delta_k))
    return RateLaw(delta_k, rate, np.concatenate([powers[:1], powers, powers[-1:]]), float(delta_k[0]))


class LocalRates(NamedTuple):
    """The laws of the points of a front: which (n,) of `laws` holds at each."""

    laws: tuple[RateLaw, ...]
    which: np.ndarray

    def rate(self, delta_k: np.ndarray) -> np.ndarray:
        """Return da/dN (n,) at Delta K (n,) of the points."""
        return self._own([law.rate_at(delta_k) for law in self.laws])

    def power(self, delta_k: np.ndarray) -> np.ndarray:
        """Return d ln(da/dN) / d ln(Delta K) (n,)."""
        return self._own([law.power_at(delta_k) for law in self.laws])

    @property
    def threshold(self) -> np.ndarray:
        """The Delta K (n,) that the points have to be over."""
        return np.array([law.threshold for law in self.laws])[self.which]

    def _own(self, values: list[np.ndarray]) -> np.ndarray:
        return np.stack(values)[self.which, np.arange(len(self.which))]


def laws_of(options: GrowthOptions) -> dict[Key, RateLaw]:
    """Return the laws of the options; raises CraftmeshError for rates beside coefficient or threshold.

    Without a coefficient that of Paris' law is 1: what extensions go with, but no cycles.
    """
    if not options.rates:
        return {None: paris(options.coefficient or 1.0, options.exponent, options.threshold)}
    if options.coefficient or options.threshold:
        raise CraftmeshError(
            "grow.rates is given, and grow.coefficient or grow.threshold too; keep one, rates have C and "
            "the threshold in their texts"
        )
    return parse_rates(options.rates)


def local_rates(
    laws: Mapping[Key, RateLaw], grain: np.ndarray, phase_of: Mapping[int, int | None]
) -> LocalRates:
    """Return the laws at points in grains (n,): the grain's own, else its phase's, else that of all.

    Raises CraftmeshError for a grain without a law.
    """
    keys = list(laws)
    which = np.zeros(len(grain), int)
    for own in np.unique(grain).tolist():
        phase = phase_of.get(own)
        found = [key for key in (f"{GRAIN}{own}", phase, None) if key in laws]
        if not found:
            raise CraftmeshError(
                f"grow.rates has no law for grain {own} of phase {phase}, in which the front runs; add "
                f"{phase}=KIND:CONSTANTS or {GRAIN}{own}=KIND:CONSTANTS"
            )
        which[grain == own] = keys.index(found[0])
    return LocalRates(tuple(laws.values()), which)


def parse_rates(texts: Iterable[str]) -> dict[Key, RateLaw]:
    """Return laws by phase, by GRAIN_<id>, or for all (None), of texts such as "2=paris:1e-12,3".

    Raises CraftmeshError for other texts, and for two of one key.
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
                f"grow.rates: {text!r}; expected paris:C,m, paris:C,m,THRESHOLD or table:DELTA_K,RATE,... "
                f"of rising positive numbers, after PHASE= or {GRAIN}<id>= where it is not for all"
            ) from None
        if key in laws:
            raise CraftmeshError(f"grow.rates: {text!r} is a second law for the same place; keep one")
        laws[key] = found
    return laws


def _law(kind: str, constants: str) -> RateLaw:
    """Return the law of a kind and its constants; raises ValueError or TypeError for what is none."""
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
    """Return Delta K that drives a crack, over K of the largest load, of cycles with ratios R (n,).

    closure none: 1 - R, with R < 0 as 0, for closed lips carry the rest; open:U: U (1 - R);
    newman:ALPHA,SMAX: 1 - f, the opening function of J. C. Newman, Int. J. Fract. 24 (1984), with the
    constraint factor ALPHA and the largest stress over the flow stress SMAX. Raises CraftmeshError else.
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
    """Return Newman's f (n,), the load at which the crack opens over the largest one."""
    a0 = (0.825 - 0.34 * alpha + 0.05 * alpha**2) * math.cos(math.pi / 2 * largest) ** (1 / alpha)
    a1 = (0.415 - 0.071 * alpha) * largest
    a3 = 2 * a0 + a1 - 1
    a2 = 1 - a0 - a1 - a3
    opens = a0 + a1 * ratio
    return np.where(ratio < 0, opens, np.maximum(ratio, opens + a2 * ratio**2 + a3 * ratio**3))
