"""Points to refine around in .csv files: bare points, void lists of craftmesher, pore lists of Avizo."""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io.front_csv import read_front, read_front_points

_VOID_COLUMNS = 5
_TITLE_LINES = 3  # at most, above the names of the columns in a table of Avizo
_CENTRE = ("barycenterx", "barycentery", "barycenterz")
_DIAMETER, _VOLUME = "eqdiameter", "volume3d"
_NO_POINTS, _NO_SPHERES = np.zeros((0, 3)), np.zeros((0, 4))


@dataclass(frozen=True, eq=False)
class SourcePoints:
    """What a file holds: points (k, 3) and spheres (s, 4) x, y, z, r in model units, or voids (v, 4).

    Voids are x, y, z, r in fractions of the model's box, r of the cube root of its volume.
    """

    points: np.ndarray
    voids: np.ndarray
    spheres: np.ndarray


def read_source_points(path: Path) -> SourcePoints:
    """Read the points of a csv with x, y, z, the voids of a void list, or the pores of an Avizo table.

    A void list has columns id, x, y, z, r; it is one by its header, or by five columns without one. A table
    of Avizo (Label Analysis, saved as csv, also with semicolons or tabs) has BaryCenterX, Y, Z, and
    EqDiameter or Volume3d; units behind the names are not looked at. Raises CraftmeshError for files that
    are none of these, and for radii that are not > 0.
    """
    spheres = _avizo_rows(path)
    if spheres is not None:
        return SourcePoints(_NO_POINTS, _NO_SPHERES, _checked(path, spheres))
    voids = _void_rows(path)
    if voids is not None:
        return SourcePoints(_NO_POINTS, _checked(path, voids), _NO_SPHERES)
    return SourcePoints(read_front_points(path), _NO_SPHERES, _NO_SPHERES)


def _checked(path: Path, rows: np.ndarray) -> np.ndarray:
    bad = ~np.isfinite(rows).all(axis=1) | (rows[:, 3] <= 0)
    if bad.any():
        row = int(np.flatnonzero(bad)[0])
        raise CraftmeshError(
            f"{path}: void {row + 1} is {rows[row].tolist()}; expected x, y, z, r, finite and r > 0"
        )
    return rows


def _avizo_rows(path: Path) -> np.ndarray | None:
    """Return x, y, z, r (k, 4) of a table of Avizo, None where the file is none."""
    text = path.read_text("utf-8-sig", errors="replace")  # the unit may be a micro sign of another encoding
    lines = [line for line in text.splitlines() if line.strip(" ,;\t")]
    for number, line in enumerate(lines[: _TITLE_LINES + 1]):
        separator = next((mark for mark in "\t;" if mark in line), ",")
        names = [_name(cell) for cell in next(csv.reader([line], delimiter=separator))]
        if set(_CENTRE) <= set(names) and (_DIAMETER in names or _VOLUME in names):
            rows = list(csv.reader(lines[number + 1 :], delimiter=separator))
            return _pores(path, names, rows, decimal="." if separator == "," else ",")
    return None


def _name(cell: str) -> str:
    """Return a column's name without its unit, as `EqDiameter (um)`, in small letters."""
    return cell.split("(")[0].split("[")[0].strip().casefold()


def _pores(path: Path, names: list[str], rows: list[list[str]], decimal: str) -> np.ndarray:
    size = _DIAMETER if _DIAMETER in names else _VOLUME
    # tables with semicolons may have decimal commas
    columns = [names.index(name) for name in (*_CENTRE, size)]
    values = np.zeros((len(rows), 4))
    for number, row in enumerate(rows):
        try:
            values[number] = [float(row[c].replace(decimal, ".")) for c in columns]
        except (ValueError, IndexError):
            found = [row[c] for c in columns if c < len(row)]
            raise CraftmeshError(
                f"{path}: pore {number + 1} has {found}; expected numbers for {', '.join((*_CENTRE, size))}"
            ) from None
    if size == _DIAMETER:
        values[:, 3] /= 2
    else:
        values[:, 3] = np.cbrt(values[:, 3] * 3 / (4 * np.pi))
    return values


def _void_rows(path: Path) -> np.ndarray | None:
    """Return x, y, z, r (k, 4) of a void list, None where the file is none."""
    with open(path, newline="", encoding="utf-8-sig", errors="replace") as stream:
        rows = [[cell.strip() for cell in row] for row in csv.reader(stream) if any(map(str.strip, row))]
    if rows and "r" in rows[0]:
        columns = read_front(path, "xyzr")
        return np.stack([columns[name] for name in "xyzr"], axis=1)
    if not rows or any(len(row) != _VOID_COLUMNS for row in rows):
        return None
    try:
        return np.array(rows, float)[:, 1:]
    except ValueError:
        return None
