"""Sheets of a crack that lie over each other almost in one surface, or whose fronts touch, become one."""

from itertools import combinations
from typing import NamedTuple

import numpy as np
import shapely

from craftmesh.cracks.behind_front import Plane
from craftmesh.cracks.height_fit import interpolation
from craftmesh.cracks.in_plane import filled
from craftmesh.cracks.prescription import frame_along
from craftmesh.cracks.promises import LEAST_AREA_PROMISED, PREPARATION, PROMISED
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


# Of l_min, two coplanar pennies of 7 l_min: 0.02 of overlap left 4 flat tets, the bare touch 2; 0.05 of
# overlap and 0.02 of a gap none. Where fronts are farther apart than the first, or overlap by more than
# the second, they stay as they are.
GAP = PROMISED.front
OVERLAP = 0.04
# Of l_min: as far as it is narrower than this a strip is filled, and each front moves by half of it.
WIDTH = 2 * PREPARATION.front
# Of l_min: so far on from there the front is straight. Where it kept its points, as near to the corner as
# they stood, its nodes stood as near.
STRAIGHT = 0.5
SAME = 1e-3  # of WIDTH: what differs by less is the same
ARC = 32  # segments of a quarter of a circle of WIDTH / 2


def with_neck(pair: SheetPair, l_min: float) -> shapely.Polygon | None:
    """Return the outline of two sheets that touch or all but do, with the strips between them filled.

    None where they are apart, or overlap in more. Where a strip becomes wide both fronts end in one
    corner, half way between them.
    """
    apart = shapely.distance(*pair.outlines)
    if apart > GAP * l_min or not pair.common.buffer(-OVERLAP / 2 * l_min).is_empty:
        return None
    reach = WIDTH / 2 * l_min
    near = SAME * reach
    both = shapely.union(*pair.outlines)
    closed = both.buffer(reach, quad_segs=ARC).buffer(-reach, join_style="bevel")
    strips = shapely.get_parts(closed.difference(both.buffer(near)))
    strips = strips[shapely.area(strips) > reach**2]
    whole = shapely.union_all([both, *shapely.buffer(strips, 2 * near)]).simplify(4 * near)
    if whole.geom_type != "Polygon":
        return None
    holes = [ring for ring in whole.interiors if shapely.Polygon(ring).area > reach**2]
    rings = [
        _pointed(np.asarray(ring.coords), both, reach, STRAIGHT * l_min)
        for ring in (whole.exterior, *holes)
    ]
    pointed = shapely.Polygon(rings[0], rings[1:])
    return pointed if pointed.is_valid else None


def _pointed(ring: np.ndarray, both: shapely.Geometry, reach: float, straight: float) -> np.ndarray:
    """Return a closed ring (k, 2) whose edges across the mouths of strips are corners, straight around."""
    middle = (ring[:-1] + np.roll(ring[:-1], -1, axis=0)) / 2
    across = shapely.distance(both, shapely.points(middle)) > reach / 2
    if not across.any():
        return ring
    corners = shapely.multipoints(middle[across])
    far = shapely.distance(corners, shapely.points(ring[:-1])) > straight
    points = np.where(across[:, None], middle, ring[:-1])[across | far]
    return np.concatenate([points, points[:1]])


def heights_at_neck(pair: SheetPair, at: np.ndarray) -> np.ndarray:
    """Return the heights (n,) at places (n, 2): the first sheet's, the second's, or between both of them.

    Beside both the sheets' ends count by the distances from these.
    """
    first, second = (pair.heights(number, at)[0] for number in range(2))
    heights = np.where(np.isnan(first), second, first)
    beside = np.isnan(heights)
    between = at[beside]
    ends = [pair.heights(k, feet_in(outline, between))[0] for k, outline in enumerate(pair.outlines)]
    away = [shapely.distance(outline, shapely.points(between)) for outline in pair.outlines]
    total = away[0] + away[1]
    heights[beside] = (ends[0] * away[1] + ends[1] * away[0]) / np.where(total > 0, total, 1.0)
    return heights


SPACING = 0.25  # of l_min: places at which the sheets are held against each other, and the new triangles
CLOSE = 0.1  # of l_min: points of sheets so near to the other are left out where both become one
BLEND = 3.0  # l_min: over this way from the first sheet's front on the second comes back to its own height


def merged_sheets(crack: Crack, box: np.ndarray, l_min: float, reach: float) -> Crack:
    """Return the crack with sheets that overlap at a distance of `reach` at most made one; box (2, 3).

    Where both are, the new sheet is the first one; beyond that the second, which comes from the first's
    height to its own within BLEND l_min. Sheets that only touch, or all but do, are one with the strip
    between them. Others in one surface to rounding stay as they are, and so do those that are farther than
    `reach` from each other somewhere.
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
    whole = with_neck(pair, l_min)
    if whole is not None:
        return _joined_at_neck(pair, whole, box, l_min, reach)
    common = pair.common
    if common.area < LEAST_AREA_PROMISED * l_min**2:
        return None
    at = np.concatenate([places_in(common, SPACING * l_min), shapely.get_coordinates(common)])
    most = float(np.nanmax(np.abs(pair.heights(1, at)[0] - pair.heights(0, at)[0]), initial=0.0))
    whole = shapely.union(*pair.outlines)
    if not SAME_PLACE * l_min < most <= reach or whole.geom_type != "Polygon":
        return None
    apart = ~shapely.contains_xy(pair.outlines[0], *pair.places[1][:, :2].T)
    given = np.concatenate([pair.places[0][:, :2], pair.places[1][apart, :2]])
    uv, triangles = filled(whole, given, SPACING * l_min)
    return _sheet(pair, uv, _blended(pair, uv, BLEND * l_min), triangles, box)


def _joined_at_neck(
    pair: SheetPair, whole: shapely.Polygon, box: np.ndarray, l_min: float, reach: float
) -> Crack | None:
    """Return two sheets that all but touch as one, None where their heights differ by more than `reach`."""
    ends = shapely.get_coordinates(shapely.shortest_line(*pair.outlines))
    low, high = (pair.heights(number, ends[[number]])[0][0] for number in range(2))
    if not abs(high - low) <= reach:
        return None
    given = []
    for places, other in zip(pair.places, pair.outlines[::-1]):
        away = shapely.distance(other, shapely.points(places[:, :2]))
        given.append(places[away > CLOSE * l_min, :2])
    uv, triangles = filled(whole, np.concatenate(given), SPACING * l_min)
    return _sheet(pair, uv, heights_at_neck(pair, uv), triangles, box)


def _sheet(
    pair: SheetPair, uv: np.ndarray, heights: np.ndarray, triangles: np.ndarray, box: np.ndarray
) -> Crack:
    """Return the sheet through places (n, 2) of the pair's plane, at heights (n,) over it."""
    points = pair.plane.lifted(np.column_stack([uv, heights]))
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
