"""J of a body that may have yielded, from nodal stresses and densities of work, on several rings.

A ring is an integration domain: the elements between two distances from the front.
"""

from typing import NamedTuple

import numpy as np
import scipy

from craftmesh.cracks.polyline import feet, polyline
from craftmesh.fracture.tube import OF_CURVATURE
from craftmesh.mechanics.materials import COMPONENT
from craftmesh.mesh.front_curve import local_sizes
from craftmesh.mesh.front_frames import Front, faces_of_nodes, fronts_of
from craftmesh.mesh.integration import shape_slopes, shape_values, tet_rule
from craftmesh.mesh.lips import lip_pairs
from craftmesh.mesh.mesh_sets import is_lip
from craftmesh.mesh.tet_connectivity import face_nodes
from craftmesh.types import BOX_PLANES, TetMesh

# Inner and outer radius of the rings, in edges of the front. The first contains parts of the elements at
# the front, which are the least accurate.
RINGS = ((1, 2), (2, 3), (3, 4))


class NodalField(NamedTuple):
    """Nodal displacement (n, 3), stress (n, 6) as 11, 22, 33, 12, 13, 23, and work of the stress (n,).

    The work is per volume and includes plastic work.
    """

    displacement: np.ndarray
    stress: np.ndarray
    work: np.ndarray


class FrontRings(NamedTuple):
    """J of one front on each of RINGS, and the lips' mean and largest opening an edge behind the front.

    J is a mean along the front, NaN for a ring without room. Differences between the rings show how far J
    depends on the path: because of unloading, of different grains, and of the mesh.
    """

    J: tuple[float, ...]
    opening: float
    largest_opening: float

    def figures(self) -> dict[str, float]:
        """Return the numbers by name: the lips' mean and largest opening, J of each ring with room."""
        rings = {f"J {inner:g} to {outer:g} edges off": J for (inner, outer), J in zip(RINGS, self.J)}
        known = {name: J for name, J in rings.items() if np.isfinite(J)}
        return {"opening": self.opening, "largest opening": self.largest_opening} | known


def front_rings(mesh: TetMesh, field: NodalField) -> list[FrontRings]:
    """Return J and the opening of the lips (crack faces) of each front of a 10-node mesh.

    J is the domain integral of sigma_ij u_i,k v_k,j - W v_k,k (Li, Shih & Needleman 1985), W the work of
    the stresses, including plastic work; tractions on lips are not considered. If all loads have grown in
    proportion, J is the energy that a longer crack would release. After cycles it only describes the field
    around the front.
    """
    pairs = lip_pairs(mesh)
    gaps, lips = pairs.gaps(field.displacement), scipy.spatial.cKDTree(mesh.points[pairs.nodes[:, 0]])
    found = []
    for front in fronts_of(mesh):
        ends = mesh.points[front.corners]
        line = polyline(np.concatenate([ends, ends[:1]]) if front.closed else ends)
        sizes = local_sizes(ends, front.closed)
        binormal = front.curve.frames(line.arc[: len(ends)] * front.curve.length / line.length)[3]
        behind = gaps[lips.query(ends - sizes[:, None] * binormal)[1]]
        arc, distance = feet(line, mesh.points)
        edge = np.interp(arc, line.arc, np.append(sizes, sizes[:1]) if front.closed else sizes)
        s = arc / line.length * front.curve.length
        bend = front.curve.bend_radius(s) / edge
        J = []
        for inner, outer in RINGS:
            q = np.clip((outer - distance / edge) / (outer - inner), 0, 1)
            moved = _extension(mesh, front, q[:, None] * front.curve.frames(s)[3])
            if moved is None or (bend[q > 0] * OF_CURVATURE < outer).any():
                J.append(np.nan)
            else:
                J.append(_integral(mesh, field, moved) / line.length)
        found.append(FrontRings(tuple(J), float(behind.mean()), float(behind.max())))
    return found


def _extension(mesh: TetMesh, front: Front, moved: np.ndarray) -> np.ndarray | None:
    """Return the virtual extension moved (n, 3), kept in the planes of the box where the front ends.

    Changes `moved` in place. Returns None if the extension moves another outer face, except lips.
    """
    ends = [] if front.closed else faces_of_nodes(mesh, front.corners[[0, -1]])
    for name, faces in mesh.face_sets.items():
        nodes = np.unique(face_nodes(mesh.tets, faces))
        if is_lip(name) or not moved[nodes].any():
            continue
        if name not in BOX_PLANES or not any(name in end for end in ends):
            return None
        moved[nodes, BOX_PLANES.index(name) // 2] = 0.0
    return moved


def _integral(mesh: TetMesh, field: NodalField, moved: np.ndarray) -> float:
    """Return J times the front's length; moved (n, 3): virtual extension of the nodes, 1 at the front."""
    tets = mesh.tets[np.ptp(moved[mesh.tets], axis=1).any(axis=1)]
    places, weights = tet_rule(4)
    total = 0.0
    for value, slopes, weight in zip(shape_values(places), shape_slopes(places, 10), weights):
        jacobian = np.einsum("wk,mwi->mik", slopes, mesh.points[tets])
        gradient = np.einsum("wk,mkj->mwj", slopes, np.linalg.inv(jacobian))
        u, v = (np.einsum("mwi,mwj->mij", own[tets], gradient) for own in (field.displacement, moved))
        stress = np.einsum("w,mwc->mc", value, field.stress[tets])[:, COMPONENT]
        work = field.work[tets] @ value
        density = np.einsum("mij,mik,mkj->m", stress, u, v) - work * np.trace(v, axis1=1, axis2=2)
        total += weight * float(density @ np.linalg.det(jacobian))
    return total
