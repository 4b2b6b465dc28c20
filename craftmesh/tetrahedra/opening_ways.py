"""Moves, contractions, partings and swaps at flat, poor and stretched tets, each kept if it gains."""

from collections.abc import Iterator
from operator import attrgetter

import numpy as np

from craftmesh.mesh.poor import is_flat
from craftmesh.tetrahedra.opening_model import Opening, moved, repaired, with_parting, with_swap
from craftmesh.tetrahedra.opening_stages import Stage
from craftmesh.tetrahedra.surface_contractions import contracted
from craftmesh.tetrahedra.surface_partings import Parting, partings_at, worthwhile
from craftmesh.tetrahedra.surface_swaps import swaps_at

# Rounds of contractions: what one leaves may be contracted in the next.
CONTRACTIONS = 3
# Rounds of partings. Of four random cracks with 4, 2, 1 and 23 flat tets 2, 1, 0 and 10 are left
# after up to three; later ones gain little.
PARTINGS = 4
# Edges that are parted at flat tets though that alone gains nothing. Of four random cracks with 1, 1, 3 and
# 12 flat tets 0, 0, 0 and 10 are left, after one, one, three and seven of these.
TRIES = 16


def with_moves(now: Opening, stage: Stage) -> Opening:
    """Return the best of the models with nodes near bad tets moved, further each round."""
    best, held = now, now.changed_by(stage.drift)
    for reach in stage.reaches:
        bad = now.bad(stage.is_bad)
        if not bad.any():
            break
        after = moved(now, reach, bad, stage, held)
        while over := after.changed_by(stage.drift) - held:
            held |= over
            after = moved(now, reach, bad, stage, held)
        now = after
        best = min(best, now, key=attrgetter("faults"))
    return best


def with_contractions(now: Opening, stage: Stage) -> Opening:
    """Return the best model with edges at bad tets contracted, and nodes moved again after that."""
    best = now
    for _ in range(CONTRACTIONS):
        bad = now.bad(stage.is_bad)
        if stage.score is None or not bad.any():
            break
        model, grains, count = contracted(now.model, bad, stage.score)
        if not count:
            break
        now = with_moves(now.replaced(repaired(model, grains, stage.aim), grains, count), stage)
        best = min(best, now, key=attrgetter("faults"))
    return best


def with_partings(now: Opening, stage: Stage) -> Opening:
    """Return the best model with edges at bad tets parted where that gains, and nodes moved after that."""
    best = now
    for _ in range(PARTINGS):
        parting = worthwhile(now.model, now.bad(stage.is_bad))
        if not len(parting.edges):
            break
        now, grains = with_parting(now, parting)
        now = with_moves(now.replaced(repaired(now.model, grains, stage.aim), grains), stage)
        best = min(best, now, key=attrgetter("faults"))
    return best


def opened_singly(now: Opening, stage: Stage) -> Opening:
    """Return the best model with edges at flat tets parted one by one, then swapped one by one."""
    return swapped_singly(parted_singly(now, stage), stage)


def parted_singly(now: Opening, stage: Stage) -> Opening:
    """Return the best model with edges at flat tets parted one by one, and what gains then.

    A needle between two long edges is flat with either of them parted, and sound with both.
    """
    best, offered = now, _at_flat(now)
    tried: set[bytes] = set()
    while len(tried) < TRIES:
        parting = next(offered, None)
        if parting is None:
            break
        place = parting.places(best.model.points).tobytes()
        if place in tried:
            continue
        tried.add(place)
        after = with_partings(with_parting(best, parting)[0], stage)
        if after.faults < best.faults:
            best, offered = after, _at_flat(after)
    return best


def swapped_singly(now: Opening, stage: Stage) -> Opening:
    """Return the best model with edges of the surface at flat tets swapped one by one."""
    best, offered = now, swaps_at(now.model, np.flatnonzero(now.bad(is_flat)))
    for swap in offered:
        swapped = with_swap(best, swap)
        if swapped is None:
            continue
        after, grains = swapped
        after = with_moves(after.replaced(repaired(after.model, grains, stage.aim), grains), stage)
        if after.faults < best.faults:
            return swapped_singly(after, stage)
    return best


def _at_flat(now: Opening) -> Iterator[Parting]:
    return partings_at(now.model, np.flatnonzero(now.bad(is_flat)))
