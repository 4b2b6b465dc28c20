"""Make a synthetic polycrystal: Voronoi or Laguerre grains, a foam, voids, embedded grains."""

import argparse
from pathlib import Path

import numpy as np

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.mesh_flags import within_box
from craftmesh.commands.stage_io import add_output
from craftmesh.errors import CraftmeshError, existing
from craftmesh.io.npz import write_labels
from craftmesh.io.point_files import read_source_points
from craftmesh.voxels.generate import GenerateOptions, generate


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_output(parser, "labelled volume .npz (labels[x,y,z], spacing, origin, orientations)")
    add_options(parser, GenerateOptions)


def run(arguments: argparse.Namespace) -> None:
    options = options_from(arguments, GenerateOptions)
    voids = _voids(options)
    voxels = generate(options, voids)
    write_labels(arguments.output, voxels)
    print(_summary(options.voids + len(voids), voxels.labels))


def _voids(options: GenerateOptions) -> np.ndarray:
    """Return spheres (v, 4), centre and radius, from the file `options.voids_from`; (0, 4) without a file.

    Raises CraftmeshError for a file of points without radii, and if no sphere touches the box.
    """
    if options.voids_from is None:
        return np.zeros((0, 4))
    path = existing(Path(options.voids_from))
    given = read_source_points(path)
    if len(given.points):
        raise CraftmeshError(
            f"{path} has points without a radius; expected a table of voids with columns id, x, y, z, r"
        )
    return within_box(path, given, options.box)


def _summary(asked: int, labels: np.ndarray) -> str:
    """Return a line with the counts of grains and voids, and the fraction of the box that grains fill.

    asked: number of void spheres in the options and the file; labels (nx, ny, nz).
    """
    present = np.unique(labels)
    text = f"{(present > 0).sum()} grains, {(labels > 0).mean():.3f} of the box"
    if asked:
        enclosed = (present < 0).sum()
        text += f"; {enclosed} enclosed voids of {asked} balls: the others meet another or open to the air"
        text = text if enclosed < asked else text.partition(":")[0]
    return text
