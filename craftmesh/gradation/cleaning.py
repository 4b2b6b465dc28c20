"""Cleaning after the gradation: needles and caps go by collapse, swap and sliding; ears are split."""

import numpy as np

from craftmesh.gradation.kernels.collapse import collapse_pass
from craftmesh.gradation.kernels.split import split_pass
from craftmesh.gradation.locality import block_order
from craftmesh.gradation.passes import Limits, Workshop, slide_all, swap_all
from craftmesh.gradation.state import ON_FRONT
from craftmesh.surface.kernels.facet_shape import LEAST_ANGLE, poor_facets, relative_lengths, score_of_angle
from craftmesh.surface.measure import facet_angles

POOR_ANGLE = 12.0
SHORT = 0.5
LATE_GOAL = 20.0


def clean_facets(shop: Workshop, sizing, limits: Limits, rounds: int, goal: float) -> None:
    """Raise facet angles towards `goal` degrees in `rounds` of collapse, swap and slide.

    After the first round vertices slide only where a facet is still under 20 degrees; the cleaning ends
    when none is under 15 and junction points that lie too close have been merged.
    """
    for n in range(rounds):
        slide_goal = goal if n == 0 else min(goal, LATE_GOAL)
        if n > rounds // 2 + 1 and _least_angle(shop) >= LEAST_ANGLE:
            break
        shop.set_sizes(sizing)
        loose = loosened(limits, n, rounds)
        done = collapse_poor(shop, loose, goal)
        done += swap_all(shop, loose)
        done += slide_all(shop, loose._replace(longest=1.2 * limits.longest), score_of_angle(slide_goal))
        if not done:
            break


def _least_angle(shop: Workshop) -> float:
    state = shop.state
    return float(facet_angles(state.points, state.facets[np.flatnonzero(state.alive)]).min())


def loosened(limits: Limits, n: int, rounds: int) -> Limits:
    """Return the limits of round `n`: the later, the longer an edge and the further a normal may go."""
    late = n >= rounds // 2
    return limits._replace(
        collapse=9.0,
        longest=limits.longest * (1.4 if late else 1.2),
        gain=1e-3,
        cosine=np.cos(np.arccos(limits.cosine) * (1.5 if late else 1.0)),
        merge_points=late,
    )


def collapse_poor(shop: Workshop, limits: Limits, goal: float) -> int:
    """Collapse the shortest edges of facets under `goal` degrees where these are needles or short."""
    s = shop.state
    facets = s.facets[poor_facets(s.points, s.facets, s.alive, s.used[1], score_of_angle(goal))]
    angles = facet_angles(s.points, facets)
    smallest = angles.argmin(1)
    rows = np.arange(len(facets))
    worst = angles[rows, smallest]
    edges = np.stack([facets[rows, (smallest + 1) % 3], facets[rows, (smallest + 2) % 3]], axis=1)
    ratio = relative_lengths(s.points, s.size, edges)
    chosen = np.flatnonzero((worst < goal) & ((ratio < SHORT) | (worst < POOR_ANGLE)))
    order = chosen[block_order(edges[chosen], worst[chosen])]
    return shop.repeat("cleaning collapses", collapse_pass, len(order), limits, edges, order, ())


def ear_edges(shop: Workshop) -> np.ndarray:
    """Return the crack edges (k, 2), other than front edges, that join two front vertices."""
    state = shop.state
    facets = state.facets[shop.living(on_crack=True)]
    pairs = facets[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    on_front = (state.flags[pairs] & ON_FRONT).all(1)
    pairs, count = np.unique(np.sort(pairs[on_front], axis=1), axis=0, return_counts=True)
    return pairs[count > 1]


def split_ears(shop: Workshop, limits: Limits) -> int:
    """Split crack edges that join two front vertices, so that every crack facet can open."""
    edges = ear_edges(shop)
    free = limits._replace(split=0.0, floor=0.0)
    return shop.repeat("split ears", split_pass, len(edges), free, edges, np.arange(len(edges)), (0.0,))
