"""Points to refine around in .csv files: bare points, and void lists of craftmesher."""

import csv
from pathlib import Path

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io.front_csv import read_front, read_front_points

_VOID_COLUMNS = 5


def read_source_points(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Read the points (k, 3) of a csv with x, y, z, or the voids (v, 4) of a void list; one is empty.

    A void list has columns id, x, y, z, r in fractions of the model's box, the radius of the cube root of
    its volume; it is one by its header, or by five columns without one. Raises CraftmeshError for files
    that are neither.
    """
    voids = _void_rows(path)
    if voids is None:
        return read_front_points(path), np.zeros((0, 4))
    bad = ~np.isfinite(voids).all(axis=1) | (voids[:, 3] <= 0)
    if bad.any():
        row = int(np.flatnonzero(bad)[0])
        raise CraftmeshError(
            f"{path}: void {row + 1} is {voids[row].tolist()}; expected x, y, z, r, finite and r > 0"
        )
    return np.zeros((0, 3)), voids


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
