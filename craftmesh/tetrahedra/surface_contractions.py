"""Short edges of grain boundaries and of the crack contracted where they force flat or poor tetrahedra."""

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from craftmesh.mesh.shape_measures import (
    FLAT_DIHEDRALS,
    FLAT_SHAPE_FACTOR,
    LARGEST_DIHEDRAL,
    LEAST_DIHEDRAL,
    LEAST_SHAPE_FACTOR,
    shape_measures,
)
from craftmesh.tetrahedra.contraction_reach import keeps_surface
from craftmesh.tetrahedra.contraction_rules import keeps_topology, may_merge
from craftmesh.tetrahedra.stars import Corners, Stars, classes_of, renamed, stars_of
from craftmesh.tetrahedra.whole_mesh import Model, nodes_near

# Tets looked at in a round, the worst ones: each takes 15 ms.
MOST = 300


@dataclass(frozen=True)
class Contraction:
    """`gone` becomes `kept`; the worst score of the tets that change."""

    kept: int
    gone: int
    score: float


def contracted(model: Model, bad: np.ndarray, least: float) -> tuple[Model, np.ndarray, int]:
    """Return the model with edges at its `bad` tets (m,) contracted, the grains changed, and how many.

    An edge of the surface goes where the worst of the tets that change gets better and scores `least`: 0
    at the limits of flat tets, 1 at those of poor ones. Grains, crack and front stay what
    (`contraction_rules`) and where they are (`contraction_reach`).
    """
    tets = model.tets
    worst = _worst_first(model.points, tets, bad)[:MOST]
    stars = stars_of(model, classes_of(model.surface), np.flatnonzero(nodes_near(tets, worst)))
    count, done = Counter({one.grain: len(one.tets) for one in model.grain_tets}), 0
    for t in worst.tolist():
        if t in stars.gone_tets or _score(stars.points, [stars.tets[t]]) >= least:
            continue
        best = _best(stars, stars.tets[t], count, least)
        if best is not None:
            count.subtract(stars.grain[_dying(stars, best)].tolist())
            stars.merge(best.kept, best.gone)
            done += 1
    if not done:
        return model, np.zeros(0, np.int64), 0
    return *rebuilt(model, stars), done


def _worst_first(points: np.ndarray, tets: np.ndarray, bad: np.ndarray) -> np.ndarray:
    rows = np.flatnonzero(bad)
    return rows[np.argsort(_scores(points[tets[rows]]), kind="stable")]


def _dying(stars: Stars, one: Contraction) -> list[int]:
    return sorted(stars.tets_at[one.kept] & stars.tets_at[one.gone])


def _best(stars: Stars, corners: Corners, count: Counter[int], least: float) -> Contraction | None:
    """Return the contraction at a corner of a tet that leaves the best worst tet, None without any.

    count: how many tets each grain has.
    """
    found = []
    for gone in filter(stars.on_surface, corners):
        beside = {node for t in stars.tets_at[gone] for node in stars.tets[t]} - {gone}
        for kept in sorted(filter(stars.on_surface, beside)):
            if may_merge(stars, kept, gone):
                score = _score_after(stars, kept, gone)
                if score is not None and (score >= least or stars.touch(kept, gone)):
                    found.append(Contraction(kept, gone, score))
    for one in sorted(found, key=lambda one: (-one.score, one.kept, one.gone)):
        if _keeps_grains(stars, one, count) and keeps_surface(stars, one.kept, one.gone):
            if keeps_topology(stars, one.kept, one.gone):
                return one
    return None


def _score_after(stars: Stars, kept: int, gone: int) -> float | None:
    """Return the worst score of the tets that would change; None where that is no better."""
    old = sorted(stars.tets_at[gone])
    changed = [renamed(stars.tets[t], gone, kept) for t in old if t not in stars.tets_at[kept]]
    if len(changed) in (0, len(old)):
        return None
    after = _score(stars.points, changed)
    return after if after > _score(stars.points, [stars.tets[t] for t in old]) else None


def _score(points: np.ndarray, tets: list[Corners]) -> float:
    """Return 1 where the worst tet is at the limits of poor ones, 0 at those of flat ones."""
    return float(_scores(points[np.array(tets, np.int64)]).min())


def _scores(corners: np.ndarray) -> np.ndarray:
    """Return the score (k,) of each tet (k, 4, 3), -inf where it is inverted."""
    measures = shape_measures(corners.reshape(-1, 3), np.arange(4 * len(corners)).reshape(-1, 4))
    low, high, factor = measures[:, 2], measures[:, 3], measures[:, 4]
    small = (low - FLAT_DIHEDRALS[0]) / (LEAST_DIHEDRAL - FLAT_DIHEDRALS[0])
    large = (FLAT_DIHEDRALS[1] - high) / (FLAT_DIHEDRALS[1] - LARGEST_DIHEDRAL)
    shape = (factor - FLAT_SHAPE_FACTOR) / (LEAST_SHAPE_FACTOR - FLAT_SHAPE_FACTOR)
    positive = np.linalg.det(corners[:, 1:] - corners[:, :1]) > 0
    return np.where(positive, np.minimum(np.minimum(small, large), shape), -np.inf)


def _keeps_grains(stars: Stars, one: Contraction, count: Counter[int]) -> bool:
    """Tell whether each grain has tets left."""
    lost = Counter(stars.grain[_dying(stars, one)].tolist())
    return all(count[grain] > gone for grain, gone in lost.items())


def rebuilt(model: Model, stars: Stars) -> tuple[Model, np.ndarray]:
    """Return the model with the changes of the stars, and the grains that they changed."""
    surface, tets, facets = model.surface, model.tets, stars.classes.facets.copy()
    changed = np.zeros(len(tets), bool)
    for t, corners in stars.tets.items():
        changed[t] = t in stars.gone_tets or tuple(tets[t].tolist()) != corners
        tets[t] = corners
    for f, corners in stars.facets.items():
        facets[f] = corners
    kept = np.delete(np.arange(len(facets)), sorted(stars.gone_facets))
    surface = replace(surface, facets=facets[kept], sides=surface.sides[kept], kind=surface.kind[kept])
    alive = np.delete(np.arange(len(tets)), sorted(stars.gone_tets))
    return model.changed(surface, tets[alive], stars.grain[alive]), np.unique(stars.grain[changed])
