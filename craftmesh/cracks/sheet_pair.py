"""Two sheets that lie over each other, over their common plane."""

from typing import NamedTuple

import numpy as np
import shapely

from craftmesh.cracks.behind_front import Plane
from craftmesh.cracks.height_fit import interpolation
from craftmesh.cracks.prescription import frame_along
from craftmesh.surface.measure import area_vectors
from craftmesh.types import Crack

STEEPEST = np.cos(np.radians(60.0))  # of the sheets to their common plane: they are one height over it


ROUNDING = 1e-9  # of a sheet's extent: places this near its outline are on it


class SheetPair(NamedTuple):
    """Two sheets over one plane: their points (n, 3) as u, v and height, triangles, and outlines."""

    plane: Plane
    places: tuple[np.ndarray, np.ndarray]
    triangles: tuple[np.ndarray, np.ndarray]
    outlines: tuple[shapely.Polygon, shapely.Polygon]

    @property
    def common(self) -> shapely.Geometry:
        """Where in the plane both sheets are."""
        return shapely.intersection(*self.outlines)

    def heights(self, number: int, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the heights (n,) of a sheet at places (n, 2), NaN beside it, and its triangles there."""
        points = self.places[number]
        near = ROUNDING * float(np.ptp(points[:, :2], axis=0).max())
        row, triangle, weights = interpolation(points[:, :2], self.triangles[number], at, near)
        heights, found = np.full(len(at), np.nan), np.full(len(at), -1)
        heights[row], found[row] = weights @ points[:, 2], triangle
        return heights, found


def sheet_pair(first: Crack, second: Crack, reach: float) -> SheetPair | None:
    """Return two sheets over their mean plane; None where it is too steep to one, or they are far apart.

    reach: sheets whose boxes are farther from each other than that are.
    """
    low = np.maximum(first.points.min(axis=0), second.points.min(axis=0))
    high = np.minimum(first.points.max(axis=0), second.points.max(axis=0))
    if (low > high + reach).any():
        return None
    vectors = [area_vectors(sheet.points, sheet.triangles) for sheet in (first, second)]
    mean = [total / np.linalg.norm(total) for total in (vector.sum(axis=0) for vector in vectors)]
    turn = 1.0 if mean[0] @ mean[1] >= 0 else -1.0
    normal = mean[0] + turn * mean[1]
    frame = frame_along(normal, np.eye(3)[np.abs(normal).argmin()])
    for vector, sign in zip(vectors, (1.0, turn)):
        if (sign * vector @ frame[2] < STEEPEST * np.linalg.norm(vector, axis=1)).any():
            return None
    plane = Plane(first.points.mean(axis=0), frame)
    places = plane.of(first.points), plane.of(second.points)
    triangles = first.triangles.astype(np.int64), second.triangles.astype(np.int64)
    outlines = [shapely.union_all(shapely.polygons(at[rows, :2])) for at, rows in zip(places, triangles)]
    if any(outline.geom_type != "Polygon" for outline in outlines):
        return None
    return SheetPair(plane, places, triangles, (outlines[0], outlines[1]))


def feet_in(region: shapely.Geometry, at: np.ndarray) -> np.ndarray:
    """Return the places (n, 2) of a region nearest to places (n, 2)."""
    lines = shapely.shortest_line(region, shapely.points(at))
    feet: np.ndarray = shapely.get_coordinates(shapely.get_point(lines, 0))
    return feet


def places_in(region: shapely.Geometry, spacing: float) -> np.ndarray:
    """Return the places (n, 2) of a square grid of that spacing within a region."""
    x0, y0, x1, y1 = region.bounds
    grid = np.stack(np.meshgrid(np.arange(x0, x1, spacing), np.arange(y0, y1, spacing)), axis=-1)
    grid = grid.reshape(-1, 2)
    inside: np.ndarray = grid[shapely.contains_xy(region, *grid.T)]
    return inside
