"""Select the front nodes that steer growth, that is, whose own K counts.

The same rule holds for kink angles, rates, the strips of new crack surface, and the report.
"""

from collections.abc import Collection, Sequence
from typing import NamedTuple

import numpy as np
import scipy

# Flags of nodes whose K does not represent the front. K has no meaning at a free surface (end), at the end
# of a material (limit) or along an interface; at nodes flagged short or error it has a large error.
DOUBTED = frozenset(("end", "limit", "interface", "short", "error"))
# Flags of nodes where the front leaves the body or a grain; they do not steer if any other node can.
PIERCED = frozenset(("end", "limit", "pierce"))
# Distance from a front's end, in front edges, within which nodes do not steer. K_II and K_III are unbounded
# where a front meets a free surface, and integration domains reach beyond it: with these nodes the ends of
# a tilted half penny kinked by 35 degrees, alternating in sign, at each increment.
END = 2.0


class Trust(NamedTuple):
    """steers (n,): mask of nodes whose own K counts; doubted: numbers of fronts without a reliable node."""

    steers: np.ndarray
    doubted: tuple[int, ...]


def trusted(flags: Sequence[str], front: np.ndarray | None = None, s: np.ndarray | None = None) -> Trust:
    """Return the nodes that steer, and the fronts without reliable nodes.

    flags (n,): each node's flags, words joined by +. front (n,): front numbers, None means one front; s
    (n,): arc lengths, None skips the distance from the ends. A node is reliable and steers if it has no
    flag of DOUBTED and is at least END edges from each end of its front. On a front without such nodes, all
    except PIERCED nodes steer, at least END edges from the ends if possible; if all are PIERCED, all steer.
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
    """Return the row (n,) of the node whose K each node takes.

    A node that steers (n,) takes its own K; others take K of the nearest steering node on their front, or
    their own if there is none. points (n, 3); front (n,): front numbers, None means one front.
    """
    number = np.zeros(len(points), int) if front is None else front
    source = np.arange(len(points))
    for one in np.unique(number):
        from_, to = (np.flatnonzero((number == one) & chosen) for chosen in (steers, ~steers))
        if len(from_) and len(to):
            source[to] = from_[scipy.spatial.cKDTree(points[from_]).query(points[to])[1]]
    return source


def doubted_sentence(fronts: Collection[int]) -> str:
    """Return a sentence: no node of `fronts` (numbers) has a reliable K, and which nodes count instead."""
    which = f"front{'s' * (len(fronts) > 1)} {', '.join(map(str, fronts))}"
    there = "all nodes count except those where a front leaves the body or a grain"
    return f"no node of {which} has a reliable K, so {there}"


def _has(cells: Sequence[str], words: Collection[str]) -> np.ndarray:
    """Return a mask (n,) of cells, words joined by +, that contain one of `words`."""
    return np.array([not set(words).isdisjoint(str(cell).split("+")) for cell in cells], bool)
