"""What a grain's surface forces: its poor tetrahedra, with the facets, wedges and edges they lie on."""

from collections.abc import Sequence

import numpy as np

from craftmesh.mesh.kernels.shape_measures import shape_measures
from craftmesh.mesh.poor import is_poor
from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.measure import facet_angles
from craftmesh.surface.wedges import wedges
from craftmesh.tetrahedra.grain_surface import GrainSurface, grain_surfaces
from craftmesh.types import GrainTets, Surface


def poor_by_grain(
    surface: Surface, grain_tets: Sequence[GrainTets], grains: np.ndarray
) -> dict[str, list[dict]]:
    """Return the rows of `poor_tets` of each of the grains (k,), by its id."""
    if not len(grains):
        return {}
    tets_of = {one.grain: one for one in grain_tets}
    result = {}
    for own in grain_surfaces(surface, grains):
        one = tets_of[own.grain]
        nodes = np.concatenate([surface.points[one.nodes], one.interior])
        result[str(own.grain)] = poor_tets(own, nodes, one.tets)
    return result


def poor_tets(surface: GrainSurface, nodes: np.ndarray, tets: np.ndarray) -> list[dict]:
    """Return a row for each poor tet of a grain, the one with the least dihedral angle first.

    nodes (n, 3) begin with the surface's points, tets (m, 4). Poor: see `mesh/poor`. A row names the
    facets (of the Surface) that share an edge with the tet, the smallest angle of these, the sharpest wedge
    of the grain at a common edge and the shortest of those edges; None where the tet has no edge on the
    surface.
    """
    measures = shape_measures(nodes, np.ascontiguousarray(tets))
    _, _, low, high, factor = measures.T
    poor = np.flatnonzero(is_poor(measures))
    if not len(poor):
        return []
    poor = poor[np.argsort(low[poor], kind="stable")]
    angles = facet_angles(surface.points, surface.facets).min(axis=1)
    edges, of_corner, _ = unique_edges(surface.facets)
    sharpest = _sharpest_wedges(surface, edges)
    rows = []
    for t in poor:
        shared = np.all(np.isin(edges, tets[t]), axis=1)
        facets = np.flatnonzero(shared[of_corner].any(axis=1))
        ends = surface.points[edges[shared]]
        length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        rows.append(
            {
                "dihedrals": [round(float(low[t]), 2), round(float(high[t]), 2)],
                "shape_factor": float(factor[t]),
                "centre": [round(float(x), 6) for x in nodes[tets[t]].mean(axis=0)],
                "facets": surface.facet_ids[facets].tolist(),
                "facet_angle": _least(angles[facets], 2),
                "wedge": _least(sharpest[shared], 2),
                "edge": _least(length, 6),
            }
        )
    return rows


def _least(values: np.ndarray, digits: int) -> float | None:
    return round(float(values.min()), digits) if len(values) else None


def _sharpest_wedges(surface: GrainSurface, edges: np.ndarray) -> np.ndarray:
    """Return the smallest angle (e,) that the grain has at each of its edges, in degrees."""
    sides = np.stack([np.ones(len(surface.facets), np.int64), surface.internal.astype(np.int64)], axis=1)
    found = wedges(surface.points, surface.facets, sides, edges)
    inside = found.where(found.label == 1)
    result = np.full(len(edges), 360.0)
    keys, wanted = (pairs[:, 0] * len(surface.points) + pairs[:, 1] for pairs in (edges, inside.edge))
    np.minimum.at(result, np.searchsorted(keys, wanted), inside.angle)
    return result
