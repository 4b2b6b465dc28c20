"""The surface of each grain, after a repair of the whole surface where facets intersect."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from craftmesh.arguments import as_array
from craftmesh.errors import CraftmeshError
from craftmesh.surface.connectivity import compact, lowest_equal_point
from craftmesh.surface.measure import area_vectors
from craftmesh.surface.repair import repair_surface
from craftmesh.types import Surface


@dataclass(frozen=True)
class GrainSurface:
    """The surface of one grain, the input of a mesher.

    nodes (k,): ids of the grain's points in the Surface; points (k, 3): their coordinates; facets (m, 3):
    rows of `points`, with normals out of the grain; internal (m,): mask of crack facets with the grain on
    both sides; facet_ids (m,): rows of the Surface's facets.
    """

    grain: int
    nodes: np.ndarray
    points: np.ndarray
    facets: np.ndarray
    internal: np.ndarray
    facet_ids: np.ndarray

    @cached_property
    def volume(self) -> float:
        """Volume that the boundary facets enclose, by the divergence theorem."""
        facets = self.facets[~self.internal]
        centred = self.points - self.points.mean(0)
        return float(np.einsum("ij,ij->", centred[facets].mean(1), area_vectors(centred, facets)) / 3)


def grain_surfaces(surface: Surface, grains: Iterable[int] | None = None) -> list[GrainSurface]:
    """Return the surfaces of `grains` (default: all), by ascending id.

    Points with the same coordinates count as one point, with the lowest id. Raises CraftmeshError for
    a grain that has no facets.
    """
    ids = surface.grains if grains is None else as_array("grains", list(grains), np.int64, (None,))
    wanted = np.unique(ids)
    missing = np.setdiff1d(wanted, surface.grains)
    if len(missing):
        raise CraftmeshError(f"grain {missing[0]} has no facets; give ids of grains on the surface")
    corners = lowest_equal_point(surface.points)[surface.facets]
    inside = surface.sides[:, 0] == surface.sides[:, 1]
    behind = np.flatnonzero(surface.sides[:, 0] > 0)
    ahead = np.flatnonzero((surface.sides[:, 1] > 0) & ~inside)
    facet = np.concatenate([behind, ahead])
    owner = np.concatenate([surface.sides[behind, 0], surface.sides[ahead, 1]])
    turned = np.repeat([False, True], [len(behind), len(ahead)])
    order = np.lexsort((facet, owner))
    start = np.searchsorted(owner[order], wanted, "left")
    stop = np.searchsorted(owner[order], wanted, "right")
    result = []
    for grain, a, b in zip(wanted, start, stop):
        rows = order[a:b]
        facets = corners[facet[rows]]
        facets[turned[rows]] = facets[turned[rows]][:, [0, 2, 1]]
        points, facets, nodes = compact(surface.points, facets)
        result.append(GrainSurface(int(grain), nodes, points, facets, inside[facet[rows]], facet[rows]))
    return result


@dataclass(frozen=True)
class Mended:
    """A surface after repair, with the repair's report and warning; both are None if nothing was faulty."""

    surface: Surface
    report: dict | None = None
    warning: str | None = None


def mended(surface: Surface) -> Mended:
    """Return the surface with points of intersecting or degenerate facets moved apart, and a report.

    Some faults may remain; the warning tells their number.
    """
    found, report = repair_surface(surface)
    if not report["faults"]:
        return Mended(surface)
    warning = (
        f"{report['faults']} facets of the surface intersect or are degenerate, at grains "
        f"{', '.join(map(str, report['grains'][:6]))}: {report['points_moved']} points were moved by up to "
        f"{report['largest_move']:.3g} ({report['largest_move_edges']:.2g} times the local edge length), "
        f"{report['faults_left']} such facets are left, the largest change of a grain's volume is "
        f"{100 * report['volume_drift_worst']:.2g} %"
    )
    return Mended(found, report, warning)
