"""Make a synthetic polycrystal: columnar Voronoi or Laguerre grains with voids and embedded grains."""

import argparse

from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.stage_io import add_output
from craftmesh.io.npz import write_labels
from craftmesh.voxels.generate import GenerateOptions, generate


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_output(parser, "labelled volume .npz (labels[x,y,z], spacing, origin, orientations)")
    add_options(parser, GenerateOptions)


def run(arguments: argparse.Namespace) -> None:
    write_labels(arguments.output, generate(options_from(arguments, GenerateOptions)))
