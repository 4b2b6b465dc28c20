"""Reading of labelled microstructures in any format."""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from craftmesh.arguments import as_array
from craftmesh.errors import CraftmeshError, existing, listed, named
from craftmesh.io.file_volume import UNSAID, FileVolume
from craftmesh.io.header_checks import enough_memory
from craftmesh.io.metaimage_nrrd import read_metaimage, read_nrrd
from craftmesh.io.npz import read_npy, read_npz
from craftmesh.io.tesr import read_tesr
from craftmesh.io.tiff import read_tiff
from craftmesh.io.volume_format import AUTO, format_of
from craftmesh.io.vti import read_vti
from craftmesh.options import Options, option
from craftmesh.surface.side_data import place_beside
from craftmesh.types import UNINDEXED, Voxels
from craftmesh.voxels.background import background_shown
from craftmesh.voxels.file_orientations import orientation_table, quaternions_of_voxels
from craftmesh.voxels.remapping import (
    Meaning,
    RawVolume,
    by_grain,
    integer_labels,
    phase_table,
    phases_by_voxels,
    refuse_scattered,
    rename,
)

Format = Literal["auto", "npz", "npy", "dream3d", "vti", "labdct", "tiff", "tesr", "metaimage", "nrrd"]


@dataclass(frozen=True)
class ReadOptions(Options):
    """How a microstructure file is read."""

    format: Format = option(AUTO, "format of the file; auto: by its name and content")
    dataset: str = option(
        "", "array of the grain ids: entry name, cell array or HDF5 path; empty: the format's usual name"
    )
    spacing: tuple[float, float, float] | None = option(
        None, "voxel spacing along x, y, z instead of the file's", "model units", above=0
    )
    origin: tuple[float, float, float] | None = option(
        None, "lower corner of the volume instead of the file's", "model units"
    )
    axes: Literal["", "xyz", "xzy", "yxz", "yzx", "zxy", "zyx"] = option(
        "", "axis order of a .npy or .npz array"
    )
    background: Literal["auto", "unindexed", "void", "grain"] = option(
        AUTO,
        "meaning of background_value; auto: as the format defines it, else found from the volume",
    )
    background_value: int = option(0, "label of the background")
    void_labels: tuple[int, ...] = option((), "labels of voids: v becomes void v, with the label -v")
    table: str = option("", "HDF5 array or group with the grains' orientations and phases, if several fit")
    angles: Literal["auto", "degrees", "radians"] = option(
        AUTO,
        "unit of the file's Euler angles; auto: as the file states, else from their range",
    )
    ignore_unknown_orientations: bool = option(
        False, "accept grains without an orientation, if others in the file have one"
    )
    voxel_orientations: bool = option(
        False, "keep the orientations of voxels in addition to the grains' means, for inp.orientations"
    )


@np.errstate(all="ignore")  # checks below reject values that are not numbers
def read_voxels(
    path: str | os.PathLike,
    options: ReadOptions = ReadOptions(),  # noqa: B008
    fills: bool = False,
) -> RawVolume:
    """Read a labelled volume in one of the formats of `Format`; a TIFF stack is a file or a folder.

    Ids in the file are kept as grain ids; only if 0 is a grain, every id increases by 1, which `remap` and
    `notes` say. fills: whether the user sets fill_unindexed; then 0 is unindexed if the format does not
    define it, else `background_shown` finds its meaning. Raises CraftmeshError for files that cannot be
    read or meshed: missing files or datasets, fewer than two voxels along an axis, ids that are not
    integers or exceed int32, undeclared negative ids, spacing <= 0, and an ambiguous label 0.
    """
    path = existing(Path(path))
    with enough_memory(path):
        return _understood(path, _read_file(path, options), options, fills)


def _understood(path: Path, content: FileVolume, options: ReadOptions, fills: bool) -> RawVolume:
    """Return a file's content with labels renamed (`rename`), and orientations and phases by grain.

    Renamed labels are > 0 for grains and < 0 for voids. fills: whether the user sets fill_unindexed; then
    label 0 is unindexed if neither the options nor the format tell its meaning.
    """
    labels = integer_labels(path, content.labels)
    refuse_scattered(path, content.name, labels)
    spacing = _spacing(path, content, options)
    origin = _origin(path, content, options)
    with named(path):
        meaning, background = _meaning(content, labels, options, fills)
    renaming = rename(path, np.unique(labels), meaning)
    renamed = renaming.renamed(labels)
    unit = "" if options.angles == AUTO else options.angles
    table, notes = orientation_table(path, content.orientations, labels, renamed > 0, unit)
    kept = quaternions_of_voxels(path, content.orientations, unit) if options.voxel_orientations else None
    orientations = by_grain(path, table, renaming.remap)
    if orientations is not None and not options.ignore_unknown_orientations:
        grains = [(old, new) for old, new in renaming.remap.items() if new > 0]
        unknown = [old for old, new in grains if not np.isfinite(orientations[new]).all()]
        if unknown:
            raise CraftmeshError(
                f"{path}: no orientation for grains {listed(unknown)}; "
                "complete them or set ignore_unknown_orientations"
            )
    phases = content.phases
    if phases is not None and phases.ndim == 3:
        phases, more_notes = phases_by_voxels(path, phases, labels, renamed > 0)
        notes += more_notes
    phases = by_grain(path, phase_table(path, phases, renaming.remap), renaming.remap)
    voxels = Voxels(renamed, spacing, origin, orientations, phases, content.crystals, kept)
    notes = content.notes + notes + background + renaming.notes
    taken = meaning.background if background else ""
    return RawVolume(voxels, np.isin(labels, renaming.unindexed), renaming.remap, notes, taken)


@np.errstate(all="ignore")
def read_marked(
    path: str | os.PathLike, label: int | None, grid: Voxels | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[str]]:
    """Return a mask (nx, ny, nz) of a file's voxels with a label, their spacing and origin, and notes.

    label: None for any label except 0; grid: volume of the model, whose grid `place_beside` gives to an
    array of the same shape. The formats are those of `read_voxels`; a .npy has axes x, y, z. Raises
    CraftmeshError as these functions do, and if no voxel has the label.
    """
    path = existing(Path(path))
    with enough_memory(path):
        content = _read_file(path, ReadOptions(axes="xyz" if path.suffix.lower() == ".npy" else ""))
    marked = content.labels != 0 if label is None else content.labels == label
    if not marked.any():
        missing = "other than 0" if label is None else label
        raise CraftmeshError(f"{path}: no voxel has a label {missing}; set label to the crack's")
    known = ReadOptions()
    if grid is None:
        return marked, _spacing(path, content, known), _origin(path, content, known), []
    spacing = None if content.spacing is None else _spacing(path, content, known)
    with named(path):
        return marked, *place_beside(marked, spacing, _origin(path, content, known), grid)


def _read_file(path: Path, options: ReadOptions) -> FileVolume:
    kind = format_of(path) if options.format == AUTO else options.format
    if path.is_dir() and kind != "tiff":
        raise CraftmeshError(
            f"{path}: is a folder; give a {kind} file, or set format to tiff for a folder of slices"
        )
    plain = {"tiff": read_tiff, "tesr": read_tesr, "metaimage": read_metaimage, "nrrd": read_nrrd}
    if kind in plain:
        return plain[kind](path)
    if kind == "npz":
        return read_npz(path, options.dataset, options.axes)
    if kind == "npy":
        return read_npy(path, options.axes)
    if kind == "vti":
        return read_vti(path, options.dataset)
    from craftmesh.io.hdf5_volumes import (
        read_dream3d,
        read_labdct,
    )  # here because the import of h5py is slow

    if kind == "dream3d":
        return read_dream3d(path, options.dataset, options.table)
    return read_labdct(path, options.dataset)


def _spacing(path: Path, content: FileVolume, options: ReadOptions) -> np.ndarray:
    """Return the voxel spacing (3,) of the options, else of the file; CraftmeshError if none or not > 0."""
    spacing = content.spacing if options.spacing is None else options.spacing
    if spacing is None:
        raise CraftmeshError(
            f"{path}: has no voxel spacing; set spacing to three lengths, --spacing DX DY DZ"
        )
    spacing = as_array(f"{path}: spacing", spacing, float, (3,))
    if not (spacing**3 > np.finfo(float).tiny).all():  # voxel volumes must not underflow
        raise CraftmeshError(
            f"{path}: spacing is {spacing.tolist()}; expected three lengths > 0, "
            "not so small that volumes underflow"
        )
    return spacing


def _meaning(
    content: FileVolume, labels: np.ndarray, options: ReadOptions, fills: bool
) -> tuple[Meaning, tuple[str, ...]]:
    """Return the meaning of labels (nx, ny, nz), and a note if that of 0 was found from the volume."""
    notes: tuple[str, ...] = ()
    background: str = options.background
    if background == AUTO:
        background = content.zero if options.background_value == 0 else UNINDEXED
    if background == UNSAID:
        ids = set(np.unique(labels).tolist()) - set(options.void_labels)
        has_zero = 0 in ids and min(ids) == 0  # negative ids are reported first
        tables = [rotations.values for rotations in content.orientations.values()]
        tables += [] if content.phases is None else [content.phases[..., None]]
        tables = [table for table in tables if table.dtype.kind in "iuf" and table.ndim in (2, 4)]
        background, notes = background_shown(labels, tables, fills) if has_zero else (UNINDEXED, ())
    return Meaning(background, options.background_value, options.void_labels, content.negative_voids), notes


def _origin(path: Path, content: FileVolume, options: ReadOptions) -> np.ndarray:
    given = next((v for v in (options.origin, content.origin) if v is not None), (0.0, 0.0, 0.0))
    return as_array(f"{path}: origin", given, float, (3,))
