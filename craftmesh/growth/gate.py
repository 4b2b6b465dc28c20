"""Which points of a front stay where they are, and why."""

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

CLOSED, ARRESTED, NOISE = "closed", "arrested", "noise"
STAYS = {
    CLOSED: "K_I is not over 0",
    ARRESTED: "Delta K is not over grow.threshold",
    NOISE: "K is not over its own doubt",
}
# Of sigma root(pi a): K under that says nothing. With five edges to the radius exact K are off by up to
# 0.43 % of it (the lens and the crystal of docs/fracture.md), and K_II of a penny under compression, which
# is 0, by 0.54 %.
NOISE_SHARE = 0.01
# Flags of points that say nothing: K is the mean of two grains' limits, or of too short a segment, or its
# error is large.
UNTRUSTED = frozenset(("limit", "short", "error"))


class Evidence(NamedTuple):
    """How far K of front points says something: what a driving force is held against.

    points (n, 3); doubt (n,): of K, in its unit. trusted (n,) bool: points that are not stay as the trusted
    ones next to them do. contact: whether the field is one in which
    lips do not overlap, so that K_II of closed lips is true.
    """

    points: np.ndarray
    doubt: np.ndarray
    trusted: np.ndarray
    contact: bool = False


def doubts(error: np.ndarray, stress: float, radius: float) -> np.ndarray:
    """Return the doubt (n,) of K: its own `error` (n,), or what the mesh alone makes.

    That is NOISE_SHARE of what the body's mean `stress` would give a crack of that radius.
    """
    return np.maximum(error, NOISE_SHARE * stress * np.sqrt(np.pi * radius))


def reasons(
    k: np.ndarray,
    driving: np.ndarray,
    span: np.ndarray,
    threshold: float | np.ndarray,
    known: Evidence | None = None,
) -> np.ndarray:
    """Return why each point stays, a word of STAYS, or "" where it goes on: (n,) texts.

    k (n, 3); driving (n,): the intensity that drives a point; span (n,): its Delta K over a cycle, which
    has to be over the threshold. What is known: K is exact by default.
    """
    words = np.full(len(k), "", object)
    known = known or Evidence(np.zeros((len(k), 3)), np.zeros(len(k)), np.ones(len(k), bool))
    words[span <= threshold] = ARRESTED
    if not known.contact:
        words[k[:, 0] <= known.doubt] = CLOSED
    words[driving <= known.doubt] = NOISE
    words[k[:, 0] < -known.doubt] = CLOSED
    if known.trusted.any() and not known.trusted.all():
        _, nearest = cKDTree(known.points[known.trusted]).query(known.points)
        words = np.where(known.trusted, words, words[known.trusted][nearest])
    return words
