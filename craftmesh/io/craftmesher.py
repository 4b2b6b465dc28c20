"""Files of craftmesher, the program of the paper: lists of voids and config.xml."""

import csv
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io.front_csv import read_front, read_front_points

_VOID_COLUMNS = 5


def read_source_points(path: Path, box: np.ndarray, step: float) -> np.ndarray:
    """Return points (k, 3) of a csv: x, y, z as they are, or points on the voids of a void list.

    A void list has columns id, x, y, z, r in fractions of `box` (2, 3), the radius of the cube root of
    its volume; it is one by its header, or by five columns without one. Points on a void's sphere are
    about `step` apart. Raises CraftmeshError for files that are neither.
    """
    voids = _void_rows(path)
    if voids is None:
        return read_front_points(path)
    bad = ~np.isfinite(voids).all(axis=1) | (voids[:, 3] <= 0)
    if bad.any():
        row = int(np.flatnonzero(bad)[0])
        raise CraftmeshError(
            f"{path}: void {row + 1} is {voids[row].tolist()}; expected x, y, z, r, finite and r > 0"
        )
    extent = box[1] - box[0]
    centres = box[0] + voids[:, :3] * extent
    radii = voids[:, 3] * np.cbrt(extent.prod())
    return np.concatenate([_sphere(c, r, step) for c, r in zip(centres, radii)])


def _void_rows(path: Path) -> np.ndarray | None:
    """Return x, y, z, r (k, 4) of a void list, None where the file is none."""
    with open(path, newline="", encoding="utf-8-sig", errors="replace") as stream:
        rows = [[cell.strip() for cell in row] for row in csv.reader(stream) if any(map(str.strip, row))]
    if rows and "r" in rows[0]:
        columns = read_front(path)
        if "r" not in columns:
            raise CraftmeshError(f"{path}: column 'r' has to hold numbers, the voids' radii")
        return np.stack([columns[name] for name in "xyzr"], axis=1)
    if not rows or any(len(row) != _VOID_COLUMNS for row in rows):
        return None
    try:
        return np.array(rows, float)[:, 1:]
    except ValueError:
        return None


def _sphere(centre: np.ndarray, radius: float, step: float) -> np.ndarray:
    """Return points on a sphere, about `step` apart, along a Fibonacci spiral."""
    count = int(np.clip(np.ceil(4 * np.pi * (radius / step) ** 2), 12, 100_000))
    place = np.arange(count) + 0.5
    height = 1 - 2 * place / count
    turn = np.pi * (1 + np.sqrt(5)) * place
    ring = np.sqrt(1 - height**2)
    return centre + radius * np.stack([ring * np.cos(turn), ring * np.sin(turn), height], axis=1)


def read_config(path: Path) -> dict[str, str]:
    """Read a config.xml: texts by key, those of nested elements as outer/inner.

    Raises CraftmeshError for a file that is missing or not XML, and for a key that is there twice.
    """
    try:
        root = ElementTree.parse(path).getroot()
    except FileNotFoundError:
        raise CraftmeshError(f"{path}: no such file; check the path") from None
    except ElementTree.ParseError as error:
        raise CraftmeshError(f"{path}: not XML ({error}); expected craftmesher's config.xml") from None
    found: dict[str, str] = {}
    for prefix, element in _leaves(root, ""):
        if prefix in found:
            raise CraftmeshError(f"{path}: key {prefix} is there twice; keep one")
        found[prefix] = (element.text or "").strip()
    return found


def _leaves(element, prefix: str):
    for child in element:
        name = f"{prefix}{child.tag}"
        if len(child):
            yield from _leaves(child, f"{name}/")
        else:
            yield name, child
