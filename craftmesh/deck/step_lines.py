"""Lines of the deck for loads: a single static step, a step per load case, or the steps of a history."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from craftmesh.deck.inp_format import number
from craftmesh.mechanics.history import RAMP, LoadStep
from craftmesh.mechanics.load import Fixed, Load, Traction, acting_faces, combined, nodal_forces
from craftmesh.surface.rounding import EXACT
from craftmesh.types import BOX_PLANES, TetMesh

# Requests for the output that both solvers write to their results files (.fil, .frd).
_OUTPUT = "*NODE FILE\nU, RF\n*EL FILE\nS, E\n"
# Initial temperature; materials expand by the eigenstrains of their grains times the temperature.
_COLD = "*INITIAL CONDITIONS, TYPE=TEMPERATURE\nNALL, 0.0\n"
# Shortest increment over the longest: an increment that does not converge is halved at most ten times.
_SHORTEST = 1e-3
_MOST_INCREMENTS = 100_000  # largest number of increments of a step, never reached; the default is only 100
_PAIRS_PER_LINE = 4  # pairs of time and level in a line of an amplitude


def step_lines(load: Load, mesh: TetMesh, temperature: np.ndarray | None = None) -> Iterator[str]:
    """Yield the supports and the static step of a load on a mesh.

    Prescribed displacements that are not 0 are in the step, even if `load` holds them before it.
    temperature (n,): factor of the load's heat at the nodes, None for 1.
    """
    still = [fixed for fixed in load.held if not np.any(fixed.displacement)]
    moved = [fixed for fixed in load.held if np.any(fixed.displacement)] + [*load.moved]
    yield "*BOUNDARY\n"
    for fixed in still:
        yield from (f"{nodes}, {fixed.axis + 1}, {fixed.axis + 1}\n" for nodes in _nodes(fixed))
    if load.heat:
        yield _COLD
    yield "*STEP\n*STATIC\n"
    if moved:
        yield "*BOUNDARY\n"
    for fixed in moved:
        yield from _moved_lines(fixed)
    yield from _pulled(load.pulled, mesh)
    if load.heat:
        yield from _heat_lines(load, temperature)
    yield _OUTPUT + "*END STEP\n"


def steps_of_cases(
    cases: Mapping[str, Load], mesh: TetMesh, temperature: np.ndarray | None
) -> Iterator[str]:
    """Yield a step for each load case; each step removes the supports and loads of the step before."""
    heated = any(load.heat for load in cases.values())
    if heated:
        yield _COLD
    for name, load in cases.items():
        yield f"*STEP\n** Load case {name}, by itself\n*STATIC\n*BOUNDARY, OP=NEW\n"
        for fixed in (*load.held, *load.moved):
            yield from _moved_lines(fixed)
        yield "*CLOAD, OP=NEW\n*DSLOAD, OP=NEW\n"
        yield from _pulled(load.pulled, mesh)
        if heated:
            yield from _heat_lines(load, temperature, ", OP=NEW")
        yield _OUTPUT + "*END STEP\n"


def history_lines(
    loads: Mapping[str, Load],
    steps: Sequence[LoadStep],
    mesh: TetMesh,
    extras: Sequence[str],
    nlgeom: bool,
    temperature: np.ndarray | None,
) -> Iterator[str]:
    """Yield the steps of a history.

    loads: by the names in the steps; extras: lines for the output of each step; nlgeom: with finite strain.
    A step holds, moves or pulls everything that any of the loads does, with 0 where its own load does not,
    so that nothing of the step before remains.
    """
    if any(load.heat for load in loads.values()):
        yield _COLD
    for count, step in enumerate(steps, 1):
        if step.kind != RAMP:
            yield f"*AMPLITUDE, NAME=STEP_{count}\n"
            table = step.table()
            for start in range(0, len(table), _PAIRS_PER_LINE):
                values = table[start : start + _PAIRS_PER_LINE].ravel().tolist()
                yield ", ".join(map(number, values)) + "\n"
    forces = (np.abs(_parted(load.pulled, mesh)[1]) for load in loads.values())
    sizes = sum(forces, np.zeros(mesh.points.shape))
    loaded = sizes > EXACT * sizes.max(initial=0.0)
    for count, (step, asked) in enumerate(zip(steps, extras, strict=True), 1):
        yield f"*STEP, INC={_MOST_INCREMENTS}{', NLGEOM=YES' if nlgeom else ''}\n"
        yield f"** Step {count}: {step.kind} of the load {step.load}".rstrip() + "\n"
        longest = step.time / step.increments
        yield f"*STATIC\n{', '.join(map(number, (longest, step.duration, _SHORTEST * longest, longest)))}\n"
        yield from _load_lines(loads, step, count, mesh, loaded, temperature)
        yield f"{asked}*END STEP\n"


def face_lines(loads: Mapping[str, Load]) -> str:
    """Return the lines that print displacements and forces of the faces that move or are pulled.

    They belong to every step and also print the body's strain energy: CalculiX gives the energy in the last
    step only if the first step asks for it too.
    """
    acting = {plane for plane, _ in acting_faces(loads.values())}
    return "*EL PRINT, ELSET=EALL, TOTALS=ONLY\nELSE\n" + "".join(
        f"*NODE PRINT, NSET={plane}, TOTALS=YES\nU, RF\n" for plane in BOX_PLANES if plane in acting
    )


def _load_lines(
    loads: Mapping[str, Load],
    step: LoadStep,
    count: int,
    mesh: TetMesh,
    loaded: np.ndarray,
    temperature: np.ndarray | None,
) -> Iterator[str]:
    """Yield supports and loads of a step: for a ramp those at its end, for cycles those at level 1.

    Cycles refer to the amplitude STEP_<count>, the level over time. loaded (n, 3): mask, by node and axis,
    of the forces that any of the loads has.
    """
    level, amplitude = (step.level, "") if step.kind == RAMP else (1.0, f", AMPLITUDE=STEP_{count}")
    load = combined([(level * (name == step.load), one) for name, one in loads.items()])
    yield "*BOUNDARY" + amplitude + "\n"
    for fixed in (*load.held, *load.moved):
        yield from _moved_lines(fixed)
    yield from _pulled(load.pulled, mesh, amplitude, loaded)
    if any(one.heat for one in loads.values()):
        yield from _heat_lines(load, temperature, amplitude)


def _heat_lines(load: Load, temperature: np.ndarray | None, option: str = "") -> Iterator[str]:
    """Yield the temperature of all nodes, or of each: temperature (n,) times the load's factor."""
    yield f"*TEMPERATURE{option}\n"
    if temperature is None or not load.heat:
        yield f"NALL, {number(load.heat)}\n"
        return
    for node, value in enumerate((load.heat * temperature).tolist(), 1):
        yield f"{node}, {number(value)}\n"


def _moved_lines(fixed: Fixed) -> Iterator[str]:
    """Yield the line of a node set with one displacement, or one line for each node."""
    axis = fixed.axis + 1
    if np.ndim(fixed.displacement):
        values = np.asarray(fixed.displacement).tolist()
        for node, value in zip(fixed.nodes.tolist(), values):
            yield f"{node + 1}, {axis}, {axis}, {number(value)}\n"
    else:
        value = number(float(fixed.displacement))
        yield from (f"{nodes}, {axis}, {axis}, {value}\n" for nodes in _nodes(fixed))


def _pulled(
    tractions: Sequence[Traction], mesh: TetMesh, option: str = "", loaded: np.ndarray | None = None
) -> Iterator[str]:
    """Yield pressures on surfaces, and all other tractions as forces at nodes.

    CalculiX has no tractions but uniform pressure. option: text after both keywords; loaded (n, 3): mask of
    the forces to write, by default those that are not 0 up to rounding.
    """
    pressures, forces = _parted(tractions, mesh)
    if pressures:
        yield f"*DSLOAD{option}\n"
    yield from (f"{one.name}, P, {number(-float(one.stress))}\n" for one in pressures)
    if loaded is None:
        loaded = np.abs(forces) > EXACT * np.abs(forces).max(initial=0.0)
    if loaded.any():
        yield f"*CLOAD{option}\n"
    nodes, axes = np.nonzero(loaded)
    for node, axis, force in zip(nodes.tolist(), axes.tolist(), forces[nodes, axes].tolist()):
        yield f"{node + 1}, {axis + 1}, {number(force)}\n"


def _parted(tractions: Sequence[Traction], mesh: TetMesh) -> tuple[list[Traction], np.ndarray]:
    """Return the uniform normal tractions (pressures of a deck), and forces (n, 3) of all others."""
    pressures = [one for one in tractions if one.axis is None and not np.ndim(one.stress)]
    return pressures, nodal_forces([one for one in tractions if one not in pressures], mesh)


def _nodes(fixed: Fixed) -> list[str]:
    """Return the name of the node set, or the numbers of nodes without a set."""
    return [fixed.name] if fixed.name else [str(node + 1) for node in fixed.nodes.tolist()]
