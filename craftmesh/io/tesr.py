"""Neper's raster tessellations (.tesr, formats 2.0 to 2.2): labels in text or binary, x fastest.

Source: the chapter on file formats of Neper's reference manual. Neper calls the rotation active that brings
the sample's axes onto the crystal's, which is the one from crystal to sample components here.
"""

import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io.crystals import of_symmetry
from craftmesh.io.file_volume import EULERS, QUATERNIONS, RODRIGUES, VOID, FileVolume, table_rows
from craftmesh.types import Crystal

_BINARY = {
    "binary8": "u1",
    "binary16": "<i2",
    "binary16_big": ">i2",
    "binary32": "<i4",
    "binary32_big": ">i4",
}
_WIDTH = {"rodrigues": 3, "euler-bunge": 3, "quaternion": 4, "axis-angle": 4}


def read(path: str | os.PathLike) -> FileVolume:
    """Read the cells of the voxels, the voxel sizes, the origin and the cells' orientations.

    Cells go by their `*id` where there is one; 0 is void. Raises CraftmeshError.
    """
    path = Path(path)
    content = path.read_bytes()
    head, found, data = content.partition(b"**data")
    if not found or not head.lstrip().startswith(b"***tesr"):
        raise CraftmeshError(f"{path}: has no ***tesr with **data; expected a raster tessellation of Neper")
    fields = _fields(head.decode("ascii", "replace").split())
    general = _numbers(path, fields, "**general")
    if len(general) != 7 or general[0] != 3:
        raise CraftmeshError(
            f"{path}: **general is {general.tolist()}; expected 3, three sizes, three lengths"
        )
    shape, spacing = general[1:4].astype(np.int64), general[4:]
    cells = _cells(path, data, shape).reshape(shape, order="F")
    origin = _numbers(path, fields, "*origin") if "*origin" in fields else np.zeros(3)
    symmetry = " ".join(fields.get("*crysym", []))
    crystals = {0: Crystal(of_symmetry(symmetry))} if symmetry else {}
    if "*ori" not in fields and "*id" not in fields:
        return FileVolume(cells, spacing, origin, crystals=crystals, zero=VOID)
    count = int(np.append(_numbers(path, fields, "**cell"), 0)[0])
    ids = _numbers(path, fields, "*id").astype(np.int64) if "*id" in fields else np.arange(1, count + 1)
    if len(ids) != count or not 0 <= cells.min() <= cells.max() <= count or (ids <= 0).any():
        raise CraftmeshError(
            f"{path}: labels run from {cells.min()} to {cells.max()}, and *id has {len(ids)}; "
            f"expected 0 to {count} and {count} positive ids as **cell says"
        )
    labels = np.concatenate([[0], ids])[cells]
    return FileVolume(labels, spacing, origin, _orientations(path, fields, ids), None, crystals, VOID)


def _fields(words: list[str]) -> dict[str, list[str]]:
    """Return the words after each name that begins with stars."""
    fields: dict[str, list[str]] = {}
    name = ""
    for word in words:
        if word.startswith("*"):
            name = word
            fields[name] = []
        else:
            fields[name].append(word)
    return fields


def _numbers(path: Path, fields: Mapping[str, list[str]], name: str, skip: int = 0) -> np.ndarray:
    try:
        return np.array(fields.get(name, [])[skip:], float)
    except ValueError:
        raise CraftmeshError(
            f"{path}: {name} is {' '.join(fields[name][:8])}; expected numbers, write it anew with Neper"
        ) from None


def _cells(path: Path, data: bytes, shape: np.ndarray) -> np.ndarray:
    """Return the cells of all voxels; `data` is what follows **data."""
    kind, _, rest = data.lstrip().partition(b"\n")
    name = kind.decode("ascii", "replace").strip()
    if rest.lstrip().startswith(b"*file"):
        other = path.parent / rest.split()[1].decode("utf-8", "replace")
        if not other.is_file():
            raise CraftmeshError(f"{path}: *file {other} is missing; put it beside the .tesr")
        rest = other.read_bytes()
    count = int(shape.prod())
    if name in _BINARY:
        dtype = np.dtype(_BINARY[name])
        cells = np.frombuffer(rest[: count * dtype.itemsize], dtype)
    elif name == "ascii":
        words = rest.split(b"*", 1)[0].split()[:count]
        cells = np.array(words, np.int64) if all(w.isdigit() for w in words) else np.zeros(0)
    else:
        raise CraftmeshError(f"{path}: **data is {name!r}; expected ascii or {', '.join(_BINARY)}")
    if len(cells) != count:
        raise CraftmeshError(
            f"{path}: **data has {len(cells)} of {count} whole labels >= 0; write it anew with Neper"
        )
    return cells.astype(np.int64)


def _orientations(path: Path, fields: Mapping[str, list[str]], ids: np.ndarray) -> dict[str, np.ndarray]:
    """Return the cells' orientations as a table (g, k) by id, NaN where there is none."""
    if "*ori" not in fields:
        return {}
    descriptor, _, convention = (fields["*ori"] or [""])[0].partition(":")
    if descriptor not in _WIDTH or convention not in ("", "active", "passive"):
        raise CraftmeshError(
            f"{path}: *ori is {descriptor!r}; expected {', '.join(_WIDTH)}: write it with "
            "`neper -T -loadtesr FILE -oridescriptor rodrigues`"
        )
    rows = _numbers(path, fields, "*ori", skip=1)
    if len(rows) != len(ids) * _WIDTH[descriptor]:
        raise CraftmeshError(f"{path}: *ori has {len(rows)} numbers; expected {_WIDTH[descriptor]} a cell")
    kind, values = _as_kind(descriptor, rows.reshape(len(ids), -1))
    if convention == "passive":
        values = _inverse(kind, values)
    table = np.full((table_rows(path, ids), values.shape[1]), np.nan)
    table[ids] = values
    return {kind: table}


def _as_kind(descriptor: str, rows: np.ndarray) -> tuple[str, np.ndarray]:
    if descriptor == "rodrigues":
        return RODRIGUES, rows
    if descriptor == "euler-bunge":
        return EULERS, np.radians(rows)
    if descriptor == "quaternion":
        return QUATERNIONS, rows
    half = np.radians(rows[:, 3:]) / 2
    axes = rows[:, :3] / np.linalg.norm(rows[:, :3], axis=1, keepdims=True)
    return QUATERNIONS, np.concatenate([np.cos(half), np.sin(half) * axes], axis=1)


def _inverse(kind: str, values: np.ndarray) -> np.ndarray:
    if kind == RODRIGUES:
        return -values
    if kind == EULERS:
        return -values[:, ::-1]
    return values * [1, -1, -1, -1]
