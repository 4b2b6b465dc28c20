"""Check the invariants of any stage file: one line per breach and exit status 1; measure the mesh."""

import argparse
from pathlib import Path

from craftmesh.arguments import refuse_others
from craftmesh.commands.stage_io import add_file, of_suffix, warn
from craftmesh.errors import CraftmeshError, existing
from craftmesh.io.json_file import read_json, write_json
from craftmesh.types import Crack, Surface, TetMesh, Voxels


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", type=Path, help=f"a stage file: {', '.join(CHECKS)}")
    add_file(parser, "--labels", "labels .npz for the volume per grain")
    add_file(parser, "--quality", "write the mesh's measures to this .json")
    add_file(
        parser,
        "--meshing",
        "report .json of assemble or tetrahedralize; its part `meshing` goes into the measures",
    )


def run(arguments: argparse.Namespace) -> int:
    file, check_file = arguments.file, of_suffix(arguments.file, CHECKS)
    if arguments.quality and file.suffix != ".vtu":
        raise CraftmeshError(f"--quality measures a mesh .vtu; {file} is none")
    breaches = check_file(file, arguments)
    for breach in breaches:
        print(breach)
    return 1 if breaches else 0


def check(thing: Voxels | Crack | Surface | TetMesh) -> list[str]:
    """Return a sentence for each broken invariant of a volume, crack, surface or mesh."""
    from craftmesh.cracks.check_crack import check_crack
    from craftmesh.mesh.check_tets import check_tets
    from craftmesh.surface.check_surface import check_surface

    refuse_others("thing", thing, (Voxels, Crack, Surface, TetMesh))
    if isinstance(thing, Voxels):
        return [] if (thing.labels > 0).any() else ["no voxel belongs to a grain; expected labels > 0"]
    if isinstance(thing, Crack):
        return check_crack(thing)
    return check_surface(thing) if isinstance(thing, Surface) else check_tets(thing)


def check_mesh(file: Path, arguments: argparse.Namespace) -> list[str]:
    from craftmesh.io.mesh_formats import read_exodus
    from craftmesh.io.npz import read_labels
    from craftmesh.io.vtk import read_tets
    from craftmesh.mesh.shape_measures import flat_sentence, flat_tets

    mesh = read_tets(file) if file.suffix == ".vtu" else read_exodus(file)
    breaches = check(mesh)
    warn(flat_sentence(flat_tets(mesh)))
    if arguments.quality:
        from craftmesh.mesh.quality import drift_sentence, quality

        voxels = read_labels(existing(arguments.labels)) if arguments.labels else None
        meshing = {"meshing": read_json(arguments.meshing).get("meshing")} if arguments.meshing else {}
        measured = quality(mesh, voxels)
        write_json(arguments.quality, {"breaches": breaches} | measured | meshing)
        warn(drift_sentence(measured.get("volume_drift", {})))
    return breaches


def check_polygons(file: Path, _: argparse.Namespace) -> list[str]:
    """Check a surface or, where the file has no `sides`, a crack."""
    from craftmesh.io import vtk, vtk_xml

    is_surface = "sides" in vtk_xml.read_dataset(file, "PolyData").at_cells
    return check(vtk.read_surface(file) if is_surface else vtk.read_crack(file))


def check_volume(file: Path, _: argparse.Namespace) -> list[str]:
    from craftmesh.io.npz import read_labels
    from craftmesh.io.vtk import read_voxels

    voxels = read_voxels(file) if file.suffix == ".vti" else read_labels(file)
    return [f"{file}: {breach}" for breach in check(voxels)]


def check_arrays(file: Path, arguments: argparse.Namespace) -> list[str]:
    """Check a sizing or, where the file is none, a volume of labels."""
    from craftmesh.io.stage_npz import is_sizing

    if not is_sizing(file):
        return check_volume(file, arguments)
    from craftmesh.commands.mesh_flags import stored_sizing

    stored_sizing(file)
    return []


def check_islands(file: Path, _: argparse.Namespace) -> list[str]:
    from craftmesh.voxels.islands import islands_from_json

    islands_from_json(read_json(file), str(file))
    return []


def check_front(file: Path, _: argparse.Namespace) -> list[str]:
    from craftmesh.io.front_csv import read_front

    read_front(file)
    return []


def check_input_deck(file: Path, _: argparse.Namespace) -> list[str]:
    from craftmesh.deck.check_deck import check_deck

    return check_deck(file)


CHECKS = {
    ".vti": check_volume,
    ".npz": check_arrays,
    ".vtp": check_polygons,
    ".vtu": check_mesh,
    ".e": check_mesh,
    ".exo": check_mesh,
    ".inp": check_input_deck,
    ".json": check_islands,
    ".csv": check_front,
}
