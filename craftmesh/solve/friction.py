"""Coulomb friction of lips that touch: which pairs of nodes stick, and the forces on pairs that slide."""

from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from craftmesh.mesh.front_curve import unit
from craftmesh.mesh.lips import LipPairs

# Largest number of releases of a pair from sticking. A pair that sticks again after these keeps sticking.
# In 6 of 161 pressed blocks the force of such a pair exceeds its limit, by up to 0.2 % of the largest
# normal force. With 3 releases it does in 16 blocks, by up to 5 %.
_MOST_RELEASES = 10


class Friction(NamedTuple):
    """Friction at pairs of lip nodes in a field, and the friction to solve for next.

    sticks (p,): mask of pairs that do not slide, if closed; slip (p, 3): unit vectors of the slip of pairs
    that slide, the motion of the first node against the second; drag, spring (p, 3): a jump J of the
    displacement gives the force drag - spring (spring . J) on the first node; releases (p,): how often each
    pair began to slide; settled: whether the field had this friction up to the tolerance.
    """

    sticks: np.ndarray
    slip: np.ndarray
    drag: np.ndarray
    spring: np.ndarray
    releases: np.ndarray
    settled: bool


def friction_at_rest(pairs: LipPairs, coefficient: float) -> Friction:
    """Return the friction before the load: every pair sticks, or slides if the coefficient is 0."""
    count = len(pairs.nodes)
    none = np.zeros((count, 3))
    return Friction(np.full(count, coefficient > 0), none, none, none, np.zeros(count, int), True)


def next_friction(
    last: Friction,
    pairs: LipPairs,
    around: csr_array,
    coefficient: float,
    displacement: np.ndarray,
    force: np.ndarray,
    closed: np.ndarray,
    least: float,
) -> Friction:
    """Return the friction that follows from a field that was solved with the friction `last`.

    Active set and Newton's method (Hueeber, Stadler & Wohlmuth 2008): pairs whose force along the lips
    exceeds the coefficient times their normal force begin to slide, and pairs whose slip turns back stick.
    The forces of corners that stick are compared together with the forces around them, as in contact. A
    pair that slides has a force against its slip, as large as its normal force in this field times the
    coefficient; a spring across the slip gives the change of this force if the slip turns.

    around (p, p): as in `with_contact`; force (p, 3): on the first nodes of pairs in the field; closed
    (p,): mask of the pairs that were closed; least: largest force that counts as 0.
    """
    if not coefficient:
        return last
    push, drag = pairs.split(force)
    _, slip = pairs.split(pairs.jumps(displacement))
    wide_drag = drag + around @ drag
    excess = np.linalg.norm(drag, axis=1) - coefficient * push
    wide_excess = np.linalg.norm(wide_drag, axis=1) - coefficient * (push + around @ push)
    sticks, slides = closed & last.sticks, closed & ~last.sticks
    begins = sticks & (excess > least) & (wide_excess > least) & (last.releases < _MOST_RELEASES)
    ends = slides & ((slip * last.slip).sum(axis=1) < 0)
    size = np.linalg.norm(slip, axis=1)
    slip = unit(np.where(slides[:, None], slip, -wide_drag))
    wanted = np.where((slides | begins)[:, None], -coefficient * push[:, None] * slip, 0.0)
    rate = np.divide(
        coefficient * np.maximum(push, 0.0), size, out=np.zeros_like(size), where=slides & (size > 0)
    )
    off = np.linalg.norm((wanted - drag)[slides])
    return Friction(
        ~closed | (last.sticks | ends) & ~begins,
        slip,
        wanted,
        np.sqrt(rate)[:, None] * np.cross(pairs.normal, slip),
        last.releases + begins,
        bool(off <= least) and not (begins | ends).any(),
    )
