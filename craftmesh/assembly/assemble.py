"""One mesh of the grains' tetrahedra, merged at the surface's points, with its crack opened."""

from collections.abc import Sequence

import numpy as np

from craftmesh.arguments import typed
from craftmesh.assembly.opening import is_closed, opened_tets
from craftmesh.cracks.sheets import crack_numbers
from craftmesh.errors import CraftmeshError
from craftmesh.mesh.common_nodes import common_points, common_tets, grain_of_tets
from craftmesh.mesh.front import front_polylines
from craftmesh.mesh.front_curve import arc_lengths
from craftmesh.mesh.mesh_sets import crack_sets, is_lip, lip_faces, node_sets_of
from craftmesh.mesh.tet_connectivity import RowGroups, face_nodes, facet_groups, half_face_corners
from craftmesh.surface.connectivity import compact, same_turn
from craftmesh.surface.measure import total_area
from craftmesh.surface.patches import is_on_box
from craftmesh.types import BOX_PLANES, CRACK, Crack, GrainTets, Surface, TetMesh


def refuse_other_surface(surface: Surface, grain_tets: Sequence[GrainTets]) -> None:
    """Raise CraftmeshError unless each grain's tetrahedra have the points that the surface gives it.

    Without this check, files of tetrahedra of an older surface make kernels read beyond their arrays, which
    ends the process. Grains of the surface that `grain_tets` lacks are not checked here.
    """
    sides = surface.sides.ravel()
    order = np.argsort(sides, kind="stable")
    ascending = sides[order]
    for one in grain_tets:
        first, last = np.searchsorted(ascending, (one.grain, one.grain + 1))
        expected = np.unique(surface.facets[order[first:last] // 2])
        if not np.array_equal(np.sort(one.nodes), expected):
            raise CraftmeshError(
                f"grain {one.grain}: its tetrahedra have {len(one.nodes)} points, which are not the"
                f" {len(expected)} that this surface gives it; run tetrahedralize again for this surface"
            )


@typed
def assemble(
    surface: Surface, grain_tets: Sequence[GrainTets], crack: Crack | None = None
) -> tuple[TetMesh, dict]:
    """Merge grains by surface point, open the crack and name the sets; return the mesh and a report.

    Surface points in use come first, then the interior points of each grain by id, then the nodes that
    opening adds. A node is a connected component of (tet, corner) pairs over shared faces that are not
    crack facets. So crack fronts stay single without special care, and bodies that touch only in a point or
    an edge are separated. Lip A (crack face A) is ahead of the crack facets' normals, lip B behind. Face
    sets: XMIN..ZMAX, CRACK_LIP_A/B (several cracks are numbered: CRACK_1_LIP_A), VOID_<k>, EXTERIOR. Node
    sets: planes, edges and corners of the box, lips, and fronts in order (`node_sets_of`). crack: the
    prescribed crack; pieces of one of its surfaces count as one crack, without it each connected piece
    does. Raises CraftmeshError if the grains do not fit the surface or each other.
    """
    points, tets, grain = _merge(surface, sorted(grain_tets, key=lambda g: g.grain))
    groups, facet = _match(surface, tets, grain)
    pairs, free = groups.pairs, groups.lead[groups.count == 1]
    del groups  # to free memory: it is as large as the tets
    is_crack = np.zeros(len(surface.facets) + 1, bool)
    is_crack[:-1] = surface.kind == CRACK
    across_crack = is_crack[facet[pairs[:, 0]]]
    crack_faces = np.concatenate([pairs[across_crack].ravel(), free[is_crack[facet[free]]]])

    bounding = np.concatenate([free, crack_faces])
    opened, parent = opened_tets(tets, pairs[~across_crack], bounding, len(points))
    points, opened, used = compact(points[parent], opened)
    parent = parent[used]
    closed = is_closed(opened, pairs[across_crack])
    face_sets = _face_sets(surface, tets, facet, free, pairs[across_crack][~closed].ravel(), crack)
    fronts = front_polylines(points, opened, face_sets)
    mesh = TetMesh(points, opened, grain, node_sets_of(opened, face_sets, fronts), face_sets)
    added = parent[len(np.unique(parent)) :]
    by_crack = int(np.isin(added, half_face_corners(tets, crack_faces)).sum())
    return mesh, _report(mesh, fronts, closed, {"by_crack": by_crack, "unwelded": len(added) - by_crack})


def _report(mesh: TetMesh, fronts: Sequence, closed: np.ndarray, added: dict[str, int]) -> dict:
    """Return the report: counts, and area and length of cracks and fronts.

    closed (c,): mask of crack facets that stay closed; added: numbers of added nodes by reason.
    """
    points = mesh.points
    return {
        "nodes": len(points),
        "tets": len(mesh.tets),
        "grains": len(np.unique(mesh.grain)),
        "crack_facets": len(closed),
        "crack_facets_not_opened": int(closed.sum()),
        "cracks": sum(is_lip(name) for name in mesh.face_sets) // 2,
        "crack_area": total_area(points, face_nodes(mesh.tets, lip_faces(mesh.face_sets)[0])),
        "nodes_opened_by_crack": added["by_crack"],
        "nodes_unwelded": added["unwelded"],
        "fronts": len(fronts),
        "front_nodes": sum(len(nodes) for nodes, _ in fronts),
        "front_length": sum(arc_lengths(points[nodes], is_ring)[1] for nodes, is_ring in fronts),
        "faces": {name: len(faces) for name, faces in mesh.face_sets.items()},
    }


def _merge(surface: Surface, grain_tets: Sequence[GrainTets]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points (all surface points first), tets and their grains of the whole model.

    Raises CraftmeshError if there are no tetrahedra, or if one refers to a point that the surface lacks.
    """
    if not any(len(g.tets) for g in grain_tets):
        raise CraftmeshError("no tetrahedra to assemble; run tetrahedralize for the surface's grains first")
    for g in grain_tets:
        if len(g.nodes) and (g.nodes.min() < 0 or g.nodes.max() >= len(surface.points)):
            raise CraftmeshError(
                f"grain {g.grain}: refers to surface point {g.nodes.max()} of {len(surface.points)}; "
                "tetrahedralize this surface again"
            )
    grain = grain_of_tets(grain_tets).astype(np.int32)
    return common_points(surface, grain_tets), common_tets(surface, grain_tets), grain


def _match(surface: Surface, tets: np.ndarray, grain: np.ndarray) -> tuple[RowGroups, np.ndarray]:
    """Group half faces that coincide; return the groups, and the surface facet (4m,) of each half face.

    The facet is -1 inside a grain. Raises CraftmeshError for duplicate facets, and if faces and facets do
    not match.
    """
    n_half = 4 * len(tets)
    groups, row_facet, count = facet_groups(tets, surface.facets)
    has_facet = row_facet >= 0
    twice = has_facet & (groups.order[np.maximum(groups.first[1:] - 2, 0)] >= n_half) & (count > 0)
    if twice.any():
        raise CraftmeshError(f"{twice.sum()} facets of the surface are duplicate; run check on the surface")
    _refuse_unmatched(surface, grain, groups, row_facet, count)
    tet_groups = count > 0
    facet = np.empty(n_half, np.int64)
    is_half = groups.order < n_half
    facet[groups.order[is_half]] = np.repeat(np.where(has_facet, row_facet, -1), count)
    first = np.concatenate([[0], np.cumsum(count[tet_groups])])
    return RowGroups(groups.order[is_half], first), facet


def _refuse_unmatched(
    surface: Surface, grain: np.ndarray, groups: RowGroups, row_facet: np.ndarray, count: np.ndarray
) -> None:
    """Raise CraftmeshError unless each half face has a neighbour or facet, and each facet its tets.

    row_facet, count (g,): surface facet, or -1, and number of half faces of each group.
    """
    wanted = np.full(len(count), 2)
    has_facet = row_facet >= 0
    wanted[has_facet] = (surface.sides[row_facet[has_facet]] > 0).sum(axis=1)
    wrong = np.flatnonzero(count != wanted)
    if not len(wrong):
        return
    inside = wrong[~has_facet[wrong]]
    if len(inside):
        found = int(grain[groups.lead[inside[0]] // 4])
        raise CraftmeshError(
            f"grain {found}: {len(inside)} faces of tetrahedra match neither a neighbour nor a facet of "
            "the surface; tetrahedralize every grain of this surface again"
        )
    sides = surface.sides[row_facet[wrong[0]]].tolist()
    raise CraftmeshError(
        f"grain {max(sides)}: {len(wrong)} facets of the surface lack their tetrahedra (the first lies "
        f"between {sides[0]} and {sides[1]}); give the tetrahedra of every grain of this surface"
    )


def _face_sets(
    surface: Surface,
    tets: np.ndarray,
    facet: np.ndarray,
    free: np.ndarray,
    lips: np.ndarray,
    crack: Crack | None,
) -> dict[str, np.ndarray]:
    """Return the named faces as rows (tet, face), sorted; empty sets are left out.

    facet (4m,): the surface facet on each half face 4 * tet + face, -1 inside a grain. free: half faces
    that no other tet shares; lips: half faces on both sides of opened crack facets.
    """
    kind, sides = surface.kind[facet[free]], surface.sides[facet[free]].min(axis=1)
    on_crack = kind == CRACK
    chosen = {name: free[kind == plane] for plane, name in enumerate(BOX_PLANES, 1)}
    all_lips = np.concatenate([lips, free[on_crack]])
    ahead = same_turn(half_face_corners(tets, all_lips), surface.facets[facet[all_lips]])
    rows = np.flatnonzero(surface.kind == CRACK)
    of_facet = np.full(len(surface.facets), -1)
    of_facet[rows] = crack_numbers(surface.points, surface.facets[rows], crack)
    number = of_facet[facet[all_lips]]
    chosen |= crack_sets(
        [
            (all_lips[own & ahead], all_lips[own & ~ahead])
            for own in (number == k for k in np.unique(number))
        ]
    )
    rest = ~is_on_box(kind) & ~on_crack
    for label in np.unique(sides[rest & (sides < 0)])[::-1]:
        chosen[f"VOID_{-label}"] = free[rest & (sides == label)]
    chosen["EXTERIOR"] = free[rest & (sides == 0)]
    ordered = {name: np.sort(rows) for name, rows in chosen.items() if len(rows)}
    return {name: np.stack([rows // 4, rows % 4], axis=1) for name, rows in ordered.items()}
