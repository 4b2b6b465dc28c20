"""Make a synthetic polycrystal: Voronoi or Laguerre grains, a foam, voids, embedded grains."""

import argparse

import numpy as np

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.stage_io import add_output
from craftmesh.io.npz import write_labels
from craftmesh.voxels.generate import GenerateOptions, generate


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_output(parser, "labelled volume .npz (labels[x,y,z], spacing, origin, orientations)")
    add_options(parser, GenerateOptions)


def run(arguments: argparse.Namespace) -> None:
    options = options_from(arguments, GenerateOptions)
    voxels = generate(options)
    write_labels(arguments.output, voxels)
    print(_summary(options, voxels.labels))


def _summary(options: GenerateOptions, labels: np.ndarray) -> str:
    """Return in a line how many grains and voids there are, and what part of the box is material."""
    present = np.unique(labels)
    text = f"{(present > 0).sum()} grains, {(labels > 0).mean():.3f} of the box"
    asked = options.voids + len(options.void_list)
    if asked:
        enclosed = (present < 0).sum()
        text += f"; {enclosed} enclosed voids of {asked} balls: the others meet another or open to the air"
        text = text if enclosed < asked else text.partition(":")[0]
    return text
