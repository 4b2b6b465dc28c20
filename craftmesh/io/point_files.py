"""Points in users' files: measured crack points, points and pores to refine around, target lengths."""

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
# Columns of a void list (a row per spherical void), and their number without a header, where id is first.
_VOID, _VOID_COLUMNS = "xyzr", 5
_CENTRE = ("barycenterx", "barycentery", "barycenterz")
_DIAMETER, _VOLUME = "eqdiameter", "volume3d"
_NO_POINTS, _NO_SPHERES = np.zeros((0, 3)), np.zeros((0, 4))
_KINDS = {".vtp": "PolyData", ".vti": "ImageData"}


def read_points(path: str | os.PathLike) -> np.ndarray:
    """Return the points (n, 3) of a file, with or without triangles.

    The file is a .csv or text with columns x, y, z, or without header (text: x, y, z first; .csv: as
    `bare_front` says); a .vtp; or a file that trimesh reads (.ply, .obj, ...). Of a .csv with several load
    cases only the first one's rows are returned. Raises CraftmeshError for a missing or damaged file, no
    points, and numbers that are not finite.
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
        raise CraftmeshError(f"{path}: has {len(points)} points; expected at least one, all of them finite")
    return points


@dataclass(frozen=True, eq=False)
class SourcePoints:
    """Places to refine around: points (k, 3) and spheres (s, 4) in model units, or voids (v, 4).

    A row of spheres or voids is x, y, z, r. Voids are in fractions: x, y, z of the extents of the model's
    box, r of the cube root of the box's volume.
    """

    points: np.ndarray
    voids: np.ndarray
    spheres: np.ndarray

    def in_box(self, box: np.ndarray) -> np.ndarray:
        """Return spheres and voids (s + v, 4) in model units; box (2, 3): its lower and upper corner."""
        low, high = box
        extent = high - low
        sizes = [*extent, np.cbrt(extent.prod())]
        return np.concatenate([self.spheres, self.voids * sizes + [*low, 0]])


def read_source_points(path: Path) -> SourcePoints:
    """Read the points of a csv with x, y, z, the voids of a void list, or the pores of an Avizo table.

    A void list has a header with x, y, z, r, or no header and the five columns id, x, y, z, r. A table of
    Avizo (Label Analysis, saved as csv) has BaryCenterX, Y, Z, and EqDiameter or Volume3d; its pores are
    spheres. Raises CraftmeshError for other files, and for radii that are not > 0.
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
            "expected x, y, z, r with r > 0"
        )
    return rows


def _pores(table: Table) -> np.ndarray:
    if table.has([_DIAMETER]):
        return table.numbers((*_CENTRE, _DIAMETER)) * [1, 1, 1, 0.5]
    radius = np.cbrt(table.numbers([_VOLUME]) * 3 / (4 * np.pi))
    return np.column_stack([table.numbers(_CENTRE), radius])


def read_length_field(path: Path, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return points (k, 3) of a .vtp or .vti and the target lengths (k,) there, from the array `name`.

    Point data are preferred. Cell data are taken as lengths at the cells' centres. Raises CraftmeshError
    for other files, a missing array, and an array that is not scalar.
    """
    kind = _KINDS.get(path.suffix.lower())
    if kind is None:
        raise CraftmeshError(f"{path}: unknown suffix {path.suffix!r}; give a .vtp or .vti with lengths")
    data = vtk_xml.read_dataset(path, kind)
    at_points = name in data.at_points
    lengths = vtk_xml.named_array(
        path, data.at_points if at_points else data.at_cells, [name], "point or cell data"
    )
    if lengths.ndim != 1:
        raise CraftmeshError(f"{path}: {name!r} has {lengths.shape[1]} components; expected a scalar array")
    if not data.place and at_points:
        return data.points, lengths
    if not data.place:
        return data.centres("Polys"), lengths
    extent = data.place["extent"].reshape(3, 2)
    if at_points:
        return _lattice(data, [np.arange(low, high + 1) for low, high in extent]), lengths
    cells = [np.arange(low, max(high, low + 1)) for low, high in extent]
    far = [np.minimum(own + 1, high) for own, high in zip(cells, extent[:, 1])]
    return (_lattice(data, cells) + _lattice(data, far)) / 2, lengths


def _lattice(image: vtk_xml.Dataset, axes: list[np.ndarray]) -> np.ndarray:
    """Return positions (k, 3) of an image's points at all combinations of the indices on each axis.

    axes: the indices along x, y, z; x varies fastest.
    """
    at = np.stack(np.meshgrid(*axes[::-1], indexing="ij")[::-1], axis=-1).reshape(-1, 3)
    steps = image.place["direction"].reshape(3, 3) * image.place["spacing"]
    return at @ steps.T + image.place["origin"]
