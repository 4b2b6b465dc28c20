"""Merge the grains' tetrahedra by surface node and open the crack.

Where grains are left without tetrahedra, or with mesher tetwild, the whole model is meshed here; last,
points slide within the surface, which --no-optimise omits: give the same sizes and options as to
tetrahedralize.
"""

import argparse
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from craftmesh.assembly.assemble import assemble, refuse_other_surface
from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.mesh_flags import (
    add_mesh_flags,
    check_sizing,
    given_crack,
    given_sizing,
    write_mesh,
)
from craftmesh.commands.stage_io import add_output, warn
from craftmesh.io.stage_npz import read_grain_tets, read_record
from craftmesh.io.vtk import read_surface
from craftmesh.mesh.shape_measures import flat_sentence, flat_tets
from craftmesh.mesh.tet_connectivity import severed_sentence
from craftmesh.progress import ProgressLine
from craftmesh.sizing.sizing import Lengths
from craftmesh.surface.repair import repair_surface
from craftmesh.tetrahedra.fallback import Completion, completed
from craftmesh.tetrahedra.flat_places import given_way
from craftmesh.tetrahedra.options import TetrahedralizeOptions
from craftmesh.tetrahedra.record import merged, with_counts
from craftmesh.tetrahedra.whole_optimisation import optimised_whole
from craftmesh.types import Crack, GrainTets, Surface, TetMesh


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("surface", type=Path, help="the gradated surface .vtp that was tetrahedralized")
    parser.add_argument("chunks", type=Path, nargs="+", metavar="CHUNK", help="chunks of grains .npz")
    add_output(parser, "mesh .vtu with the crack opened")
    add_mesh_flags(parser)
    add_options(parser, TetrahedralizeOptions)


def run(arguments: argparse.Namespace) -> None:
    check_sizing(arguments)
    surface = read_surface(arguments.surface)
    grain_tets = [grain for chunk in arguments.chunks for grain in read_grain_tets(chunk)]
    record = merged([read_record(chunk) for chunk in arguments.chunks])
    if record.get("repair"):
        surface, _ = repair_surface(surface)
    options, crack = options_from(arguments, TetrahedralizeOptions), given_crack(arguments)
    sizing = partial(given_sizing, arguments, surface)
    write_mesh(arguments, *complete_mesh(surface, grain_tets, record, sizing, options, crack))


def complete_mesh(
    surface: Surface,
    grain_tets: Sequence[GrainTets],
    record: dict,
    sizing_of: Callable[[], Lengths | None],
    options: TetrahedralizeOptions,
    crack: Crack | None = None,
) -> tuple[TetMesh, dict]:
    """Return the assembled mesh and its report, with the record under `meshing`.

    crack: the given one, which tells what is one crack, see assemble.
    """
    refuse_other_surface(surface, grain_tets)
    with ProgressLine("whole model") as progress:
        whole = completed(Completion(surface, grain_tets), record, sizing_of, options, progress)
    warn(whole.warning)
    opened = given_way(whole.surface, whole.grain_tets)
    warn(opened.warning)
    surface, grain_tets, poor, smooth = opened.surface, opened.grain_tets, opened.poor, None
    if options.optimise:
        smoothed = optimised_whole(surface, grain_tets)
        surface, grain_tets, smooth = smoothed.surface, smoothed.grain_tets, smoothed.report
        poor = dict.fromkeys(record.get("poor", {}) | poor, []) | smoothed.poor
    mesh, report = assemble(surface, grain_tets, crack)
    warn(flat_sentence(flat_tets(mesh)))
    warn(severed_sentence(mesh))
    meshing = with_counts(record, whole.whole_model, opened.report, smooth, poor)
    return mesh, report | {"meshing": meshing}
