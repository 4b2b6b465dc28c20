"""Lines of the deck for the load: supports, and one static step with its output."""

from collections.abc import Iterator

import numpy as np

from craftmesh.deck.inp_format import number
from craftmesh.mechanics.load import Fixed, Load

# Both solvers write these to their results files (.fil, .frd).
_OUTPUT = "*NODE FILE\nU, RF\n*EL FILE\nS, E\n"


def step_lines(load: Load) -> Iterator[str]:
    """Yield the supports and the step of a load."""
    yield "*BOUNDARY\n"
    for fixed in load.held:
        yield f"{_nodes(fixed)}, {fixed.axis + 1}, {fixed.axis + 1}\n"
    yield "*STEP\n*STATIC\n"
    if load.moved:
        yield "*BOUNDARY\n"
    for moved in load.moved:
        yield from _moved(moved)
    if load.pulled:
        yield "*DSLOAD\n"
    for pulled in load.pulled:
        yield f"{pulled.name}, P, {number(-pulled.stress)}\n"
    yield _OUTPUT + "*END STEP\n"


def _moved(moved: Fixed) -> Iterator[str]:
    """Yield the line of a node set that moves by one value, or one of each node."""
    axis = moved.axis + 1
    if isinstance(moved.displacement, np.ndarray):
        for node, value in zip(moved.nodes.tolist(), moved.displacement.tolist()):
            yield f"{node + 1}, {axis}, {axis}, {number(value)}\n"
    else:
        yield f"{_nodes(moved)}, {axis}, {axis}, {number(moved.displacement)}\n"


def _nodes(fixed: Fixed) -> str:
    """Return the name of the node set, or the number of the single node."""
    if fixed.name:
        return fixed.name
    (node,) = fixed.nodes
    return str(node + 1)
