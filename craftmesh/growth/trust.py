"""Select the front nodes that steer growth: one rule for kinks, rates, strips and the report."""

from collections.abc import Collection, Sequence
from typing import NamedTuple

import numpy as np
import scipy

# Flags of nodes whose K does not represent the front: it has no meaning at a free surface, at the end of a
# material or along an interface, and has a large error at the others.
DOUBTED = frozenset(("end", "limit", "interface", "short", "error"))
# Flags of nodes where the front leaves the body or a grain; they do not steer if any other node can.
PIERCED = frozenset(("end", "limit", "pierce"))
# Distance from a front's end, in front edges, within which nodes are doubted. K_II and K_III are unbounded
# where a front meets a free surface, and integration domains reach over it: with these nodes the ends of a
# tilted half penny kinked by 35 degrees, alternating in sign, at each increment.
END = 2.0


class Trust(NamedTuple):
    """steers (n,): True at nodes whose own K counts; doubted: numbers of fronts without a reliable node."""

    steers: np.ndarray
    doubted: tuple[int, ...]


def trusted(flags: Sequence[str], front: np.ndarray | None = None, s: np.ndarray | None = None) -> Trust:
    """Return the nodes that steer, from their flags (n,), words joined by +, front numbers and arc lengths.

    A node steers if it has no flag of DOUBTED and is at least END edges from each end of its front. On a
    front without such nodes, all except PIERCED ones steer, farther than END edges from the ends if
    possible; if all are PIERCED, all steer. front (n,): None means one front; s (n,): arc lengths, None
    skips END.
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
    """Return the mask (n,) of rows that are trusted and `among` (n,); `among` itself if there are none."""
    both = trusted & among
    return both if both.any() else among


def sources(points: np.ndarray, steers: np.ndarray, front: np.ndarray | None = None) -> np.ndarray:
    """Return the index (n,) of the node whose K each node takes: its own if it steers (n,).

    Other nodes take K of the nearest steering node on their front (n,), or their own if it has none.
    """
    number = np.zeros(len(points), int) if front is None else front
    source = np.arange(len(points))
    for one in np.unique(number):
        from_, to = (np.flatnonzero((number == one) & chosen) for chosen in (steers, ~steers))
        if len(from_) and len(to):
            source[to] = from_[scipy.spatial.cKDTree(points[from_]).query(points[to])[1]]
    return source


def doubted_sentence(fronts: Collection[int]) -> str:
    """Return a sentence: no node of `fronts` (numbers) is reliable, and which nodes count instead."""
    which = f"front{'s' * (len(fronts) > 1)} {', '.join(map(str, fronts))}"
    there = "all nodes count except those where a front leaves the body or a grain"
    return f"no node of {which} has a reliable K, so {there}"


def _has(cells: Sequence[str], words: Collection[str]) -> np.ndarray:
    """Return a mask (n,) of cells, words joined by +, that contain one of `words`."""
    return np.array([not set(words).isdisjoint(str(cell).split("+")) for cell in cells], bool)
