"""Cleaning after the gradation: collapse, swap and moves remove needles and caps.

Ears, inner crack edges between two vertices of the crack front, are split, because they cannot open.
An angle score is a number for both the smallest and the largest angle of a facet; more is better.
"""

import numpy as np

from craftmesh.gradation.kernels.one_pass import COLLAPSE
from craftmesh.gradation.kernels.slide import LEAST_RISE
from craftmesh.gradation.locality import block_order
from craftmesh.gradation.passes import Gradation, Limits, slide_all, split_all, swap_all
from craftmesh.gradation.state import ON_FRONT
from craftmesh.sizing.sizing import Sizing
from craftmesh.surface.front import ears
from craftmesh.surface.kernels.facet_shape import LEAST_ANGLE, relative_lengths, score_of_angle
from craftmesh.surface.measure import facet_angles

# Degrees: facets with a smaller angle are needles, collapsed whatever the length of their edges.
NEEDLE_ANGLE = 20.0
# Ratio of length to target length below which the shortest edge of any other facet under the goal is
# collapsed. At 0.5 the surface has 3% more facets, of no better shape.
SHORT = 0.7
# Degrees: goal of vertex moves after the first round. With 22 almost twice as many facets stay under 25
# degrees; with 28 there are half as many moves again, and no fewer such facets.
LATE_GOAL = 25.0
# Factors on the limits of the rounds, chosen by hand: for the longest new edge, at first and in the later
# half of the cleaning, and for the turn of normals in the later half.
LOOSE_LENGTH = 1.2
LATE_LENGTH = 1.4
LATE_TURN = 1.5


def clean_facets(gradation: Gradation, sizing: Sizing, limits: Limits, rounds: int, goal: float) -> None:
    """Raise facet angles towards `goal` degrees in at most `rounds` rounds of collapse, swap and moves.

    After the first round, vertices move only at facets under LATE_GOAL. The cleaning ends early if a round
    changes nothing, or, past half of the rounds, if no facet angle is under LEAST_ANGLE.
    """
    for n in range(rounds):
        slide_goal = goal if n == 0 else min(goal, LATE_GOAL)
        mesh = gradation.mesh
        if n > rounds // 2 + 1 and facet_angles(mesh.points, mesh.facets[mesh.alive]).min() >= LEAST_ANGLE:
            break
        gradation.set_sizes(sizing)
        loose = loosened(limits, n, rounds)
        done = collapse_poor(gradation, loose, goal)
        done += swap_all(gradation, loose)
        loose = loose._replace(longest=LOOSE_LENGTH * limits.longest)
        done += slide_all(gradation, loose, score_of_angle(slide_goal))
        if not done:
            break


def loosened(limits: Limits, n: int, rounds: int) -> Limits:
    """Return the limits of round `n`; from half of the `rounds` on, they are looser.

    Edges may then be longer, normals may turn more, and junction points may merge.
    """
    late = n >= rounds // 2
    return limits._replace(
        collapse=np.inf,  # edges to collapse are chosen by their facets
        longest=limits.longest * (LATE_LENGTH if late else LOOSE_LENGTH),
        gain=LEAST_RISE,
        cosine=np.cos(np.arccos(limits.cosine) * (LATE_TURN if late else 1.0)),
        merge_points=late,
    )


def collapse_poor(gradation: Gradation, limits: Limits, goal: float) -> int:
    """Collapse the shortest edge of each facet under `goal` degrees; return the number of collapses.

    The facet must be a needle (under NEEDLE_ANGLE), or the edge shorter than SHORT times its target. In
    each block of vertices the smallest angles are first (`block_order`).
    """
    facets = gradation.poor_facets(score_of_angle(goal))
    angles = facet_angles(gradation.mesh.points, facets)
    smallest = angles.argmin(1)
    rows = np.arange(len(facets))
    worst = angles[rows, smallest]
    edges = np.stack([facets[rows, (smallest + 1) % 3], facets[rows, (smallest + 2) % 3]], axis=1)
    ratio = relative_lengths(gradation.mesh.points, gradation.mesh.size, edges)
    chosen = np.flatnonzero((worst < goal) & ((ratio < SHORT) | (worst < NEEDLE_ANGLE)))
    order = chosen[block_order(edges[chosen, 0], worst[chosen])]
    return gradation.repeat("cleaning_collapses", COLLAPSE, limits, edges[order])


def split_ears(gradation: Gradation, limits: Limits) -> int:
    """Split the crack's ears, so that every crack facet can open; return the number of splits.

    An ear is an inner crack edge between two front vertices. Angles and lengths are not checked.
    """
    mesh = gradation.mesh
    edges = ears(mesh.facets[mesh.alive & mesh.patch_crack[mesh.patch]], mesh.flags & ON_FRONT > 0)
    any_angle = limits._replace(split=0.0, floor=0.0)
    return split_all(gradation, "split_ears", any_angle, edges, 0.0)
