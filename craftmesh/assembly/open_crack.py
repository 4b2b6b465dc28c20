"""A crack opened in any conformal mesh: its nodes are doubled, the nodes of its front stay single."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np

from craftmesh.arguments import as_array, check_indices
from craftmesh.assembly.foreign_mesh import foreign_facets, foreign_with_crack, tet_mesh_of
from craftmesh.assembly.opening import opened_across, with_copies
from craftmesh.cracks.one_sheet import lip_a_ahead, turned_alike
from craftmesh.errors import CraftmeshError
from craftmesh.mesh.front import mesh_fronts
from craftmesh.mesh.mesh_sets import crack_sets, is_lip, lip_faces, node_sets_of
from craftmesh.mesh.tet_connectivity import face_nodes, facet_groups, half_face_corners, tet_volumes
from craftmesh.surface.connectivity import pieces, same_turn
from craftmesh.surface.measure import total_area
from craftmesh.types import TetMesh

if TYPE_CHECKING:
    from meshio import Mesh

AnyMesh = TypeVar("AnyMesh", TetMesh, "Mesh")


class Opened(NamedTuple):
    """A mesh's tetrahedra on separated nodes.

    tets: the given tetrahedra with new node ids; parent (n,): the old node of each node; old nodes come
    first and keep their ids. ahead, behind (k,): half faces 4 * tet + face of the lips (crack faces) A and
    B; crack (k,): number of the crack of each pair, from 0. free: half faces that were free before. shut:
    number of crack facets that stay closed because all their corners are on the front; on_boundary: number
    of given facets that are on the mesh's boundary, and are ignored.
    """

    tets: np.ndarray
    parent: np.ndarray
    ahead: np.ndarray
    behind: np.ndarray
    crack: np.ndarray
    free: np.ndarray
    shut: int
    on_boundary: int


def open_crack(mesh: AnyMesh, facets: np.ndarray | str) -> tuple[AnyMesh, dict[str, int | float]]:
    """Return the mesh opened along the crack's facets, with sets of its lips and fronts, and a report.

    mesh: a TetMesh or a meshio.Mesh of conformal tetrahedra, of 4 or 10 nodes each, of any origin; the
    result has the same type. facets (k, 3): the corners of faces between two tetrahedra, in any order, or
    the name of a set of faces (in meshio: a cell set or a physical group of triangles).

    A node becomes one node for each group of elements around it that are connected by faces that are not
    on the crack. So nodes on the front stay single, a crack mouth on the mesh's boundary opens, and a
    junction of branches gets one node per sector. Facets connected by edges are one crack. Several cracks
    are numbered after those that a TetMesh already has, by their lowest corners (by z, then y, then x). Lip
    A (crack face A) is on the side to which the largest component of the mean normal is positive
    (`lip_a_ahead`). The order and orientation of the facets make no difference. Old nodes keep their ids.

    Sets: CRACK_LIP_A and CRACK_LIP_B, or CRACK_1_LIP_A ... of several cracks, and the fronts in order, such
    as CRACK_FRONT. Other node sets also get the copies of their nodes; other face sets stay, except the
    face set that is opened. A meshio mesh gets each lip as a block of triangles and a cell set. Raises
    CraftmeshError for facets that are no faces of the mesh, if none opens, for a crack that cannot be
    given two sides, and for a mesh whose faces belong to more than two elements.
    """
    if isinstance(mesh, TetMesh):
        result, _, report = _opened(mesh, facets)
        return result, report
    if not hasattr(mesh, "cell_sets_dict"):  # duck-typed, so that meshio is not imported for a TetMesh
        raise CraftmeshError(f"mesh is a {type(mesh).__name__}; expected a TetMesh or a meshio.Mesh")
    if isinstance(facets, str):
        facets = foreign_facets(mesh, facets)
    opened, parent, report = _opened(tet_mesh_of(mesh), facets)
    return foreign_with_crack(mesh, opened, parent), report


def _opened(mesh: TetMesh, facets: np.ndarray | str) -> tuple[TetMesh, np.ndarray, dict[str, int | float]]:
    """Return the opened mesh, the old node (n,) of each of its nodes, and the report."""
    sets = dict(mesh.face_sets)
    if isinstance(facets, str):
        if facets not in sets:
            known = ", ".join(sets) or "none"
            raise CraftmeshError(f"facets: the mesh has no face set {facets!r}; it has {known}")
        facets = face_nodes(mesh.tets[:, :4], sets.pop(facets))
    opened = opened_along(mesh.points, mesh.tets, facets)
    points = mesh.points[opened.parent]
    face_sets = {name: faces for name, faces in sets.items() if not is_lip(name)}
    own = [opened.crack == k for k in np.unique(opened.crack)]
    lips = [(_faces(opened.ahead[one]), _faces(opened.behind[one])) for one in own]
    face_sets |= crack_sets([*_known_lips(sets), *lips])
    all_lips = {name: faces for name, faces in face_sets.items() if is_lip(name)}
    named = np.concatenate(lip_faces(all_lips)) @ np.array([4, 1])
    rest = {"FREE": _faces(np.setdiff1d(opened.free, named))}  # so that every free face is in a set
    bare = TetMesh(points, opened.tets, mesh.grain, {}, all_lips | rest)
    fronts = mesh_fronts(bare)
    node_sets = with_copies(mesh.node_sets, opened.parent, len(mesh.points))
    node_sets |= node_sets_of(opened.tets, face_sets, fronts)
    result = replace(mesh, points=points, tets=opened.tets, node_sets=node_sets, face_sets=face_sets)
    return result, opened.parent, _report(opened, points, fronts)


def _known_lips(face_sets: Mapping[str, np.ndarray]) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the lips A and B of each crack in a mesh; raise CraftmeshError for a lip A without lip B."""
    names = [name for name in face_sets if is_lip(name) and name.endswith("A")]
    alone = [name for name in names if f"{name[:-1]}B" not in face_sets]
    if alone:
        raise CraftmeshError(
            f"the mesh has the face set {alone[0]} without its lip B; give both lips of a crack, or none"
        )
    return [(face_sets[name], face_sets[f"{name[:-1]}B"]) for name in names]


def _faces(rows: np.ndarray) -> np.ndarray:
    rows = np.sort(rows)
    return np.stack([rows // 4, rows % 4], axis=1)


def _report(opened: Opened, points: np.ndarray, fronts: list) -> dict[str, int | float]:
    return {
        "cracks": len(np.unique(opened.crack)),
        "crack_facets": len(opened.ahead) + opened.shut,
        "crack_facets_not_opened": opened.shut,
        "crack_facets_on_boundary": opened.on_boundary,
        "crack_area": total_area(points, half_face_corners(opened.tets, opened.ahead)),
        "nodes_opened_by_crack": int((opened.parent != np.arange(len(points))).sum()),
        "fronts": len(fronts),
        "front_nodes": sum(len(nodes) for nodes, _ in fronts),
    }


def opened_along(points: np.ndarray, tets: np.ndarray, facets: np.ndarray) -> Opened:
    """Return the tetrahedra (m, 4) or (m, 10) opened along the faces with the corners `facets` (k, 3).

    A node becomes one node for each group of elements around it that are connected by other faces. Raises
    CraftmeshError for facets that are no faces or cannot open, and for invalid meshes, as `open_crack`.
    """
    facets = lip_a_ahead(points, turned_alike(points, _checked(points, tets, facets)))
    groups, row, count = facet_groups(tets, facets)
    _refuse(points, facets, row, count)
    second = groups.order[np.minimum(groups.first[:-1] + 1, len(groups.order) - 1)]
    pairs = np.stack([groups.lead, second], axis=1)
    free = groups.lead[count == 1]
    across = pairs[(count == 2) & (row >= 0)]
    facet = row[(count == 2) & (row >= 0)]
    linked = pairs[(count == 2) & (row < 0)]
    opened, parent, shut = opened_across(tets, linked, across, len(points))
    if shut.all():
        raise CraftmeshError(
            f"none of the {len(shut)} crack facets within the mesh opens: all their corners are on the "
            "crack's front; give facets around at least one node inside the crack, or on its mouth"
        )
    order = np.argsort(facet[~shut], kind="stable")
    across, facet = across[~shut][order], facet[~shut][order]
    is_ahead = same_turn(half_face_corners(tets, across[:, 0]), facets[facet])
    ahead, behind = np.where(is_ahead[:, None], across, across[:, ::-1]).T
    on_boundary = int(((count == 1) & (row >= 0)).sum())
    return Opened(opened, parent, ahead, behind, pieces(facets)[facet], free, int(shut.sum()), on_boundary)


def _checked(points: np.ndarray, tets: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """Return the facets (k, 3), each once and sorted, with sorted corners: by z, then y, then x.

    Raises CraftmeshError for facets that are no node ids and for elements without positive volume.
    """
    facets = as_array("facets", facets, np.int64, (None, 3))
    if not len(facets):
        raise CraftmeshError("facets is empty; give node ids (k, 3) of faces between two tetrahedra")
    check_indices("facets", facets, len(points), "nodes")
    inverted = np.flatnonzero(tet_volumes(points, tets) <= 0)
    if len(inverted):
        raise CraftmeshError(
            f"tet {inverted[0]} and {len(inverted) - 1} more have no positive volume; expected nodes in "
            "Abaqus' order, corners 1, 2, 3 right-handed around the direction to corner 4"
        )
    place = np.empty(len(points), np.int64)  # rank of each node by z, then y, then x
    place[np.lexsort(points.T)] = np.arange(len(points))
    corners = np.take_along_axis(facets, np.argsort(place[facets], axis=1), axis=1)
    first = np.unique(place[corners], axis=0, return_index=True)[1]
    found: np.ndarray = corners[first]
    return found


def _refuse(points: np.ndarray, facets: np.ndarray, rows: np.ndarray, count: np.ndarray) -> None:
    """Raise CraftmeshError for facets that are no faces of the mesh or all on its boundary.

    It is also raised for faces of more than two elements. rows (g,): facet of each group of equal faces,
    below 0 for none; count (g,): number of elements with this face.
    """
    lost = rows[count == 0]
    if len(lost):
        corners = facets[lost.min()]
        place = np.round(points[corners].mean(axis=0), 6).tolist()
        raise CraftmeshError(
            f"{len(lost)} of {len(facets)} facets are no faces of the mesh, the first has the nodes "
            f"{corners.tolist()} at {place}; give faces between two tetrahedra that were not opened before"
        )
    if (count > 2).any():
        raise CraftmeshError(
            f"{int((count > 2).sum())} faces belong to more than two tetrahedra; expected a conformal mesh"
        )
    if not ((count == 2) & (rows >= 0)).any():
        raise CraftmeshError(
            f"all {len(facets)} facets lie on the mesh's boundary, with a tetrahedron on one side only; "
            "give faces between two tetrahedra: merge duplicate nodes, and open a crack only once"
        )
