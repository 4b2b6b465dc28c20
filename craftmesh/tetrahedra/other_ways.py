"""Other ways to open a surface, for flat tets that the first one leaves: the same steps in other orders.

Which flat tets are left depends on what was moved or parted before, almost at random: where one order
leaves some another often leaves none.
"""

from collections.abc import Callable
from dataclasses import replace
from operator import attrgetter

from craftmesh.mesh.poor import is_flat
from craftmesh.tetrahedra.opening_model import Opening
from craftmesh.tetrahedra.opening_stages import JOINING, REACHES, STAGES
from craftmesh.tetrahedra.opening_ways import opened_singly, with_contractions, with_moves, with_partings

AT_FLAT, AT_POOR, AT_FAULT = STAGES[0], STAGES[1], STAGES[-1]
# Moves after partings that come first, near enough to leave room for those that follow.
NEAR = REACHES[:3]
# Reaches of moves that go far at once.
FAR = REACHES[-1:] * 3
# Where more flat tets are left no order is likely to open all, and each takes as long as the first way.
MOST_LEFT = 10


def opened_otherwise(before: Opening, after: Opening) -> Opening:
    """Return the best of `after` and what other ways make of `before`, while a few flat tets are left."""
    best = after
    if best.count(is_flat) > MOST_LEFT:
        return best
    for way in WAYS.values():
        if not best.count(is_flat):
            break
        best = min(best, _ended(way(_begun(before))), key=attrgetter("faults"))
    return best


def _begun(now: Opening) -> Opening:
    """Return the opening with nodes that touch joined at flat tets."""
    return with_contractions(now, JOINING)


def _ended(now: Opening) -> Opening:
    """Return the opening after what all ways end with."""
    now = with_contractions(with_moves(now, AT_FLAT), AT_FLAT)
    now = with_moves(with_moves(now, AT_POOR), AT_FAULT)
    return opened_singly(with_partings(now, AT_FAULT), AT_FAULT)


def _partings_first(now: Opening) -> Opening:
    return with_partings(now, replace(AT_FAULT, reaches=NEAR))


def _far_moves_first(now: Opening) -> Opening:
    return with_moves(now, replace(AT_FLAT, reaches=FAR))


def _contractions_first(now: Opening) -> Opening:
    for stage in (AT_FLAT, AT_POOR):
        now = with_contractions(now, stage)
    return now


# In this order, until no flat tet is left. Of five random cracks with 2, 1, 2, 1 and 4 flat tets left the
# first of these leaves 2, 0, 0, 1 and 4, the second 0, 2, 2, 1 and 3, the third 2, 0, 2, 1 and 3.
WAYS: dict[str, Callable[[Opening], Opening]] = {
    "far moves first": _far_moves_first,
    "partings first": _partings_first,
    "contractions first": _contractions_first,
}
