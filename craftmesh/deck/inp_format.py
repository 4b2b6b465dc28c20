"""Numbers, rows and sets in the form that Abaqus and CalculiX read."""

from collections.abc import Iterable, Iterator

import numpy as np

from craftmesh.deck.limits import ROW_LIMIT

_FIELD = 20  # most characters of a number: CalculiX rejects or cuts longer ones
_ROWS = 50_000  # rows formatted at once
LARGE = 1e16  # from here on numbers are written with an exponent


def number(value: float) -> str:
    """Return the shortest text that reads back as `value`, or the closest text of 20 characters.

    Only numbers of 16 or 17 digits below 0.1, or from 1e16 on, are too long; they keep 13 digits or more.
    """
    text = repr(value)
    return text if len(text) <= _FIELD else _shortened(value, text)


def _shortened(value: float, text: str) -> str:
    sign = "-" if value < 0 else ""
    if "e" not in text:
        decimals = f"{abs(value):.{_FIELD - 1 - len(sign)}f}"
        return sign + decimals.removeprefix("0").rstrip("0")
    exponent = f"e{int(text.partition('e')[2])}"
    rounded = f"{abs(value):.{_FIELD - 2 - len(sign) - len(exponent)}e}"
    digits, _, power = rounded.partition("e")
    return f"{sign}{digits.rstrip('0')}e{int(power)}"


def integer_rows(rows: np.ndarray) -> Iterator[str]:
    """Yield the lines of an integer table (k, c), many at a time."""
    line = ",".join(["%d"] * rows.shape[1]) + "\n"
    for block in _blocks(rows):
        yield line * len(block) % tuple(block.ravel().tolist())


def node_rows(points: np.ndarray) -> Iterator[str]:
    """Yield the lines `id,x,y,z` of nodes numbered from 1."""
    start = 1
    for block in _blocks(points):
        fields: list = [None] * (4 * len(block))
        fields[::4] = range(start, start + len(block))
        for axis, column in enumerate(block.T, 1):
            values: list = column.tolist()
            # all other numbers have at most 17 digits, a point and a sign, 19 characters
            for row in np.flatnonzero((np.abs(column) < 0.1) | (np.abs(column) >= LARGE)).tolist():
                values[row] = number(values[row])
            fields[axis::4] = values
        yield "%d,%s,%s,%s\n" * len(block) % tuple(fields)
        start += len(block)


def id_lines(ids: np.ndarray) -> Iterator[str]:
    """Yield ids, counted from 0, as lines of up to 16 ids counted from 1."""
    whole = len(ids) // ROW_LIMIT * ROW_LIMIT
    yield from integer_rows(np.asarray(ids[:whole]).reshape(-1, ROW_LIMIT) + 1)
    if whole < len(ids):
        yield from integer_rows(np.asarray(ids[whole:])[None] + 1)


def name_lines(names: Iterable[str]) -> Iterator[str]:
    """Yield names of sets, up to 8 a line."""
    names = list(names)
    for start in range(0, len(names), 8):
        yield ",".join(names[start : start + 8]) + "\n"


def constant_lines(values: list[float]) -> Iterator[str]:
    """Yield material constants, up to 8 a line."""
    for start in range(0, len(values), 8):
        yield ",".join(map(number, values[start : start + 8])) + "\n"


def _blocks(rows: np.ndarray) -> Iterator[np.ndarray]:
    for start in range(0, len(rows), _ROWS):
        yield rows[start : start + _ROWS]
