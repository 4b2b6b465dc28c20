"""Layers of cohesive elements on grain boundaries: the mesh opened there, and the elements between."""

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from craftmesh.assembly.opening import copies_of, opened_across, with_copies
from craftmesh.mesh.mesh_sets import is_front, is_lip
from craftmesh.mesh.tet_connectivity import face_nodes, group_triples, half_face_nodes, half_faces
from craftmesh.types import TetMesh

# Order of a face's nodes with the normal out of the solid element, as a cohesive element needs them.
_OUTWARD = [0, 2, 1, 5, 4, 3]
# Triangles of 3 nodes on the nodes of a facet, such that each node is in one. Mid nodes come in the order
# 12, 23, 31.
_PARTS = {3: np.array([[0, 1, 2]]), 6: np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]])}


def grain_pairs(mesh: TetMesh) -> list[tuple[int, int]]:
    """Return the pairs of grains, the smaller id first, that share faces which are not on the crack."""
    _, between = _boundary(mesh)
    return [(a, b) for a, b in np.unique(between, axis=0).tolist() if a < b]


def boundary_layers(
    mesh: TetMesh, pairs: Collection[tuple[int, int]]
) -> tuple[TetMesh, dict[tuple[int, int], np.ndarray]]:
    """Return the mesh opened along the boundaries of pairs (a < b), and their cohesive elements (k, 6).

    Nodes 1 to 3 of an element are on grain a, with the normal out of it, and nodes 4 to 6 on b, at the same
    points. A face with 3 nodes has one element, a face with 6 nodes four. Nodes are separated as in a
    crack: a node becomes one node for each group of elements around it that are connected by other faces,
    so a node of a triple line becomes 3 if all its boundaries are chosen. Elements keep their ids, and so
    do old nodes, which stay in the grain of lowest id that has them. Node sets also get the copies of their
    nodes, except fronts, which keep their old nodes in order; their copies are CRACK_FRONT_COPIES.
    """
    shared, between = _boundary(mesh)
    chosen = np.zeros(len(shared), bool)
    for pair in pairs:
        chosen |= (between == pair).all(axis=1)
    across, between = shared[chosen], between[chosen]
    opened, parent, shut = opened_across(mesh.tets, shared[~chosen], across, len(mesh.points))
    layers, between = _elements(opened, parent, across[~shut]), between[~shut]
    elements = {pair: layers[(between == pair).all(axis=1)].reshape(-1, 6) for pair in sorted(pairs)}
    elements = {pair: rows[(rows[:, :3] != rows[:, 3:]).any(axis=1)] for pair, rows in elements.items()}
    sets = with_copies(mesh.node_sets, parent, len(mesh.points))
    for name, nodes in mesh.node_sets.items():
        if is_lip(name):
            sets[name] = np.unique(face_nodes(opened, mesh.face_sets[name]))
        elif is_front(name):
            sets[name] = nodes
    front = mesh.node_sets.get("CRACK_FRONT", np.zeros(0, np.int64))
    copies = copies_of(front, parent, len(mesh.points))
    if len(copies):
        sets["CRACK_FRONT_COPIES"] = copies
    return replace(mesh, points=mesh.points[parent], tets=opened, node_sets=sets), elements


def _boundary(mesh: TetMesh) -> tuple[np.ndarray, np.ndarray]:
    """Return the pairs of half faces (p, 2) that two elements share, and their grains (p, 2), ascending."""
    shared = group_triples(half_faces(mesh.tets[:, :4])).pairs
    between = mesh.grain[shared // 4]
    order = np.argsort(between, axis=1, kind="stable")
    return np.take_along_axis(shared, order, 1), np.take_along_axis(between, order, 1)


def _elements(opened: np.ndarray, parent: np.ndarray, across: np.ndarray) -> np.ndarray:
    """Return the cohesive elements between pairs of half faces: (p, 1, 6), or (p, 4, 6) with mid nodes.

    opened: tets of the opened mesh; parent: old node of each of its nodes, the same on both sides; across
    (p, 2): half faces 4 * tet + face of the first and the second grain.
    """
    bottom, top = (half_face_nodes(opened, across[:, side]) for side in range(2))
    bottom = bottom[:, _OUTWARD[: bottom.shape[1]]]
    turn = (parent[bottom][:, :, None] == parent[top][:, None, :]).argmax(axis=2)
    top = np.take_along_axis(top, turn, axis=1)
    parts = _PARTS[bottom.shape[1]]
    return np.concatenate([bottom[:, parts], top[:, parts]], axis=2)
