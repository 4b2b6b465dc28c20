"""Neper's raster tessellations (.tesr, formats 2.0 to 2.2): labels in text or binary, x fastest.

Source: Neper's reference manual, chapter on file formats. The rotation that turns the sample's axes onto
the crystal's axes converts crystal to sample components, as `Rotations` requires. Neper calls it active up
to format 2.1, and passive from 2.2 (Neper 4.10) on.
"""

import math
import os
import re
from collections.abc import Mapping
from dataclasses import replace
from mmap import ACCESS_READ, mmap
from pathlib import Path

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io.file_volume import (
    DEGREES,
    EULERS,
    KOCKS,
    MATRICES,
    QUATERNIONS,
    RODRIGUES,
    ROE,
    FileVolume,
    Rotations,
    ids_in_text,
    left_unread,
    of_symmetry,
    table_rows,
)
from craftmesh.io.header_checks import data_file, refuse_false_size
from craftmesh.types import VOID, Crystal

_BINARY = {
    "binary8": "u1",
    "binary16": "<i2",
    "binary16_big": ">i2",
    "binary32": "<i4",
    "binary32_big": ">i4",
}
# Kind and numbers per row of Neper's orientation descriptors, also by the short names of older files.
_AXIS_ANGLE = "axis-angle"
_NEWEST = (2, 2)  # newest format known here, in which Neper exchanged active and passive
_DESCRIPTORS = {
    **dict.fromkeys(("rodrigues", "R"), (RODRIGUES, 3)),
    **dict.fromkeys(("euler-bunge", "e"), (EULERS, 3)),
    **dict.fromkeys(("euler-kocks", "ek"), (KOCKS, 3)),
    **dict.fromkeys(("euler-roe", "er"), (ROE, 3)),
    **dict.fromkeys(("rotmat", "g"), (MATRICES, 9)),
    **dict.fromkeys((_AXIS_ANGLE, "rtheta"), (_AXIS_ANGLE, 4)),
    **dict.fromkeys(("quaternion", "q"), (QUATERNIONS, 4)),
}


def read_tesr(path: str | os.PathLike) -> FileVolume:
    """Read the cell labels of voxels, voxel sizes, origin, orientations and crystal symmetry.

    Labels are the cells' `*id` if the file has them; 0 is void. Orientations are those of the cells (*ori),
    else those of the voxels (**oridata), NaN where **oridef is 0. Raises CraftmeshError for files that are
    not a .tesr, for labels without a cell, and for wrong counts or conventions of orientations.
    """
    path = Path(path)
    content = path.read_bytes()
    head, found, data = content.partition(b"**data")
    if not found or not head.lstrip().startswith(b"***tesr"):
        raise CraftmeshError(f"{path}: has no ***tesr with **data; give a raster tessellation of Neper")
    fields = _fields(head.decode("ascii", "replace").split())
    general = _numbers(path, fields, "**general")
    if len(general) != 7 or general[0] != 3:
        raise CraftmeshError(
            f"{path}: **general is {general.tolist()}; expected 3, three numbers of voxels, three lengths"
        )
    if not (np.isfinite(general).all() and (general[1:4] == np.round(general[1:4])).all()):
        raise CraftmeshError(f"{path}: **general is {general.tolist()}; expected counts and finite lengths")
    shape, spacing = tuple(int(n) for n in general[1:4]), general[4:]
    origin = _numbers(path, fields, "*origin") if "*origin" in fields else np.zeros(3)
    kind = " ".join(fields.get("**format", [])[1:])  # data type: here in format 2.0, in each section later
    cells, data = _cells(path, data, shape, kind)
    structure = of_symmetry(" ".join(fields.get("*crysym", [])))
    crystals = {0: Crystal(structure)} if structure else {}
    first = np.append(_numbers(path, fields, "**cell"), 0)[0]
    count = int(first) if 0 <= first <= len(head) else 0  # at most one cell per byte of the header
    ids = _numbers(path, fields, "*id") if "*id" in fields else np.arange(1, count + 1)
    if "*ori" in fields or "*id" in fields:
        _check_ids(path, cells, ids, count)
        ids = ids.astype(np.int64)
        cells = np.concatenate([[0], ids])[cells]
    elif "**cell" in fields and cells.max(initial=0) > first:
        raise CraftmeshError(
            f"{path}: largest label is {cells.max()}, but **cell gives {first:g} cells; write it again"
        )
    unread: list[str] = [name for name in ("*lam", "*mode", "*group") if name in fields]
    orientations = _of_cells(path, fields, ids) if "*ori" in fields else {}
    if data.lstrip().startswith(b"**oridata"):
        unread += ["**oridata"] * bool(orientations)
        orientations = orientations or _of_voxels(path, fields, data, shape, kind)
    notes = left_unread(unread) + (_newer(fields) if orientations else ())
    return FileVolume(cells, spacing, origin, orientations, None, crystals, VOID, notes=notes)


def _check_ids(path: Path, cells: np.ndarray, ids: np.ndarray, count: int) -> None:
    different = np.unique(ids[(ids > 0) & (ids <= np.iinfo(np.int32).max) & (ids == np.floor(ids))])
    if not (0 <= cells.min() <= cells.max() <= count == len(ids) == len(different)):
        raise CraftmeshError(
            f"{path}: labels range from {cells.min()} to {cells.max()}, and *id has {len(ids)} numbers, "
            f"{len(different)} of them different integers > 0; "
            f"expected labels 0 to {count} and {count} different ids, as in **cell"
        )


def _fields(words: list[str]) -> dict[str, list[str]]:
    """Return the words of each section by its name, a word that begins with a star: *ori, **cell, ..."""
    fields: dict[str, list[str]] = {}
    name = ""
    for word in words:
        if word.startswith("*"):
            name = word
            fields[name] = []
        else:
            fields.setdefault(name, []).append(word)
    return fields


def _numbers(path: Path, fields: Mapping[str, list[str]], name: str, skip: int = 0) -> np.ndarray:
    try:
        return np.array(fields.get(name, [])[skip:], float)
    except ValueError:
        raise CraftmeshError(
            f"{path}: {name} is {' '.join(fields[name][:8])}; expected numbers, write it again with Neper"
        ) from None


def _cells(path: Path, data: bytes, shape: tuple[int, ...], kind: str) -> tuple[np.ndarray, bytes]:
    """Return the cell labels (nx, ny, nz) of all voxels, and the bytes after them.

    data: the bytes after **data; kind: data type, "" if it is the first word in `data`.
    """
    name, rest = (kind, data.lstrip(b" \t\r").removeprefix(b"\n")) if kind else _word(data)
    rest, after = _inline_or_beside(path, rest)
    count = math.prod(shape)
    refuse_false_size(path, "**data", shape, 1, len(rest))
    if name in _BINARY:
        cells, tail = _binary(rest, np.dtype(_BINARY[name]), count)
    elif name == "ascii":
        text, tail = _until_star(rest)
        cells = ids_in_text(path, text.split()[:count])
    else:
        raise CraftmeshError(f"{path}: **data is {name!r}; expected ascii or {', '.join(_BINARY)}")
    if len(cells) != count:
        raise CraftmeshError(
            f"{path}: **data has {len(cells)} of {count} integer labels; write it again with Neper"
        )
    return cells.astype(np.int64).reshape(shape, order="F"), tail if after is None else after


def _inline_or_beside(path: Path, rest: bytes) -> tuple[bytes, bytes | None]:
    """Return the bytes with a section's numbers, and None.

    If the numbers are in a file, named after *file, the second value is the bytes after this name.
    """
    if not rest.lstrip().startswith(b"*file"):
        return rest, None
    _, name, after = (*rest.split(maxsplit=2), b"", b"")[:3]
    return _beside(path, name).read_bytes(), after


def _beside(path: Path, name: bytes) -> Path:
    return data_file(path, "*file", name.decode("utf-8", "replace"))


def tesr_data(path: Path) -> list[Path]:
    """Return the files in which a .tesr stores numbers; raises CraftmeshError if one is missing."""
    if not path.stat().st_size:
        return []
    with open(path, "rb") as stream, mmap(stream.fileno(), 0, access=ACCESS_READ) as content:
        names = re.findall(rb"\*file\s+(\S+)", content)
    return [_beside(path, name) for name in dict.fromkeys(names)]


def _binary(rest: bytes, dtype: np.dtype, count: int) -> tuple[np.ndarray, bytes]:
    there = min(count, len(rest) // dtype.itemsize)
    return np.frombuffer(rest, dtype, there), rest[there * dtype.itemsize :]


def _until_star(rest: bytes) -> tuple[bytes, bytes]:
    end = rest.find(b"*")
    return (rest, b"") if end < 0 else (rest[:end], rest[end:])


def _of_cells(path: Path, fields: Mapping[str, list[str]], ids: np.ndarray) -> dict[str, Rotations]:
    """Return the cells' orientations as a table (g, k) by id; rows without an orientation are NaN."""
    rows = _numbers(path, fields, "*ori", skip=1)
    name = (fields["*ori"] or [""])[0]
    rotations = _rotations(path, fields, "*ori", name, rows)
    if len(rotations.values) != len(ids):
        raise CraftmeshError(
            f"{path}: *ori has {len(rotations.values)} rows; expected a row per cell, {len(ids)}; "
            "write it again with Neper"
        )
    table = np.full((table_rows(path, ids), rotations.values.shape[1]), np.nan)
    table[ids] = rotations.values
    return {"*ori": replace(rotations, values=table)}


def _of_voxels(
    path: Path, fields: Mapping[str, list[str]], data: bytes, shape: tuple[int, ...], kind: str
) -> dict[str, Rotations]:
    """Return the voxels' orientations (nx, ny, nz, k), NaN at voxels that **oridef marks as undefined.

    data: bytes from **oridata on; kind: data type in format 2.0, "" if each section names its own.
    """
    count = math.prod(shape)
    name, data = _word(_word(data)[1])
    width = _DESCRIPTORS.get(name.partition(":")[0], ("", 0))[1]
    numbers, data = _floats(path, "**oridata", data, "<f8", count * width, kind)
    rotations = _rotations(path, fields, "**oridata", name, numbers)
    values = rotations.values.copy()
    section, data = _word(data)
    if section == "**oridef":
        values[_floats(path, section, data, "u1", count)[0] == 0] = np.nan
    return {"**oridata": replace(rotations, values=values.reshape(*shape, -1, order="F"))}


def _word(data: bytes) -> tuple[str, bytes]:
    """Return the next word and the bytes after it, without the line end if it is the last on its line."""
    word, rest = re.match(rb"\s*(\S*)[ \t\r]*\n?(.*)", data, re.S).groups()  # type: ignore[union-attr]
    return word.decode("ascii", "replace"), rest


def _floats(
    path: Path, section: str, data: bytes, dtype: str, count: int, kind: str = ""
) -> tuple[np.ndarray, bytes]:
    """Return `count` numbers of a section as floats, and the bytes after them.

    data: begins with the section's data type, or with its numbers if `kind` is this type; dtype: type of
    binary numbers. Raises CraftmeshError if there are fewer numbers.
    """
    kind, rest = (re.sub("binary.*", "binary", kind), data) if kind else _word(data)
    rest, after = _inline_or_beside(path, rest)
    if kind == "ascii":
        text, tail = _until_star(rest)
        numbers = _numbers(path, {section: text.decode("ascii", "replace").split()[:count]}, section)
    else:
        numbers, tail = _binary(rest, np.dtype(dtype), count)
    if kind not in ("ascii", "binary") or len(numbers) != count:
        raise CraftmeshError(
            f"{path}: {section} ({kind}) has {len(numbers)} of {count} numbers; "
            "expected ascii or binary with one row per voxel"
        )
    return numbers.astype(float), tail if after is None else after


def _rotations(
    path: Path, fields: Mapping[str, list[str]], section: str, name: str, numbers: np.ndarray
) -> Rotations:
    """Return a section's numbers as Rotations, in degrees.

    name: Neper's descriptor and convention, such as "rodrigues:active". Raises CraftmeshError for unknown
    names, for incomplete rows, and if the format's version does not define the convention.
    """
    descriptor, _, convention = name.partition(":")
    if descriptor not in _DESCRIPTORS or convention not in ("", "active", "passive"):
        raise CraftmeshError(
            f"{path}: {section} is {name!r}; known: {', '.join(_DESCRIPTORS)}; write it with "
            "`neper -T -loadtesr FILE -oridescriptor rodrigues`"
        )
    version = _version(fields)
    if convention and not version:
        raise CraftmeshError(
            f"{path}: **format is {' '.join(fields.get('**format', []))!r}; expected 2.0, 2.1 or 2.2, to "
            f"define {convention}; write the file again with Neper"
        )
    is_swapped = version >= _NEWEST
    if is_swapped and not convention:
        raise CraftmeshError(
            f"{path}: {section} is {name!r}; format 2.2 exchanged the conventions, so write {name}:passive "
            f"(Bunge's rotation) or {name}:active"
        )
    kind, width = _DESCRIPTORS[descriptor]
    if len(numbers) % width:
        raise CraftmeshError(f"{path}: {section} has {len(numbers)} numbers; expected {width} per row")
    rows = numbers.reshape(-1, width)
    if kind == _AXIS_ANGLE:
        kind, half = QUATERNIONS, np.radians(rows[:, 3:]) / 2
        length = np.linalg.norm(rows[:, :3], axis=1, keepdims=True)
        axes = rows[:, :3] / np.where(length > 0, length, 1)
        rows = np.concatenate([np.cos(half), np.sin(half) * axes], axis=1)
    return Rotations(kind, rows, DEGREES, inverse=convention == ("active" if is_swapped else "passive"))


def _version(fields: Mapping[str, list[str]]) -> tuple[int, ...]:
    """Return the file's format version as numbers, such as (2, 1); empty if the file has none."""
    name = " ".join(fields.get("**format", [])[:1])
    return tuple(map(int, name.split("."))) if re.fullmatch(r"[0-9]{1,4}(\.[0-9]{1,4})+", name) else ()


def _newer(fields: Mapping[str, list[str]]) -> tuple[str, ...]:
    """Return a note, in a tuple, if the file's format is newer than _NEWEST; else an empty tuple."""
    if _version(fields) <= _NEWEST:
        return ()
    return (
        f"format {fields['**format'][0]} is newer than {'.'.join(map(str, _NEWEST))}, whose conventions "
        "for orientations are used: check one grain",
    )
