"""Lines of the deck for the load: supports, and one static step with its output."""

from collections.abc import Iterator

import numpy as np

from craftmesh.deck.inp_format import number
from craftmesh.mechanics.load import Fixed, Load

# Both solvers write these to their results files (.fil, .frd).
_OUTPUT = "*NODE FILE\nU, RF\n*EL FILE\nS, E\n"


def step_lines(load: Load) -> Iterator[str]:
    """Yield the supports and the step of a load; what moves does so in the step."""
    still = [fixed for fixed in load.held if not np.any(fixed.displacement)]
    moved = [fixed for fixed in load.held if np.any(fixed.displacement)] + [*load.moved]
    yield "*BOUNDARY\n"
    for fixed in still:
        yield from (f"{nodes}, {fixed.axis + 1}, {fixed.axis + 1}\n" for nodes in _nodes(fixed))
    yield "*STEP\n*STATIC\n"
    if moved:
        yield "*BOUNDARY\n"
    for fixed in moved:
        yield from _moved(fixed)
    if load.pulled:
        yield "*DSLOAD\n"
    for pulled in load.pulled:
        yield f"{pulled.name}, P, {number(-pulled.stress)}\n"
    yield _OUTPUT + "*END STEP\n"


def _moved(fixed: Fixed) -> Iterator[str]:
    """Yield the line of a node set that moves by one value, or one of each node."""
    axis = fixed.axis + 1
    if np.ndim(fixed.displacement):
        values = np.asarray(fixed.displacement).tolist()
        for node, value in zip(fixed.nodes.tolist(), values):
            yield f"{node + 1}, {axis}, {axis}, {number(value)}\n"
    else:
        value = number(float(fixed.displacement))
        yield from (f"{nodes}, {axis}, {axis}, {value}\n" for nodes in _nodes(fixed))


def _nodes(fixed: Fixed) -> list[str]:
    """Return the name of the node set, or the numbers of single nodes."""
    return [fixed.name] if fixed.name else [str(node + 1) for node in fixed.nodes.tolist()]
