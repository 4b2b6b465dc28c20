"""Numbers of nodes and elements from one mesh to the next: what stays keeps its number."""

from typing import NamedTuple

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mesh.mesh_sets import NEW, is_front
from craftmesh.types import TetMesh


class NumberMap(NamedTuple):
    """From the rows of an old mesh to the rows of a new one; -1 for nodes and elements that are gone.

    nodes (n,), elements (m,): for each old one its new row.
    """

    nodes: np.ndarray
    elements: np.ndarray


def renumbered(old: TetMesh, new: TetMesh, origin: np.ndarray) -> tuple[TetMesh, NumberMap, np.ndarray]:
    """Return the new mesh with the old numbers of all that stays, the map, and the row of each new node.

    origin (m,): the old row of each new element, -1 for new ones. New nodes and elements take free numbers,
    the lowest first. If the new mesh has fewer, the numbers beyond its count move to free ones. The element
    set NEW has the new elements.
    """
    stays = np.flatnonzero(origin >= 0)
    node_of = np.full(len(new.points), -1)
    node_of[new.tets[stays]] = old.tets[origin[stays]]
    if not np.array_equal(new.points[new.tets[stays]], old.points[old.tets[origin[stays]]]):
        raise CraftmeshError("elements kept from the mesh before have nodes at other positions than there")
    node, element = _numbers(node_of), _numbers(origin)
    sets = {
        name: node[ids] if is_front(name) else np.sort(node[ids]) for name, ids in new.node_sets.items()
    }
    faces = {name: _sorted_faces(element[rows[:, 0]], rows[:, 1]) for name, rows in new.face_sets.items()}
    by_node, by_element = np.argsort(node), np.argsort(element)
    points, tets, grain = new.points[by_node], node[new.tets[by_element]], new.grain[by_element]
    mesh = TetMesh(points, tets, grain, sets, faces, {NEW: np.sort(element[origin < 0])})
    numbers = NumberMap(_map(node_of, node, len(old.points)), _map(origin, element, len(old.tets)))
    return mesh, numbers, node


def _numbers(wanted: np.ndarray) -> np.ndarray:
    """Return different numbers (k,) from 0 to k - 1: the wanted ones (k,) where these are >= 0 and below k.

    The first of two rows that want one number gets it.
    """
    count = len(wanted)
    result = np.full(count, -1)
    rows = np.flatnonzero((wanted >= 0) & (wanted < count))
    _, first = np.unique(wanted[rows], return_index=True)
    result[rows[first]] = wanted[rows[first]]
    free = np.ones(count, bool)
    free[result[rows[first]]] = False
    result[result < 0] = np.flatnonzero(free)
    return result


def _map(wanted: np.ndarray, number: np.ndarray, count: int) -> np.ndarray:
    """Return the new number (count,) of each old one; wanted (k,): the old number of each row, or -1."""
    result = np.full(count, -1)
    rows = np.flatnonzero(wanted >= 0)[::-1]  # the first of two rows counts
    result[wanted[rows]] = number[rows]
    return result


def _sorted_faces(element: np.ndarray, face: np.ndarray) -> np.ndarray:
    rows = np.sort(4 * element + face)
    return np.stack([rows // 4, rows % 4], axis=1)
