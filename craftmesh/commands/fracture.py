"""Find J, K_I, K_II, K_III and T along the crack's fronts: from the displacements of a solved mesh.

Give the options with which the mesh was solved: a displacement field that does not fit them is rejected,
unless load is none. Box faces that the load holds, moves or pulls count as loaded if a front ends on them.
"""

import argparse
from dataclasses import replace
from pathlib import Path

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.microstructure import add_microstructure, known_of_files
from craftmesh.commands.stage_io import add_file, add_output, add_units, tell, warn
from craftmesh.errors import existing, named
from craftmesh.fracture.options import FractureOptions
from craftmesh.fracture.parameters import stress_intensities
from craftmesh.growth.front_extensions import counted_front, front_extensions
from craftmesh.growth.load_history import rainflow_blocks
from craftmesh.growth.options import GrowthOptions, check_cycle
from craftmesh.growth.slip_planes import SlipField
from craftmesh.growth.trust import doubted_sentence
from craftmesh.io.front_csv import LOAD_CASE, rows_by_load, write_front
from craftmesh.io.json_file import read_json, write_json
from craftmesh.io.model_tables import read_blocks, read_slip_table
from craftmesh.io.stage_npz import read_solutions
from craftmesh.io.vtk import read_crack, read_tets
from craftmesh.mechanics.model import elastic_model
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.mechanics.units import UnitsOptions
from craftmesh.solve.foreign import check_solutions

TOLD = (LOAD_CASE, "front", "nodes", "radius", "largest_K", "error", "root_of_J_over_G", "flagged")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("volume", type=Path, help="mesh .vtu")
    parser.add_argument("solution", type=Path, help="solution .npz of `craftmesh solve`")
    add_output(parser, "parameters .csv, one row per front node")
    add_file(parser, "--json", "write what was integrated, with reliability measures, to this .json")
    add_microstructure(parser)
    add_file(
        parser, "--crack", "crack surface .vtp: also find its growth, columns kink_angle and extension"
    )
    add_file(
        parser,
        "--last",
        "the --json of the previous increment, made with --crack: load cycles are counted from there",
    )
    add_file(
        parser, "--last-growth", "the report of `craftmesh grow` on it: the cycles are of the step laid"
    )
    add_units(parser, "the units in --json")
    add_options(parser, FractureOptions, ModelOptions, GrowthOptions)


def run(arguments: argparse.Namespace) -> None:
    known, growth = known_of_files(arguments), options_from(arguments, GrowthOptions)
    if growth.block_table:
        with named(growth.block_table):
            table = read_blocks(existing(Path(growth.block_table)))
            rows = table if isinstance(table, tuple) else rainflow_blocks(table)
            growth = replace(growth, blocks=rows, block_table="")
    model, _ = elastic_model(read_tets(arguments.volume), options_from(arguments, ModelOptions), **known)
    solutions = read_solutions(existing(arguments.solution))
    check_solutions(model, solutions, str(arguments.solution))
    check_cycle(growth, list(solutions))
    solutions = {name: solutions[name] for name in dict.fromkeys([*growth.loads, *solutions])}
    crack = read_crack(existing(arguments.crack)) if arguments.crack else None
    if crack is not None and "CRACK_FRONT" not in model.mesh.node_sets:
        solutions = {}  # the crack has no front in the material, so there is no K
    found, report = stress_intensities(model, solutions, options_from(arguments, FractureOptions))
    columns = {name: one.columns() for name, one in found.items()}
    if crack is not None:
        last, slip, slips = None, None, growth.slip_table
        if arguments.last:
            laid = read_json(arguments.last_growth) if arguments.last_growth else None
            with named(arguments.last):
                last = counted_front(read_json(arguments.last).get("growth", {}), laid)
        if slips:
            slip = SlipField(**read_slip_table(existing(Path(slips)))._asdict(), source=slips)
        own, report["growth"] = front_extensions(crack, model, solutions, found, growth, last, slip)
        columns[next(iter(columns), "")] = own
    written = rows_by_load(columns)
    write_front(arguments.output, written)
    if arguments.json:
        units = UnitsOptions(*arguments.units).of_columns(("x", "y", "z", *written))
        write_json(arguments.json, {"units": units} | report)
    for front in report["fronts"]:
        tell({key: front[key] for key in TOLD if key in front}, None)
    if crack is not None:
        if doubted := report["growth"].get("doubted"):
            said = doubted_sentence(doubted)
            warn(f"{arguments.output}: {said}; shorter edges there (sizing.l_min) make K more reliable")
        tell(report["growth"], None)
