"""Lines of the deck for the load: supports, and one static step with its output."""

from collections.abc import Iterator

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
        yield f"{_nodes(moved)}, {moved.axis + 1}, {moved.axis + 1}, {number(moved.displacement)}\n"
    if load.pulled:
        yield "*DSLOAD\n"
    for pulled in load.pulled:
        yield f"{pulled.name}, P, {number(-pulled.stress)}\n"
    yield _OUTPUT + "*END STEP\n"


def _nodes(fixed: Fixed) -> str:
    """Return the name of the node set, or the number of the single node."""
    if fixed.name:
        return fixed.name
    (node,) = fixed.nodes
    return str(node + 1)
