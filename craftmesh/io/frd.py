"""CalculiX' results file .frd: displacements of the nodes, read block by block."""

import os
from typing import BinaryIO

import numpy as np

from craftmesh.errors import CraftmeshError

# Columns of a row of values in the long ASCII form: key, node, then fields of twelve.
_NODE, _FIRST, _FIELD = slice(3, 13), 13, 12
_ROWS = 100_000  # rows read at once


def read_displacements(path: str | os.PathLike) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers (k,) of the nodes and their displacements (k, 3) in the last step of a .frd.

    Other blocks are passed by. Raises CraftmeshError for a missing or cut file, one without displacements,
    and rows that are not in the long ASCII form.
    """
    try:
        stream = open(path, "rb")
    except FileNotFoundError:
        raise CraftmeshError(f"{path}: no such file; expected CalculiX' results") from None
    found = None
    with stream:
        while head := stream.readline():
            if head.startswith(b" -4  DISP"):
                found = _block(path, stream)
    if found is None:
        raise CraftmeshError(
            f"{path}: holds no displacements; expected a block DISP, as *NODE FILE with U writes it"
        )
    return found


def _block(path: str | os.PathLike, stream: BinaryIO) -> tuple[np.ndarray, np.ndarray]:
    """Return numbers and displacements of the block whose first line has been read."""
    row = stream.readline()
    while row.startswith(b" -5"):
        row = stream.readline()
    numbers, values = [np.zeros(0, np.int64)], [np.zeros((0, 3))]
    rest = row + stream.read(_ROWS * len(row))
    while count := _rows_of_values(rest, len(row)):
        try:
            table = np.frombuffer(rest, "S1", count * len(row)).reshape(count, len(row))
            numbers.append(_column(table, _NODE).astype(np.int64))
            fields = [slice(_FIRST + _FIELD * k, _FIRST + _FIELD * (k + 1)) for k in range(3)]
            values.append(np.column_stack([_column(table, at).astype(float) for at in fields]))
        except ValueError:
            raise CraftmeshError(
                f"{path}: displacements are not in the long ASCII form of CalculiX; write them anew"
            ) from None
        rest = rest[count * len(row) :] + stream.read(_ROWS * len(row))
    if not rest.startswith(b" -3"):
        raise CraftmeshError(f"{path}: was cut short within the displacements; solve again")
    stream.seek(-len(rest), os.SEEK_CUR)
    return np.concatenate(numbers), np.concatenate(values)


def _rows_of_values(text: bytes, width: int) -> int:
    """Return how many whole rows of values `text` starts with."""
    keys = np.frombuffer(text, "S1", len(text) // width * width).reshape(-1, width)[:, 1:3]
    other = np.flatnonzero(np.ascontiguousarray(keys).view("S2").ravel() != b"-1")
    return int(other[0]) if len(other) else len(keys)


def _column(table: np.ndarray, at: slice) -> np.ndarray:
    return np.ascontiguousarray(table[:, at]).view(f"S{at.stop - at.start}").ravel()
