"""Stresses of two meshes at the same places: where they are compared, and by how much they are apart."""

import csv
from pathlib import Path

import numpy as np

# Stresses are compared in a square so many l_min wide, across the middle of the front, or l_min off voids.
WIDTH, PLACES = 16.0, 40_000
WORDS = ("id", "load_case", "face", "flags", "stays")  # columns that are no numbers


def read_table(path: Path) -> dict[str, np.ndarray]:
    """Return the columns of numbers of a csv with a header."""
    with open(path, encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    numbers = [key for key in rows[0] if key not in WORDS]
    return {key: np.array([float(row[key] or "nan") for row in rows]) for key in numbers}


def square(front: dict, edge: float) -> np.ndarray:
    """Return places (n, 3) of a square of WIDTH edges, square to the front at its middle."""
    origin, ahead, up = middle_of(front)
    steps = np.linspace(-WIDTH / 2, WIDTH / 2, round(PLACES**0.5)) * edge
    across, along = np.meshgrid(steps, steps, indexing="ij")
    return origin + across.reshape(-1, 1) * ahead + along.reshape(-1, 1) * up


def middle_of(front: dict) -> np.ndarray:
    """Return (3, 3): the place at half of a front's length, the direction ahead of it, and its normal."""
    middle = np.argmin(np.abs(front["s"] - front["s"][-1] / 2))
    return np.array(
        [[front[f"{name}{axis}"][middle] for axis in "xyz"] for name in ("", "binormal_", "normal_")]
    )


def shells(voids: Path, config: dict, edge: float) -> np.ndarray:
    """Return random places (n, 3) an edge out of the surfaces of voids, listed as shares of the box."""
    table = read_table(voids)
    centres = np.stack([table[axis] for axis in "xyz"], axis=1)
    extent = np.array(config["generate"]["shape"]) * config["generate"]["spacing"]
    random = np.random.default_rng(1)
    which = random.integers(len(centres), size=PLACES)
    way = random.normal(size=(PLACES, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    return centres[which] * extent + (table["r"][which, None] * extent + edge) * way


def differences(fine: np.ndarray, coarse: np.ndarray) -> np.ndarray:
    """Return by how many % of its mean size a stress (n,) differs, nan where it has no value."""
    return 100 * np.abs(coarse - fine) / np.nanmean(np.abs(fine))


def stresses_off(fine: np.ndarray, coarse: np.ndarray) -> dict:
    """Return how far stresses (n,) of two meshes are apart place by place, and the largest 1 % of them."""
    both = np.isfinite(fine) & np.isfinite(coarse)
    fine, coarse = fine[both], coarse[both]
    largest = [np.percentile(np.abs(one), 99) for one in (fine, coarse)]
    return {
        "stress": np.percentile(differences(fine, coarse), (50, 95)).tolist(),
        "largest": 100 * float(largest[1] / largest[0] - 1),
    }


def largest_stress(path: Path, places: np.ndarray) -> np.ndarray:
    """Return the principal stress of the largest size (n,) at places (n, 3), nan out of the body."""
    return largest_principal(stress_at(path, places))


def largest_principal(tensor: np.ndarray) -> np.ndarray:
    """Return the principal value of the largest size (n,) of tensors (n, 3, 3), nan for nan."""
    inside = np.isfinite(tensor[:, 0, 0])
    principal = np.linalg.eigvalsh(tensor[inside])
    found = np.full(len(tensor), np.nan)
    found[inside] = np.take_along_axis(principal, np.abs(principal).argmax(axis=1)[:, None], axis=1)[:, 0]
    return found


def stress_at(path: Path, places: np.ndarray) -> np.ndarray:
    """Return the stress (n, 3, 3) of a solution.vtu at places (n, 3), nan out of the body."""
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkPolyData
    from vtkmodules.vtkFiltersCore import vtkProbeFilter
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    points, asked = vtkPoints(), vtkPolyData()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(places), deep=True))
    asked.SetPoints(points)
    probe = vtkProbeFilter()
    probe.SetSourceConnection(reader.GetOutputPort())
    probe.SetInputData(asked)
    probe.Update()
    xx, yy, zz, xy, yz, xz = vtk_to_numpy(probe.GetOutput().GetPointData().GetArray("stress")).T
    tensor = np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], axis=1).reshape(-1, 3, 3).astype(float)
    tensor[vtk_to_numpy(probe.GetOutput().GetPointData().GetArray("vtkValidPointMask")) == 0] = np.nan
    return tensor


def arc(front: dict, radius: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return angles (n,) from straight ahead, places (n, 3) on an arc round the middle of the front, and
    the directions (n, 3) of the tangential stress there.
    """
    origin, ahead, up = middle_of(front)
    angles = np.radians(np.linspace(-80.0, 80.0, 161))
    cosine, sine = np.cos(angles)[:, None], np.sin(angles)[:, None]
    return np.degrees(angles), origin + radius * (cosine * ahead + sine * up), cosine * up - sine * ahead
