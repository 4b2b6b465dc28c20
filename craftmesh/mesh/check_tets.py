"""Checks of a finite-element mesh from its arrays."""

from collections.abc import Iterator

import numpy as np

from craftmesh.mesh.front import mesh_fronts
from craftmesh.mesh.integration import smallest_jacobians
from craftmesh.mesh.mesh_sets import is_front, is_lip, lip_faces, node_sets_of
from craftmesh.mesh.tet_connectivity import (
    EDGE_CORNERS,
    FACE_EDGES,
    RowGroups,
    face_nodes,
    group_triples,
    half_faces,
    tet_volumes,
)
from craftmesh.types import BOX_PLANES, TetMesh

# Largest distance of a mid node from its edge's middle over the edge's length; a quarter point has 0.25.
_MID_NODE_REACH = 0.51


def check_tets(mesh: TetMesh) -> list[str]:
    """Return one sentence per broken invariant, none for a valid mesh.

    Checked: positive volumes and, of 10-node elements, Jacobians at the integration points; no unused node;
    every face has two elements or is in exactly one face set, and faces in sets are free; nodes on box
    planes lie exactly on them; lips coincide facet by facet; node sets hold the nodes of their faces,
    fronts in order, with edges that both lips share; mid nodes are near their edges' middles and shared
    with the neighbours. A front node may have copies only across facets of another crack; elsewhere, faces
    between the copies are free and in no set.
    """
    if not len(mesh.tets):
        return ["The mesh has no tetrahedra."]
    breaches = list(_check_elements(mesh))
    wrong_sets = list(_check_ids(mesh))
    if wrong_sets:
        return breaches + wrong_sets
    groups = group_triples(half_faces(mesh.tets))
    breaches += _check_conformity(mesh, groups)
    breaches += _check_planes(mesh)
    breaches += _check_lips(mesh)
    breaches += _check_node_sets(mesh)
    if mesh.tets.shape[1] == 10:
        breaches += _check_mid_nodes(mesh, groups)
    return breaches


def _check_elements(mesh: TetMesh) -> Iterator[str]:
    flat = np.flatnonzero(~(tet_volumes(mesh.points, mesh.tets) > 0))
    if len(flat):
        yield (
            f"{len(flat)} tetrahedra have a volume <= 0 (the first is tet {flat[0]} of grain "
            f"{mesh.grain[flat[0]]})."
        )
    if mesh.tets.shape[1] == 10:
        folded = np.flatnonzero(~(smallest_jacobians(mesh.points, mesh.tets) > 0))
        if len(folded):
            yield (
                f"{len(folded)} tetrahedra have a Jacobian <= 0 at an integration point (the first is tet "
                f"{folded[0]} of grain {mesh.grain[folded[0]]})."
            )
    if (mesh.grain <= 0).any():
        yield f"{(mesh.grain <= 0).sum()} tetrahedra have a grain id <= 0."
    unused = len(mesh.points) - np.count_nonzero(np.bincount(mesh.tets.ravel(), minlength=len(mesh.points)))
    if unused:
        yield f"{unused} nodes belong to no tetrahedron."


def _check_ids(mesh: TetMesh) -> Iterator[str]:
    for name, nodes in mesh.node_sets.items():
        if len(nodes) and (nodes.min() < 0 or nodes.max() >= len(mesh.points)):
            yield f"Node set {name} names nodes {nodes.min()}..{nodes.max()}; there are {len(mesh.points)}."
    for name, faces in mesh.face_sets.items():
        if len(faces) and ((faces < 0) | (faces >= [len(mesh.tets), 4])).any():
            yield f"Face set {name} names tetrahedra or faces that do not exist."
    for name, rows in mesh.element_sets.items():
        if len(rows) and (rows.min() < 0 or rows.max() >= len(mesh.tets)):
            yield f"Element set {name} names elements that do not exist; there are {len(mesh.tets)}."


def _check_conformity(mesh: TetMesh, groups: RowGroups) -> Iterator[str]:
    crowded = int((groups.count > 2).sum())
    if crowded:
        yield f"{crowded} faces belong to more than two tetrahedra."
    times = np.zeros(4 * len(mesh.tets), np.int64)
    free = np.zeros(len(times), bool)
    free[groups.lead[groups.count == 1]] = True
    for name, faces in mesh.face_sets.items():
        rows = 4 * faces[:, 0] + faces[:, 1]
        np.add.at(times, rows, 1)
        if not free[rows].all():
            yield f"{(~free[rows]).sum()} faces of set {name} have a tetrahedron on both sides."
    if (times > 1).any():
        yield f"{(times > 1).sum()} faces are named more than once by the face sets."
    bare = np.flatnonzero(free & (times == 0))
    if len(bare):
        yield (
            f"{len(bare)} free faces are in no face set (the first is of tet {bare[0] // 4} of grain "
            f"{mesh.grain[bare[0] // 4]})."
        )


def _check_planes(mesh: TetMesh) -> Iterator[str]:
    box = mesh.box
    for plane, name in enumerate(BOX_PLANES):
        if name in mesh.face_sets:
            axis, limit = plane // 2, box[plane % 2]
            off = face_nodes(mesh.tets, mesh.face_sets[name])
            off = np.unique(off[mesh.points[off, axis] != limit[axis]])
            if len(off):
                plane_text = f"{'xyz'[axis]} = {float(limit[axis])!r}"
                yield f"{len(off)} nodes of {name} are not on the plane {plane_text}."


def _check_lips(mesh: TetMesh) -> Iterator[str]:
    if not any(map(is_lip, mesh.face_sets)):
        return
    lips = [face_nodes(mesh.tets, faces) for faces in lip_faces(mesh.face_sets)]
    used = np.unique(np.concatenate(lips))
    where = np.unique(mesh.points[used], axis=0, return_inverse=True)[1]
    new = np.zeros(len(mesh.points), np.int64)
    new[used] = where.ravel()
    sides = [np.unique(np.sort(new[lip], axis=1), axis=0) for lip in lips]
    both = np.unique(np.concatenate(sides), axis=0, return_counts=True)[1]
    lone, twice = int((both != 2).sum()), sum(map(len, lips)) - sum(map(len, sides))
    if lone:
        yield f"{lone} facets of the crack's lips lack a coincident facet on the other lip."
    if twice:
        yield f"{twice} facets of the crack's lips stand in their lip twice."
    closed = group_triples(np.concatenate(lips)[:, :3]).count
    if (closed > 1).any():
        yield f"{(closed > 1).sum()} facets of the crack have the same three nodes on both lips."


def _check_node_sets(mesh: TetMesh) -> Iterator[str]:
    expected = node_sets_of(mesh.tets, mesh.face_sets, mesh_fronts(mesh))
    own = {name for name in mesh.node_sets if name.split("_")[0] in (*BOX_PLANES, "CRACK")}
    for name in sorted(own | expected.keys()):
        found = mesh.node_sets.get(name, np.zeros(0, np.int64))
        wanted = expected.get(name, np.zeros(0, np.int64))
        if not np.array_equal(found if is_front(name) else np.sort(found), wanted):
            lacking, beyond = len(np.setdiff1d(wanted, found)), len(np.setdiff1d(found, wanted))
            what = f"{lacking} nodes are missing, {beyond} too many"
            if not lacking and not beyond:
                what = "its nodes are not in order"
            yield f"Node set {name} does not fit the face sets: {what}."


def _check_mid_nodes(mesh: TetMesh, groups: RowGroups) -> Iterator[str]:
    wrong = 0
    for place, (i, j) in enumerate(EDGE_CORNERS, 4):
        a, b, mid = (mesh.points[mesh.tets[:, column]] for column in (i, j, place))
        off, edge = 2 * mid - a - b, b - a
        wrong += (_squares(off) > (2 * _MID_NODE_REACH) ** 2 * _squares(edge)).sum()
    if wrong:
        yield f"{wrong} mid nodes are not on their edges: the node order is not Abaqus'."
    here, there = (
        np.sort(mesh.tets[(rows // 4)[:, None], 4 + FACE_EDGES[rows % 4]], axis=1)
        for rows in groups.pairs.T
    )
    apart = int((here != there).any(axis=1).sum())
    if apart:
        yield f"{apart} faces have different mid nodes in their two tetrahedra."


def _squares(vectors: np.ndarray) -> np.ndarray:
    return np.einsum("ij,ij->i", vectors, vectors)
