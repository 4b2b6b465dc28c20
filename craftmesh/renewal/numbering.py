"""Numbers of nodes and elements from one mesh to the next: what stays keeps its number."""

from typing import NamedTuple

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mesh.mesh_sets import NEW, is_front
from craftmesh.types import TetMesh


class NumberMap(NamedTuple):
    """For each node (n,) and element (m,) of an old mesh the row in a new mesh, -1 if it is gone."""

    nodes: np.ndarray
    elements: np.ndarray


def renumbered(old: TetMesh, new: TetMesh, origin: np.ndarray) -> tuple[TetMesh, NumberMap, np.ndarray]:
    """Return `new` with the old numbers of what stays, the map from `old`, and the number of each node.

    origin (m,): the row in `old` of each element of `new`, -1 for new elements. New nodes and elements take
    free numbers, the lowest first. If `new` has fewer than `old`, what has a number beyond the new count
    takes a free number too. The element set NEW has the new elements. The last result (n,) gives for each
    node of `new`, as it was passed, its number. Raises CraftmeshError if kept elements have moved nodes.
    """
    stays = np.flatnonzero(origin >= 0)
    node_of = np.full(len(new.points), -1)
    node_of[new.tets[stays]] = old.tets[origin[stays]]
    if not np.array_equal(new.points[new.tets[stays]], old.points[old.tets[origin[stays]]]):
        raise CraftmeshError("kept elements have nodes at other positions than before; please report this")
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
    """Return different numbers (k,) from 0 to k - 1: `wanted` (k,) where possible, others the lowest free.

    Wanted numbers < 0 or >= k are not given. The first of several rows that want one number gets it.
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
    """Return the new number (count,) of each old one, -1 if it is gone.

    wanted, number (k,): the old number of each new row, or -1, and its new number.
    """
    result = np.full(count, -1)
    rows = np.flatnonzero(wanted >= 0)[::-1]  # the first of two rows counts
    result[wanted[rows]] = number[rows]
    return result


def _sorted_faces(element: np.ndarray, face: np.ndarray) -> np.ndarray:
    rows = np.sort(4 * element + face)
    return np.stack([rows // 4, rows % 4], axis=1)
