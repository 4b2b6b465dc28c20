"""The tetrahedra of all grains on common nodes, and the surface that bounds the grains.

The crack is closed: the nodes of its two faces (lips) are one node, and its facets are one layer. Half face
4 * tet + k is the face of a tet opposite its corner k.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mesh.common_nodes import common_points, common_tets, grain_of_tets
from craftmesh.mesh.mesh_sets import lip_faces
from craftmesh.mesh.tet_connectivity import grains_at_nodes, group_triples, half_face_corners
from craftmesh.sizing.sizing import Lengths
from craftmesh.surface.connectivity import lowest_equal_point
from craftmesh.types import BOX_PLANES, CRACK, INTERFACE, GrainTets, Surface, TetMesh


@dataclass(frozen=True)
class Whole:
    """Tetrahedra of all grains on common nodes. The crack is closed.

    surface: the boundaries of the grains and the crack; points (n, 3): the points of the surface come
    first; lengths (n,): target edge length at each node when the node was made; tets (m, 4) and their grain
    (m,); origin (m,): row of the tet in the mesh before, -1 for new tets.
    """

    surface: Surface
    points: np.ndarray
    lengths: np.ndarray
    tets: np.ndarray
    grain: np.ndarray
    origin: np.ndarray


def whole_of(surface: Surface, grain_tets: Sequence[GrainTets], sizing: Lengths) -> Whole:
    """Return the tetrahedra of a surface's grains on common nodes; all of them are new (origin -1)."""
    points, tets = common_points(surface, grain_tets), common_tets(surface, grain_tets)
    grain = grain_of_tets(grain_tets)
    origin = np.full(len(tets), -1)
    return Whole(surface, points, sizing.at(points), tets, grain.astype(np.int32), origin)


def whole_of_mesh(mesh: TetMesh, lengths: np.ndarray) -> Whole:
    """Return the elements of a 4-node mesh with its crack closed; origin is the element's row.

    lengths (n,): target edge length at each of the mesh's nodes. Nodes with the same coordinates become
    one. Facets come from the face sets of box planes, EXTERIOR, voids and lips, and from faces between
    grains. Raises CraftmeshError if a face of one lip has none of the other lip opposite it.
    """
    tets = lowest_equal_point(mesh.points)[mesh.tets]
    ahead, behind = (faces @ np.array([4, 1]) for faces in lip_faces(mesh.face_sets))
    rows, sides, kinds = (
        [ahead],
        [_lip_sides(tets, mesh.grain, ahead, behind)],
        [np.full(len(ahead), CRACK)],
    )
    for name, faces in mesh.face_sets.items():
        if name in BOX_PLANES or name == "EXTERIOR" or name.startswith("VOID_"):
            free, label = faces @ np.array([4, 1]), -int(name[5:]) if name.startswith("VOID_") else 0
            rows.append(free)
            sides.append(np.stack([np.full(len(free), label), mesh.grain[free // 4]], axis=1))
            kind = BOX_PLANES.index(name) + 1 if name in BOX_PLANES else INTERFACE
            kinds.append(np.full(len(free), kind))
    between = _between_grains(tets, mesh.grain, np.concatenate([ahead, behind]))
    rows.append(between[:, 1])
    sides.append(mesh.grain[between // 4])
    kinds.append(np.full(len(between), INTERFACE))
    return with_surface_first(
        mesh.points,
        lengths,
        tets,
        mesh.grain,
        np.arange(len(tets)),
        (half_face_corners(tets, np.concatenate(rows)), np.concatenate(sides), np.concatenate(kinds)),
    )


def with_surface_first(
    points: np.ndarray,
    lengths: np.ndarray,
    tets: np.ndarray,
    grain: np.ndarray,
    origin: np.ndarray,
    parts: tuple[np.ndarray, np.ndarray, np.ndarray],
) -> Whole:
    """Return the tets with the points of the surface first and without unused points.

    parts: the facets (f, 3), sides (f, 2) and kind (f,) of the surface.
    """
    facets, sides, kind = parts
    used, on = np.zeros((2, len(points)), bool)
    used[tets], on[facets] = True, True
    order = np.concatenate([np.flatnonzero(on), np.flatnonzero(used & ~on)])
    number = np.full(len(points), -1)
    number[order] = np.arange(len(order))
    surface = Surface(points[order[: on.sum()]], number[facets], sides, kind)
    return Whole(surface, points[order], lengths[order], number[tets], grain, origin)


def grain_tets_of(whole: Whole) -> tuple[list[GrainTets], np.ndarray]:
    """Return the tets grain by grain, by ascending id, and the rows (m,) of whole.tets in that order."""
    number = np.full(len(whole.points), -1)
    number[: len(whole.surface.points)] = np.arange(len(whole.surface.points))
    return grouped_tets(whole, np.arange(len(whole.tets)), number)


def grouped_tets(whole: Whole, rows: np.ndarray, number: np.ndarray) -> tuple[list[GrainTets], np.ndarray]:
    """Return the tets `rows` (k,) of a model grain by grain, by ascending id, and the rows in that order.

    number (n,): each node's id among the surface points of the result, -1 for interior nodes.
    """
    rows = rows[np.argsort(whole.grain[rows], kind="stable")]
    result, place = [], np.empty(len(whole.points), np.int64)
    for mine in np.split(rows, np.flatnonzero(np.diff(whole.grain[rows])) + 1):
        used = np.unique(whole.tets[mine])
        on, inside = used[number[used] >= 0], used[number[used] < 0]
        place[on], place[inside] = np.arange(len(on)), len(on) + np.arange(len(inside))
        grain, local = int(whole.grain[mine[0]]), place[whole.tets[mine]]
        result.append(GrainTets(grain, number[on], whole.points[inside], local))
    return result, rows


def _lip_sides(tets: np.ndarray, grain: np.ndarray, ahead: np.ndarray, behind: np.ndarray) -> np.ndarray:
    """Return the grains (k, 2) behind and ahead of each crack facet.

    ahead, behind (k,): half faces of the tets on lip A and on lip B. Raises CraftmeshError if they do not
    pair up.
    """
    groups = group_triples(half_face_corners(tets, np.concatenate([ahead, behind])))
    if not (groups.count == 2).all():
        raise CraftmeshError("faces of lips A and B do not pair up; give the mesh as it was assembled")
    first, second = groups.pairs.T
    across = np.empty(len(ahead), np.int64)
    across[first] = behind[second - len(ahead)]
    return np.stack([grain[across // 4], grain[ahead // 4]], axis=1)


def _between_grains(tets: np.ndarray, grain: np.ndarray, lips: np.ndarray) -> np.ndarray:
    """Return the pairs (p, 2) of half faces between elements of two grains, without half faces in `lips`.

    Only faces whose three nodes all have elements of several grains are compared, which saves time.
    """
    lowest, highest = grains_at_nodes(tets, grain)
    is_shared = lowest < highest
    rows = np.flatnonzero(is_shared[tets].sum(axis=1) >= 3)
    halves = (4 * rows[:, None] + np.arange(4)).ravel()
    corners = half_face_corners(tets, halves)
    halves = halves[is_shared[corners].all(axis=1)]
    halves = halves[~np.isin(halves, lips)]
    pairs = halves[group_triples(half_face_corners(tets, halves)).pairs]
    return pairs[grain[pairs[:, 0] // 4] != grain[pairs[:, 1] // 4]]
