"""Draw an increment for the report: grains, element sizes, crack, new elements, and the 3-D scene."""

import argparse
import json
from pathlib import Path

from craftmesh.atomic import atomic_folder
from craftmesh.commands.stage_io import add_file, add_units
from craftmesh.errors import existing
from craftmesh.io.stage_npz import read_solution, read_solution_vtu
from craftmesh.io.vtk import read_tets
from craftmesh.mechanics.units import UnitsOptions
from craftmesh.mesh.mesh_sets import NEW
from craftmesh.report.mesh_pictures import SolvedMesh, mesh_pictures, opened_body, solved_pictures
from craftmesh.report.pictures import as_svg, as_webp
from craftmesh.report.shown_mesh import scene, shown_mesh


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("volume", type=Path, help="mesh .vtu of an increment")
    add_file(parser, "--solution", "solution.npz, with its .vtu next to it: also draw the deformed body")
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="FOLDER", help="folder for the pictures"
    )
    add_units(parser, "the units in the pictures")


def run(arguments: argparse.Namespace) -> None:
    units = UnitsOptions(*arguments.units)
    mesh = read_tets(existing(arguments.volume))
    shown = shown_mesh(mesh)
    pictures = mesh_pictures(shown, units.length, mesh.element_sets.get(NEW))
    if arguments.solution:
        solution = read_solution(existing(arguments.solution))
        points, elements, stress, slip = read_solution_vtu(existing(arguments.solution.with_suffix(".vtu")))
        solved = SolvedMesh(mesh, solution, points, elements[:, :4], stress, slip)
        pictures |= solved_pictures(solved, shown, units)
    with atomic_folder(arguments.output) as folder:
        for name, picture in pictures.items():
            (folder / f"{name}.svg").write_text(as_svg(picture), encoding="utf-8")
        (folder / "opened.webp").write_bytes(as_webp(opened_body(shown)))
        text = json.dumps(scene(shown), separators=(",", ":"))
        (folder / "scene.json").write_text(text, encoding="utf-8")
