"""Tables from users and other programs: displacements, eigenstrains of grains, crack-face loads, slip."""

import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import BinaryIO, NamedTuple

import numpy as np

from craftmesh.errors import CraftmeshError, existing_file
from craftmesh.io.npz import load
from craftmesh.io.point_fields import NAMES
from craftmesh.io.text_table import read_table

COLUMNS = ("node", "ux", "uy", "uz")
DISPLACEMENT_FORMAT = (
    "csv with the columns node,ux,uy,uz, or .npz with the entries node (k,) and displacement (k, 3)"
)
# Character positions in a .frd line of the long ASCII form: key, node, then six fields of twelve.
_NODE, _FIRST, _FIELD, _PER_LINE = slice(3, 13), 13, 12, 6
_ROWS = 100_000  # number of rows read at a time
# The line above a block of values in a .dat: quantity, node set and time.
_PRINT = re.compile(
    r"^ *(displacements|total force|forces|total internal energy)(?: \(.*\))? +for set (\S+) +and time "
    r"+(\S+)\s*$"
)
ONE, SIX = ("e",), ("e11", "e22", "e33", "e12", "e13", "e23")  # columns of isotropic and of full strains
_INDICES = r"_(-?\d)(-?\d)(-?\d)"
_SLIP = re.compile(f"slip{_INDICES}(?:{_INDICES})?")
OCTAHEDRAL = ("111", "-111", "1-11", "11-1")  # Miller indices of the octahedral planes of cubic crystals
HISTORY = ("load",)  # column of a load history
PRESSURE, TRACTION = ("pressure",), ("tx", "ty", "tz")


def read_displacement_table(path: str | os.PathLike) -> tuple[np.ndarray, np.ndarray]:
    """Return node numbers (k,) of the deck and displacements (k, 3) from a .csv or .npz.

    A .csv has the columns node, ux, uy, uz, an .npz the entries `node` and `displacement`. An .npz without
    `node` contains all nodes in order, like solution.npz. Raises CraftmeshError for other content.
    """
    if Path(path).suffix == ".npz":
        arrays = load(path)
        values = arrays.get("displacement", np.zeros(0))
        numbers = arrays.get("node", np.arange(1, len(values) + 1))
        is_sound = values.ndim == 2 and values.shape[1] == 3 and values.dtype.kind == "f"
        if not is_sound or numbers.shape != values.shape[:1] or numbers.dtype.kind not in "iu":
            raise CraftmeshError(
                f"{path}: its entries are {', '.join(arrays)}; expected {DISPLACEMENT_FORMAT}"
            )
        return numbers.astype(np.int64), values.astype(float)
    try:
        rows = read_table(path, COLUMNS).numbers(COLUMNS)
    except CraftmeshError as error:
        raise CraftmeshError(f"{error}; expected {DISPLACEMENT_FORMAT}") from None
    numbers = rows[:, 0].astype(np.int64)
    if (numbers != rows[:, 0]).any():
        raise CraftmeshError(f"{path}: column 'node' contains fractions; expected node numbers of the deck")
    return numbers, rows[:, 1:]


def read_displacements(path: str | os.PathLike) -> tuple[np.ndarray, np.ndarray]:
    """Return node numbers (k,) and displacements (k, 3) from the last block DISP of CalculiX's .frd file.

    Raises CraftmeshError for a missing, truncated or malformed file, as `read_frd`.
    """
    return read_frd(path, {"DISP": 3})["DISP"]


def read_frd(
    path: str | os.PathLike, columns: Mapping[str, int]
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return node numbers (k,) and values (k, c) by block name, from the last such block of a .frd file.

    columns: block name -> number c of columns to read. DISP contains displacements, STRESS xx, yy, zz, xy,
    yz, xz, SDV state variables. Other blocks are skipped. Raises CraftmeshError for a missing or truncated
    file, a missing block, and rows that are not in the long ASCII form.
    """
    found = {}
    with existing_file(path, "give a results file of CalculiX").open("rb") as stream:
        while head := stream.readline():
            name = head[5:13].decode("latin-1").strip() if head.startswith(b" -4") else ""
            if name in columns:
                found[name] = _block(path, stream, columns[name])
    for name in columns:
        if name not in found:
            raise CraftmeshError(f"{path}: has no block {name}; request it with *NODE FILE or *EL FILE")
    return found


def _block(path: str | os.PathLike, stream: BinaryIO, columns: int) -> tuple[np.ndarray, np.ndarray]:
    """Return node numbers (k,) and values (k, columns) of the block whose first line has been read."""
    row = stream.readline()
    while row.startswith(b" -5"):
        row = stream.readline()
    width, line = len(row), stream.readline()
    while line.startswith(b" -2"):
        row, line = row + line, stream.readline()
    places = [width * (k // _PER_LINE) + _FIRST + _FIELD * (k % _PER_LINE) for k in range(columns)]
    numbers, values = [np.zeros(0, np.int64)], [np.zeros((0, columns))]
    rest = row + line + stream.read(_ROWS * len(row))
    while count := _rows_of_values(rest, len(row)):
        try:
            table = np.frombuffer(rest, "S1", count * len(row)).reshape(count, len(row))
            numbers.append(_column(table, _NODE).astype(np.int64))
            fields = [_column(table, slice(at, at + _FIELD)).astype(float) for at in places]
            values.append(np.column_stack(fields))
        except ValueError:
            raise CraftmeshError(
                f"{path}: values are not in the long ASCII form of CalculiX; write the file again"
            ) from None
        rest = rest[count * len(row) :] + stream.read(_ROWS * len(row))
    if not rest.startswith(b" -3"):
        raise CraftmeshError(f"{path}: is truncated within a block of values; solve again")
    stream.seek(-len(rest), os.SEEK_CUR)
    return np.concatenate(numbers), np.concatenate(values)


def _rows_of_values(text: bytes, width: int) -> int:
    """Return the number of complete rows of values, `width` bytes each, at the start of `text`."""
    keys = np.frombuffer(text, "S1", len(text) // width * width).reshape(-1, width)[:, 1:3]
    other = np.flatnonzero(np.ascontiguousarray(keys).view("S2").ravel() != b"-1")
    return int(other[0]) if len(other) else len(keys)


def _column(table: np.ndarray, at: slice) -> np.ndarray:
    return np.ascontiguousarray(table[:, at]).view(f"S{at.stop - at.start}").ravel()


class FacePrint(NamedTuple):
    """CalculiX's printed output of a node set in k increments: times (k,), numbers (n,) of its nodes,
    displacement (k, n, 3), and force (k, 3), the sum over these nodes."""

    times: np.ndarray
    numbers: np.ndarray
    displacement: np.ndarray
    force: np.ndarray


def read_face_prints(path: str | os.PathLike) -> dict[str, FacePrint]:
    """Return a FacePrint by node set from a .dat of CalculiX, the output of *NODE PRINT of U and RF.

    Raises CraftmeshError if the file is missing, if it has no output of both, or if an increment lacks it.
    """
    blocks: dict[tuple[str, str], list[tuple[float, list[list[float]]]]] = {}
    into: list[list[float]] = []
    try:
        with open(path, encoding="latin-1") as stream:
            for line in stream:
                if head := _PRINT.match(line):
                    into = []
                    blocks.setdefault((head[2], head[1]), []).append((float(head[3]), into))
                elif line.strip():
                    into.append([float(word) for word in line.split()])
        found = {}
        for name in dict.fromkeys(name for name, kind in blocks if kind == "displacements"):
            times, moved = zip(*blocks[name, "displacements"])
            forces = [rows[0] for _, rows in blocks[name, "total force"]]
            table = np.array(moved)
            numbers = table[0, :, 0].astype(np.int64)
            found[name] = FacePrint(np.array(times), numbers, table[:, :, 1:], np.array(forces))
        if found:
            return found
    except (OSError, ValueError, KeyError, IndexError):
        pass
    raise CraftmeshError(f"{path}: an increment lacks displacements or total forces; solve the deck again")


def read_grain_strains(path: str | os.PathLike) -> tuple[list[int], np.ndarray]:
    """Return the ids of grains (k,) and their strains (k, 1) or (k, 6) as 11, 22, 33, 12, 13, 23.

    Raises CraftmeshError for other tables, and, naming the line, for duplicate or fractional ids and for
    strains of magnitude over 1.
    """
    table = read_table(path, ("grain", *ONE), ("grain", *SIX))
    strains = table.numbers(ONE if table.has(ONE) else SIX)
    grains = table.numbers(["grain"])[:, 0]
    for row, (grain, line) in enumerate(zip(grains.tolist(), table.lines)):
        if grain != int(grain) or grain in grains[:row]:
            raise CraftmeshError(
                f"{path}, line {line}: grain is {grain:g}; use an integer, and each grain only once"
            )
        if np.abs(strains[row]).max() > 1:
            raise CraftmeshError(
                f"{path}, line {line}: strain is {np.abs(strains[row]).max():g}; write fractions up to 1"
            )
    return grains.astype(int).tolist(), strains


def read_lip_field(path: str | os.PathLike) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points (k, 3), pressures (k,) and tractions (k, 3) on crack faces from a table.

    Without the column pressure, pressures are 0; without tx, ty, tz, tractions are. Raises CraftmeshError
    if both are missing, and for cells that are not numbers.
    """
    kinds = [(*"xyz", *names) for names in (PRESSURE, TRACTION)]
    table = read_table(path, *kinds)
    known = [names for names in (PRESSURE, TRACTION) if table.has(names)]
    if not known:
        raise CraftmeshError(
            f"{path}: its columns are {', '.join(table.names) or 'not named'}; expected x, y, z, and "
            "pressure or tx, ty, tz"
        )
    points = table.numbers("xyz")
    none = {PRESSURE: np.zeros((len(points), 1)), TRACTION: np.zeros((len(points), 3))}
    values = none | {names: table.numbers(names) for names in known}
    return points, values[PRESSURE][:, 0], values[TRACTION]


def read_blocks(path: str | os.PathLike) -> tuple[str, ...] | np.ndarray:
    """Return a text "CYCLES,LARGEST,SMALLEST" per row of a table with columns cycles, largest, smallest.

    These cells are copied; whether they are numbers is not checked. Of a table with the column load, the
    loads (k,) of a history are returned instead. Raises CraftmeshError for a load that is not a finite
    number, if a column is missing, or if there are no rows.
    """
    names = ("cycles", "largest", "smallest")
    table = read_table(path, names[:1], HISTORY)
    if table.has(HISTORY):
        return table.numbers(HISTORY)[:, 0]
    columns = [table.words(name) for name in names]
    known = [column for column in columns if column is not None]
    if len(known) < len(names) or not known[0]:
        raise CraftmeshError(
            f"{path}: its columns are {', '.join(table.names) or 'not named'}, its rows {len(table.rows)}; "
            f"expected {', '.join(names)} and rows of load cycles, or the column load of a load history"
        )
    return tuple(map(",".join, zip(*known)))


class SlipTable(NamedTuple):
    """A table of the slip of s planes or slip systems at points (k,).

    points (k, 3); normals, directions (s, 3): Miller indices, directions None for planes; slip (k, s);
    grain (k,), stress (k, 6): None if unknown.
    """

    points: np.ndarray
    normals: np.ndarray
    slip: np.ndarray
    grain: np.ndarray | None
    directions: np.ndarray | None
    stress: np.ndarray | None


def read_slip_table(path: str | os.PathLike) -> SlipTable:
    """Return the slip around a front from a table of the user.

    The table has columns x, y, z, and either a column slip_hkl per plane, such as slip_111 or slip_1-11, or
    slip_hkl_uvw per slip system, such as slip_111_0-11, or a column slip, whose values hold for each plane
    of OCTAHEDRAL. Grains need the column grain, stress all columns of NAMES. Raises CraftmeshError if
    other columns are missing, for systems mixed with planes, for indices 000, for directions not in their
    plane, and for cells that are not numbers.
    """
    table = read_table(path, "xyz")
    names = [name for name in table.names if _SLIP.fullmatch(name.casefold())]
    if not names and not table.has(["slip"]):
        raise CraftmeshError(
            f"{path}: its columns are {', '.join(table.names) or 'not named'}; expected x, y, z, and slip "
            "or slip_hkl of planes, such as slip_111, slip_1-11, or slip_hkl_uvw of systems"
        )
    columns = [name.casefold() for name in names] or [f"slip_{hkl}" for hkl in OCTAHEDRAL]
    found = [[int(index) for index in re.findall(r"-?\d", name)] for name in columns]
    if len({len(indices) for indices in found}) > 1:
        raise CraftmeshError(
            f"{path}: has columns slip_hkl of planes and slip_hkl_uvw of systems; give one of the two"
        )
    indices = np.array(found, float).reshape(len(found), -1, 3)
    for name, one in zip(columns, indices):
        if not one.any(axis=1).all() or (len(one) > 1 and one[0] @ one[1]):
            raise CraftmeshError(
                f"{path}: {name} is not a plane, or a plane and a direction in it; use Miller indices that "
                "are not all 0, and directions perpendicular to the normal hkl"
            )
    slip = table.numbers(columns if names else ["slip"] * len(columns))
    grain = table.numbers(["grain"])[:, 0].astype(int) if table.has(["grain"]) else None
    directions = indices[:, 1] if indices.shape[1] > 1 else None
    stress = table.numbers(NAMES) if table.has(NAMES) else None
    return SlipTable(table.numbers("xyz"), indices[:, 0], slip, grain, directions, stress)
