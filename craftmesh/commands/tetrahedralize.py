"""Fill the grains of a surface with tetrahedra; last, points slide within it, which --no-optimise omits.

Without --sizing, --front and sizes, edges inside the grains follow those of the surface.
"""

import argparse
from pathlib import Path

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.mesh_flags import (
    add_mesh_flags,
    check_sizing,
    given_crack,
    given_sizing,
    write_mesh,
)
from craftmesh.commands.stage_io import add_file, add_output, tell, warn
from craftmesh.errors import CraftmeshError, MeshingError
from craftmesh.io.json_file import read_json
from craftmesh.io.stage_npz import write_grain_tets
from craftmesh.io.vtk import read_surface, write_facets, write_surface
from craftmesh.progress import ProgressLine
from craftmesh.sizing.sizing import Lengths
from craftmesh.tetrahedra.grain_surface import mended
from craftmesh.tetrahedra.meshers import TETWILD
from craftmesh.tetrahedra.options import TetrahedralizeOptions
from craftmesh.tetrahedra.record import record_of
from craftmesh.tetrahedra.tetrahedralize import grains_of_chunk, tetrahedralize
from craftmesh.types import GrainTets, Surface
from craftmesh.voxels.islands import islands_from_json


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("surface", type=Path, help="gradated surface .vtp")
    add_output(parser, "mesh .vtu with the crack opened; with --chunk the chunk's grains .npz")
    add_file(parser, "--islands", "voids and embedded grains .json")
    parser.add_argument("--workers", type=int, default=1, metavar="N", help="worker processes (default 1)")
    parser.add_argument(
        "--chunk", type=chunk, metavar="K/N", help="only the K-th of N parts of the grains, K = 1..N"
    )
    add_mesh_flags(parser)
    add_options(parser, TetrahedralizeOptions)


def run(arguments: argparse.Namespace) -> None:
    check_sizing(arguments)
    surface = read_surface(arguments.surface)
    if arguments.workers < 1:
        raise CraftmeshError(f"--workers is {arguments.workers}; expected a number >= 1")
    if arguments.chunk is not None and arguments.front_csv is not None:
        raise CraftmeshError("--front-csv needs all grains, not a --chunk; give it to craftmesh assemble")
    options = options_from(arguments, TetrahedralizeOptions)
    surface, repair = repaired(surface, arguments.output) if options.repair else (surface, None)
    sizing = given_sizing(arguments, surface)
    grains = surface.grains.tolist()
    if arguments.chunk is not None:
        grains = grains_of_chunk(surface, *arguments.chunk)
    if options.mesher == TETWILD:
        grain_tets: list[GrainTets] = []
        report: dict = {}
        left = grains
    else:
        grain_tets, report, left = mesh_grains(arguments, surface, sizing, options, grains)
    record = record_of(options.mesher, report, left, repair)
    if arguments.chunk is not None:
        write_grain_tets(arguments.output, grain_tets, record)
        tell(report | {"left_to_the_whole_model": left}, arguments.report)
        return
    from craftmesh.commands.assemble import complete_mesh

    mesh, opened = complete_mesh(
        surface, grain_tets, record, lambda: sizing, options, given_crack(arguments)
    )
    write_mesh(arguments, mesh, report | opened)


def repaired(surface: Surface, output: Path) -> tuple[Surface, dict | None]:
    """Return the surface, repaired where facets intersect, and what was done, if anything.

    The facets as they were are written beside the output.
    """
    found = mended(surface)
    if found.faulty is not None:
        path = output.with_name(f"{output.stem}-faulty-facets.vtp")
        write_surface(path, found.faulty)
        warn(f"{found.warning}; see {path}")
    return found.surface, found.report


def mesh_grains(
    arguments: argparse.Namespace,
    surface: Surface,
    sizing: Lengths | None,
    options: TetrahedralizeOptions,
    grains: list[int],
) -> tuple[list[GrainTets], dict, list[int]]:
    """Return the tets of the grains, the report and the ids of the grains that are left.

    Raises CraftmeshError when grains fail, `fallback` is none and there is no chunk to keep the others in.
    """
    file = arguments.islands
    islands = islands_from_json(read_json(file), str(file)) if file else ()
    try:
        with ProgressLine("tetrahedralize") as progress:
            return *tetrahedralize(
                surface,
                sizing,
                islands,
                options,
                grains=grains,
                workers=arguments.workers,
                progress=progress,
            ), []
    except MeshingError as error:
        output, paths = arguments.output, []
        for failure in error.failures:
            paths.append(output.with_name(f"{output.stem}-failed-grain-{failure.grain}.vtp"))
            write_facets(paths[-1], failure.surface.points, failure.surface.facets, failure.marks)
        places = f"; see {', '.join(map(str, paths))}" if paths else ""
        if options.fallback == "none" and arguments.chunk is None:
            raise CraftmeshError(f"{error}{places}") from None
        warn(f"{error}{places}")
        return list(error.done), error.report, [failure.grain for failure in error.failures]


def chunk(text: str) -> tuple[int, int]:
    """Read K/N with 1 <= K <= N."""
    part, _, parts = text.partition("/")
    if not (part.isdecimal() and parts.isdecimal() and 1 <= int(part) <= int(parts)):
        raise argparse.ArgumentTypeError(f"{text!r} is not K/N with 1 <= K <= N")
    return int(part), int(parts)
