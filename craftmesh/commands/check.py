"""Check the invariants of any stage file: print a line per breach, exit with 1; measure a mesh."""

import argparse
from pathlib import Path

from craftmesh.commands.stage_io import add_file, of_suffix, warn
from craftmesh.errors import CraftmeshError, existing
from craftmesh.io.json_file import read_json, write_json


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", type=Path, help=f"a stage file: {', '.join(CHECKS)}")
    add_file(parser, "--labels", "labels .npz for the volume per grain")
    add_file(parser, "--quality", "write the mesh's measures to this .json")
    add_file(
        parser,
        "--meshing",
        "report .json of assemble, tetrahedralize or renew; its parts `meshing` and `renewed` go into the "
        "measures",
    )


def run(arguments: argparse.Namespace) -> int:
    file, check_file = arguments.file, of_suffix(arguments.file, CHECKS)
    if arguments.quality and file.suffix != ".vtu":
        raise CraftmeshError(f"--quality measures a mesh .vtu, but the file is {file}; remove --quality")
    breaches = check_file(file, arguments)
    for breach in breaches:
        print(breach)
    return 1 if breaches else 0


def _mesh(file: Path, arguments: argparse.Namespace) -> list[str]:
    from craftmesh.io.mesh_formats import read_exodus
    from craftmesh.io.npz import read_labels
    from craftmesh.io.vtk import read_tets
    from craftmesh.mesh.check import check
    from craftmesh.mesh.shape_measures import flat_sentence, flat_tets

    mesh = read_tets(file) if file.suffix == ".vtu" else read_exodus(file)
    breaches = check(mesh)
    warn(flat_sentence(flat_tets(mesh)))
    if arguments.quality:
        from craftmesh.mesh.quality import drift_sentence, quality

        voxels = read_labels(existing(arguments.labels)) if arguments.labels else None
        told = read_json(arguments.meshing) if arguments.meshing else {}
        meshing = {key: told[key] for key in ("meshing", "renewed") if key in told}
        measured = quality(mesh, voxels)
        write_json(arguments.quality, {"breaches": breaches} | measured | meshing)
        warn(drift_sentence(measured.get("volume_drift", {})))
    return breaches


def _volume_or_surface(file: Path, _: argparse.Namespace) -> list[str]:
    """Return the breaches of invariants of labels, a surface or a crack; a sizing is only read: []."""
    from craftmesh.io.stage_npz import is_sizing
    from craftmesh.io.vtk import read_body, read_polygons
    from craftmesh.mesh.check import check

    if file.suffix == ".vtp":
        return check(read_polygons(file))
    if file.suffix != ".npz" or not is_sizing(file):
        return [f"{file}: {breach}" for breach in check(read_body(file))]
    from craftmesh.commands.mesh_flags import stored_sizing

    stored_sizing(file)
    return []


def _text(file: Path, _: argparse.Namespace) -> list[str]:
    """Return the breaches of an input deck; files of islands and fronts are only read: []."""
    from craftmesh.deck.check_deck import check_deck
    from craftmesh.io.front_csv import read_front
    from craftmesh.voxels.islands import islands_from_json

    if file.suffix == ".inp":
        return check_deck(file)
    if file.suffix == ".csv":
        read_front(file)
    else:
        islands_from_json(read_json(file), str(file))
    return []


CHECKS = dict.fromkeys((".vti", ".npz", ".vtp"), _volume_or_surface)
CHECKS |= dict.fromkeys((".vtu", ".e", ".exo"), _mesh) | dict.fromkeys((".inp", ".json", ".csv"), _text)
