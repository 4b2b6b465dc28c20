"""Flags and output files of the subcommands that write the mesh."""

import argparse

from craftmesh.assembly.assemble import assemble
from craftmesh.commands.mesh_flags import add_crack, add_front, add_sizing, given_crack
from craftmesh.commands.stage_io import add_file, add_report, tell, warn
from craftmesh.io.front_csv import write_front
from craftmesh.io.vtk import write_tets
from craftmesh.mesh.shape_measures import flat_sentence, flat_tets
from craftmesh.mesh.tet_connectivity import severed_sentence
from craftmesh.tetrahedra.volume import Volume
from craftmesh.types import TetMesh


def add_mesh_flags(parser: argparse.ArgumentParser) -> None:
    """Add the flags that `write_assembled` and `given_sizing` read."""
    add_file(parser, "--front-csv", "ordered front nodes with their frames")
    add_report(parser)
    add_front(parser)
    add_crack(parser, "that was inserted: it decides which components of the mesh crack count as one crack")
    add_sizing(parser)


def write_assembled(arguments: argparse.Namespace, volume: Volume, report: dict) -> None:
    """Assemble a volume's mesh; write it, its report and, with --front-csv, the ordered fronts.

    report: counts with which the report begins.
    """
    mesh, assembled = assemble(volume.surface, volume.grain_tets, given_crack(arguments))
    write_mesh(arguments, mesh, report | assembled | {"meshing": volume.record})


def write_mesh(arguments: argparse.Namespace, mesh: TetMesh, report: dict) -> None:
    """Write a mesh, its report and, if --front-csv names a file, the ordered fronts.

    Prints warnings on flat tetrahedra and severed bodies.
    """
    warn(flat_sentence(flat_tets(mesh)), severed_sentence(mesh))
    if arguments.front_csv is not None:
        from craftmesh.mesh.front_frames import front_frames
        from craftmesh.mesh.second_order import raise_order

        write_front(arguments.front_csv, front_frames(raise_order(mesh)).columns())
    write_tets(arguments.output, mesh)
    tell(report, arguments.report)
