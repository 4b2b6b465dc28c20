"""Merge the grains' tetrahedra into one mesh and open the crack."""

from collections.abc import Sequence

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from craftmesh.errors import CraftmeshError
from craftmesh.mesh.front import front_polylines
from craftmesh.mesh.mesh_sets import LIPS, node_sets_of
from craftmesh.mesh.tet_connectivity import (
    FACE_CORNERS,
    RowGroups,
    face_nodes,
    group_triples,
    half_face_corners,
    half_faces,
)
from craftmesh.surface.measure import area_vectors
from craftmesh.surface.patches import is_on_box
from craftmesh.types import BOX_PLANES, CRACK, GrainTets, Surface, TetMesh

_NO_FACET = -1


def assemble(surface: Surface, grain_tets: Sequence[GrainTets]) -> tuple[TetMesh, dict]:
    """Merge grains by surface point, open the crack and name the sets; return the mesh and a report.

    Surface points in use come first, then the interior points of each grain by id, then the nodes
    that opening adds. A node is a connected component of (tet, corner) pairs over shared faces that
    are not crack facets: crack fronts stay single by themselves, and bodies that touch only in a
    point or an edge come apart. Lip A is ahead of the crack facets' normals, lip B behind. Face sets:
    XMIN..ZMAX, CRACK_LIP_A/B, VOID_<k>, EXTERIOR; node sets: see `node_sets_of`. Raises CraftmeshError
    when the grains do not fit the surface or each other.
    """
    points, tets, grain = _merge(surface, sorted(grain_tets, key=lambda g: g.grain))
    groups, facet = _match(surface, tets, grain)
    pairs, free = groups.pairs, groups.lead[groups.count == 1]
    is_crack = np.zeros(len(surface.facets) + 1, bool)
    is_crack[:-1] = surface.kind == CRACK
    across_crack = is_crack[facet[pairs[:, 0]]]
    crack_faces = np.concatenate([pairs[across_crack].ravel(), free[is_crack[facet[free]]]])

    opened, parent = _open(tets, pairs[~across_crack], np.concatenate([free, crack_faces]), len(points))
    points, opened, parent = _drop_unused(points[parent], opened, parent)
    closed = _is_closed(opened, pairs[across_crack])
    face_sets = _face_sets(surface, tets, facet, free, pairs[across_crack][~closed].ravel())
    fronts = front_polylines(points, opened, face_sets)
    mesh = TetMesh(points, opened, grain, node_sets_of(opened, face_sets, fronts), face_sets)

    on_crack = half_face_corners(tets, crack_faces)
    added = parent[len(np.unique(parent)) :]
    by_crack = int(np.isin(added, on_crack).sum())
    report = {
        "nodes": len(points),
        "tets": len(opened),
        "grains": len(np.unique(grain)),
        "crack_facets": int(across_crack.sum()),
        "crack_facets_not_opened": int(closed.sum()),
        "crack_area": _area(points, opened, face_sets.get(LIPS[0])),
        "nodes_opened_by_crack": by_crack,
        "nodes_unwelded": len(added) - by_crack,
        "fronts": len(fronts),
        "front_nodes": sum(len(nodes) for nodes, _ in fronts),
        "front_length": sum(_length(points[nodes], is_closed) for nodes, is_closed in fronts),
        "faces": {name: len(faces) for name, faces in face_sets.items()},
    }
    return mesh, report


def _merge(surface, grain_tets) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points, with all surface points first, tets and grains of the whole model."""
    if not any(len(g.tets) for g in grain_tets):
        raise CraftmeshError("no tetrahedra to assemble; run tetrahedralize for the surface's grains first")
    blocks, offset = [], len(surface.points)
    for g in grain_tets:
        if len(g.nodes) and (g.nodes.min() < 0 or g.nodes.max() >= len(surface.points)):
            raise CraftmeshError(
                f"grain {g.grain}: refers to surface point {g.nodes.max()} of {len(surface.points)}; "
                "tetrahedralize this surface again"
            )
        ids = np.concatenate([g.nodes, offset + np.arange(len(g.interior))])
        blocks.append(ids[g.tets])
        offset += len(g.interior)
    points = np.concatenate([surface.points, *(g.interior for g in grain_tets)])
    grain = np.repeat([g.grain for g in grain_tets], [len(g.tets) for g in grain_tets]).astype(np.int32)
    return points, np.concatenate(blocks), grain


def _match(surface, tets, grain) -> tuple[RowGroups, np.ndarray]:
    """Group half faces that coincide; return the groups and each one's surface facet (4m,), -1 inside."""
    n_half = 4 * len(tets)
    groups = group_triples(np.concatenate([half_faces(tets), surface.facets]))
    row_facet = groups.order[groups.first[1:] - 1] - n_half  # facets have the highest rows
    has_facet = row_facet >= 0
    count = groups.count - has_facet
    if (
        twice := has_facet & (groups.order[np.maximum(groups.first[1:] - 2, 0)] >= n_half) & (count > 0)
    ).any():
        raise CraftmeshError(
            f"{twice.sum()} facets of the surface are there twice; run check on the surface"
        )
    _refuse_unmatched(surface, grain, groups, row_facet, count)
    tet_groups = count > 0
    facet = np.empty(n_half, np.int64)
    is_half = groups.order < n_half
    facet[groups.order[is_half]] = np.repeat(np.where(has_facet, row_facet, _NO_FACET), count)
    first = np.concatenate([[0], np.cumsum(count[tet_groups])])
    return RowGroups(groups.order[is_half], first), facet


def _refuse_unmatched(surface, grain, groups, row_facet, count) -> None:
    """Raise CraftmeshError unless each half face has its neighbour or facet, and each facet its tets."""
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
            f"grain {found}: {len(inside)} faces fit neither a neighbour nor a facet of the surface; "
            "tetrahedralize every grain of this surface again"
        )
    sides = surface.sides[row_facet[wrong[0]]].tolist()
    raise CraftmeshError(
        f"grain {max(sides)}: {len(wrong)} facets of the surface lack their tetrahedra (the first lies "
        f"between {sides[0]} and {sides[1]}); give the tetrahedra of every grain of this surface"
    )


def _open(tets, linked, bounding, n_points) -> tuple[np.ndarray, np.ndarray]:
    """Return the tets on separated nodes and the old node (n,) of each new one; old ids come first.

    linked (p, 2): half faces that stay together; bounding: half faces that are free or on the crack.
    Only nodes of the latter can come apart: around any other the elements fill the whole sphere.
    """
    at_boundary = np.zeros(n_points, bool)
    at_boundary[half_face_corners(tets, bounding)] = True
    linked = linked[at_boundary[half_face_corners(tets, linked[:, 0])].any(axis=1)]
    here, there = (half_face_corners(tets, linked[:, i]) for i in range(2))
    links = []
    for i in range(3):
        same = (there == here[:, i, None]).argmax(axis=1)
        ends = [4 * (rows // 4) + FACE_CORNERS[rows % 4, j] for rows, j in zip(linked.T, (i, same))]
        links.append(np.stack(ends, axis=1)[at_boundary[here[:, i]]])
    movable = np.flatnonzero(at_boundary[tets.ravel()])  # flat (tet, corner) ids
    return _renumber(tets, movable, np.concatenate(links), n_points)


def _renumber(tets, movable, links, n_points) -> tuple[np.ndarray, np.ndarray]:
    """Give each component of the movable corners a node; the first of each old node keeps its id."""
    place = np.full(tets.size, -1, np.int64)
    place[movable] = np.arange(len(movable))
    ones = np.ones(len(links), np.int8)
    graph = coo_array((ones, (place[links[:, 0]], place[links[:, 1]])), shape=(len(movable),) * 2)
    count, component = connected_components(graph, directed=False)
    first = np.full(count, len(movable), np.int64)
    np.minimum.at(first, component, np.arange(len(movable)))
    old = tets.ravel()[movable[first]]
    order = np.lexsort((first, old))
    repeated = np.zeros(count, bool)
    repeated[order[1:]] = old[order[1:]] == old[order[:-1]]
    extra = order[repeated[order]]
    new_id = old.copy()
    new_id[extra] = n_points + np.arange(len(extra))
    opened = tets.copy()
    opened.ravel()[movable] = new_id[component]
    return opened, np.concatenate([np.arange(n_points), old[extra]])


def _drop_unused(points, tets, parent) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    used = np.zeros(len(points), bool)
    used[tets.ravel()] = True
    new = np.cumsum(used) - 1
    return points[used], new[tets], parent[used]


def _is_closed(opened, crack_pairs) -> np.ndarray:
    """Return which crack facets (p,) kept all three corners on both sides: they cannot open."""
    corners = np.sort(half_face_corners(opened, crack_pairs), axis=2)
    return (corners[:, 0] == corners[:, 1]).all(axis=1)


def _face_sets(surface, tets, facet, free, lips) -> dict[str, np.ndarray]:
    """Return the named faces as rows (tet, face), sorted; empty sets are left out."""
    kind, sides = surface.kind[facet[free]], surface.sides[facet[free]].min(axis=1)
    on_crack = kind == CRACK
    chosen = {name: free[kind == plane] for plane, name in enumerate(BOX_PLANES, 1)}
    all_lips = np.concatenate([lips, free[on_crack]])
    ahead = _same_turn(half_face_corners(tets, all_lips), surface.facets[facet[all_lips]])
    chosen |= dict(zip(LIPS, (all_lips[ahead], all_lips[~ahead])))
    rest = ~is_on_box(kind) & ~on_crack
    for label in np.unique(sides[rest & (sides < 0)])[::-1]:
        chosen[f"VOID_{-label}"] = free[rest & (sides == label)]
    chosen["EXTERIOR"] = free[rest & (sides == 0)]
    ordered = {name: np.sort(rows) for name, rows in chosen.items() if len(rows)}
    return {name: np.stack([rows // 4, rows % 4], axis=1) for name, rows in ordered.items()}


def _same_turn(triangles, reference) -> np.ndarray:
    """Return where rows of `triangles` list the same corners in the same sense as rows of `reference`."""
    shift = (triangles == reference[:, :1]).argmax(axis=1)
    return np.take_along_axis(triangles, ((shift + 1) % 3)[:, None], axis=1)[:, 0] == reference[:, 1]


def _area(points, tets, faces) -> float:
    if faces is None:
        return 0.0
    return float(np.linalg.norm(area_vectors(points, face_nodes(tets, faces)), axis=1).sum())


def _length(points, closed) -> float:
    steps = np.diff(points, axis=0, append=points[:1] if closed else points[-1:])
    return float(np.linalg.norm(steps, axis=1).sum())
