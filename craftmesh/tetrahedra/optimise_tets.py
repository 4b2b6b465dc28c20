"""Local optimisation of a grain's tetrahedra; its surface and crack facets stay as they are.

Every change of topology replaces a cavity, a set of tets, by tets of positive volume with the same outer
faces and a better value: worst quality, sum of aspect ratios, or fault weight (a penalty on flat, poor and
stretched tets). The frozen nodes of the surface do not move, and no surface or crack facet lies inside a
cavity.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from craftmesh.tetrahedra.kernels.tet_cavity import KINDS, POINTS, TETS, Scratch, TetState, new_scratch
from craftmesh.tetrahedra.kernels.tet_means import mean_ratios
from craftmesh.tetrahedra.kernels.tet_objective import FALL, FAULTS, GAIN, RATIOS, SOUND_FROM, WORST, Aim
from craftmesh.tetrahedra.kernels.tet_passes import (
    aspect_pass,
    contraction_pass,
    improve_pass,
    smooth_pass,
    swap_pass,
)
from craftmesh.tetrahedra.kernels.tet_quality import (
    COMBINED_QUALITY,
    SHAPE_QUALITY,
    VOLUME_LENGTH,
    WIDE,
    all_qualities,
)
from craftmesh.tetrahedra.tet_state import mesh_of, new_state

# Numbers of this schedule are chosen on volumes of 270,000 to 560,000 tets.
# Aspect ratio above which swaps for a lower mean are tried.
STRETCHED = 2.2
# A point is tried for contraction if the mean aspect ratio of its tets exceeds the mean of all by this.
CROWDED = 0.2


@dataclass(frozen=True)
class Step:
    """A step of the schedule.

    kind: "improve" works on tets with a quality under `threshold`, "contract" merges points into
    neighbours, "swap" removes edges, "aspect" moves points; in the last three no quality falls below the
    smaller of `threshold` and the worst quality before. measure: of quality (`tet_quality`). objective,
    gain: the value that changes raise, and its smallest rise, negative if it may fall (`tet_objective`).
    rounds: most iterations of "improve". inserts: whether "improve" may insert points.
    """

    kind: str
    threshold: float
    measure: int = VOLUME_LENGTH
    objective: int = WORST
    gain: float = GAIN
    rounds: int = 1
    inserts: bool = False

    def aim(self, reference: float = 0.0) -> Aim:
        """Return the step's numbers for kernels; reference: the mean aspect ratio of all tets."""
        return Aim(self.objective, self.measure, self.threshold, self.gain, reference)


# First the volume-length quality is raised, then rounds lower the mean aspect ratio. In all rounds except
# the last, a swap may raise the sum of aspect ratios by up to 2, because the moves after it lower the sum
# again; a search in which the sum only falls ends in the nearest local minimum.
CONTRACT, MOVE = Step("contract", 0.35, objective=RATIOS, gain=0.3), Step("aspect", 0.45)
FREE_ROUND = (CONTRACT, Step("swap", 0.35, objective=RATIOS, gain=-2.0), MOVE)
LAST_ROUND = (Step("swap", 0.35, objective=RATIOS, gain=0.01), MOVE)
FREE_REPEATS = 2
# Last, FORMED raises the worst tets by SHAPE_QUALITY towards dihedral angles of 15..149 degrees, which
# spreads bad shapes at the surface over several tets. LIGHTEN then lowers the fault weight, so that few of
# these tets stay poor or stretched.
LIGHTEN = Step("improve", SOUND_FROM, COMBINED_QUALITY, FAULTS, FALL, rounds=8, inserts=True)
# Its threshold is a little over SOUND_FROM, the quality from which tets are neither poor nor stretched.
SOUNDER = Step("improve", 0.355, COMBINED_QUALITY, rounds=2, inserts=True)
FORMED = Step("improve", WIDE, SHAPE_QUALITY, rounds=4, inserts=True)
SCHEDULE = (MOVE, Step("improve", 0.55), *(FREE_REPEATS * FREE_ROUND), *LAST_ROUND, FORMED, LIGHTEN)


def optimise_tets(
    points: np.ndarray,
    tets: np.ndarray,
    frozen: int,
    blocked: np.ndarray,
    size: np.ndarray,
    steps: Sequence[Step] = SCHEDULE,
) -> tuple[np.ndarray, np.ndarray, dict]:
    """Return points (p, 3) and tets (t, 4) of better quality, and counts of operations by kind (KINDS).

    The first `frozen` points keep their numbers and bits. The facets `blocked` (k, 3) inside the mesh stay
    faces of tets on both sides. tets (m, 4) must have positive volumes (not checked); size (n,): target
    edge lengths at the points.
    """
    # sorted by largest point id: the tets of successive points are then close in memory, which saves a
    # tenth of the time
    tets = tets[np.argsort(tets.max(axis=1), kind="stable")]
    state = new_state(points, tets, frozen, blocked, size)
    work = new_scratch()
    do_steps(state, steps, work)
    return *mesh_of(state, frozen), {k: int(v) for k, v in zip(KINDS, work.done)}


def do_steps(state: TetState, steps: Sequence[Step], work: Scratch, measure: int | None = None) -> None:
    """Do the steps in order; changes `state` in place and counts the operations in work.done.

    measure: the measure of the qualities that the state has, None if it has none yet. All qualities are
    computed again only when a step has another measure than the one before.
    """
    for step in steps:
        if step.measure != measure:
            measure = step.measure
            all_qualities(state.points, state.tets, state.counts[TETS], state.quality, measure)
        _do(state, step, work)


def _do(state: TetState, step: Step, work: Scratch) -> None:
    """Do one step; state.quality must be by the step's measure."""
    if step.kind == "contract":
        _contract(state, step, work)
    elif step.kind == "swap":
        _swap(state, step, work)
    elif step.kind == "aspect":
        room = np.empty(state.counts[POINTS] + 1, np.int32), np.empty(4 * state.counts[TETS], np.int32)
        aspect_pass(state, step.aim(), room, work)
    else:
        _improve(state, step, work)


def _improve(state: TetState, step: Step, work: Scratch) -> None:
    """Improve the tets under step.threshold, worst first, in at most step.rounds rounds.

    For the objective WORST, with another measure than volume-length, each round ends with moves of all
    corners of these tets. Otherwise the step ends early if a round changes nothing.
    """
    for _ in range(step.rounds):
        touched = np.zeros(len(state.points), bool)
        poor = _worst_first(state, step.threshold)
        if not len(poor):
            return
        changes = improve_pass(state, step.aim(), poor, step.inserts, touched, work)
        if step.objective == WORST and step.measure != VOLUME_LENGTH:
            smooth_pass(state, step.aim(), touched, work)
        elif not changes:
            return


def _worst_first(state: TetState, threshold: float) -> np.ndarray:
    """Return the ids (k,) of live tets with a quality under the threshold, worst first."""
    quality = state.quality[: state.counts[TETS]]
    poor = np.flatnonzero((state.tets[: state.counts[TETS], 0] >= 0) & (quality < threshold))
    return poor[np.argsort(quality[poor], kind="stable")]


def _swap(state: TetState, step: Step, work: Scratch) -> None:
    """Remove an edge of each tet with an aspect ratio over STRETCHED if that helps, the worst tet first."""
    ratio, _, mean = _ratios(state)
    stretched = np.flatnonzero(ratio > STRETCHED)
    swap_pass(state, step.aim(mean), stretched[np.argsort(-ratio[stretched], kind="stable")], work)


def _contract(state: TetState, step: Step, work: Scratch) -> None:
    """Merge points into neighbours, if that helps, worst first.

    The points are those whose tets have a mean aspect ratio over the mean of all plus CROWDED.
    """
    _, mean, reference = _ratios(state)
    crowded = np.flatnonzero(~state.frozen[: len(mean)] & (mean > reference + CROWDED))
    order = crowded[np.argsort(-mean[crowded], kind="stable")]
    contraction_pass(state, step.aim(reference), order, work)


def _ratios(state: TetState) -> tuple[np.ndarray, np.ndarray, float]:
    """Return the aspect ratios (t,) of tets, the mean (n,) of the tets at each point, and the mean of all.

    The ratio is 0 for dead tets and INVERTED for flat tets; the mean of all excludes both.
    """
    ratio, mean = np.empty(state.counts[TETS]), np.empty(state.counts[POINTS])
    reference = mean_ratios(state.points, state.tets, ratio, mean, np.empty(len(mean), np.int64))
    return ratio, mean, reference
