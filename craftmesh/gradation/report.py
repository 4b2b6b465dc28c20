"""The report of a gradation: operations, size adherence, angles and volume drift."""

from typing import NamedTuple

import numpy as np

from craftmesh.gradation.kernels.result_codes import REFUSALS
from craftmesh.gradation.passes import Gradation
from craftmesh.sizing.sizing import Sizing
from craftmesh.surface.front import front_edges
from craftmesh.surface.kernels.facet_shape import LARGEST_ANGLE
from craftmesh.surface.measure import edge_lengths, facet_angles, volume_drift, volumes_of
from craftmesh.surface.patches import feature_edges
from craftmesh.surface.wedges import sharp_wedges
from craftmesh.types import Surface

# Degrees: every tetrahedron on a facet with a smaller angle has an aspect ratio over 5.
POOR_ANGLE = 12.0
# Ratio of an edge's target length to l_max above which the edge counts as far from the front.
FAR = 0.95


class Before(NamedTuple):
    """The input's numbers of facets and of sharp wedges, and the volumes of its grains and voids by label.

    A wedge is a dihedral angle of a grain; `sharp_wedges` finds the sharp ones.
    """

    facets: int
    sharp_wedges: int
    volumes: dict[int, float]


def figures_before(surface: Surface, volumes: dict[int, float]) -> Before:
    """Return the input's figures for the report; volumes: of its grains and voids by label."""
    return Before(len(surface.facets), len(sharp_wedges(surface).angle), volumes)


def gradation_report(gradation: Gradation, before: Before, result: Surface, sizing: Sizing) -> dict:
    """Return counts, refusals, size adherence, angles, wedges and volume changes as numbers for JSON.

    A pair [a, b] is the number before and after the gradation; angles are in degrees.
    """
    angles, refused = facet_angles(result.points, result.facets), gradation.state.scratch.refused
    return {
        "facets": [before.facets, len(result.facets)],
        "operations": {k: int(v) for k, v in gradation.done.items()},
        "refusals": {reason: int(refused[code]) for code, reason in REFUSALS.items()},
        "adherence": size_adherence(result, sizing),
        "smallest_angle": float(angles.min()),
        "largest_angle": float(angles.max()),
        "facets_under_12_degrees": int((angles.min(1) < POOR_ANGLE).sum()),
        "facets_over_135_degrees": int((angles.max(1) > LARGEST_ANGLE).sum()),
        "wedges_under_12_degrees": [before.sharp_wedges, len(sharp_wedges(result).angle)],
        "drift": _drift_of_volumes(before.volumes, result),
    }


def size_adherence(surface: Surface, sizing: Sizing) -> dict:
    """Return the 5, 50 and 95 % quantiles of the ratio of edge length to target length, by group of edges.

    The groups are regular (inside patches), junction (feature edges off the front) and front; regular_far
    and junction_far have only edges with a target near l_max. The list of an empty group is empty.
    """
    edges, _, _, feature = feature_edges(surface)
    lone = front_edges(surface)
    width = len(surface.points) + 1
    front = np.isin(edges[:, 0] * width + edges[:, 1], lone[:, 0] * width + lone[:, 1])
    target = sizing.at(surface.points)[edges].mean(1)
    ratio = edge_lengths(surface.points, edges) / target
    far = target > FAR * sizing.l_max
    groups = {
        "regular": ~feature,
        "regular_far": ~feature & far,
        "junction": feature & ~front,
        "junction_far": feature & far & ~front,
        "front": front,
    }
    parts = {k: np.percentile(ratio[own], (5, 50, 95)) if own.any() else [] for k, own in groups.items()}
    return {k: [round(float(v), 4) for v in part] for k, part in parts.items()}


def _drift_of_volumes(before: dict[int, float], result: Surface) -> dict:
    """Return the mean and largest relative volume change of grains and voids, and the label of the largest.

    The keys are mean, max and grain; all are 0 without volumes.
    """
    after = volumes_of(result)
    drift = {grain: abs(part) for grain, part in volume_drift(before, after).items()}
    if not drift:
        return {"mean": 0.0, "max": 0.0, "grain": 0}
    worst = max(drift, key=lambda grain: drift[grain])
    return {"mean": float(np.mean(list(drift.values()))), "max": drift[worst], "grain": worst}
