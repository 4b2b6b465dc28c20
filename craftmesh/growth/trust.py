"""Which nodes of a crack's fronts steer its growth: the one rule of kinks, rates, strips and the report."""

from collections.abc import Collection, Sequence
from typing import NamedTuple

import numpy as np
import scipy

# Flags of nodes whose K is not that of the front beside them: it has no meaning at the very surface, at the
# end of a material and along a boundary of two, and errs by much elsewhere.
DOUBTED = frozenset(("end", "limit", "interface", "short", "error"))
# Flags of points where the front leaves the body or a grain: they steer where no other node does.
PIERCED = frozenset(("end", "limit", "pierce"))
# Nodes this near to an end of a front, in its edges, are doubted. K_II and K_III have no bound where it
# meets a free surface, and the integrals reach over it: with those nodes the ends of a tilted half penny
# kinked by 35 degrees, to and fro at each increment.
END = 2.0


class Trust(NamedTuple):
    """steers (n,) bool: nodes whose own K counts; doubted: numbers of fronts without one to be trusted."""

    steers: np.ndarray
    doubted: tuple[int, ...]


def trusted(flags: Sequence[str], front: np.ndarray | None = None, s: np.ndarray | None = None) -> Trust:
    """Return which nodes steer, by their flags (n,), words joined by +, fronts (n,) and arc lengths (n,).

    They are those without a flag of DOUBTED, and farther than END edges from the ends of an open front. Of
    a front that has none all do but PIERCED ones, so that it goes as its K says. Without `front` there is
    one, without s the ends are their nodes alone.
    """
    number = np.zeros(len(flags), int) if front is None else np.asarray(front).astype(int)
    steers, pierced, ends = (~_has(flags, DOUBTED), _has(flags, PIERCED), _has(flags, {"end"}))
    doubted = []
    for one in np.unique(number).tolist():
        own = np.flatnonzero(number == one)
        near = np.zeros(len(own), bool)
        if s is not None and len(own) > 1:
            off = np.abs(s[own][:, None] - s[own][ends[own]]).min(axis=1, initial=np.inf)
            near = off < END * np.median(np.diff(s[own]))
        tiers = steers[own] & ~near, ~pierced[own] & ~near, ~pierced[own], np.ones(len(own), bool)
        if not tiers[0].any():
            doubted.append(one)
        steers[own] = next(tier for tier in tiers if tier.any())
    return Trust(steers, tuple(doubted))


def or_all(trusted: np.ndarray, among: np.ndarray) -> np.ndarray:
    """Return the mask (n,) of trusted rows `among` (n,) some, all of these where none is trusted."""
    both = trusted & among
    return both if both.any() else among


def sources(points: np.ndarray, steers: np.ndarray, front: np.ndarray | None = None) -> np.ndarray:
    """Return the node (n,) whose K each node takes: itself where it steers, else the nearest that does.

    points (n, 3). That is one of its own front (n,); a front without any keeps its K.
    """
    number = np.zeros(len(points), int) if front is None else front
    source = np.arange(len(points))
    for one in np.unique(number):
        from_, to = (np.flatnonzero((number == one) & chosen) for chosen in (steers, ~steers))
        if len(from_) and len(to):
            source[to] = from_[scipy.spatial.cKDTree(points[from_]).query(points[to])[1]]
    return source


def doubted_sentence(fronts: Collection[int]) -> str:
    """Return in words that no node of the fronts is trusted, and which nodes count instead."""
    which = f"front{'s' * (len(fronts) > 1)} {', '.join(map(str, fronts))}"
    there = "all count but those where it leaves the body or a grain"
    return f"no node of {which} has a K to be trusted, so {there}"


def _has(cells: Sequence[str], words: Collection[str]) -> np.ndarray:
    """Return which cells (n,), words joined by +, hold one of `words`."""
    return np.array([not set(words).isdisjoint(str(cell).split("+")) for cell in cells], bool)
