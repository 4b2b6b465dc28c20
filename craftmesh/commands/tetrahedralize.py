"""Fill the grains of a surface with tetrahedra; last, improve them by moving points within the surface.

--no-optimise omits the improvement. Without --sizing, --front and sizes, the lengths of edges inside the
grains follow the surface's edges.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.licence import licence_note
from craftmesh.commands.mesh_flags import (
    add_filling,
    check_sizing,
    checked_workers,
    given_islands,
    given_sizing,
)
from craftmesh.commands.mesh_output import add_mesh_flags, write_assembled
from craftmesh.commands.stage_io import add_output, tell, warn
from craftmesh.errors import CraftmeshError, MeshingError
from craftmesh.io.stage_npz import write_grain_tets
from craftmesh.io.vtk import read_surface, write_facets, write_surface
from craftmesh.progress import ProgressLine
from craftmesh.tetrahedra.diagnose import GrainFailure
from craftmesh.tetrahedra.options import TetrahedralizeOptions
from craftmesh.tetrahedra.tetrahedralize import grains_of_chunk
from craftmesh.tetrahedra.volume import fill_grains, mesh_volume
from craftmesh.types import Surface


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("surface", type=Path, help="gradated surface .vtp")
    add_output(parser, "mesh .vtu with the crack opened; with --chunk the chunk's grains .npz")
    add_filling(parser)
    parser.add_argument(
        "--chunk", type=chunk, metavar="K/N", help="only the K-th of N parts of the grains, K = 1..N"
    )
    add_mesh_flags(parser)
    add_options(parser, TetrahedralizeOptions)


def run(arguments: argparse.Namespace) -> None:
    check_sizing(arguments)
    surface = read_surface(arguments.surface)
    workers = checked_workers(arguments)
    if arguments.chunk is not None and arguments.front_csv is not None:
        raise CraftmeshError("--front-csv needs all grains, not a --chunk; give it to craftmesh assemble")
    options, islands = options_from(arguments, TetrahedralizeOptions), given_islands(arguments)
    sizing = given_sizing(arguments, surface)
    licence_note()
    try:
        with ProgressLine("tetrahedralize") as progress:
            if arguments.chunk is None:
                volume, report = mesh_volume(surface, sizing, options, islands, workers, progress)
            else:
                grains = grains_of_chunk(surface, *arguments.chunk)
                volume, report = fill_grains(surface, sizing, options, islands, grains, workers, progress)
    except MeshingError as error:
        shown = write_faults(arguments.output, surface, error.report.get("repair"), error.failures)
        raise CraftmeshError("; see ".join(filter(None, [str(error), shown]))) from None
    shown = write_faults(arguments.output, surface, volume.record["repair"], volume.failures)
    warn(*volume.warnings, f"faulty facets are in {shown}" if shown else None)
    if arguments.chunk is None:
        write_assembled(arguments, volume, report)
        return
    write_grain_tets(arguments.output, list(volume.grain_tets), volume.record)
    tell(report | {"left_to_the_whole_model": volume.record["left"]}, arguments.report)


def write_faults(
    output: Path, surface: Surface, repair: dict | None, failures: Sequence[GrainFailure]
) -> str:
    """Write repaired facets and the surfaces of failed grains; return the files' paths, comma-separated.

    The files are written next to `output`; without faults there are none, and the text is "". surface: the
    surface before the repair; repair: the report of the repair, None without one.
    """
    paths = []
    if repair:
        paths.append(output.with_name(f"{output.stem}-faulty-facets.vtp"))
        rows = repair["facets"]
        faulty = Surface(surface.points, surface.facets[rows], surface.sides[rows], surface.kind[rows])
        write_surface(paths[-1], faulty)
    for failure in failures:
        paths.append(output.with_name(f"{output.stem}-failed-grain-{failure.grain}.vtp"))
        write_facets(paths[-1], failure.surface.points, failure.surface.facets, failure.marks)
    return ", ".join(map(str, paths))


def chunk(text: str) -> tuple[int, int]:
    """Return (K, N) from the text K/N with 1 <= K <= N."""
    part, _, parts = text.partition("/")
    if not (part.isdecimal() and parts.isdecimal() and 1 <= int(part) <= int(parts)):
        raise argparse.ArgumentTypeError(f"{text!r} is not K/N with 1 <= K <= N")
    return int(part), int(parts)
