"""Reading of labelled microstructures: one door for every format."""

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io import dream3d, labdct, npy, npz, tiff, vti
from craftmesh.io.file_volume import GRAIN, UNINDEXED, VOID, FileVolume, listed, table_rows
from craftmesh.io.hdf5 import opened
from craftmesh.options import Options, option
from craftmesh.types import Voxels
from craftmesh.voxels.raw_volume import RawVolume

AUTO = "auto"
FORMATS = (AUTO, "npz", "npy", "dream3d", "vti", "labdct", "tiff")
_LARGEST = np.iinfo(np.int32).max
_BY_SUFFIX = {".npz": "npz", ".npy": "npy", ".dream3d": "dream3d", ".vti": "vti"}
_BY_SUFFIX |= {suffix: "tiff" for suffix in tiff.SUFFIXES}
_ORIENTATION_MAPS = (".ang", ".ctf", ".h5oina", ".crc", ".osc")


@dataclass(frozen=True)
class ReadOptions(Options):
    """How a microstructure file is to be understood."""

    format: str = option(AUTO, "format of the file; auto: by its name and contents", choices=FORMATS)
    dataset: str = option(
        "", "array with the grain ids: entry, cell array or HDF5 path; empty: the usual one"
    )
    spacing: tuple[float, float, float] | None = option(
        None, "voxel spacing along x, y, z in place of the file's", "model units", above=0
    )
    origin: tuple[float, float, float] | None = option(
        None, "lower corner of the volume in place of the file's", "model units"
    )
    axes: str = option(
        "", "axis order of a .npy or .npz array", choices=("", "xyz", "xzy", "yxz", "yzx", "zxy", "zyx")
    )
    background: str = option(
        AUTO,
        "what the background value means; auto: unindexed, save in formats that say otherwise",
        choices=(AUTO, UNINDEXED, VOID, GRAIN),
    )
    background_value: int = option(0, "label that is the background")
    void_labels: tuple[int, ...] = option((), "labels that are voids: v becomes the void v, label -v")
    ignore_unknown_orientations: bool = option(
        False, "accept grains without an orientation in a file that has orientations"
    )


def read_voxels(path: str | os.PathLike, options: ReadOptions = ReadOptions()) -> RawVolume:  # noqa: B008
    """Read a labelled volume: npz, npy, DREAM.3D, vti, LabDCT .h5, or a TIFF stack (file or folder).

    Ids in the file are kept as grain ids; only where 0 is a grain every id goes up by 1 (in `remap` and
    `notes`). Raises CraftmeshError for what cannot be read or meshed: missing files or datasets, fewer than
    two voxels along an axis, ids that are no integers or over int32, undeclared negative ids, spacing <= 0.
    """
    path = Path(path)
    if not path.exists():
        raise CraftmeshError(f"{path}: no such file; check the path")
    content = _read_file(path, options)
    labels = _integer_labels(path, content.labels)
    spacing = _spacing(path, content, options)
    origin = next((v for v in (options.origin, content.origin) if v is not None), (0.0, 0.0, 0.0))
    if np.shape(origin) != (3,) or not np.isfinite(origin).all():
        raise CraftmeshError(f"{path}: origin is {np.asarray(origin).tolist()}; expected three numbers")
    ids = np.unique(labels)
    remap, unindexed_ids, notes = _assign(path, ids, content, options)
    new_ids = np.array([remap[v] for v in ids.tolist()], np.int32)
    relabelled = new_ids[np.searchsorted(ids, labels)]
    orientations = _table(path, content.orientations, remap)
    if orientations is not None and not options.ignore_unknown_orientations:
        _check_known(path, orientations, remap)
    phases = _table(path, content.phases, remap)
    voxels = Voxels(relabelled, spacing, origin, orientations, phases)
    return RawVolume(voxels, np.isin(labels, unindexed_ids), remap, content.notes + notes)


def _read_file(path: Path, options: ReadOptions) -> FileVolume:
    kind = _format(path) if options.format == AUTO else options.format
    if path.is_dir() and kind != "tiff":
        raise CraftmeshError(
            f"{path}: is a folder; expected a {kind} file, or format tiff for a folder of slices"
        )
    if kind == "npz":
        return npz.read(path, options.dataset, options.axes)
    if kind == "npy":
        return npy.read(path, options.axes)
    if kind == "tiff":
        return tiff.read(path)
    return {"dream3d": dream3d, "labdct": labdct, "vti": vti}[kind].read(path, options.dataset)


def _format(path: Path) -> str:
    suffix = path.suffix.lower()
    if path.is_dir():
        return "tiff"
    if suffix in _BY_SUFFIX:
        return _BY_SUFFIX[suffix]
    if suffix in _ORIENTATION_MAPS:
        raise CraftmeshError(
            f"{path}: is an orientation map without grain ids; segment it first (DREAM.3D, MTEX, orix)"
        )
    if suffix in (".h5", ".hdf5"):
        with opened(path) as file:
            for group, kind in (
                ("LabDCT", "labdct"),
                ("DataContainers", "dream3d"),
                ("DataStructure", "dream3d"),
            ):
                if group in file:
                    return kind
            raise CraftmeshError(
                f"{path}: has groups {listed(file)}; expected LabDCT, DataContainers or DataStructure"
            )
    raise CraftmeshError(
        f"{path}: format not known by its name; give format as one of {', '.join(FORMATS[1:])}"
    )


def _integer_labels(path: Path, labels: np.ndarray) -> np.ndarray:
    """Return the labels as int64; refuses empty or flat volumes and ids that are no int32."""
    shape = " x ".join(map(str, labels.shape))
    if labels.size == 0:
        raise CraftmeshError(
            f"{path}: the volume is empty ({shape} voxels); expected at least 2 along each axis"
        )
    if min(labels.shape) < 2:
        raise CraftmeshError(
            f"{path}: the volume has {shape} voxels; expected at least 2 along each axis, "
            "a slice one voxel thick cannot be meshed"
        )
    if labels.dtype.kind == "f":
        wrong = ~(labels == np.round(labels))
        if wrong.any():
            raise CraftmeshError(f"{path}: label {labels[wrong][0]} is not an integer; expected grain ids")
    elif labels.dtype.kind not in "iub":
        raise CraftmeshError(f"{path}: labels are of type {labels.dtype}; expected integers")
    low, high = labels.min(), labels.max()
    if high >= _LARGEST or low < -_LARGEST:
        raise CraftmeshError(
            f"{path}: labels run from {low} to {high}; expected ids below {_LARGEST} (int32), renumber them"
        )
    return labels.astype(np.int64)


def _spacing(path: Path, content: FileVolume, options: ReadOptions) -> np.ndarray:
    spacing = content.spacing if options.spacing is None else options.spacing
    if spacing is None:
        raise CraftmeshError(f"{path}: the format has no voxel spacing; give spacing as three lengths")
    spacing = np.asarray(spacing, float)
    if spacing.shape != (3,) or not (np.isfinite(spacing).all() and (spacing > 0).all()):
        raise CraftmeshError(f"{path}: spacing is {spacing.tolist()}; expected three lengths > 0")
    return spacing


def _assign(path, ids: np.ndarray, content: FileVolume, options: ReadOptions):
    """Return the remap of the file's ids, the ids that are unindexed, and notes for the report."""
    present = ids.tolist()
    absent = [v for v in options.void_labels if v not in present]
    if absent:
        raise CraftmeshError(f"{path}: void label {absent[0]} does not occur; labels are {listed(present)}")
    background = options.background
    if background == AUTO:
        background = content.zero if options.background_value == 0 else UNINDEXED
    empty = set(options.void_labels) | ({options.background_value} if background != GRAIN else set())
    voids = set(options.void_labels) - {0, options.background_value}
    if content.negative_voids:
        voids |= {v for v in present if v < 0}
    grains = [v for v in present if v not in empty | voids]
    if grains and grains[0] < 0:
        raise CraftmeshError(
            f"{path}: label {grains[0]} is negative; declare it by background_value or void_labels"
        )
    shift = 1 if 0 in grains else 0
    remap = {v: v + shift for v in grains} | {v: -abs(v) - shift for v in voids}
    remap = {v: remap.get(v, 0) for v in present}
    is_unindexed = background == UNINDEXED and options.background_value not in options.void_labels
    notes = ("label 0 is a grain: every id is the file's id + 1",) if shift else ()
    return remap, [options.background_value] if is_unindexed else [], notes


def _table(path, table: np.ndarray | None, remap: dict[int, int]) -> np.ndarray | None:
    """Return a table whose rows go by the file's ids with rows by grain id; rows that lack are NaN or 0."""
    if table is None:
        return None
    grains = [(old, new) for old, new in remap.items() if new > 0]
    size = table_rows(path, np.array([new for _, new in grains], np.int64))
    made = np.full((size, *table.shape[1:]), np.nan if table.dtype.kind == "f" else 0, table.dtype)
    old, new = (np.array(column, np.int64) for column in zip(*grains)) if grains else ([], [])
    has_row = np.asarray(old) < len(table)
    made[np.asarray(new)[has_row]] = table[np.asarray(old)[has_row]]
    return made


def _check_known(path, orientations: np.ndarray, remap: dict[int, int]) -> None:
    unknown = [old for old, new in remap.items() if new > 0 and not np.isfinite(orientations[new]).all()]
    if unknown:
        raise CraftmeshError(
            f"{path}: no orientation for grains {listed(unknown)}; "
            "complete them or set ignore_unknown_orientations"
        )
