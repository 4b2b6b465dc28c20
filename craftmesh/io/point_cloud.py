"""Points of a surface in other tools' files: text with three columns, .vtp, and what trimesh reads."""

import os
from pathlib import Path

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io import vtk_xml
from craftmesh.io.front_csv import read_front_points
from craftmesh.io.surface_files import listed_suffixes, vertices_of
from craftmesh.io.text_table import read_table

TEXTS = (".txt", ".xyz", ".asc", ".pts")


def read_points(path: str | os.PathLike) -> np.ndarray:
    """Return the points (n, 3) of a file: a .csv with columns x, y, z, text with these or with them as its
    first three columns, a .vtp, or a file that trimesh reads (.ply, .obj, ...), triangles or not.

    Raises CraftmeshError for a missing or broken file and numbers that are not finite.
    """
    path = Path(path)
    if not path.is_file():
        raise CraftmeshError(f"{path}: no such file; give points as .csv, .xyz, .vtp, {listed_suffixes()}")
    suffix = path.suffix.lower()
    if suffix == ".csv":
        return read_front_points(path)
    if suffix in TEXTS:
        points = _columns(path)
    elif suffix == ".vtp":
        points = vtk_xml.points_of(vtk_xml.read_dataset(path, "PolyData"))
    else:
        points = vertices_of(path)
    if not len(points) or not np.isfinite(points).all():
        raise CraftmeshError(f"{path}: holds {len(points)} points; expected finite ones, at least three")
    return points


def _columns(path: Path) -> np.ndarray:
    table = read_table(path, "xyz")
    return (table if table.names else table.named("xyz")).numbers("xyz")
