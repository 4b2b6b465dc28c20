"""Shape of tetrahedra: measures, which are poor or flat, and whether a surface wedge forces a flat one."""

import numpy as np

from craftmesh.mesh.kernels.measure_shapes import fill_measures
from craftmesh.mesh.tet_connectivity import EDGE_CORNERS, dihedral_angles
from craftmesh.surface.connectivity import joined
from craftmesh.types import TetMesh

LEAST_SHAPE_FACTOR = 0.02  # an element with a smaller one is poor
# Dihedral angles in degrees beyond which an element is poor.
LEAST_DIHEDRAL = 10.0
LARGEST_DIHEDRAL = 160.0
# Limits of flat elements, whose stresses mean nothing: they are named with their places.
FLAT_SHAPE_FACTOR = 0.005
FLAT_DIHEDRALS = (5.0, 172.0)
MAX_NAMED = 100  # most flat elements that are named, the flattest first


def shape_measures(points: np.ndarray, tets: np.ndarray) -> np.ndarray:
    """Return (m, 5): volume, aspect ratio, smallest and largest dihedral in degrees, shape factor.

    Aspect ratio: longest edge over smallest altitude; infinite for a flat element. Shape factor: volume
    over the volume of the regular tetrahedron with the same circumsphere; 0 if flat.
    """
    measures = np.empty((len(tets), 5))
    fill_measures(np.ascontiguousarray(points), np.ascontiguousarray(tets, np.int64), measures)
    return measures


def poor_parts(measures: np.ndarray) -> dict[str, np.ndarray]:
    """Return a mask (m,) for each reason to call an element poor, from `shape_measures` (m, 5)."""
    low, high, factor = measures[:, 2], measures[:, 3], measures[:, 4]
    return {
        "shape_factor": factor < LEAST_SHAPE_FACTOR,
        "dihedral_under_10": low < LEAST_DIHEDRAL,
        "dihedral_over_160": high > LARGEST_DIHEDRAL,
    }


def is_poor(measures: np.ndarray) -> np.ndarray:
    """Return a mask (m,) of elements that are poor for any reason, from `shape_measures` (m, 5).

    They have a shape factor under 0.02 or a dihedral angle under 10 or over 160 degrees.
    """
    return np.logical_or.reduce(list(poor_parts(measures).values()))


def is_flat(measures: np.ndarray) -> np.ndarray:
    """Return a mask (m,) of flat elements, from `shape_measures` (m, 5).

    They have a shape factor under 0.005 or a dihedral angle under 5 or over 172 degrees.
    """
    low, high, factor = measures[:, 2], measures[:, 3], measures[:, 4]
    return (factor < FLAT_SHAPE_FACTOR) | (low < FLAT_DIHEDRALS[0]) | (high > FLAT_DIHEDRALS[1])


def flat_tets(mesh: TetMesh, measures: np.ndarray | None = None) -> dict:
    """Return the entry of quality.json on flat elements: `count`, `forced` and `places`.

    Each place has the grain, the centre, the smallest and largest dihedral angle in degrees, the shape
    factor and the sharpest wedge of the grain, in degrees, at an edge of the element (None if no edge is on
    the grain's surface or the crack). A wedge under 5 degrees forces the element. `forced` counts these
    among the places, of which there are at most 100, the flattest first. measures (m, 5): from
    `shape_measures`, if already known.
    """
    corners = np.ascontiguousarray(mesh.tets[:, :4])
    if measures is None:
        measures = shape_measures(mesh.points, corners)
    flat = np.flatnonzero(is_flat(measures))
    named = flat[np.argsort(measures[flat, 2], kind="stable")][:MAX_NAMED]
    is_named = np.zeros(len(mesh.points), bool)
    is_named[corners[named]] = True
    near = np.flatnonzero(is_named[corners].sum(axis=1) > 1)
    places, forced = [], 0
    for t in named.tolist():
        own = corners[near[mesh.grain[near] == mesh.grain[t]]]
        angles = [_wedge(mesh.points, own, corners[t], edge) for edge in EDGE_CORNERS]
        wedge = min((round(angle, 2) for angle in angles if angle is not None), default=None)
        forced += wedge is not None and wedge < FLAT_DIHEDRALS[0]
        places.append(
            {
                "grain": int(mesh.grain[t]),
                "centre": [round(float(x), 6) for x in mesh.points[corners[t]].mean(axis=0)],
                "dihedrals": [round(float(angle), 2) for angle in measures[t, 2:4]],
                "shape_factor": float(measures[t, 4]),
                "wedge": wedge,
            }
        )
    return {"count": len(flat), "forced": forced, "places": places}


def flat_sentence(flat: dict) -> str | None:
    """Return a sentence on the flat elements of `flat_tets`: number, cause and places; None without any."""
    if not flat["count"]:
        return None
    low, high = FLAT_DIHEDRALS
    where = "; ".join(
        f"grain {one['grain']}, ({', '.join(f'{x:.4g}' for x in one['centre'])}), "
        f"{one['dihedrals'][0]:g}..{one['dihedrals'][1]:g} degrees"
        for one in flat["places"][:3]
    )
    return (
        f"{flat['count']} elements are flat (a dihedral angle under {low:g} or over {high:g} degrees or a "
        f"shape factor under {FLAT_SHAPE_FACTOR:g}), {flat['forced']} of them in wedges "
        f"of the surface under {low:g} degrees: {where}; quality.json names their places under flat"
    )


def _wedge(points: np.ndarray, tets: np.ndarray, corners: np.ndarray, edge: np.ndarray) -> float | None:
    """Return the angle in degrees that tets (m, 4) fill around an edge of the tet `corners` (4,).

    edge (2,): positions of its ends in `corners`. Only tets connected to that tet by faces at the edge
    count; None if they surround the edge.
    """
    a, b = corners[edge]
    tets = tets[(tets == a).any(axis=1) & (tets == b).any(axis=1)]
    rim, place = np.unique(tets[(tets != a) & (tets != b)], return_inverse=True)
    ends = place.reshape(-1, 2)
    part = joined(len(rim), *ends.T)
    ends = rim[ends[part[ends[:, 0]] == part[np.isin(rim, corners)][0]]]
    if len(np.unique(ends)) == len(ends):
        return None
    return float(np.degrees(dihedral_angles(points, a, b, *ends.T).sum()))
