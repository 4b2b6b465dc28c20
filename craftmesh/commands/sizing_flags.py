"""The flags of the sizing function and its sources, shared by the stages that use it."""

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.stage_io import existing
from craftmesh.errors import CraftmeshError
from craftmesh.io.craftmesher import read_source_points
from craftmesh.io.front_csv import read_front_points
from craftmesh.io.size_field import read_length_field
from craftmesh.io.vtk import read_crack
from craftmesh.sizing.sizing import Sizing, SizingOptions, densify, sizing_for
from craftmesh.types import Surface


def add_front(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--front",
        type=Path,
        metavar="FILE",
        help="crack front to refine around: .csv with columns x, y, z, or a crack .vtp",
    )


def add_sizing(parser: argparse.ArgumentParser) -> None:
    add_options(parser, SizingOptions)


def is_sized(arguments: argparse.Namespace) -> bool:
    """Return whether a front, the voids or any number of the sizing function was given."""
    return bool(arguments.front) or options_from(arguments, SizingOptions) != SizingOptions()


def sizing_from(arguments: argparse.Namespace, surface: Surface, front: Path | None) -> Sizing:
    """Return the sizing function around the front in a file and all else that the flags name.

    That is the voids of the surface, points or voids in a csv, and a field of lengths: the least counts.
    """
    options = options_from(arguments, SizingOptions)
    field = options.field and read_length_field(existing(Path(options.field)), options.field_array)
    plain = sizing_for(surface, options, np.zeros((0, 3)), (field,) if field else ())
    sources = [read_front_sources(front, plain.l_min)] if front else []
    if options.around_voids:
        sources.append(surface.points[np.unique(surface.facets[(surface.sides < 0).any(axis=1)])])
    if options.points:
        used = surface.points[np.unique(surface.facets)]
        box = np.stack([used.min(axis=0), used.max(axis=0)])
        sources.append(read_source_points(existing(Path(options.points)), box, plain.l_min / 2))
    return replace(plain, sources=np.concatenate([plain.sources, *sources]))


def read_front_sources(path: Path, l_min: float) -> np.ndarray:
    """Return the points (k, 3) of a front .csv, or points l_min / 2 apart on the fronts of a crack .vtp."""
    if path.suffix != ".vtp":
        return read_front_points(path)
    crack = read_crack(path)
    if not crack.fronts:
        raise CraftmeshError(f"{path}: the crack has no front inside the box; expected at least one")
    return np.concatenate([densify(crack.points[front], l_min / 2) for front in crack.fronts])
