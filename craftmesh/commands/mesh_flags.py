"""Flags of the subcommands that mesh: the sizing, from a file or from numbers; the given crack; fronts."""

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path

import numpy as np

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.stage_io import add_file, warn
from craftmesh.errors import CraftmeshError, existing, named
from craftmesh.io.front_csv import front_table
from craftmesh.io.json_file import read_json
from craftmesh.io.point_files import SourcePoints, read_length_field, read_source_points
from craftmesh.io.stage_npz import read_sizing
from craftmesh.io.vtk import read_crack
from craftmesh.sizing.length_field import LINKED, LengthField
from craftmesh.sizing.sizing import Sizing, SizingOptions
from craftmesh.sizing.sources import Defects, sizing_around, touches_box
from craftmesh.sizing.stored import sizing_of
from craftmesh.surface.measure import span_of
from craftmesh.surface.side_data import coordinates_hint, covered, notes_on_place, spans_told
from craftmesh.types import Crack, Surface
from craftmesh.voxels.islands import Island, islands_from_json


def add_crack(parser: argparse.ArgumentParser, what: str) -> None:
    """Add the flag --crack; what: end of its help, a clause on the use of the crack."""
    add_file(parser, "--crack", f"crack .vtp {what}; default the --front if that is a .vtp")


def given_crack(arguments: argparse.Namespace) -> Crack | None:
    """Return the crack of --crack, else the crack of --front if this is a .vtp, else None."""
    file = arguments.crack or arguments.front
    return read_crack(file) if file is not None and (arguments.crack or file.suffix == ".vtp") else None


def add_front(parser: argparse.ArgumentParser) -> None:
    add_file(parser, "--front", "crack front to refine around: .csv with columns x, y, z, or a crack .vtp")


def add_filling(parser: argparse.ArgumentParser) -> None:
    """Add the flags --islands and --workers, which `given_islands` and `checked_workers` read."""
    add_file(parser, "--islands", "voids and embedded grains .json")
    parser.add_argument("--workers", type=int, default=1, metavar="N", help="worker processes (default 1)")


def given_islands(arguments: argparse.Namespace) -> Sequence[Island]:
    """Return the islands (voids and embedded grains) in the file of --islands; () without the flag."""
    file = arguments.islands
    return islands_from_json(read_json(file), str(file)) if file else ()


def checked_workers(arguments: argparse.Namespace) -> int:
    """Return the number of --workers; raises CraftmeshError if it is below 1."""
    workers: int = arguments.workers
    if workers < 1:
        raise CraftmeshError(f"--workers is {workers}; expected a number >= 1")
    return workers


def add_sizing(parser: argparse.ArgumentParser) -> None:
    add_file(
        parser, "--sizing", "sizing .npz of `craftmesh size`; replaces the front and all sizing options"
    )
    add_options(parser, SizingOptions)


def check_sizing(arguments: argparse.Namespace) -> None:
    """Raise CraftmeshError if --sizing is given with other sizing flags, or its file does not exist."""
    names = ["front", *(item.name for item in fields(SizingOptions))]
    given = [f"--{name.replace('_', '-')}" for name in names if getattr(arguments, name, None) is not None]
    if arguments.sizing and given:
        raise CraftmeshError(f"--sizing {arguments.sizing} has all sizes; remove {', '.join(given)}")
    if arguments.sizing:
        existing(arguments.sizing)


def given_sizing(arguments: argparse.Namespace, surface: Surface) -> Sizing | None:
    """Return the sizing function of the flags; None without --sizing, --front and sizing options."""
    is_given = arguments.sizing or arguments.front is not None
    if is_given or options_from(arguments, SizingOptions) != SizingOptions():
        return sizing_from(arguments, surface, arguments.front)
    return None


def sizing_from(arguments: argparse.Namespace, surface: Surface, front: Path | None) -> Sizing:
    """Return the sizing function of --sizing, else the function that the flags and `front` define.

    front: file of the front, None for no front. Prints warnings on sources outside the box.
    """
    if arguments.sizing:
        return stored_sizing(arguments.sizing)
    sizing, notes = sizing_by(options_from(arguments, SizingOptions), surface, front)
    warn(*notes)
    return sizing


def sizing_by(options: SizingOptions, surface: Surface, front: Path | None) -> tuple[Sizing, list[str]]:
    """Return the sizing function around the front in a file and the sources in `options`, and notes.

    Sources are the voids of the surface, points or voids in a csv, and a field of lengths; the smallest
    length counts. The notes are on sources that lie partly outside. Raises CraftmeshError for files that
    cannot be read, or whose data are elsewhere than the surface or in another unit.
    """
    lengths, box = None, surface.box
    if options.field:
        path = existing(Path(options.field))
        lengths_at = read_length_field(path, options.field_array)
        with named(path):
            lengths = LengthField(*lengths_at)
    crack = read_crack(front) if front is not None and front.suffix == ".vtp" else None
    points: dict[Path, np.ndarray] = {}
    if front is not None and crack is None:
        points[front] = front_table(front).numbers("xyz")
    given = given_defects(options, box)
    every = np.concatenate([*points.values(), given.points])
    if options.points:
        points[Path(options.points)] = given.centres
    sizing = sizing_around(surface, Defects(crack, every, given.spheres), options, lengths)
    if front is not None and crack is not None and crack.fronts:
        points[front] = crack.points[np.concatenate(crack.fronts)]
    notes = [] if lengths is None else coverage_notes(str(options.field), lengths, surface.points)
    return sizing, notes + notes_on_sources(points, given, sizing, box)


def notes_on_sources(
    points: Mapping[Path, np.ndarray], given: Defects, sizing: Sizing, box: np.ndarray
) -> list[str]:
    """Return a sentence on each file whose points (n, 3) lie partly outside the box (2, 3).

    points: by file; given: points and pores that options name. Points farther outside than r1 of the sizing
    plus the largest pore radius have no effect. Raises CraftmeshError if all points of a file are so far
    outside, or if they seem to be in another unit.
    """
    reach = sizing.r1 + given.spheres[:, 3].max(initial=0.0)
    placed = [(str(path), own) for path, own in points.items() if len(own)]
    return [note for path, own in placed for note in notes_on_place(path, own, box, reach, sizing.l_min)]


def coverage_notes(source: str, lengths: LengthField, points: np.ndarray) -> list[str]:
    """Return a list of one sentence if a field of lengths misses some of the points (n, 3), else [].

    source: the field's file, for the sentence. Raises CraftmeshError for a field that covers no point.
    """
    is_covered, far = covered(points, lengths.points, LINKED)
    if is_covered.all():
        return []
    text = f"{source}: covers {is_covered.mean():.2%} of the surface's points, {far}"
    if not is_covered.any():
        raise CraftmeshError(f"{text}; give the field in the unit and place of the body")
    return [f"{text}; points beyond take the length of the nearest field point"]


def given_defects(options: SizingOptions, box: np.ndarray) -> Defects:
    """Return points and voids of the file `options.points` in model units; none without a file.

    box (2, 3): the model's box, to which a list of voids is relative. Raises CraftmeshError for a file that
    cannot be read, and if none of its voids touches the box.
    """
    if not options.points:
        return Defects()
    path = existing(Path(options.points))
    given = read_source_points(path)
    return Defects(points=given.points, spheres=within_box(path, given, box))


def within_box(path: Path, given: SourcePoints, box: np.ndarray) -> np.ndarray:
    """Return a file's spheres (s, 4), x, y, z, r in model units.

    path: the file, for the error; given: its content; box (2, 3): the model's box. Raises CraftmeshError if
    there are spheres but none touches the box.
    """
    spheres = given.in_box(box)
    if len(spheres) and not touches_box(spheres, box).any():
        span = span_of(spheres[:, :3])
        raise CraftmeshError(
            f"{path}: none of its {len(spheres)} pores or voids touches the model's box: "
            f"{spans_told(('they go', 'the box'), span, box)}{coordinates_hint(span, box)}; "
            + (
                "x, y, z, r of a void list are fractions of the box"
                if len(given.voids)
                else "expected the units and the origin of the microstructure; scale the table"
            )
        )
    return spheres


def stored_sizing(path: Path) -> Sizing:
    """Return the sizing function in a file of `craftmesh size`; raises CraftmeshError for other files."""
    arrays = read_sizing(path)
    with named(path):
        return sizing_of(arrays)
