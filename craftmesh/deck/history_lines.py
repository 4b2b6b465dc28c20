"""Lines of the deck for a history of the load: its steps, with amplitudes, times, restart and output."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from craftmesh.deck.inp_format import number
from craftmesh.deck.step_lines import COLD, ROUNDING, force_lines, moved_lines, parted, pressure_lines
from craftmesh.mechanics.history import RAMP, LoadStep
from craftmesh.mechanics.load import Load, combined
from craftmesh.types import BOX_PLANES, TetMesh

# An increment that does not converge is cut to no less than that share of the longest: ten halvings.
_SHORTEST = 1e-3
_MOST_INCREMENTS = 100_000  # of a step, which ends before: the programs' own limit is 100
_PAIRS_PER_LINE = 4


def history_lines(
    loads: Mapping[str, Load], steps: Sequence[LoadStep], mesh: TetMesh, extras: Sequence[str], nlgeom: bool
) -> Iterator[str]:
    """Yield the steps of a history; loads: by the names in it; extras: lines for the output of each step.

    A step has all that any of the loads holds, moves or pulls, 0 where its own does not, so that it takes
    the place of the step before.
    """
    if any(load.heat for load in loads.values()):
        yield COLD
    for count, step in enumerate(steps, 1):
        if step.kind != RAMP:
            yield f"*AMPLITUDE, NAME=STEP_{count}\n"
            yield from _table_lines(step.table())
    loaded = _loaded(loads, mesh)
    for count, (step, asked) in enumerate(zip(steps, extras, strict=True), 1):
        yield f"*STEP, INC={_MOST_INCREMENTS}{', NLGEOM=YES' if nlgeom else ''}\n"
        yield f"** Step {count}: {step.kind} of the load {step.load}".rstrip() + "\n"
        longest = step.time / step.increments
        yield f"*STATIC\n{', '.join(map(number, (longest, step.duration, _SHORTEST * longest, longest)))}\n"
        yield from _load_lines(loads, step, count, mesh, loaded)
        yield f"{asked}*END STEP\n"


def face_lines(loads: Mapping[str, Load]) -> str:
    """Return the lines that print displacements and forces of the faces that move or are pulled.

    And the body's energy, without which in the first step CalculiX has none in the last.
    """
    acting = {part.name for load in loads.values() for part in load.moved}
    acting |= {part.name for load in loads.values() for part in load.pulled}
    return "*EL PRINT, ELSET=EALL, TOTALS=ONLY\nELSE\n" + "".join(
        f"*NODE PRINT, NSET={plane}, TOTALS=YES\nU, RF\n" for plane in BOX_PLANES if plane in acting
    )


def _loaded(loads: Mapping[str, Load], mesh: TetMesh) -> np.ndarray:
    """Return which nodes any of the loads has forces at, by axis (n, 3)."""
    forces = (np.abs(parted(load.pulled, mesh)[1]) for load in loads.values())
    sizes = sum(forces, np.zeros(mesh.points.shape))
    return sizes > ROUNDING * sizes.max(initial=0.0)


def _load_lines(
    loads: Mapping[str, Load], step: LoadStep, count: int, mesh: TetMesh, loaded: np.ndarray
) -> Iterator[str]:
    """Yield supports and loads of a step: at its end, or with its amplitude over time."""
    level, amplitude = (step.level, "") if step.kind == RAMP else (1.0, f", AMPLITUDE=STEP_{count}")
    load = combined([(level * (name == step.load), one) for name, one in loads.items()])
    yield "*BOUNDARY" + amplitude + "\n"
    for fixed in (*load.held, *load.moved):
        yield from moved_lines(fixed)
    pressures, forces = parted(load.pulled, mesh)
    if pressures:
        yield f"*DSLOAD{amplitude}\n"
        yield from pressure_lines(pressures)
    if loaded.any():
        yield f"*CLOAD{amplitude}\n"
        yield from force_lines(forces, loaded)
    if any(one.heat for one in loads.values()):
        yield f"*TEMPERATURE{amplitude}\nNALL, {number(load.heat)}\n"


def _table_lines(table: np.ndarray) -> Iterator[str]:
    """Yield times and levels (k, 2), up to four pairs a line."""
    for start in range(0, len(table), _PAIRS_PER_LINE):
        values = table[start : start + _PAIRS_PER_LINE].ravel().tolist()
        yield ", ".join(map(number, values)) + "\n"
