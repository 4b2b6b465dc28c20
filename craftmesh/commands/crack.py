"""Make the crack of one increment: from a shape, from files, along grain boundaries or on a slip plane."""

import argparse
from dataclasses import fields, replace
from pathlib import Path

import numpy as np

from craftmesh.commands.flags import Parser, add_options, options_from
from craftmesh.commands.stage_io import add_file, add_output, add_report, tell
from craftmesh.cracks.fit_bounds import Numbers, notes_on_size
from craftmesh.cracks.fitted_surface import crack_along_path, crack_through_fronts, crack_through_points
from craftmesh.cracks.in_boundaries import crack_in_boundaries
from craftmesh.cracks.in_slip_plane import crack_in_slip_plane
from craftmesh.cracks.options import IN_BOUNDARIES, OF_GRAINS, CrackOptions, crack_files, given_file
from craftmesh.cracks.prepare import prepare_crack
from craftmesh.cracks.prescription import check_crack
from craftmesh.cracks.series import GivenSurface, crack_of_increment, refuse_shrunk
from craftmesh.cracks.two_sided import middle_sheet
from craftmesh.cracks.voxel_crack import crack_through_voxels
from craftmesh.errors import CraftmeshError, existing, existing_file, named, rounded_values
from craftmesh.io.front_csv import front_table, read_fronts
from craftmesh.io.point_files import read_points
from craftmesh.io.surface_files import LISTED, read_triangles
from craftmesh.io.vtk import read_body, read_crack, read_surface, write_crack
from craftmesh.mechanics.orientation import quaternion_to_matrix
from craftmesh.sizing.sizing import SizingOptions, median_edge, sizing_for, voxel_edge
from craftmesh.types import Crack, Voxels
from craftmesh.voxels.reading import read_marked

LENGTHS = ("l_min", "l0")  # the sizing options on which l_min depends


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "volume", type=Path, help="labels .npz, volume .vti or surface .vtp that gives the box"
    )
    add_output(parser, "crack surface .vtp with its fronts as lines")
    parser.add_argument("--increment", type=int, default=0, metavar="K", help="0, 1, ... (default 0)")
    add_file(
        parser,
        "--surface",
        "surface .vtp before any crack, with the grains of shapes boundaries and slip_plane; "
        "default: the volume",
    )
    add_file(parser, "--previous", "crack .vtp of the previous increment; a smaller crack is rejected")
    add_report(parser)
    add_options(parser, CrackOptions)
    parser.add_argument(
        "--and",
        dest="others",
        nargs=argparse.REMAINDER,
        default=[],
        metavar="OPTIONS",
        help="a further crack; its options follow, and after them only further cracks",
    )
    others = (item.name for item in fields(SizingOptions) if item.name not in LENGTHS)
    add_options(parser, SizingOptions, skip=others)


def run(arguments: argparse.Namespace) -> None:
    increment = arguments.increment
    body = read_body(arguments.volume)
    box = body.box
    grid, edge = (body, voxel_edge(body)) if isinstance(body, Voxels) else (None, median_edge(body))
    lengths, cracks, reports = options_from(arguments, SizingOptions), [], {}
    known = lengths if lengths.l0 is not None else replace(lengths, l0=edge)
    l_min = sizing_for(None, np.zeros((0, 3)), known).l_min
    given = crack_options(arguments)
    for number, options in enumerate(given, 1):
        if options.shape in OF_GRAINS:
            surface_file = arguments.surface or arguments.volume
            crack, report = crack_of_grains(options, increment, surface_file, grid, l_min)
            cracks.append(crack)
        else:
            surface, report = given_surface(options, increment, box, grid, l_min)
            if surface is not None:
                notes = report.get("notes", []) + notes_on_size(surface.points, box, l_min)
                report |= {"notes": notes} if notes else {}
            cracks.append(crack_of_increment(options, increment, box, surface))
        reports[f"crack_{number}"] = report
    of_facets = [number for number, options in enumerate(given) if options.shape == IN_BOUNDARIES]
    is_guess = lengths.l_min is None and lengths.l0 is None
    crack = prepare_crack(cracks, box, l_min, of_facets, is_guess)
    if arguments.previous:
        refuse_shrunk(crack, read_crack(arguments.previous), increment)
    write_crack(arguments.output, crack)
    tell(reports if len(reports) > 1 else reports["crack_1"], arguments.report)


def crack_of_grains(
    options: CrackOptions, increment: int, path: Path, grid: Voxels | None, l_min: float
) -> tuple[Crack, Numbers]:
    """Return a crack in grain boundaries or in a slip plane of a grain, and a report.

    path: surface .vtp of the grains; grid: the voxels with the grains' orientations, which shape slip_plane
    needs. The report has the slip plane's normal in sample axes, else nothing. Raises CraftmeshError for
    other files, an unknown orientation, and values that do not define a crack.
    """
    check_crack(options, increment)
    if path.suffix != ".vtp":
        raise CraftmeshError(
            f"shape {options.shape} with {path}: the shape needs the grain boundaries of a surface; "
            "give --surface, a .vtp of craftmesh remesh"
        )
    surface = read_surface(existing(path))
    if options.shape == IN_BOUNDARIES:
        return crack_in_boundaries(surface, options, increment), {}
    turns = np.zeros((0, 4)) if grid is None or grid.orientations is None else grid.orientations
    grain = int(options.grain or 0)
    if grain >= len(turns) or np.isnan(turns[grain]).any():
        raise CraftmeshError(
            f"crack.grain is {grain}, whose orientation is not known; shape slip_plane needs a labels .npz "
            "with the orientations of the grains"
        )
    normal = quaternion_to_matrix(turns[grain]) @ np.asarray(options.plane, float)
    normal /= np.linalg.norm(normal)
    return crack_in_slip_plane(surface, options, increment, normal, l_min), {
        "normal": rounded_values(normal)
    }


def given_surface(
    options: CrackOptions,
    increment: int,
    box: np.ndarray,
    grid: Voxels | None = None,
    l_min: float | None = None,
) -> tuple[GivenSurface | None, Numbers]:
    """Return the crack surface of an increment, and a report on how well it fits the data.

    The surface is None for a shape that numbers define. box (2, 3): the model's box; grid: the model's
    voxels if known; l_min: scale of the allowed distance between surface and measured points. Raises
    CraftmeshError that names the key or the file.
    """
    check_crack(options, increment)
    if options.shape == "surface":
        given = _triangulated(options, increment)
        return (given, {}) if given.fronts else middle_sheet(given.points, given.triangles, box)
    if options.shape == "fronts":
        names = [name for key, name in crack_files(options, increment).items() if key != "front"]
        fronts = [_one_front(name) for name in names or [str(given_file(options, increment))]]
        return crack_through_fronts(fronts, box, options.spacing, options.inside)
    if options.shape == "points":
        cloud, fronts = read_points(given_file(options, increment)), read_fronts(str(options.front))
        return crack_through_points(cloud, fronts, box, options.spacing, l_min)
    if options.shape == "path":
        points = front_table(given_file(options, increment), "xy").numbers("xy")
        return crack_along_path(points, options, increment, box)
    if options.shape == "voxels":
        is_crack, edges, origin, notes = read_marked(given_file(options, increment), options.label, grid)
        surface, report = crack_through_voxels(is_crack, edges, origin, box, options.spacing)
        notes += report.pop("notes", [])
        return surface, report | ({"notes": notes} if notes else {})
    return None, {}


def _triangulated(options: CrackOptions, increment: int) -> GivenSurface:
    """Return the triangles of a file, with fronts from options.front, else from the lines of a .vtp.

    Fronts are empty if there is neither.
    """
    with named("crack.file"):
        advice = f"expected a triangulated surface .vtp, {LISTED}"
        path = existing_file(given_file(options, increment), advice)
    if path.suffix.lower() != ".vtp":
        surface = GivenSurface(*read_triangles(path))
    else:
        known = read_crack(path)
        fronts = tuple(known.points[front] for front in known.fronts)
        surface = GivenSurface(known.points, known.triangles, fronts)
    if not options.front:
        return surface
    return GivenSurface(surface.points, surface.triangles, tuple(read_fronts(options.front)))


def _one_front(path: str) -> np.ndarray:
    fronts = read_fronts(path)
    if len(fronts) > 1:
        raise CraftmeshError(f"{path}: contains {len(fronts)} fronts; write one front per increment file")
    return fronts[0]


def crack_options(arguments: argparse.Namespace) -> list[CrackOptions]:
    """Return the options of each crack: from the flags before --and, and after each --and."""
    parts: list[list[str]] = [[]] if arguments.others else []
    for word in arguments.others:
        if word == "--and":
            parts.append([])
        else:
            parts[-1].append(word)
    parser = Parser(prog="craftmesh crack ... --and", usage="options of one crack")
    add_options(parser, CrackOptions)
    first = options_from(arguments, CrackOptions)
    return [first, *(options_from(parser.parse_args(words), CrackOptions) for words in parts)]
