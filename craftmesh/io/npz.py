"""NumPy files: labels.npz of a case, written and read exactly, and volumes in users' .npz and .npy."""

import lzma
import os
import zipfile
import zlib
from collections.abc import Collection, Iterable, Mapping
from io import BytesIO
from pathlib import Path
from tokenize import TokenError
from typing import IO

import numpy as np

from craftmesh.atomic import atomic_path
from craftmesh.errors import CraftmeshError, existing
from craftmesh.io.file_volume import (
    EULERS,
    QUATERNIONS,
    RODRIGUES,
    UNSAID,
    FileVolume,
    Rotations,
    is_described,
    is_eulers,
    is_phases,
    left_unread,
    pick,
    to_xyz,
    unit_said,
)
from craftmesh.io.header_checks import refuse_false_size, refuse_false_zip
from craftmesh.types import VOID, Crystal, Voxels

# Value of the entry `format`. In this format label 0 is the outside, and -k the void k.
FORMAT = "craftmesh labels 1"
_OPTIONAL = ("orientations", "phases", "voxel_orientations")
# Exceptions that numpy, zipfile and their decoders raise for a damaged file.
BROKEN = (ValueError, OSError, EOFError, AttributeError, TypeError, RuntimeError, ArithmeticError) + (
    zipfile.BadZipFile,
    zlib.error,
    lzma.LZMAError,
)
_EPOCH = (1980, 1, 1, 0, 0, 0)  # date of all entries, so that the same arrays give the same bytes


def write_labels(path: str | os.PathLike, voxels: Voxels) -> None:
    """Write labels, their number of faces, spacing, origin and known properties of grains to an .npz.

    The same voxels give the same bytes. The file is written completely or not at all. Raises CraftmeshError
    if it cannot be written.
    """
    arrays = {"format": np.array(FORMAT), "labels": voxels.labels, "faces": np.array(voxels.faces)}
    arrays |= {"spacing": voxels.spacing, "origin": voxels.origin}
    optional = {name: getattr(voxels, name) for name in _OPTIONAL}
    arrays |= {name: values for name, values in optional.items() if values is not None}
    if voxels.crystals:
        rows = [[str(phase), *crystal] for phase, crystal in voxels.crystals.items()]
        arrays["crystals"] = np.array(rows, str)
    write_arrays(path, arrays)


def write_arrays(path: str | os.PathLike, arrays: Mapping[str, np.ndarray]) -> None:
    """Write arrays to a compressed .npz, completely or not at all; the same arrays give the same bytes."""
    with atomic_path(path) as temporary, zipfile.ZipFile(temporary, "w") as archive:
        for name, values in arrays.items():
            entry = zipfile.ZipInfo(f"{name}.npy", _EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            content = BytesIO()
            np.lib.format.write_array(content, np.asarray(values, order="C"), allow_pickle=False)
            archive.writestr(entry, content.getbuffer(), compresslevel=6)


def read_labels(path: str | os.PathLike) -> Voxels:
    """Return the voxels in an .npz of `write_labels`; raises CraftmeshError for a missing file or entry."""
    arrays = load(path)
    refuse_missing(path, arrays, ("labels", "spacing", "origin"), "a labels.npz made by craftmesh")
    place = arrays["labels"], arrays["spacing"], arrays["origin"]
    orientations, phases, of_voxels = (arrays.get(name) for name in _OPTIONAL)
    return Voxels(*place, orientations, phases, _crystals(path, arrays), of_voxels)


def read_crystals(path: str | os.PathLike) -> dict[int, Crystal]:
    """Return the crystals by phase in an .npz of `write_labels`, without reading its labels.

    Raises CraftmeshError for malformed crystals and as `load`.
    """
    return _crystals(path, load(path, ["crystals"]))


def read_npz(path: str | os.PathLike, dataset: str, axes: str) -> FileVolume:
    """Read `labels` (or `dataset`), spacing, origin, orientations and phases from an .npz.

    axes: axis order such as "zyx"; empty: the file's entry `axes`, or else xyz. Orientations come from the
    entries `orientations` (quaternions), `rodrigues`, and those with Euler (Bunge's angles) in their name.
    Orientations and `phases` are tables, row = grain id, or arrays of voxels with the labels' axes. Raises
    CraftmeshError for a damaged file, for no unique volume of labels, and for other axes.
    """
    arrays = load(path)
    volumes = [k for k, values in arrays.items() if values.ndim == 3 or k in ("labels", dataset)]
    name = pick(path, dataset, volumes, ("labels",))
    axes = axes or str(arrays.get("axes", "xyz"))
    if sorted(axes) != list("xyz"):
        raise CraftmeshError(f"{path}: axes is {axes!r}; write x, y and z in the file's order, such as zyx")
    is_ours = str(arrays.get("format", "")) == FORMAT
    notes = () if "spacing" in arrays else ("the file has no spacing, so one voxel is one unit of length",)
    labels = to_xyz(arrays.pop(name), axes, f"{path}: {name}")
    orientations = _orientations(arrays, axes, labels.size)  # not flat lists, whose order is unknown
    key = next((k for k in ("phases", *arrays) if k in arrays and is_phases(k)), "")
    phases = None if arrays.get(key, labels).shape == (labels.size,) else arrays.get(key)
    if phases is not None and phases.ndim == 3:
        phases = to_xyz(phases, axes, f"{path}: {key}")
    read = (*orientations, "" if phases is None else key)
    unread = [k for k, values in arrays.items() if values.ndim and is_described(k) and k not in read]
    return FileVolume(
        labels,
        arrays.get("spacing", np.ones(3)),
        arrays.get("origin"),
        orientations,
        phases,
        _crystals(path, arrays) if is_ours else {},
        VOID if is_ours else UNSAID,
        negative_voids=is_ours,
        notes=notes + left_unread(unread),
        name=name,
    )


def _orientations(arrays: Mapping[str, np.ndarray], axes: str, voxels: int) -> dict[str, Rotations]:
    """Return orientations of grains or voxels by entry name.

    axes: axis order of the file; voxels: the number of voxels. A list with a row per voxel is left out,
    because the order of its rows is unknown.
    """
    kinds = {"orientations": QUATERNIONS, "rodrigues": RODRIGUES}
    kinds |= {key: EULERS for key, values in arrays.items() if is_eulers(key) and values.shape[-1:] == (3,)}
    words = [f"{key} {values}" for key, values in arrays.items() if is_eulers(key) and not values.ndim]
    found = {}
    for key, kind in kinds.items():
        values = arrays.get(key)
        if values is None or values.ndim == 2 and len(values) == voxels:
            continue
        if values.ndim == 4:
            values = values.transpose([*(axes.index(axis) for axis in "xyz"), 3])
        found[key] = Rotations(kind, values, unit_said(key, *words) if kind == EULERS else "")
    return found


def _crystals(path: str | os.PathLike, arrays: Mapping[str, np.ndarray]) -> dict[int, Crystal]:
    try:
        rows = arrays["crystals"].tolist() if "crystals" in arrays else []
        return {int(phase): Crystal(structure, name) for phase, structure, name in rows}
    except (ValueError, TypeError) as error:
        raise CraftmeshError(
            f"{path}: cannot read entry crystals ({error}); expected rows of phase, structure and name"
        ) from None


def load(path: str | os.PathLike, names: Collection[str] | None = None) -> dict[str, np.ndarray]:
    """Return the entries of an .npz by name: all, or those of `names` that it has.

    Raises CraftmeshError if it is not an .npz, contains Python objects, or declares more than it contains.
    """
    try:
        refuse_false_zip(existing(Path(path)))
        with np.load(path, allow_pickle=False) as archive:
            for entry in archive.zip.infolist():
                with archive.zip.open(entry) as stream:
                    refuse_false_head(path, entry.filename, stream, entry.file_size)
            return {name: archive[name] for name in archive.files if names is None or name in names}
    except BROKEN as error:
        raise CraftmeshError(
            f"{path}: is not an .npz of plain arrays ({_fault(path, error)}); write it again"
        ) from None


def refuse_missing(
    path: str | os.PathLike, arrays: Mapping[str, np.ndarray], needed: Iterable[str], made: str
) -> None:
    """Raise CraftmeshError if `arrays`, those of an .npz, lack an entry of `needed`.

    made: the file that is expected and how it is made, for the error.
    """
    if missing := [name for name in needed if name not in arrays]:
        raise CraftmeshError(f"{path}: no entry {missing[0]}; expected {made}")


def refuse_false_head(path: str | os.PathLike, name: str, stream: IO[bytes], there: int) -> None:
    """Raise CraftmeshError if the .npy header at the start of a stream declares more than `there` bytes.

    name: the array's name, for errors. Also raises CraftmeshError for arrays of Python objects, and
    ValueError if the stream does not start with a .npy header.
    """
    version = np.lib.format.read_magic(stream)
    is_first = version == (1, 0)
    read = np.lib.format.read_array_header_1_0 if is_first else np.lib.format.read_array_header_2_0
    try:
        shape, _, dtype = read(stream)
    except TokenError as error:
        raise ValueError(f"its header is incomplete: {error}") from None
    if dtype.hasobject:
        raise CraftmeshError(f"{path}: {name} contains Python objects; save numbers or text instead")
    refuse_false_size(path, name, shape, dtype.itemsize, there)


def _fault(path: str | os.PathLike, error: Exception) -> str:
    """Return the reason for a read error as text.

    For a file that is no zip archive this is not numpy's message, which is misleading.
    """
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    return str(error) if zipfile.is_zipfile(path) else "not a zip archive, or truncated"


def read_npy(path: str | os.PathLike, axes: str) -> FileVolume:
    """Return the volume in a .npy whose axes are in the order `axes`, such as "zyx".

    Raises CraftmeshError for empty `axes`, for .npz archives and damaged files, and unless the array has
    three axes.
    """
    if not axes:
        raise CraftmeshError(f"{path}: a .npy does not store its axis order; set axes to xyz or zyx")
    if zipfile.is_zipfile(path):
        raise CraftmeshError(f"{path}: is an .npz archive; rename it to .npz or set format to npz")
    try:
        with open(path, "rb") as stream:
            refuse_false_head(path, "its array", stream, os.path.getsize(path))
        labels = np.load(path, allow_pickle=False)
    except BROKEN as error:
        raise CraftmeshError(f"{path}: is not a .npy of numbers ({error}); write it again") from None
    return FileVolume(to_xyz(labels, axes, str(path)))
