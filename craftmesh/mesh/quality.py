"""The quality table of the paper that craftmesh follows: size, shape of elements, grain volumes, crack."""

from collections.abc import Mapping

import numpy as np

from craftmesh.errors import listed
from craftmesh.mesh.front import mesh_fronts
from craftmesh.mesh.front_curve import arc_lengths
from craftmesh.mesh.integration import smallest_jacobians
from craftmesh.mesh.mesh_sets import lip_faces
from craftmesh.mesh.shape_measures import flat_tets, is_poor, poor_parts, shape_measures
from craftmesh.mesh.tet_connectivity import face_nodes, group_edges, tet_edges
from craftmesh.surface.measure import total_area, volume_drift
from craftmesh.types import TetMesh, Voxels

MOST_DRIFT = 0.05  # largest relative change of a grain's volume; the examples' grains drift by at most 1 %
_ASPECT_EDGES = (1.0, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0, 4.0, 5.0, 10.0, 20.0, np.inf)
_ANGLE_EDGES = tuple(range(0, 181, 10))


def quality(mesh: TetMesh, voxels: Voxels | None = None) -> dict:
    """Return the content of quality.json: plain numbers, percentages, angles in degrees.

    Aspect ratio: longest edge over smallest altitude, as in TetGen. Poor elements have a shape factor under
    0.02 or a dihedral angle under 10 or over 160 degrees (`mesh/shape_measures`). `jacobian_not_positive`
    counts elements with a Jacobian <= 0 at an integration point (4-node elements and straight 10-node
    elements: with a volume <= 0). With voxels, `volume_drift` compares each grain's volume with that of its
    voxels. `flat`: number and places of flat elements, as `flat_tets` returns them.
    """
    corners = np.ascontiguousarray(mesh.tets[:, :4])
    measures = shape_measures(mesh.points, corners)
    volume, aspect, low, high, _ = measures.T
    counts = {"elements": len(corners), "nodes": len(mesh.points), "dof": 3 * len(mesh.points)}
    if mesh.tets.shape[1] == 4:
        edges = len(group_edges(tet_edges(mesh.tets)).lead)
        counts["dof_second_order"] = 3 * (len(mesh.points) + edges)
    report = counts | {
        "ar_mean": float(aspect.mean()),
        "ar_median": float(np.median(aspect)),
        "ar_max": float(aspect.max()),
        "ar_under_5_pct": _percent(aspect < 5),
        "poor_pct": _percent(is_poor(measures)),
        **{f"poor_{name}_pct": _percent(poor) for name, poor in poor_parts(measures).items()},
        "dihedral_min": float(low.min()),
        "dihedral_max": float(high.max()),
        "flat": flat_tets(mesh, measures),
        "histograms": {
            "aspect_ratio": _histogram(aspect, _ASPECT_EDGES),
            "dihedral_min": _histogram(low, _ANGLE_EDGES),
            "dihedral_max": _histogram(high, _ANGLE_EDGES),
        },
        "jacobian_not_positive": int(np.count_nonzero(~(smallest_jacobians(mesh.points, mesh.tets) > 0))),
        "volume": float(volume.sum()),
        "crack_area": total_area(mesh.points, face_nodes(corners, lip_faces(mesh.face_sets)[0])),
        "front_length": sum(arc_lengths(mesh.points[ids], closed)[1] for ids, closed in mesh_fronts(mesh)),
    }
    if voxels is not None:
        report["volume_drift"] = _drift_from_voxels(mesh.grain, volume, voxels)
    return report


def _drift_from_voxels(grain: np.ndarray, volume: np.ndarray, voxels: Voxels) -> dict:
    """Return relative differences of the grains' volumes from their voxels' volumes.

    grain, volume (m,) of the elements. `mean`, `p95` and `worst` are of absolute values over the grains in
    the voxels (a missing grain drifts by -1); `worst_over_500_voxels` leaves small grains out;
    `without_voxels` lists grains of the mesh that the voxels lack.
    """
    labels, count = np.unique(voxels.labels[voxels.labels > 0], return_counts=True)
    ids, of = np.unique(grain, return_inverse=True)
    wanted = dict(zip(labels.tolist(), (count * np.prod(voxels.spacing)).tolist()))
    drift = volume_drift(wanted, dict(zip(ids.tolist(), np.bincount(of, volume).tolist())))
    size_of = np.abs(list(drift.values()))
    report: dict = {"grains": len(labels), "by_grain": {str(grain): d for grain, d in drift.items()}}
    if len(labels):
        large = size_of[count > 500]
        report |= {
            "mean": float(size_of.mean()),
            "p95": float(np.percentile(size_of, 95)),
            "worst": float(size_of.max()),
            "worst_grain": int(labels[size_of.argmax()]),
            "worst_over_500_voxels": float(large.max(initial=0.0)),
        }
    return report | {"without_voxels": np.setdiff1d(ids, labels).tolist()}


def drift_sentence(drift: Mapping) -> str | None:
    """Return a sentence on the grains whose |relative drift| exceeds MOST_DRIFT; None if there are none.

    drift: the entry `volume_drift` of `quality`.
    """
    far = {grain: off for grain, off in drift.get("by_grain", {}).items() if abs(off) > MOST_DRIFT}
    if not far:
        return None
    worst = sorted(far, key=lambda grain: -abs(far[grain]))
    return (
        f"{len(far)} of {drift['grains']} grains differ in volume from their voxels by more than "
        f"{MOST_DRIFT:.0%}: {listed(f'grain {grain} by {far[grain]:+.1%}' for grain in worst)}"
    )


def _percent(chosen: np.ndarray) -> float:
    return float(100 * chosen.mean())


def _histogram(values: np.ndarray, edges: tuple) -> dict:
    """Return the `counts` of values per bin [edge, next edge), and the `edges`; an infinite edge is None.

    Values beyond the edges count in the first or last bin.
    """
    place = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, len(edges) - 2)
    named = [None if np.isinf(edge) else edge for edge in edges]
    return {"edges": named, "counts": np.bincount(place, minlength=len(edges) - 1).tolist()}
