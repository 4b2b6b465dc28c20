"""Put tables, histograms and pictures of all increments on one self-contained html page."""

import argparse
from pathlib import Path

from craftmesh.commands.stage_io import add_output, existing, read_json
from craftmesh.io.front_csv import read_front
from craftmesh.io.solution import read_solution, read_solution_vtu
from craftmesh.io.vtk import read_crack, read_tets
from craftmesh.report.growth import SolvedMesh, growth_pictures
from craftmesh.report.outcome import increment_numbers, outcome
from craftmesh.report.page import GrowingCase, write_report


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "quality", type=Path, nargs="+", metavar="QUALITY", help="files case/increment/quality.json"
    )
    parser.add_argument(
        "--sif",
        type=Path,
        nargs="*",
        default=[],
        metavar="FILE",
        help="files case/increment/sif.csv, beside the increments' others, of cases to show pictures of",
    )
    parser.add_argument(
        "--growth",
        type=Path,
        nargs="*",
        default=[],
        metavar="FILE",
        help="files case/increment/growth.json of the increments after which those cracks grow or stop",
    )
    add_output(parser, "page .html")


def run(arguments: argparse.Namespace) -> None:
    rows = [(path.parent.parent.name, path.parent.name, read_json(path)) for path in arguments.quality]
    folders: dict[str, list[Path]] = {}
    for path in arguments.sif:
        folders.setdefault(path.parent.parent.name, []).append(existing(path).parent)
    growths = {path.parent: read_json(path) for path in arguments.growth}
    write_report(
        arguments.output, rows, {case: _growing(found, growths) for case, found in folders.items()}
    )


def _growing(increments: list[Path], growths: dict[Path, dict]) -> GrowingCase:
    """Return what is shown of a case from the folders of its increments, in order, and its growth.json."""
    cracks = {folder.name: read_crack(existing(folder / "crack.vtp")) for folder in increments}
    rows = {folder.name: read_front(folder / "sif.csv") for folder in increments}
    last = increments[-1]
    points, elements, stress = read_solution_vtu(existing(last / "solution.vtu"))
    mesh = read_tets(existing(last / "volume.vtu"))
    solution = read_solution(existing(last / "solution.npz"))
    known = {folder.name: growths[folder] for folder in increments if folder in growths}
    numbers = {name: increment_numbers(rows[name], known.get(name)) for name in cracks}
    pictures = growth_pictures(cracks, rows, SolvedMesh(mesh, solution, points, elements[:, :4], stress))
    return GrowingCase(outcome(known, len(increments)), numbers, pictures)
