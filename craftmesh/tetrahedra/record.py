"""Records of grains for the log and quality.json: failed attempts, and causes of poor tets."""

from collections.abc import Sequence

import numpy as np

from craftmesh.mesh.shape_measures import is_poor, shape_measures
from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.measure import facet_angles
from craftmesh.surface.wedges import wedges
from craftmesh.tetrahedra.grain_surface import GrainSurface, grain_surfaces
from craftmesh.tetrahedra.kernels.tet_quality import POOR
from craftmesh.tetrahedra.whole_mesh import Model


def poor_by_grain(model: Model) -> dict[str, list[dict]]:
    """Return the rows of `poor_tets` by grain id (as text); grains without poor tets are left out."""
    grains = np.unique(model.grain[model.quality < POOR])
    tets_of = {one.grain: one for one in model.grain_tets}
    result = {}
    for own in grain_surfaces(model.surface, grains) if len(grains) else ():
        one = tets_of[own.grain]
        nodes = np.concatenate([model.surface.points[one.nodes], one.interior])
        result[str(own.grain)] = poor_tets(own, nodes, one.tets)
    return result


def poor_tets(surface: GrainSurface, nodes: np.ndarray, tets: np.ndarray) -> list[dict]:
    """Return a row for each poor tet of a grain (`is_poor`), sorted by smallest dihedral angle.

    nodes (n, 3), which begin with the surface's points; tets (m, 4). A row is a dict with the smallest and
    largest `dihedrals`, the `shape_factor`, the `centre`, and the `facets` (rows of the Surface) that share
    an edge with the tet. `facet_angle` is the smallest angle of these facets, `wedge` the smallest dihedral
    angle of the grain at the shared edges, `edge` the length of the shortest of these edges; all three are
    None if no edge is on the surface. Angles are in degrees.
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
    """Return for each edge (e, 2) the smallest angle (e,) between two facets with the grain between them.

    The angles are in degrees, and 360 at edges without such facets.
    """
    sides = np.stack([np.ones(len(surface.facets), np.int64), surface.internal.astype(np.int64)], axis=1)
    found = wedges(surface.points, surface.facets, sides, edges)
    inside = found.where(found.label == 1)
    result = np.full(len(edges), 360.0)
    keys, wanted = (pairs[:, 0] * len(surface.points) + pairs[:, 1] for pairs in (edges, inside.edge))
    np.minimum.at(result, np.searchsorted(keys, wanted), inside.angle)
    return result


def record_of(mesher: str, report: dict, left: Sequence[int], repair: dict | None) -> dict:
    """Return the record of a chunk of grains, from the report of `tetrahedralize` ({} if it did not run).

    It has the keys mesher, repair, tried_again, failed, poor and left. left: ids of grains that have no
    tets yet; repair: report of the surface's repair, None if nothing was changed. The record omits times,
    so that the same input gives the same record.
    """
    return {
        "mesher": mesher,
        "repair": repair,
        "tried_again": {grain: _timeless(tried) for grain, tried in report.get("tried_again", {}).items()},
        "failed": {
            grain: one | {"attempts": _timeless(one["attempts"])}
            for grain, one in report.get("failed", {}).items()
        },
        "poor": report.get("poor", {}),
        "left": sorted(left),
    }


def merged(records: Sequence[dict]) -> dict:
    """Return the union of the records (`record_of`) of several chunks of one surface; {} without records.

    Each grain must be in one chunk only (not checked); mesher and repair are of the first record.
    """
    records = [record for record in records if record]
    if not records:
        return {}
    return {
        "mesher": records[0]["mesher"],
        "repair": records[0]["repair"],
        "tried_again": _by_grain(records, "tried_again"),
        "failed": _by_grain(records, "failed"),
        "poor": _by_grain(records, "poor"),
        "left": sorted(grain for record in records for grain in record["left"]),
    }


def with_counts(
    record: dict,
    whole_model: dict | None,
    given_way: dict | None,
    smoothed: dict | None,
    poor: dict[str, list[dict]],
) -> dict:
    """Return the record for quality.json: with numbers of grains, and reports on the whole model.

    whole_model: report of a mesh of the whole model; given_way: report of the moves off the surface at
    faulty tets; smoothed: report of the moves along the surface. Each is None if there was none. poor: rows
    of poor tets by grain, which replace the grain's rows in the record; grains with an empty list are
    left out.
    """
    counts = {f"grains_{name}": len(record.get(name, ())) for name in ("tried_again", "failed")}
    kept = {grain: rows for grain, rows in (record.get("poor", {}) | poor).items() if rows}
    rest = {"poor": kept, "whole_model": whole_model, "given_way": given_way, "smoothed": smoothed}
    return counts | record | rest


def _timeless(attempts: Sequence[dict]) -> list[dict]:
    return [{key: value for key, value in one.items() if key != "seconds"} for one in attempts]


def _by_grain(records: Sequence[dict], name: str) -> dict:
    together = {grain: one for record in records for grain, one in record[name].items()}
    return {grain: together[grain] for grain in sorted(together, key=int)}
