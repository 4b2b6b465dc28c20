"""Visible parts of a mesh: skin, body cut open, crack face, fronts, plane sections, and the 3-D view.

The skin is the free surface of the body without the crack; a lip is a crack face.
"""

import base64
from collections.abc import Mapping
from typing import Any, NamedTuple

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

# Components of the view direction along two axes, relative to its component along the third axis, which is
# nearest to the crack's normal. The crack face and two box faces are then well visible.
ASIDE = (0.75, 0.55)
SIDES = np.array([1.0, -1.0, 1.0])  # default signs of the view direction
COARSER = 1.2  # factor by which grid cells grow until there are few enough triangles (`decimated`)
# Most triangles each of the skin, the opened body and the crack face in the 3-D view: about 180 kB of text
# per increment.
MOST_TRIANGLES = 6500
LEVELS = np.iinfo(np.uint16).max  # largest integer that stands for a coordinate in the box, or for a length


class Facets(NamedTuple):
    """Triangles (m, 3) on a mesh's nodes.

    element, grain (m,): row and grain of the element behind each; is_lip (m,): mask of crack faces.
    """

    triangles: np.ndarray
    element: np.ndarray
    grain: np.ndarray
    is_lip: np.ndarray


class ShownMesh(NamedTuple):
    """The visible parts of a mesh of 4-node elements.

    points (n, 3); lengths (n,): mean length of the edges at each node; skin: facets of box, voids and
    exterior; opened: facets of the body without the part in front of the crack and its extension; lip:
    facets of the crack faces on side A (one side of each crack); fronts: node ids, the first repeated at
    the end of a closed front; normal (3,) of the crack's plane, towards the viewer, and centre (3,) on it;
    towards (3,): direction to the viewer.
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
    """Return the visible parts of a mesh; without a crack it is cut at its middle, perpendicular to z."""
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
    own = faces[:, 0]
    return Facets(half_face_corners(tets, rows), own, mesh.grain[own], np.full(len(rows), lip))


def _plane(mesh: TetMesh, lip: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return normal and centre of the plane along which the body is cut open, and the view direction.

    lip (k, 3): triangles of crack faces A.
    """
    box = mesh.box
    centre, normal = box.mean(axis=0), np.array([0.0, 0.0, 1.0])
    if len(lip):
        normal = best_fit_frame(mesh.points, lip)[2]
        centre = mesh.points[lip].mean(axis=(0, 1))
    off = (centre - box.mean(axis=0)) / np.ptp(box, axis=0)
    # seen from the side nearest to the crack, so that its mouth is visible
    sign = np.where(np.abs(off) > 1e-6, np.sign(off), SIDES)
    facing = int(np.abs(normal).argmax())
    return normal * np.sign(normal[facing]), centre, seen_from(facing, sign)


def seen_from(facing: int, sign: np.ndarray = SIDES) -> np.ndarray:
    """Return a view direction (3,) mainly along the axis `facing`; sign (3,): signs of other components."""
    return np.where(np.arange(3) == facing, 1.0, sign * np.insert(ASIDE, facing, 1.0))


def _below(
    places: np.ndarray, points: np.ndarray, lip: np.ndarray, normal: np.ndarray, centre: np.ndarray
) -> np.ndarray:
    """Return a mask (k,) of points `places` (k, 3) below the crack or below its extension.

    lip (t, 3): the crack's triangles on `points`; normal, centre (3,): of the crack's mean plane. Below is
    against the normal.
    """
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
        # the triangle's slope is extended by at most its own size
        reach = np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1)[nearest]
        share = np.minimum(1, reach / np.maximum(away, np.finfo(float).tiny))
        rise = np.einsum("ij,ij->i", slope[nearest], aside) * share
        below[near] = height[near] < middle[nearest] @ normal + rise
    return below


def _boundary(mesh: TetMesh, tets: np.ndarray, kept: np.ndarray) -> Facets:
    """Return the outer facets of the elements in the mask `kept` (m,)."""
    own = np.flatnonzero(kept)
    rows = free_half_faces(tets[own])
    rows = 4 * own[rows // 4] + rows % 4
    lips = np.concatenate(lip_faces(mesh.face_sets))
    is_lip_face = np.zeros(4 * len(tets), bool)
    is_lip_face[4 * lips[:, 0] + lips[:, 1]] = True
    return Facets(half_face_corners(tets, rows), rows // 4, mesh.grain[rows // 4], is_lip_face[rows])


def cut_tets(
    points: np.ndarray, tets: np.ndarray, level: float, axis: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the sections (p, 4, 2) of tetrahedra (m, 4) by a plane, and the rows (p,) of these tetrahedra.

    points (n, 3). The plane is perpendicular to `axis` at the coordinate `level`; a section is a polygon in
    the other two coordinates. Its corners are in cyclic order; a triangle has its last corner twice.
    Tetrahedron corners on the plane count as below it.
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
    """Return points (p, 3), at most about `most` triangles (k, 3) on them, and the triangles' rows before.

    points (n, 3); triangles (m, 3). If m <= most, the triangles are only renumbered. Otherwise the points
    in each cell of a grid are replaced by their mean. Only points on the same planes of the box (2, 3) are
    merged, so that the box keeps its faces, edges and corners; this needs some 48 triangles, even if `most`
    is less.
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
    """Return skin, opened body, crack face and fronts as JSON values for the 3-D view.

    The keys are box, lengths (smallest and largest edge length), normal, towards, skin, opened, lip and
    fronts. Coordinates are fractions of the box in steps of 1 / LEVELS, and `length` of a corner is such a
    fraction between the two `lengths`; `grain` is 0 on crack faces. Arrays are base64 of little-endian
    unsigned integers: 4 bytes in `triangles` and `grain`, 2 bytes in others.
    """
    box = np.stack([shown.points.min(axis=0), shown.points.max(axis=0)])
    lengths = np.array([shown.lengths.min(), shown.lengths.max()])
    return {
        "box": box.tolist(),
        "lengths": lengths.tolist(),
        "normal": shown.normal.tolist(),
        "towards": shown.towards.tolist(),
        "skin": _part(shown, shown.skin, box, lengths, MOST_TRIANGLES),
        "opened": _part(shown, shown.opened, box, lengths, MOST_TRIANGLES),
        "lip": _part(shown, shown.lip, box, lengths, MOST_TRIANGLES),
        "fronts": [_text(_shares(shown.points[front], box), "<u2") for front in shown.fronts],
    }


def fronts_of(made: Mapping[str, Any]) -> list[np.ndarray]:
    """Return the points (k, 3) of each front of a `scene`, to the precision of its integers."""
    low, high = np.array(made["box"])
    read = (np.frombuffer(base64.b64decode(text), "<u2").reshape(-1, 3) for text in made["fronts"])
    return [low + places / LEVELS * (high - low) for places in read]


def _part(shown: ShownMesh, facets: Facets, box: np.ndarray, lengths: np.ndarray, most: int) -> dict:
    places, triangles, rows = decimated(shown.points, facets.triangles, box, most)
    at_corner = np.zeros(len(places))
    # a corner replaces several nodes and gets the length at one of them
    at_corner[triangles] = shown.lengths[facets.triangles[rows]]
    return {
        "points": _text(_shares(places, box), "<u2"),
        "triangles": _text(triangles, "<u4"),
        "grain": _text(np.where(facets.is_lip, 0, facets.grain)[rows], "<u4"),
        "length": _text(_shares(at_corner, lengths), "<u2"),
    }


def _shares(values: np.ndarray, limits: np.ndarray) -> np.ndarray:
    span = np.maximum(limits[1] - limits[0], np.finfo(float).tiny)
    return np.rint(np.clip((values - limits[0]) / span, 0, 1) * LEVELS)


def _text(values: np.ndarray, kind: str) -> str:
    return base64.b64encode(np.ascontiguousarray(values, kind).tobytes()).decode("ascii")
