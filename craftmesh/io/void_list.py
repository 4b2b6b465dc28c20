"""Points to refine around in .csv files: bare points, void lists of craftmesher, pore lists of Avizo."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io.front_csv import bare_front
from craftmesh.io.text_table import Table, read_table

_VOID, _VOID_COLUMNS = "xyzr", 5  # without a header its id comes first
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

    def in_box(self, box: np.ndarray) -> np.ndarray:
        """Return the spheres (s, 4), or the voids as such in model units; box: (2, 3) corners."""
        low, high = box
        extent = high - low
        sizes = [*extent, np.cbrt(extent.prod())]
        return np.concatenate([self.spheres, self.voids * sizes + [*low, 0]])


def read_source_points(path: Path) -> SourcePoints:
    """Read the points of a csv with x, y, z, the voids of a void list, or the pores of an Avizo table.

    A void list has columns id, x, y, z, r; it is one by its header, or by five columns without one. A table
    of Avizo (Label Analysis, saved as csv) has BaryCenterX, Y, Z, and EqDiameter or Volume3d. Raises
    CraftmeshError for files that are none of these, and for radii that are not > 0.
    """
    pores = [(*_CENTRE, size) for size in (_DIAMETER, _VOLUME)]
    table = read_table(path, *pores, _VOID, "xyz")
    if any(map(table.has, pores)):
        return SourcePoints(_NO_POINTS, _NO_SPHERES, _checked(table, _pores(table)))
    if not table.names:
        is_list = len(table.rows[0]) == _VOID_COLUMNS
        table = table.named(("id", *_VOID)) if is_list else bare_front(table)
    if table.has("r"):
        return SourcePoints(_NO_POINTS, _checked(table, table.numbers(_VOID)), _NO_SPHERES)
    return SourcePoints(table.numbers("xyz"), _NO_SPHERES, _NO_SPHERES)


def _checked(table: Table, rows: np.ndarray) -> np.ndarray:
    bad = np.flatnonzero(rows[:, 3] <= 0)
    if len(bad):
        raise CraftmeshError(
            f"{table.path}, line {table.lines[bad[0]]}: void {bad[0] + 1} is {rows[bad[0]].tolist()}; "
            "expected x, y, z, r, and r > 0"
        )
    return rows


def _pores(table: Table) -> np.ndarray:
    if table.has([_DIAMETER]):
        return table.numbers((*_CENTRE, _DIAMETER)) * [1, 1, 1, 0.5]
    radius = np.cbrt(table.numbers([_VOLUME]) * 3 / (4 * np.pi))
    return np.column_stack([table.numbers(_CENTRE), radius])
