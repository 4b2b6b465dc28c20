"""Moves, contractions and partings at flat, poor and stretched tets, each kept if it gains."""

from operator import attrgetter

from craftmesh.tetrahedra.opening_model import Opening, moved, repaired, with_parting
from craftmesh.tetrahedra.opening_stages import Stage
from craftmesh.tetrahedra.surface_contractions import contracted
from craftmesh.tetrahedra.surface_partings import worthwhile

# Rounds of contractions: what one leaves may be contracted in the next.
CONTRACTIONS = 3
# Rounds of partings. Of four random cracks with 4, 2, 1 and 23 flat tets 2, 1, 0 and 10 are left
# after up to three; later ones gain little.
PARTINGS = 4


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
