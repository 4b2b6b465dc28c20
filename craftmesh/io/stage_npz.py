"""Files between stages: tetrahedra of grains, sizing.npz, solution.npz, and solution.vtu for ParaView."""

import json
import os
from collections.abc import Mapping, Sequence

import numpy as np

from craftmesh.arguments import as_array
from craftmesh.atomic import atomic_path
from craftmesh.errors import CraftmeshError, existing_file
from craftmesh.io import vtk_xml
from craftmesh.io.npz import load, refuse_missing, write_arrays
from craftmesh.io.vtk import tets_alone
from craftmesh.types import GrainTets, Solution

_FIELDS = ("nodes", "interior", "tets")
FORMAT = "craftmesh sizing 1"  # value of the entry `format`
_NUMBERS = ("l_min", "l0", "l_max", "r0", "r1", "exponent", "growth")
# Type and shape of each entry; None: any number of rows.
_ENTRIES = {
    **dict.fromkeys(_NUMBERS, (float, ())),
    "sources": (float, (None, 3)),
    "field_points": (float, (None, 3)),
    "field_lengths": (float, (None,)),
    "field_counts": (np.int64, (None,)),
    "field_growth": (float, (None,)),
}
MAP_FORMAT = "craftmesh map 1"  # value of the entry `format`
_MAP_ENTRIES = ("nodes", "elements", "lengths", "aspect_ratio", "cell")
SOLUTION_FORMAT = "craftmesh solution 1"  # value of the entry `format`
_HISTORY = "history "  # prefix of the entries that hold columns of a load history
# Order of VTK's stress components, yz before xz.
VTK_ORDER = [0, 1, 2, 3, 5, 4]


def write_grain_tets(
    path: str | os.PathLike, grains: Sequence[GrainTets], record: dict | None = None
) -> None:
    """Write the grains, in the given order, to one .npz; the same grains give the same bytes.

    Arrays: `grain` (g,), the ids; `nodes`, `interior` and `tets`, each for all grains in sequence; `counts`
    (g, 3), the numbers of rows of these three per grain; `record`, how the grains were made, as JSON bytes.
    """
    text = np.frombuffer(json.dumps(record or {}).encode(), np.uint8)
    counts = np.array([[len(getattr(g, name)) for name in _FIELDS] for g in grains], np.int64)
    none = np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros((0, 4), np.int64)
    joined = {
        name: np.concatenate([empty, *(getattr(g, name) for g in grains)])
        for name, empty in zip(_FIELDS, none)
    }
    with atomic_path(path) as temporary, open(temporary, "wb") as stream:
        numbers = np.array([g.grain for g in grains], np.int64)
        np.savez(stream, grain=numbers, counts=counts.reshape(-1, 3), record=text, **joined)  # type: ignore[arg-type]


def read_grain_tets(path: str | os.PathLike) -> list[GrainTets]:
    """Return the grains in a file of `write_grain_tets`; raises CraftmeshError if it lacks any array."""
    arrays = _arrays(path, ("grain", "counts", *_FIELDS))
    cuts = np.cumsum(arrays["counts"], axis=0)[:-1]
    parts = [np.split(arrays[name], cuts[:, column]) for column, name in enumerate(_FIELDS)]
    return [GrainTets(grain, *fields) for grain, *fields in zip(arrays["grain"], *parts)]


def read_record(path: str | os.PathLike) -> dict:
    """Return the record of how the grains in a file were made; raises CraftmeshError if it is missing."""
    return json.loads(_arrays(path, ("record",))["record"].tobytes())


def _arrays(path: str | os.PathLike, names: Sequence[str]) -> dict[str, np.ndarray]:
    arrays = load(existing_file(path, "run tetrahedralize for this chunk"), names)
    refuse_missing(path, arrays, names, "a chunk of grains; run tetrahedralize again")
    return arrays


def write_sizing(path: str | os.PathLike, arrays: Mapping[str, np.ndarray]) -> None:
    """Write the arrays of a sizing function, completely or not at all; same arrays give same bytes."""
    write_arrays(path, {"format": np.array(FORMAT), **{name: arrays[name] for name in _ENTRIES}})


def is_sizing(path: str | os.PathLike) -> bool:
    """Return True if the `format` of an .npz is that of a sizing; raises CraftmeshError if not an .npz."""
    return str(load(path).get("format")) == FORMAT


def read_sizing(path: str | os.PathLike) -> dict[str, np.ndarray]:
    """Return the arrays in a file of `write_sizing`; raises CraftmeshError that names a wrong entry."""
    arrays = _loaded(path, FORMAT, "size", tuple(_ENTRIES))
    arrays = {
        name: as_array(f"{path}: {name}", arrays[name], *entry, finite=False)
        for name, entry in _ENTRIES.items()
    }
    rows, counts = len(arrays["field_points"]), arrays["field_counts"]
    lengths, growth = len(arrays["field_lengths"]), len(arrays["field_growth"])
    if (counts < 1).any() or not rows == lengths == counts.sum() or len(counts) != growth:
        raise CraftmeshError(
            f"{path}: field_counts {counts.tolist()} do not fit {rows} field_points, {lengths} "
            f"field_lengths and {growth} field_growth; run `craftmesh size` again"
        )
    return arrays


def write_map(path: str | os.PathLike, arrays: Mapping[str, np.ndarray]) -> None:
    """Write the map from an old mesh to the new mesh that replaces it, completely or not at all.

    Arrays: `nodes` (n,) and `elements` (m,), the row in the new mesh of each old node and element, or -1;
    `lengths` (k,), the target lengths for which the new mesh's nodes were made; of the last mesh that was
    made from scratch `aspect_ratio`, its mean, and `cell`, the edge of its lattice's first cells.
    """
    write_arrays(path, {"format": np.array(MAP_FORMAT), **{name: arrays[name] for name in _MAP_ENTRIES}})


def read_map(path: str | os.PathLike) -> dict[str, np.ndarray]:
    """Return the arrays in a file of `write_map`; raises CraftmeshError for another file."""
    return _loaded(path, MAP_FORMAT, "renew", _MAP_ENTRIES)


def _loaded(
    path: str | os.PathLike, form: str, verb: str, needed: Sequence[str] = ()
) -> dict[str, np.ndarray]:
    """Return the entries of an .npz with the format `form`, which the subcommand `verb` writes.

    needed: entries that must exist. Raises CraftmeshError for another format or a missing entry.
    """
    what = form.split()[1]
    made = f"a {what}.npz made by `craftmesh {verb}`"
    arrays = load(path)
    if str(arrays.get("format")) != form:
        raise CraftmeshError(f"{path}: is not a {what}; expected {made}")
    refuse_missing(path, arrays, needed, made)
    return arrays


def write_solutions(path: str | os.PathLike, solutions: Mapping[str, Solution]) -> None:
    """Write an .npz of solutions by load case, "" for a single one; the same input gives the same bytes.

    The first solution has the entries `displacement`, `reactions`, `record` (JSON text), and possibly
    `contact` and each column of its history as `history NAME`. Entries of the others begin with the name of
    the load case and a point. With several load cases, `load_cases` contains their names.
    """
    names = list(solutions)
    arrays = {"format": np.array(SOLUTION_FORMAT)} | ({"load_cases": np.array(names)} if names[0] else {})
    for name, solution in solutions.items():
        text = json.dumps(dict(solution.record), sort_keys=True)
        own = {"record": np.array(text), "displacement": solution.displacement}
        own |= {"reactions": solution.reactions}
        own |= {f"{_HISTORY}{key}": values for key, values in solution.history.items()}
        own |= {} if solution.contact is None else {"contact": solution.contact}
        before = "" if name == names[0] else f"{name}."
        arrays |= {before + key: values for key, values in own.items()}
    write_arrays(path, arrays)


def read_solution(path: str | os.PathLike) -> Solution:
    """Return the first load case's solution in a file of `write_solutions`; errors as `read_solutions`."""
    return next(iter(read_solutions(path).values()))


def read_solutions(path: str | os.PathLike) -> dict[str, Solution]:
    """Return the solutions in a file by load case, "" for a single one.

    Raises CraftmeshError for a file that is not of `write_solutions`.
    """
    arrays = _loaded(path, SOLUTION_FORMAT, "solve")
    names = arrays.get("load_cases", np.array([""])).tolist()
    found = {}
    for name in names:
        before = "" if name == names[0] else f"{name}."
        own = {key.removeprefix(before): values for key, values in arrays.items() if key.startswith(before)}
        record = json.loads(str(own["record"]))
        named = {key.removeprefix(_HISTORY): own[key] for key in own if key.startswith(_HISTORY)}
        found[name] = Solution(own["displacement"], own["reactions"], record, own.get("contact"), named)
    return found


def write_solution_vtu(
    path: str | os.PathLike,
    points: np.ndarray,
    tets: np.ndarray,
    grain: np.ndarray,
    node: np.ndarray,
    displacement: np.ndarray,
    stress: np.ndarray,
    slip: np.ndarray | None = None,
) -> None:
    """Write a .vtu of elements whose grains share no points, so that stresses may jump at their boundaries.

    points (p, 3), tets (m, 4 or 10), cell data `grain` (m,). Point data: `node` (p,), its number in the
    deck; `displacement` (p, 3); `stress` (p, 6), passed as 11, 22, 33, 12, 13, 23 and written as xx, yy,
    zz, xy, yz, xz; `von_mises`; and `slip` (p,) if given.
    """
    straight, shear = stress[:, :3], stress[:, 3:]
    apart = ((straight - np.roll(straight, 1, axis=1)) ** 2).sum(axis=1)
    arrays = {
        "node": node,
        "displacement": displacement,
        "stress": stress[:, VTK_ORDER],
        "von_mises": np.sqrt(0.5 * apart + 3 * (shear**2).sum(axis=1)),
    }
    arrays |= {} if slip is None else {"slip": slip}
    data = tets_alone(points, tets, at_points=arrays, at_cells={"grain": grain})
    vtk_xml.write_dataset(path, "UnstructuredGrid", data)


def read_solution_vtu(
    path: str | os.PathLike,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray | None]:
    """Return points (p, 3), elements (m, 4 or 10), stress (p, 6) and slip (p,) of a solution.vtu.

    Stresses are 11, 22, 33, 12, 13, 23; slip is None if the file has none. Raises CraftmeshError for other
    files.
    """
    grid = vtk_xml.read_dataset(path, "UnstructuredGrid")
    stress = vtk_xml.named_array(path, grid.at_points, ["stress"], "point data")
    return grid.points, grid.elements(path), stress[:, VTK_ORDER], grid.at_points.get("slip")
