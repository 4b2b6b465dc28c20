"""Lines of the deck for the load: supports, and one static step with its output."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from craftmesh.deck.inp_format import number
from craftmesh.mechanics.load import Fixed, Load, Traction, nodal_forces
from craftmesh.types import TetMesh

# Both solvers write these to their results files (.fil, .frd).
_OUTPUT = "*NODE FILE\nU, RF\n*EL FILE\nS, E\n"
# Materials expand by the eigenstrains of their grains times the temperature.
COLD = "*INITIAL CONDITIONS, TYPE=TEMPERATURE\nNALL, 0.0\n"
# Of the largest force: what corners of 10-node elements bear, which is 0.
ROUNDING = 1e-12


def step_lines(load: Load, mesh: TetMesh) -> Iterator[str]:
    """Yield the supports and the step of a load on a mesh; what moves does so in the step."""
    still = [fixed for fixed in load.held if not np.any(fixed.displacement)]
    moved = [fixed for fixed in load.held if np.any(fixed.displacement)] + [*load.moved]
    yield "*BOUNDARY\n"
    for fixed in still:
        yield from (f"{nodes}, {fixed.axis + 1}, {fixed.axis + 1}\n" for nodes in _nodes(fixed))
    if load.heat:
        yield COLD
    yield "*STEP\n*STATIC\n"
    if moved:
        yield "*BOUNDARY\n"
    for fixed in moved:
        yield from moved_lines(fixed)
    yield from _pulled(load.pulled, mesh)
    if load.heat:
        yield f"*TEMPERATURE\nNALL, {number(load.heat)}\n"
    yield _OUTPUT + "*END STEP\n"


def steps_of_cases(cases: Mapping[str, Load], mesh: TetMesh) -> Iterator[str]:
    """Yield a step for each load case, which takes away supports and loads of the one before."""
    heated = any(load.heat for load in cases.values())
    if heated:
        yield COLD
    for name, load in cases.items():
        yield f"*STEP\n** Load case {name}, by itself\n*STATIC\n*BOUNDARY, OP=NEW\n"
        for fixed in (*load.held, *load.moved):
            yield from moved_lines(fixed)
        yield "*CLOAD, OP=NEW\n*DSLOAD, OP=NEW\n"
        yield from _pulled(load.pulled, mesh)
        if heated:
            yield f"*TEMPERATURE, OP=NEW\nNALL, {number(load.heat)}\n"
        yield _OUTPUT + "*END STEP\n"


def moved_lines(fixed: Fixed) -> Iterator[str]:
    """Yield the line of a node set that moves by one value, or one of each node."""
    axis = fixed.axis + 1
    if np.ndim(fixed.displacement):
        values = np.asarray(fixed.displacement).tolist()
        for node, value in zip(fixed.nodes.tolist(), values):
            yield f"{node + 1}, {axis}, {axis}, {number(value)}\n"
    else:
        value = number(float(fixed.displacement))
        yield from (f"{nodes}, {axis}, {axis}, {value}\n" for nodes in _nodes(fixed))


def _pulled(tractions: Sequence[Traction], mesh: TetMesh) -> Iterator[str]:
    """Yield pressures on surfaces, and other tractions as forces at nodes: CalculiX has no others."""
    pressures, forces = parted(tractions, mesh)
    if pressures:
        yield "*DSLOAD\n"
    yield from pressure_lines(pressures)
    loaded = np.abs(forces) > ROUNDING * np.abs(forces).max(initial=0.0)
    if loaded.any():
        yield "*CLOAD\n"
    yield from force_lines(forces, loaded)


def parted(tractions: Sequence[Traction], mesh: TetMesh) -> tuple[list[Traction], np.ndarray]:
    """Return the pressures on surfaces, and the forces (n, 3) at nodes of all other tractions."""
    pressures = [one for one in tractions if one.axis is None and not np.ndim(one.stress)]
    return pressures, nodal_forces([one for one in tractions if one not in pressures], mesh)


def pressure_lines(pressures: Sequence[Traction]) -> Iterator[str]:
    """Yield the lines of *DSLOAD."""
    yield from (f"{one.name}, P, {number(-float(one.stress))}\n" for one in pressures)


def force_lines(forces: np.ndarray, loaded: np.ndarray) -> Iterator[str]:
    """Yield the lines of *CLOAD: the forces (n, 3) that are loaded (n, 3)."""
    nodes, axes = np.nonzero(loaded)
    for node, axis, force in zip(nodes.tolist(), axes.tolist(), forces[nodes, axes].tolist()):
        yield f"{node + 1}, {axis + 1}, {number(force)}\n"


def _nodes(fixed: Fixed) -> list[str]:
    """Return the name of the node set, or the numbers of single nodes."""
    return [fixed.name] if fixed.name else [str(node + 1) for node in fixed.nodes.tolist()]
