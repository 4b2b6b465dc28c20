"""Displacements of nodes from other programs: csv with the columns node, ux, uy, uz, or .npz."""

import os
from pathlib import Path

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io import text_table
from craftmesh.io.npz import load

COLUMNS = ("node", "ux", "uy", "uz")
FORM = "csv with the columns node,ux,uy,uz, or .npz with the entries node (k,) and displacement (k, 3)"


def read_table(path: str | os.PathLike) -> tuple[np.ndarray, np.ndarray]:
    """Return the deck's numbers (k,) of nodes and their displacements (k, 3).

    An .npz without `node` holds all nodes in order, as solution.npz does. Raises CraftmeshError for a file
    that is neither, naming the column or entry.
    """
    if Path(path).suffix == ".npz":
        return _from_npz(path)
    try:
        rows = text_table.read_table(path, COLUMNS).numbers(COLUMNS)
    except CraftmeshError as error:
        raise CraftmeshError(f"{error}; expected {FORM}") from None
    numbers = rows[:, 0].astype(np.int64)
    if (numbers != rows[:, 0]).any():
        raise CraftmeshError(f"{path}: column 'node' holds fractions; expected the deck's node numbers")
    return numbers, rows[:, 1:]


def _from_npz(path: str | os.PathLike) -> tuple[np.ndarray, np.ndarray]:
    arrays = load(path)
    values = arrays.get("displacement", np.zeros(0))
    numbers = arrays.get("node", np.arange(1, len(values) + 1))
    is_sound = values.ndim == 2 and values.shape[1] == 3 and values.dtype.kind == "f"
    if not is_sound or numbers.shape != values.shape[:1] or numbers.dtype.kind not in "iu":
        raise CraftmeshError(f"{path}: entries {', '.join(arrays)}; expected {FORM}")
    return numbers.astype(np.int64), values.astype(float)
