"""Sheets of a crack that lie over each other, almost in one surface: they become one sheet."""

from itertools import combinations
from typing import NamedTuple

import numpy as np
import shapely

from craftmesh.cracks.behind_front import Plane
from craftmesh.cracks.height_fit import interpolation
from craftmesh.cracks.in_plane import filled
from craftmesh.cracks.prescription import frame_along
from craftmesh.cracks.promises import LEAST_AREA
from craftmesh.cracks.sheets import one_crack, sheets
from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.surface.measure import area_vectors
from craftmesh.surface.rounding import ROUNDING, SAME_PLACE
from craftmesh.types import Crack

STEEPEST = np.cos(np.radians(60.0))  # of the sheets to their common plane: they are one height over it


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


SPACING = 0.25  # of l_min: places at which the sheets are held against each other, and the new triangles
BLEND = 3.0  # l_min: over this way from the first sheet's front on the second comes back to its own height


def merged_sheets(crack: Crack, box: np.ndarray, l_min: float, reach: float) -> Crack:
    """Return the crack with sheets that overlap at a distance of `reach` at most made one; box (2, 3).

    Where both are, the new sheet is the first one; beyond that the second, which comes from the first's
    height to its own within BLEND l_min. Sheets that only touch, those in one surface to rounding and
    those that are farther than `reach` from each other somewhere stay as they are.
    """
    given = parts = sheets(crack)
    pairs = list(combinations(range(len(parts)), 2))
    while pairs:
        low, high = pairs.pop(0)
        one = _merged(parts[low], parts[high], box, l_min, reach)
        if one is not None:
            parts = [one if k == low else part for k, part in enumerate(parts) if k != high]
            pairs = list(combinations(range(len(parts)), 2))
    return crack if parts is given else one_crack(parts)


def _merged(first: Crack, second: Crack, box: np.ndarray, l_min: float, reach: float) -> Crack | None:
    """Return two sheets as one, None where they are not to be merged."""
    pair = sheet_pair(first, second, reach)
    if pair is None:
        return None
    common = pair.common
    if common.area < LEAST_AREA * l_min**2:
        return None
    at = np.concatenate([places_in(common, SPACING * l_min), shapely.get_coordinates(common)])
    most = float(np.nanmax(np.abs(pair.heights(1, at)[0] - pair.heights(0, at)[0]), initial=0.0))
    whole = shapely.union(*pair.outlines)
    if not SAME_PLACE * l_min < most <= reach or whole.geom_type != "Polygon":
        return None
    apart = ~shapely.contains_xy(pair.outlines[0], *pair.places[1][:, :2].T)
    given = np.concatenate([pair.places[0][:, :2], pair.places[1][apart, :2]])
    uv, triangles = filled(whole, given, SPACING * l_min)
    points = pair.plane.lifted(np.column_stack([uv, _blended(pair, uv, BLEND * l_min)]))
    return crack_from_triangles(points, triangles, None, box)


def _blended(pair: SheetPair, uv: np.ndarray, reach: float) -> np.ndarray:
    """Return the heights (n,) of the merged sheet at places (n, 2); reach: of the first beside itself."""
    heights, second = (pair.heights(number, uv)[0] for number in range(2))
    beside = np.flatnonzero(np.isnan(heights))
    common = pair.common
    foot = feet_in(common, uv[beside])
    step = pair.heights(0, foot)[0] - pair.heights(1, foot)[0]
    share = np.clip(1 - shapely.distance(common, shapely.points(uv[beside])) / reach, 0, 1)
    heights[beside] = second[beside] + share * np.where(np.isnan(step), 0.0, step)
    return heights
