"""A model while its surface gives way: the stages of that, its tets, and nodes near bad ones moved."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np

from craftmesh.mesh.shape_measures import is_flat, is_poor, shape_measures
from craftmesh.mesh.tet_connectivity import tet_edges
from craftmesh.surface.connectivity import touching
from craftmesh.surface.measure import mean_edges, side_volumes, volume_drift
from craftmesh.tetrahedra.kernels.tet_cavity import TETS, new_scratch
from craftmesh.tetrahedra.kernels.tet_objective import (
    FALL,
    FAULTS,
    GAIN,
    OF_FLAT,
    OF_POOR,
    SOUND_FROM,
    WORST,
    Aim,
)
from craftmesh.tetrahedra.kernels.tet_quality import FORM, POOR, STRETCHED, WHOLE, WIDE, all_qualities
from craftmesh.tetrahedra.kernels.tet_smoothing import move_nodes
from craftmesh.tetrahedra.optimise_tets import repaired_tets
from craftmesh.tetrahedra.surface_freedom import Freedom, freedom
from craftmesh.tetrahedra.tet_state import new_state
from craftmesh.tetrahedra.whole_mesh import Model, changed_inside, nodes_near
from craftmesh.types import GrainTets, Surface


@dataclass(frozen=True)
class Stage:
    """Which tets the surface gives way to, by `shape_measures`, and how far.

    reaches: nodes of the surface move by at most these parts of the mean edge at them, round by round, as
    long as there are such tets: what a small move opens is not opened by a large one. aim: what moves
    better (`tet_objective`). drift: no move changes a volume by more than this part; nodes of one that has
    changed by more stay.
    """

    is_bad: Callable[[np.ndarray], np.ndarray]
    reaches: tuple[float, ...]
    aim: Aim
    drift: float = np.inf


# Degrees: the least dihedral angle of tets where no facet has a smaller one.
NARROW = 15.0
# What a narrow tet weighs where a stretched one weighs 1.
OF_NARROW = 0.01


def is_stretched(measures: np.ndarray) -> np.ndarray:
    """Return (m,) bool: tets of an aspect ratio over STRETCHED, from `shape_measures` (m, 5)."""
    return measures[:, 1] > STRETCHED


def is_at_fault(measures: np.ndarray) -> np.ndarray:
    """Return (m,) bool: tets that are flat, poor or stretched."""
    return is_poor(measures) | is_stretched(measures)


def is_narrow(measures: np.ndarray) -> np.ndarray:
    """Return (m,) bool: tets with a dihedral angle under NARROW, from `shape_measures` (m, 5)."""
    return measures[:, 2] < NARROW


def weighed_faults(measures: np.ndarray) -> float:
    """Return the number of flat, poor, stretched and narrow tets, by their weights (`tet_objective`)."""
    flat, poor, stretched, narrow = (
        np.count_nonzero(is_bad(measures)) for is_bad in (is_flat, is_poor, is_stretched, is_narrow)
    )
    return OF_FLAT * flat + OF_POOR * poor + stretched + OF_NARROW * narrow


def _worst(measure: int, floor: float) -> Aim:
    return Aim(WORST, measure, floor, GAIN, 0.0)


# Rounds go as far as the one before leaves such tets: on random cracks 0.15 leaves several times as many
# stretched ones as 0.4.
REACHES = (0.025, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4)
# How far volumes of grains and voids may drift for stretched tets; small grains would change by more.
MOST_DRIFT = 0.05
STAGES = (
    Stage(is_flat, REACHES, _worst(FORM, POOR)),
    Stage(is_poor, REACHES, _worst(FORM, POOR)),
    Stage(is_stretched, REACHES, _worst(WHOLE, SOUND_FROM), drift=MOST_DRIFT),
    Stage(is_at_fault, REACHES, Aim(FAULTS, WHOLE, SOUND_FROM, FALL, 0.0), drift=MOST_DRIFT),
    # Small moves: few tets are narrow alone.
    Stage(is_narrow, REACHES[:3], _worst(FORM, WIDE), drift=0.01),
)
# Sweeps over the nodes near a bad tet in a round.
SWEEPS = 3


@dataclass(frozen=True)
class Opening:
    """A model while its surface gives way: the measures of its tets by grain, and what was done to it.

    homes (n, 3): the surface's points at first; free: how they may move; changed: grains.
    """

    model: Model
    measures: Mapping[int, np.ndarray]
    homes: np.ndarray
    free: Freedom
    changed: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))

    def bad(self, is_bad: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        """Return (m,) bool: the tets that are bad."""
        return np.concatenate([is_bad(self.measures[one.grain]) for one in self.model.grain_tets])

    def count(self, is_bad: Callable[[np.ndarray], np.ndarray]) -> int:
        """Return how many tets are bad."""
        return int(self.bad(is_bad).sum())

    @cached_property
    def drifts(self) -> dict[int, float]:
        """Return the relative changes of the volumes, by label."""
        surface = self.model.surface
        volumes = [side_volumes(at, surface.facets, surface.sides) for at in (self.homes, surface.points)]
        return volume_drift(*volumes)

    def changed_by(self, drift: float) -> set[int]:
        """Return the labels of volumes that have changed by more than `drift`, which may be infinite."""
        if drift == np.inf:
            return set()
        return {label for label, change in self.drifts.items() if abs(change) > drift}

    def mobile(self, held: set[int]) -> np.ndarray:
        """Return (n,) bool: surface nodes that may move, none of a volume whose label is held."""
        result, surface = np.any(self.free.steps != 0, axis=(1, 2)), self.model.surface
        result[surface.facets[np.isin(surface.sides, list(held)).any(axis=1)]] = False
        return result

    @cached_property
    def faults(self) -> float:
        """Return the number of its flat, poor, stretched and narrow tets, by their weights."""
        return sum(weighed_faults(self.measures[one.grain]) for one in self.model.grain_tets)

    def replaced(self, model: Model, grains: np.ndarray) -> "Opening":
        """Return the opening with another model, whose tets differ in `grains` alone."""
        return replace(
            self,
            model=model,
            measures=_measures(model, self.measures, grains),
            changed=np.union1d(self.changed, grains),
        )


def _measures(
    model: Model, known: Mapping[int, np.ndarray], grains: np.ndarray
) -> Mapping[int, np.ndarray]:
    """Return the measures of each grain's tets, those of `grains` anew."""
    result, points = dict(known), model.surface.points
    for one in model.grain_tets:
        if one.grain in grains:
            result[one.grain] = shape_measures(np.concatenate([points[one.nodes], one.interior]), one.tets)
    return result


def begun(surface: Surface, grain_tets: Sequence[GrainTets]) -> Opening | None:
    """Return the opening of a surface and its tets as they are; None where none is at fault or narrow."""
    model = Model(surface, list(grain_tets))
    measures = _measures(model, {}, surface.grains)
    if not any((is_at_fault(one) | is_narrow(one)).any() for one in measures.values()):
        return None
    return Opening(model, measures, surface.points, freedom(surface))


def moved(now: Opening, reach: float, bad: np.ndarray, stage: Stage, held: set[int]) -> Opening:
    """Return the opening with nodes near bad tets (m,) moved, but those of the volumes held.

    reach: the largest move of a surface point from its home, in mean edges.
    """
    points, grains = _moved_points(now, reach, bad, stage, held)
    return now.replaced(repaired(now.model.moved(points), grains, stage.aim), grains)


def _moved_points(
    now: Opening, reach: float, bad: np.ndarray, stage: Stage, held: set[int]
) -> tuple[np.ndarray, np.ndarray]:
    """Return all nodes, those near bad tets moved, and the grains that see a move."""
    points, tets, homes = now.model.points, now.model.tets, now.homes
    near, mobile = nodes_near(tets, bad), now.mobile(held)
    near[: len(mobile)] &= mobile
    nodes, rows = np.flatnonzero(near), np.flatnonzero(touching(tets, near))
    used, local = np.unique(tets[rows], return_inverse=True)
    state = new_state(points[used], local.reshape(-1, 4))
    all_qualities(state.points, state.tets, state.counts[TETS], state.quality, stage.aim.measure)
    outer = nodes < len(homes)
    home, steps, part = points[nodes], np.repeat(np.eye(3)[None], len(nodes), axis=0), np.ones(len(nodes))
    home[outer], steps[outer], part[outer] = homes[nodes[outer]], now.free.steps[nodes[outer]], reach
    furthest = part * mean_edges(points, tet_edges(tets[rows]))[nodes]
    furthest[outer] = np.minimum(furthest[outer], now.free.reach[nodes[outer]])
    valence = np.bincount(tets[rows].ravel(), minlength=len(points))[nodes]
    work, place = new_scratch(), np.searchsorted(used, nodes)
    for _ in range(SWEEPS):
        if not move_nodes(state, place, home, furthest, steps, valence, stage.aim, work):
            break
    moved = points.copy()
    moved[used] = state.points[: len(used)]
    changed = (moved != points).any(axis=1)
    return moved, np.unique(now.model.grain[touching(tets, changed)])


def repaired(model: Model, grains: np.ndarray, aim: Aim) -> Model:
    """Return the model with the worst tets of `grains` by an aim repaired, the surface as it is."""
    measure = None if aim.objective == FAULTS else aim.measure
    return changed_inside(model, grains, partial(repaired_tets, measure=measure))
