"""What of a mesh is shown: its skin, the body cut open at the crack, the crack's lip and fronts."""

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from craftmesh.cracks.frame import best_fit_frame
from craftmesh.cracks.prescription import frame_along
from craftmesh.mesh.front import mesh_fronts
from craftmesh.mesh.mesh_sets import is_lip, lip_faces
from craftmesh.mesh.tet_connectivity import free_half_faces, group_edges, half_face_corners, tet_edges
from craftmesh.surface.measure import area_vectors, mean_edges
from craftmesh.types import TetMesh

# Along the crack's normal, and along the two other axes: looked at from there its lip is seen well, and so
# are two faces of the box.
STEEPLY, ASIDE = 1.0, (0.75, 0.55)


class Facets(NamedTuple):
    """Triangles (m, 3) of a mesh's nodes, the grain (m,) behind each, and which are a crack's lip (m,)."""

    triangles: np.ndarray
    grain: np.ndarray
    is_lip: np.ndarray


class ShownMesh(NamedTuple):
    """A mesh of 4-node elements to be shown.

    points (n, 3); lengths (n,): mean length of the edges at each node; skin: facets of box, voids and
    exterior; opened: facets of the body without what lies before the crack's plane; lip: those of lips A;
    fronts: node ids, the first one again at the end of closed ones; normal (3,) of that plane, towards who
    looks, and centre (3,) on it; towards (3,): where the body is looked at from.
    """

    points: np.ndarray
    lengths: np.ndarray
    skin: Facets
    opened: Facets
    lip: Facets
    fronts: list[np.ndarray]
    normal: np.ndarray
    centre: np.ndarray
    towards: np.ndarray


def shown_mesh(mesh: TetMesh) -> ShownMesh:
    """Return what is shown of `mesh`; without a crack it is cut open in the middle, square to z."""
    tets = mesh.tets[:, :4]
    faces = lip_faces(mesh.face_sets)[0]
    lip = _facets(mesh, tets, faces, True)
    normal, centre, towards = _plane(mesh, lip.triangles)
    kept = _below(mesh.points[tets].mean(axis=1), mesh.points, lip.triangles, normal, centre)
    names = [name for name in mesh.face_sets if not is_lip(name)]
    skin = np.concatenate([np.zeros((0, 2), np.int64), *(mesh.face_sets[name] for name in names)])
    fronts = [np.append(nodes, nodes[:1]) if closed else nodes for nodes, closed in mesh_fronts(mesh)]
    return ShownMesh(
        points=mesh.points,
        lengths=_mean_lengths(mesh.points, tets),
        skin=_facets(mesh, tets, skin, False),
        opened=_boundary(mesh, tets, kept),
        lip=lip,
        fronts=fronts,
        normal=normal,
        centre=centre,
        towards=towards,
    )


def _facets(mesh: TetMesh, tets: np.ndarray, faces: np.ndarray, lip: bool) -> Facets:
    rows = 4 * faces[:, 0] + faces[:, 1]
    return Facets(half_face_corners(tets, rows), mesh.grain[faces[:, 0]], np.full(len(rows), lip))


def _plane(mesh: TetMesh, lip: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return normal and centre of the plane that the body is cut open along, and the direction of view."""
    box = mesh.box
    centre, normal = box.mean(axis=0), np.array([0.0, 0.0, 1.0])
    if len(lip):
        normal = best_fit_frame(mesh.points, lip)[2]
        centre = mesh.points[lip].mean(axis=(0, 1))
    off = (centre - box.mean(axis=0)) / np.ptp(box, axis=0)
    # from the side to which the crack is nearest, so that its mouth is seen
    sign = np.where(np.abs(off) > 1e-6, np.sign(off), [1.0, -1.0, 1.0])
    facing = int(np.abs(normal).argmax())
    others = [axis for axis in range(3) if axis != facing]
    towards = np.zeros(3)
    towards[others] = sign[others] * ASIDE
    towards[facing] = STEEPLY
    return normal * np.sign(normal[facing]), centre, towards


def _below(
    places: np.ndarray, points: np.ndarray, lip: np.ndarray, normal: np.ndarray, centre: np.ndarray
) -> np.ndarray:
    """Tell which places (k, 3) are below the crack, or beside it below its nearest triangle."""
    height = (places - centre) @ normal
    below = height < 0
    corners = points[lip] - centre
    near = np.flatnonzero(np.abs(height) <= np.abs(corners @ normal).max(initial=0))
    if len(near):
        across = frame_along(normal, np.eye(3)[np.abs(normal).argmin()])[:2].T
        middle, slope = corners.mean(axis=1), _slopes(points, lip, normal, across)
        away, nearest = cKDTree(middle @ across).query((places[near] - centre) @ across)
        aside = (places[near] - centre - middle[nearest]) @ across
        # no further up the slope than the triangle reaches
        reach = np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1)[nearest]
        share = np.minimum(1, reach / np.maximum(away, np.finfo(float).tiny))
        rise = np.einsum("ij,ij->i", slope[nearest], aside) * share
        below[near] = height[near] < middle[nearest] @ normal + rise
    return below


def _slopes(points: np.ndarray, lip: np.ndarray, normal: np.ndarray, across: np.ndarray) -> np.ndarray:
    """Return how much triangles (m, 3) rise along `normal`, over the columns of `across` (3, 2): (m, 2)."""
    vectors = area_vectors(points, lip)
    along = vectors @ normal
    return -(vectors @ across) / np.where(along == 0, np.inf, along)[:, None]


def _boundary(mesh: TetMesh, tets: np.ndarray, kept: np.ndarray) -> Facets:
    """Return the facets of the elements `kept` (m,) that no two of them share."""
    own = np.flatnonzero(kept)
    rows = free_half_faces(tets[own])
    rows = 4 * own[rows // 4] + rows % 4
    lips = np.concatenate(lip_faces(mesh.face_sets))
    is_lip_face = np.zeros(4 * len(tets), bool)
    is_lip_face[4 * lips[:, 0] + lips[:, 1]] = True
    return Facets(half_face_corners(tets, rows), mesh.grain[rows // 4], is_lip_face[rows])


def _mean_lengths(points: np.ndarray, tets: np.ndarray) -> np.ndarray:
    """Return the mean length of the edges at each node (n,)."""
    edges = tet_edges(tets)
    return mean_edges(points, edges[group_edges(edges).lead])
