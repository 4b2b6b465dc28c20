"""Find J, K_I, K_II, K_III and T along the crack's fronts: from the displacements of a solved mesh.

Give the options with which it was solved: a field that does not fit them is refused, unless load is none.
Planes that the load holds, moves or pulls count as loaded where a front ends on them.
"""

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.microstructure import add_microstructure, known_of_files
from craftmesh.commands.solved_loads import by_load, solved_loads
from craftmesh.commands.stage_io import add_file, add_output, add_units, tell, warn
from craftmesh.cracks.polyline import polyline
from craftmesh.errors import CraftmeshError, existing
from craftmesh.fracture.options import FractureOptions
from craftmesh.fracture.parameters import FrontParameters, fracture_parameters
from craftmesh.growth.extension import (
    NEAR_FIELD,
    SLIP,
    CrackFronts,
    Evidence,
    KinksAndExtensions,
    doubts,
    kinks_and_extensions,
)
from craftmesh.growth.grow import row_spacing
from craftmesh.growth.kink_angle import SlipField, slip_ways
from craftmesh.growth.options import GrowthOptions
from craftmesh.growth.rates import laws_of, local_rates
from craftmesh.growth.relaxation import rows_along
from craftmesh.growth.steps import Counted, counted, crack_size
from craftmesh.growth.trust import Trust, doubted_sentence, trusted
from craftmesh.io.front_csv import LOAD_CASE, write_front
from craftmesh.io.json_file import read_json, write_json
from craftmesh.io.model_tables import read_slip_table
from craftmesh.io.vtk import read_crack, read_tets
from craftmesh.mechanics.lips import mean_traction, on_lips
from craftmesh.mechanics.load import Load
from craftmesh.mechanics.materials import turned
from craftmesh.mechanics.model import ElasticModel, elastic_model
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.mechanics.units import UnitsOptions
from craftmesh.mesh.front_frames import FrontFrames, front_frames
from craftmesh.solve.stress import mean_stress
from craftmesh.types import Crack, Solution

CYCLES = ("cycles", "doubt", "ahead", "ahead_doubt")
TOLD = (LOAD_CASE, "front", "nodes", "radius", "largest_K", "error", "root_of_J_over_G", "flagged")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("volume", type=Path, help="mesh .vtu")
    parser.add_argument("solution", type=Path, help="solution .npz of `craftmesh solve`")
    add_output(parser, "parameters .csv, one row per front node")
    add_file(parser, "--json", "what was integrated, and how far to trust it")
    add_microstructure(parser)
    add_file(
        parser, "--crack", "crack surface .vtp: find how it grows as well, columns kink_angle and extension"
    )
    add_file(
        parser,
        "--last",
        "the --json of the increment before, made with --crack: load cycles are counted on from there",
    )
    add_units(parser, "the units in --json")
    add_options(parser, FractureOptions, ModelOptions, GrowthOptions)


class SolvedFront(NamedTuple):
    """A model under one load, its solution, and what was found along its fronts."""

    model: ElasticModel
    solution: Solution
    parameters: FrontParameters


def run(arguments: argparse.Namespace) -> None:
    known = known_of_files(arguments)
    model, _ = elastic_model(read_tets(arguments.volume), options_from(arguments, ModelOptions), **known)
    growth = options_from(arguments, GrowthOptions)
    loads = solved_loads(model, arguments.solution, growth.cycle)
    if arguments.crack and "CRACK_FRONT" not in model.mesh.node_sets:
        write_without_front(arguments, model.mesh.box)
        return
    solved: dict[str, SolvedFront] = {}
    report: dict = {"fronts": []}
    for name, (loaded, solution) in loads.items():
        parameters, found = fracture_parameters(
            model.mesh,
            solution.displacement,
            model.grains,
            model.stiffness(),
            options_from(arguments, FractureOptions),
            loaded_planes(loaded.load),
            solution.contact,
            on_lips(loaded.load),
            loaded.eigenstrain(),
        )
        solved[name] = SolvedFront(loaded, solution, parameters)
        report["fronts"] += [({LOAD_CASE: name} if name else {}) | front for front in found["fronts"]]
    columns = {name: one.parameters.columns() for name, one in solved.items()}
    if arguments.crack:
        ends = [solved[name] for name in growth.cycle or list(solved)[:1]]
        own = columns[next(iter(columns))]
        way, report["growth"] = growth_of(ends, growth, arguments)
        own |= way | {"flags": own.pop("flags")}
    written = columns[""] if "" in columns else by_load(columns)
    write_front(arguments.output, written)
    if arguments.json:
        units = UnitsOptions(*arguments.units).of_columns(("x", "y", "z", *written))
        write_json(arguments.json, {"units": units} | report)
    for front in report["fronts"]:
        tell({key: front[key] for key in TOLD if key in front}, None)
    if arguments.crack:
        tell(report["growth"], None)


def write_without_front(arguments: argparse.Namespace, box: np.ndarray) -> None:
    """Write what there is of a crack that ends in faces of the body (box (2, 3)): the cycles to there."""
    options, size = options_from(arguments, GrowthOptions), crack_size(read_crack(arguments.crack), box)
    last = read_counted(arguments.last) if arguments.last else None
    growth = counted_report(counted(last, size, 0.0, 0.0, 0.0, 0.0), options)
    none = dict.fromkeys(("node", "kink_angle", "extension", "stays"), np.zeros(0))
    write_front(arguments.output, {"points": np.zeros((0, 3))} | none)
    if arguments.json:
        write_json(arguments.json, {"fronts": [], "growth": growth})
    tell(growth, None)


def growth_of(
    ends: Sequence[SolvedFront], options: GrowthOptions, arguments: argparse.Namespace
) -> tuple[dict[str, np.ndarray], dict]:
    """Return the columns that say how a front goes on, and a report.

    ends: the largest load of a cycle, and perhaps the least.
    """
    (model, solution, parameters), *least = ends
    crack, frames = read_crack(existing(arguments.crack)), front_frames(model.mesh)
    trust = trusted(parameters.flags.tolist(), parameters.front, parameters.s)
    fronts = crack_fronts(frames, parameters, crack, model.mesh.box, trust)
    stress = mean_stress(model, solution.displacement) + mean_traction(model.load, model.mesh)
    evidence = Evidence(
        parameters.points,
        doubts(parameters.error, stress, fronts.size),
        trust.steers,
        "contact_closed" in solution.record,
        parameters.front,
    )
    of_grains, axes = model.stiffness()[np.searchsorted(model.grains, frames.grain)], frames.axes
    growth = kinks_and_extensions(
        intensities(parameters),
        fronts,
        options,
        evidence,
        read_counted(arguments.last) if arguments.last else None,
        local_rates(laws_of(options), frames.grain, model.phase_of),
        turned(of_grains, axes) if options.criterion == NEAR_FIELD else None,
        intensities(least[0].parameters) if least else None,
        slip_angles(model, frames, options) if options.criterion == SLIP else None,
    )
    if trust.doubted:
        said = doubted_sentence(trust.doubted)
        warn(f"{arguments.output}: {said}; shorter edges there (sizing.l_min) make K surer")
    report = {"stress": stress} | counted_report(growth.counted, options)
    return growth_columns(growth, report, bool(least)), report | {"doubted": trust.doubted}


def crack_fronts(
    frames: FrontFrames, parameters: FrontParameters, crack: Crack, box: np.ndarray, trust: Trust
) -> CrackFronts:
    """Return the fronts of a crack in a box (2, 3) as growth takes them, with the error of what steers."""
    lines = [polyline(crack.points[front]) for front in crack.fronts]
    return CrackFronts(
        crack_size(crack, box),
        rows_along(lines, frames.points, frames.binormal),
        row_spacing(frames.points),
        float(np.median(parameters.error[trust.steers])),
    )


def counted_report(count: Counted, options: GrowthOptions) -> dict[str, float | None]:
    """Return a front's cycles as `read_counted` reads them; null without a law that gives them."""
    known = options.has_rates
    return {key: value if known or key not in CYCLES else None for key, value in count._asdict().items()}


def read_counted(path: Path) -> Counted | None:
    """Read the front before; None where it did not go on. Raises CraftmeshError for another file."""
    found = read_json(existing(path)).get("growth", {})
    if not set(Counted._fields) <= found.keys():
        raise CraftmeshError(
            f"{path}: no growth to count on from; expected the --json of `craftmesh fracture --crack`"
        )
    last = Counted(*(found[key] or 0.0 for key in Counted._fields))
    return last if last.rate > 0 else None


def intensities(parameters: FrontParameters) -> np.ndarray:
    """Return K_I, K_II, K_III (n, 3) of the front nodes."""
    return np.column_stack([parameters.K_I, parameters.K_II, parameters.K_III])


def slip_angles(model: ElasticModel, frames: FrontFrames, options: GrowthOptions) -> np.ndarray:
    """Return the kink angles (n,) of the front nodes along the planes that slip most in a table."""
    unknown = sorted(set(frames.grain.tolist()) - set(model.axes))
    if unknown:
        raise CraftmeshError(
            f"grow.criterion slip: grain {unknown[0]} at the front has no orientation; give orientations "
            "with the microstructure"
        )
    table = read_slip_table(existing(Path(options.slip_table)))
    turns = np.array([model.own_axes(grain) for grain in frames.grain.tolist()])
    return slip_ways(frames, turns, SlipField(*table, options.slip_table), options.ring)


def growth_columns(
    growth: KinksAndExtensions, counted: Mapping[str, float | None], by_pair: bool = False
) -> dict[str, np.ndarray]:
    """Return the columns of sif.csv that say how a front goes on; kink angles in degrees.

    Load cycles to the front and their doubt stand in every row, where a law gives them; so do da/dN and the
    cycles in which each node goes its extension at that rate, NaN where it stays. Delta K and R stand where
    they are those of two loads.
    """
    angle = np.degrees(growth.kink_angle)
    way = {"kink_angle": angle, "extension": growth.extension, "driving": growth.driving}
    way |= {"delta_K": growth.delta_k, "R": growth.ratio} if by_pair else {}
    way |= {"rate": growth.rate, "power": np.full(len(angle), growth.power)}
    if counted["cycles"] is not None:
        way |= {"cycles": np.full(len(angle), counted["cycles"])}
        way |= {"cycles_doubt": np.full(len(angle), counted["doubt"])}
        goes = growth.da_dn > 0
        ahead = growth.extension / np.where(goes, growth.da_dn, 1.0)
        way |= {"da_dN": growth.da_dn, "cycles_ahead": np.where(goes, ahead, np.nan)}
    return way | {"stays": growth.stays}


def loaded_planes(load: Load | None) -> set[str]:
    """Return the names of the planes that a load holds, moves or pulls; the load of lips is known."""
    if load is None:
        return set()
    names = {part.name for part in (*load.held, *load.moved)} | {part.name for part in load.pulled}
    return names - {part.name for part in on_lips(load)} - {""}
