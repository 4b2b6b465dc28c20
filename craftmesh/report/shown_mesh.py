"""What of a mesh is shown: skin, cut open at the crack, lip and fronts; a plane's cut; the page's view."""

import base64
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from craftmesh.cracks.height_parts import best_fit_frame
from craftmesh.cracks.prescription import frame_along
from craftmesh.mesh.front import mesh_fronts
from craftmesh.mesh.mesh_sets import is_lip, lip_faces
from craftmesh.mesh.tet_connectivity import (
    EDGE_CORNERS,
    free_half_faces,
    group_edges,
    half_face_corners,
    tet_edges,
)
from craftmesh.surface.measure import area_vectors, mean_edges
from craftmesh.types import TetMesh

# The view along the two axes beside the one that faces it, over that: a lip is seen well, and two faces.
ASIDE = (0.75, 0.55)
SIDES = np.array([1.0, -1.0, 1.0])  # the side of each axis, where nothing tells it
COARSER = 1.2  # the grid's cells grow by this until the triangles are few enough
# Triangles of the body's skin, and of the crack: some 180 kB of text a case and increment at most.
MOST_TRIANGLES = 6500
LEVELS = np.iinfo(np.uint16).max  # of coordinates within the box, and of lengths


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
    edges = tet_edges(tets)
    return ShownMesh(
        points=mesh.points,
        lengths=mean_edges(mesh.points, edges[group_edges(edges).lead]),
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
    sign = np.where(np.abs(off) > 1e-6, np.sign(off), SIDES)
    facing = int(np.abs(normal).argmax())
    return normal * np.sign(normal[facing]), centre, seen_from(facing, sign)


def seen_from(facing: int, sign: np.ndarray = SIDES) -> np.ndarray:
    """Return a direction of view (3,) in which an axis faces it; sign (3,): the sides of the two others."""
    return np.where(np.arange(3) == facing, 1.0, sign * np.insert(ASIDE, facing, 1.0))


def _below(
    places: np.ndarray, points: np.ndarray, lip: np.ndarray, normal: np.ndarray, centre: np.ndarray
) -> np.ndarray:
    """Tell which places (k, 3) are below the crack, or beside it below its nearest triangle."""
    height = (places - centre) @ normal
    below = height < 0
    corners = points[lip] - centre
    near = np.flatnonzero(np.abs(height) <= np.abs(corners @ normal).max(initial=0))
    if len(near) and len(lip):
        across = frame_along(normal, np.eye(3)[np.abs(normal).argmin()])[:2].T
        middle, vectors = corners.mean(axis=1), area_vectors(points, lip)
        along = vectors @ normal
        slope = -(vectors @ across) / np.where(along == 0, np.inf, along)[:, None]
        away, nearest = cKDTree(middle @ across).query((places[near] - centre) @ across)
        aside = (places[near] - centre - middle[nearest]) @ across
        # no further up the slope than the triangle reaches
        reach = np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1)[nearest]
        share = np.minimum(1, reach / np.maximum(away, np.finfo(float).tiny))
        rise = np.einsum("ij,ij->i", slope[nearest], aside) * share
        below[near] = height[near] < middle[nearest] @ normal + rise
    return below


def _boundary(mesh: TetMesh, tets: np.ndarray, kept: np.ndarray) -> Facets:
    """Return the facets of the elements `kept` (m,) that no two of them share."""
    own = np.flatnonzero(kept)
    rows = free_half_faces(tets[own])
    rows = 4 * own[rows // 4] + rows % 4
    lips = np.concatenate(lip_faces(mesh.face_sets))
    is_lip_face = np.zeros(4 * len(tets), bool)
    is_lip_face[4 * lips[:, 0] + lips[:, 1]] = True
    return Facets(half_face_corners(tets, rows), mesh.grain[rows // 4], is_lip_face[rows])


def cut_tets(
    points: np.ndarray, tets: np.ndarray, level: float, axis: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the polygons (p, 4, 2) in which a plane square to an axis cuts tetrahedra (m, 4), and which.

    points (n, 3); polygons have the two other coordinates, and corners in an order that goes round; a
    triangle has its last corner twice. Corners of tetrahedra on the plane count as below it.
    """
    above = points[:, axis] > level
    rows = np.flatnonzero(above[tets].any(axis=1) & ~above[tets].all(axis=1))
    start, end = np.moveaxis(tets[rows][:, EDGE_CORNERS], 2, 0)
    crossed = above[start] != above[end]
    step = points[end] - points[start]
    share = (level - points[start, axis]) / np.where(crossed, step[..., axis], 1.0)
    corners = np.delete(points[start] + share[..., None] * step, axis, axis=2)
    middle = np.average(corners, axis=1, weights=np.repeat(crossed[..., None], 2, axis=2))
    x, y = np.moveaxis(corners - middle[:, None], 2, 0)
    order = np.where(crossed, np.arctan2(y, x), np.inf).argsort(axis=1)[:, :4]
    order[crossed.sum(axis=1) == 3, 3] = order[crossed.sum(axis=1) == 3, 2]
    return np.take_along_axis(corners, order[..., None], axis=1), rows


def decimated(
    points: np.ndarray, triangles: np.ndarray, box: np.ndarray, most: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the places (p, 3) of corners, triangles (k, 3) on them, about `most`, and what those were.

    points (n, 3); triangles (m, 3). The last result (k,) has the row of each triangle among those given;
    few enough triangles stay as they are. A corner is the mean of the points that it stands for, which all
    lie on the same planes of the box (2, 3), so faces, edges and corners of the box stay in place, which
    takes some 48 triangles, however few are asked for.
    """
    used, local = np.unique(triangles, return_inverse=True)
    local = local.reshape(-1, 3)
    if len(triangles) <= most:
        return points[used], local, np.arange(len(triangles))
    corners = points[used]
    planes = (corners[:, None] == box).reshape(-1, 6) @ (1 << np.arange(6))
    diagonal = float(np.linalg.norm(np.ptp(box, axis=0)))
    size = diagonal / np.sqrt(most)
    while True:
        cells = np.column_stack([np.floor((corners - box[0]) / size).astype(np.int64), planes])
        _, place, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
        found = place.reshape(-1)[local]
        whole = (found != np.roll(found, 1, axis=1)).all(axis=1)
        _, first = np.unique(np.sort(found[whole], axis=1), axis=0, return_index=True)
        rows = np.sort(np.flatnonzero(whole)[first])
        if len(rows) <= most or size > diagonal:
            break
        size *= COARSER
    sums = [np.bincount(place.reshape(-1), corners[:, k]) for k in range(3)]
    return np.stack(sums, axis=1) / count[:, None], found[rows], rows


def scene(shown: ShownMesh) -> dict:
    """Return the skin, the crack's lip and its fronts as JSON can hold them.

    Coordinates are shares of `box`, in steps of 1 / LEVELS; `length` of a corner is that share of the way
    between the two `lengths`; arrays are little-endian numbers, unsigned and of 2 bytes but for `triangles`
    and `grain` of 4, as base64.
    """
    box = np.stack([shown.points.min(axis=0), shown.points.max(axis=0)])
    lengths = np.array([shown.lengths.min(), shown.lengths.max()])
    return {
        "box": box.tolist(),
        "lengths": lengths.tolist(),
        "normal": shown.normal.tolist(),
        "towards": shown.towards.tolist(),
        "skin": _part(shown, shown.skin, box, lengths, MOST_TRIANGLES),
        "lip": _part(shown, shown.lip, box, lengths, MOST_TRIANGLES),
        "fronts": [_text(_shares(shown.points[front], box), "<u2") for front in shown.fronts],
    }


def _part(shown: ShownMesh, facets: Facets, box: np.ndarray, lengths: np.ndarray, most: int) -> dict:
    places, triangles, rows = decimated(shown.points, facets.triangles, box, most)
    at_corner = np.zeros(len(places))
    # of the nodes that a corner stands for, those of the triangles that are left
    at_corner[triangles] = shown.lengths[facets.triangles[rows]]
    return {
        "points": _text(_shares(places, box), "<u2"),
        "triangles": _text(triangles, "<u4"),
        "grain": _text(facets.grain[rows], "<u4"),
        "length": _text(_shares(at_corner, lengths), "<u2"),
    }


def _shares(values: np.ndarray, limits: np.ndarray) -> np.ndarray:
    span = np.maximum(limits[1] - limits[0], np.finfo(float).tiny)
    return np.rint(np.clip((values - limits[0]) / span, 0, 1) * LEVELS)


def _text(values: np.ndarray, kind: str) -> str:
    return base64.b64encode(np.ascontiguousarray(values, kind).tobytes()).decode("ascii")
