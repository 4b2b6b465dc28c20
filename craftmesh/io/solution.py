"""solution.npz: a solver's field; solution.vtu: the same for ParaView, with stresses."""

import json
import os
from collections.abc import Mapping

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io import vtk_xml
from craftmesh.io.npz import load, write_arrays
from craftmesh.io.vtk import VTK_CELL_TYPE
from craftmesh.types import Solution

FORMAT = "craftmesh solution 1"  # in the entry `format`
# VTK has xz after yz.
_VTK_ORDER = [0, 1, 2, 3, 5, 4]


def write_solution(path: str | os.PathLike, solution: Solution) -> None:
    """Write an .npz with `displacement`, `reactions` and `record` (JSON text), always in the same bytes.

    `contact` too where the solution has it.
    """
    write_arrays(path, {"format": np.array(FORMAT)} | _arrays(solution))


def write_solutions(path: str | os.PathLike, solutions: Mapping[str, Solution]) -> None:
    """Write the solutions of several loads: the first as `write_solution` does, so that all may read it.

    `load_cases` has their names, and the others' entries begin with theirs and a point.
    """
    first, *others = solutions
    arrays = {"format": np.array(FORMAT), "load_cases": np.array(list(solutions))}
    arrays |= _arrays(solutions[first])
    for name in others:
        arrays |= {f"{name}.{key}": values for key, values in _arrays(solutions[name]).items()}
    write_arrays(path, arrays)


def _arrays(solution: Solution) -> dict[str, np.ndarray]:
    text = json.dumps(dict(solution.record), sort_keys=True)
    arrays = {"record": np.array(text), "displacement": solution.displacement}
    arrays |= {"reactions": solution.reactions}
    return arrays if solution.contact is None else arrays | {"contact": solution.contact}


def read_solution(path: str | os.PathLike) -> Solution:
    """Read what `write_solution` wrote, of several the first; raises CraftmeshError for another file."""
    return next(iter(read_solutions(path).values()))


def read_solutions(path: str | os.PathLike) -> dict[str, Solution]:
    """Read solutions by the names of their loads, one of a single load by ""; errors as `read_solution`."""
    arrays = load(path)
    if str(arrays.get("format")) != FORMAT:
        raise CraftmeshError(f"{path}: is no solution; expected a solution.npz made by `craftmesh solve`")
    names = arrays.get("load_cases", np.array([""])).tolist()
    found = {}
    for name in names:
        before = "" if name == names[0] else f"{name}."
        own = {key.removeprefix(before): values for key, values in arrays.items() if key.startswith(before)}
        record = json.loads(str(own["record"]))
        found[name] = Solution(own["displacement"], own["reactions"], record, own.get("contact"))
    return found


def write_solution_vtu(
    path: str | os.PathLike,
    points: np.ndarray,
    tets: np.ndarray,
    grain: np.ndarray,
    node: np.ndarray,
    displacement: np.ndarray,
    stress: np.ndarray,
) -> None:
    """Write a .vtu of elements whose grains share no points.

    points (p, 3), tets (m, 4 or 10), cell data `grain` (m,). Point data: `node` (p,), the deck's number;
    `displacement` (p, 3); `stress` (p, 6) xx, yy, zz, xy, yz, xz, given as 11, 22, 33, 12, 13, 23; and
    `von_mises`.
    """
    from vtkmodules.vtkCommonDataModel import vtkUnstructuredGrid

    grid = vtkUnstructuredGrid()
    grid.SetPoints(vtk_xml.vtk_points(points))
    grid.SetCells(VTK_CELL_TYPE[tets.shape[1]], vtk_xml.uniform_cells(tets))
    vtk_xml.add_arrays(grid.GetCellData(), {"grain": grain})
    straight, shear = stress[:, :3], stress[:, 3:]
    apart = ((straight - np.roll(straight, 1, axis=1)) ** 2).sum(axis=1)
    arrays = {
        "node": node,
        "displacement": displacement,
        "stress": stress[:, _VTK_ORDER],
        "von_mises": np.sqrt(0.5 * apart + 3 * (shear**2).sum(axis=1)),
    }
    vtk_xml.add_arrays(grid.GetPointData(), arrays)
    vtk_xml.write_dataset(path, grid, "UnstructuredGrid")


def read_solution_vtu(path: str | os.PathLike) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points (p, 3), elements (m, 4 or 10) and stress (p, 6) of a solution.vtu.

    Stresses are 11, 22, 33, 12, 13, 23. Raises CraftmeshError for a file of another kind.
    """
    grid = vtk_xml.read_dataset(path, "UnstructuredGrid")
    elements = vtk_xml.rows_of(path, grid.GetCells())
    stress = vtk_xml.named_array(path, grid.GetPointData(), ["stress"], "point data")
    return vtk_xml.points_of(grid), elements, stress[:, _VTK_ORDER]
