"""Points in users' files: those of a surface, points and pores to refine around, target lengths."""

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from craftmesh.errors import CraftmeshError, existing_file
from craftmesh.io import vtk_xml
from craftmesh.io.front_csv import bare_front, front_table
from craftmesh.io.surface_files import LISTED, vertices_of
from craftmesh.io.text_table import Table, read_table

TEXTS = (".txt", ".xyz", ".asc", ".pts")
_VOID, _VOID_COLUMNS = "xyzr", 5  # without a header its id comes first
_CENTRE = ("barycenterx", "barycentery", "barycenterz")
_DIAMETER, _VOLUME = "eqdiameter", "volume3d"
_NO_POINTS, _NO_SPHERES = np.zeros((0, 3)), np.zeros((0, 4))
_KINDS = {".vtp": "PolyData", ".vti": "ImageData"}


def read_points(path: str | os.PathLike) -> np.ndarray:
    """Return the points (n, 3) of a file: a .csv with columns x, y, z, text with these or with them as its
    first three columns, a .vtp, or a file that trimesh reads (.ply, .obj, ...), triangles or not.

    Raises CraftmeshError for a missing or broken file and numbers that are not finite.
    """
    path = existing_file(path, f"give points as .csv, .xyz, .vtp, {LISTED}")
    suffix = path.suffix.lower()
    if suffix == ".csv":
        return front_table(path).numbers("xyz")
    if suffix in TEXTS:
        table = read_table(path, "xyz")
        points = (table if table.names else table.named("xyz")).numbers("xyz")
    elif suffix == ".vtp":
        points = vtk_xml.read_dataset(path, "PolyData").points
    else:
        points = vertices_of(path)
    if not len(points) or not np.isfinite(points).all():
        raise CraftmeshError(f"{path}: holds {len(points)} points; expected finite ones, at least three")
    return points


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


def read_length_field(path: Path, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Read points (k, 3) and the array `name` of target lengths (k,) there from a .vtp or .vti.

    Cell data count at the cells' centres. Raises CraftmeshError for other files, a missing array, and one
    that is not a scalar.
    """
    kind = _KINDS.get(path.suffix.lower())
    if kind is None:
        raise CraftmeshError(f"{path}: suffix {path.suffix!r}; expected a .vtp or .vti with lengths")
    data = vtk_xml.read_dataset(path, kind)
    at_points = name in data.at_points
    lengths = vtk_xml.named_array(
        path, data.at_points if at_points else data.at_cells, [name], "point or cell data"
    )
    if lengths.ndim != 1:
        raise CraftmeshError(f"{path}: {name!r} has {lengths.shape[1]} components; expected one")
    if not data.place and at_points:
        return data.points, lengths
    if not data.place:
        corners, offsets = data.cells["Polys"]
        return np.add.reduceat(data.points[corners], offsets[:-1]) / np.diff(offsets)[:, None], lengths
    extent = data.place["extent"].reshape(3, 2)
    if at_points:
        return _lattice(data, [np.arange(low, high + 1) for low, high in extent]), lengths
    cells = [np.arange(low, max(high, low + 1)) for low, high in extent]
    far = [np.minimum(own + 1, high) for own, high in zip(cells, extent[:, 1])]
    return (_lattice(data, cells) + _lattice(data, far)) / 2, lengths


def _lattice(image: vtk_xml.Dataset, axes: list[np.ndarray]) -> np.ndarray:
    """Return the places (k, 3) of an image's points at whole numbers along its axes, the first fastest."""
    at = np.stack(np.meshgrid(*axes[::-1], indexing="ij")[::-1], axis=-1).reshape(-1, 3)
    steps = image.place["direction"].reshape(3, 3) * image.place["spacing"]
    return at @ steps.T + image.place["origin"]
