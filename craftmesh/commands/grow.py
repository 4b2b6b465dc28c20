"""Grow a crack by one increment: its fronts advance by the kink angles and extensions of sif.csv."""

import argparse
from pathlib import Path

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.stage_io import add_file, add_output, add_report, tell, warn
from craftmesh.errors import CraftmeshError, existing
from craftmesh.growth.front_step import Step
from craftmesh.growth.grow_crack import grow_crack, last_step, step_columns
from craftmesh.growth.options import CorrectionOptions, SmoothingOptions
from craftmesh.io.front_csv import front_columns, write_front
from craftmesh.io.vtk import read_body, read_crack, write_crack

WAYS = ("node", "kink_angle", "extension")
FRAMES = tuple(f"{name}_{axis}" for name in ("normal", "binormal") for axis in "xyz")
RATES = ("rate", "power")
WORDS, GAPS = ("flags", "stays"), ("K_I", "T")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("crack", type=Path, help="crack surface .vtp")
    parser.add_argument("intensities", type=Path, help="sif.csv of that crack: kink angles and extensions")
    parser.add_argument("front", type=Path, help="front.csv of its mesh: the frames along the front")
    parser.add_argument(
        "--volume",
        type=Path,
        required=True,
        metavar="FILE",
        help="labels .npz, volume .vti or surface .vtp that gives the box",
    )
    add_output(parser, "grown crack surface .vtp")
    add_file(parser, "--base", "write the crack to which the new surface was joined, a .vtp")
    add_file(parser, "--step", "write direction and length of the new surface at each node, a .csv")
    add_file(parser, "--last-base", "the --base file of the previous increment")
    add_file(parser, "--last-step", "its --step file: that new surface is made again, corrected")
    add_report(parser)
    add_options(parser, SmoothingOptions, CorrectionOptions)


def run(arguments: argparse.Namespace) -> None:
    crack = read_crack(existing(arguments.crack))
    made = "made by `craftmesh fracture --crack`"
    known = (("front", "s"), RATES)
    ways = front_columns(existing(arguments.intensities), WAYS, made, *known, words=WORDS, gaps=GAPS)
    made = "made by `craftmesh assemble --front-csv`"
    frames = front_columns(existing(arguments.front), ("node", *FRAMES), made)
    last = _last_step(arguments) if options_from(arguments, CorrectionOptions).correct else None
    options, body = options_from(arguments, SmoothingOptions), read_body(arguments.volume)
    grown, report = grow_crack(crack, body, ways, frames, options, last)
    warn(*(f"{arguments.crack}: {text}" for text in grown.warnings))
    if grown.ended:
        warn(f"{arguments.crack}: the crack stops here and is written as it is: {grown.ended}")
    write_crack(arguments.output, grown.crack)
    if arguments.base:
        write_crack(arguments.base, grown.step.crack)
    if arguments.step:
        write_front(arguments.step, step_columns(grown.step))
    tell(report, arguments.report)


def _last_step(arguments: argparse.Namespace) -> Step | None:
    """Return the previous increment's step from the files of --last-base and --last-step.

    Returns None if neither is given; raises CraftmeshError if only one is.
    """
    base, step = arguments.last_base, arguments.last_step
    if (base is None) != (step is None):
        raise CraftmeshError(
            "only one of --last-base and --last-step is given; give both, of the previous increment"
        )
    if step is None:
        return None
    needed = (*FRAMES, *WAYS[1:], "trusted")
    columns = front_columns(existing(step), needed, "made by `craftmesh grow --step`", RATES)
    return last_step(read_crack(existing(base)), columns)
