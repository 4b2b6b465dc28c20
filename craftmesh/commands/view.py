"""Show a microstructure or a stage file as a picture, without a screen."""

import argparse
from itertools import chain
from pathlib import Path

import numpy as np

from craftmesh.atomic import atomic_path
from craftmesh.commands.flags import add_options, options_from
from craftmesh.commands.stage_io import of_suffix
from craftmesh.errors import CraftmeshError, existing
from craftmesh.extras import extra
from craftmesh.io.volume_format import SUFFIXES
from craftmesh.mesh.mesh_sets import is_lip
from craftmesh.voxels.reading import ReadOptions, read_voxels


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "file", type=Path, help=f"file, or folder of TIFF slices: {', '.join([*VOLUMES, *VIEWS])}"
    )
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="picture .png (default: the file's name and .png)"
    )
    add_options(parser, ReadOptions)


def run(arguments: argparse.Namespace) -> None:
    file, options = arguments.file, options_from(arguments, ReadOptions)
    is_volume = file.is_dir() or options != ReadOptions() or file.suffix.lower() in VOLUMES
    output = arguments.output or file.with_name(f"{file.name}.png")
    picture = view_labels(file, options) if is_volume else of_suffix(file, VIEWS)(file)
    with atomic_path(output) as temporary:
        temporary.write_bytes(picture)
    print(f"wrote {output}")


def view_arrays(file: Path) -> bytes:
    """Return a picture of labels or of a sizing, as the bytes of a .png.

    Raises CraftmeshError for files that refer to a mesh in another file, and for a sizing without sources.
    """
    from craftmesh.io.npz import load
    from craftmesh.io.stage_npz import is_sizing
    from craftmesh.report.views import lengths_picture

    if is_sizing(file):
        from craftmesh.commands.mesh_flags import stored_sizing

        sizing = stored_sizing(file)
        if not len(sizing.sources):
            raise CraftmeshError(
                f"{file}: has no sources, so all lengths are {sizing.l_max:g}; give a sizing with a front"
            )
        reach = np.full(3, sizing.r1)
        box = np.stack([sizing.sources.min(axis=0) - reach, sizing.sources.max(axis=0) + reach])
        return lengths_picture(sizing, sizing.sources, box)
    arrays = load(file)
    if {"displacement", "counts"} & arrays.keys():
        other = "solution.vtu" if "displacement" in arrays else "volume.vtu"
        raise CraftmeshError(f"{file}: refers to a mesh that it does not contain; view {other} instead")
    return view_labels(file)


def view_labels(file: Path, options: ReadOptions = ReadOptions()) -> bytes:  # noqa: B008
    from craftmesh.report.notebook import picture

    try:
        voxels = read_voxels(file, options).voxels
    except CraftmeshError:
        # If the meaning of label 0 is unknown, reading fails. With fills=True label 0 counts as unindexed,
        # so reading succeeds, and these voxels stay blank.
        voxels = read_voxels(file, options, fills=True).voxels
    return picture(voxels)


def view_polygons(file: Path) -> bytes:
    """Return a picture of a surface or, if the file has no `sides`, of a crack."""
    from craftmesh.io.vtk import read_polygons
    from craftmesh.report.notebook import picture

    return picture(read_polygons(file))


def view_mesh(file: Path) -> bytes:
    """Return a picture of tetrahedra or, if the file has displacements, of the deformed body."""
    from craftmesh.io import vtk, vtk_xml

    grid = vtk_xml.read_dataset(file, "UnstructuredGrid")
    if "displacement" in grid.at_points:
        from craftmesh.mesh.tet_connectivity import free_half_faces, half_face_corners
        from craftmesh.report.pictures import as_png, deformed_body

        points, tets = grid.points, grid.elements(file)[:, :4]
        # A solution has several points at a node that grains share; the first represents all of them.
        _, first, inverse = np.unique(points, axis=0, return_index=True, return_inverse=True)
        free = free_half_faces(first[inverse.ravel()][tets])
        moved = grid.at_points["displacement"]
        return as_png(deformed_body(points, half_face_corners(tets, free), moved))
    from craftmesh.report.notebook import picture

    return picture(vtk.read_tets(file))


def view_deck(file: Path) -> bytes:
    with extra("formats"):
        import meshio
    from craftmesh.report.views import tets_picture

    try:
        deck = meshio.read(file, file_format="abaqus")
    except (meshio.ReadError, ValueError, KeyError, OSError) as error:
        raise CraftmeshError(f"{file}: cannot be read as a deck ({error}); run craftmesh check") from None
    blocks = [block.data for block in deck.cells if block.type in ("tetra", "tetra10")]
    if not blocks:
        raise CraftmeshError(f"{file}: has no C3D4 or C3D10 elements; expected a deck of craftmesh")
    grain = np.repeat(np.arange(1, len(blocks) + 1), [len(data) for data in blocks])
    lips = [np.asarray(nodes) for name, nodes in deck.point_sets.items() if is_lip(name)]
    tets = np.concatenate([data[:, :4] for data in blocks])
    return tets_picture(deck.points, tets, grain, np.concatenate([np.zeros(0, np.int64), *lips]))


def view_front(file: Path) -> bytes:
    """Return a picture of K along the fronts of a sif.csv, or of the fronts if there is no K."""
    from craftmesh.io.front_csv import read_fronts
    from craftmesh.report.case_files import front_with_flags

    columns = front_with_flags(existing(file))
    if columns and "K_I" in columns:
        from craftmesh.report.charts import along_front
        from craftmesh.report.pictures import as_png

        return as_png(*along_front({file.parent.name: columns}))
    from craftmesh.report.views import fronts_picture

    return fronts_picture(read_fronts(file))


VOLUMES = [".h5", ".hdf5", *chain.from_iterable(SUFFIXES.values())]
VOLUMES.remove(".npz")  # stages write it, too
VIEWS = {
    ".npz": view_arrays,
    ".vtp": view_polygons,
    ".vtu": view_mesh,
    ".inp": view_deck,
    ".csv": view_front,
}
