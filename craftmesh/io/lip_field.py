"""Tables of what lips of cracks bear at points."""

import os

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io.text_table import read_table

PRESSURE, TRACTION = ("pressure",), ("tx", "ty", "tz")


def read_lip_field(path: str | os.PathLike) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points (k, 3), pressures (k,) and tractions (k, 3) of a table, 0 where it has no such column.

    Raises CraftmeshError for a table with neither, and for cells that are no numbers.
    """
    kinds = [(*"xyz", *names) for names in (PRESSURE, TRACTION)]
    table = read_table(path, *kinds)
    known = [names for names in (PRESSURE, TRACTION) if table.has(names)]
    if not known:
        raise CraftmeshError(
            f"{path}: the columns are {', '.join(table.names) or 'not named'}; expected x, y, z, and "
            "pressure or tx, ty, tz"
        )
    points = table.numbers("xyz")
    none = {PRESSURE: np.zeros((len(points), 1)), TRACTION: np.zeros((len(points), 3))}
    values = none | {names: table.numbers(names) for names in known}
    return points, values[PRESSURE][:, 0], values[TRACTION]
