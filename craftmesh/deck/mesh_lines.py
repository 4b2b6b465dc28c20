"""Lines of the deck for the mesh: nodes, elements by grain, cohesive layers, node sets and surfaces."""

from collections.abc import Iterator

import numpy as np

from craftmesh.deck.inp_format import id_lines, integer_rows, name_lines, node_rows
from craftmesh.mechanics.cohesive import CohesiveLayers
from craftmesh.mesh.mesh_sets import is_front
from craftmesh.types import TetMesh


def mesh_lines(mesh: TetMesh, grains: np.ndarray, element: str) -> Iterator[str]:
    """Yield the nodes, the elements of type `element` by grain, and the set EALL of all elements.

    grains (g,): ids that occur, ascending.
    """
    yield "*NODE, NSET=NALL\n"
    yield from node_rows(mesh.points)
    order = np.argsort(mesh.grain, kind="stable")
    ends = np.searchsorted(mesh.grain[order], grains, side="right")
    for grain, rows in zip(grains, np.split(order, ends[:-1])):
        yield f"*ELEMENT, TYPE={element}, ELSET=GRAIN_{grain}\n"
        yield from integer_rows(np.column_stack([rows, mesh.tets[rows]]) + 1)
    yield "*ELSET, ELSET=EALL\n"
    yield from name_lines(f"GRAIN_{grain}" for grain in grains)


def set_lines(mesh: TetMesh) -> Iterator[str]:
    """Yield node sets (a front's in order), element sets, and face sets as surfaces, but no empty sets."""
    for name, nodes in mesh.node_sets.items():
        if len(nodes):
            yield f"*NSET, NSET={name}{', UNSORTED' if is_front(name) else ''}\n"
            yield from id_lines(nodes)
    for name, rows in mesh.element_sets.items():
        if len(rows):
            yield f"*ELSET, ELSET={name}\n"
            yield from id_lines(rows)
    for name, faces in mesh.face_sets.items():
        sides = [side for side in range(4) if (faces[:, 1] == side).any()]
        for side in sides:
            yield f"*ELSET, ELSET={name}_S{side + 1}\n"
            yield from id_lines(faces[faces[:, 1] == side, 0])
        if sides:
            yield f"*SURFACE, NAME={name}, TYPE=ELEMENT\n"
            yield from (f"{name}_S{side + 1}, S{side + 1}\n" for side in sides)


def layer_lines(layers: CohesiveLayers, first: int) -> Iterator[str]:
    """Yield the cohesive elements, numbered from `first`, in the sets COH_<a>_<b> and COH_ALL."""
    names = [layer_name(pair) for pair, rows in layers.elements.items() if len(rows)]
    for pair, rows in layers.elements.items():
        if len(rows):
            yield f"*ELEMENT, TYPE=COH3D6, ELSET={layer_name(pair)}\n"
            yield from integer_rows(np.column_stack([first + np.arange(len(rows)), rows + 1]))
            first += len(rows)
    if names:
        yield "*ELSET, ELSET=COH_ALL\n"
        yield from name_lines(names)


def layer_name(pair: tuple[int, int]) -> str:
    """Return the name of the set of cohesive elements between two grains."""
    return f"COH_{pair[0]}_{pair[1]}"
