"""Merge crack surfaces that almost coincide where they overlap, or whose fronts touch."""

from itertools import combinations
from typing import NamedTuple

import numpy as np
import shapely

from craftmesh.cracks.behind_front import Plane
from craftmesh.cracks.crack_tolerances import LEAST_AREA_PROMISED, PREPARATION, PROMISED
from craftmesh.cracks.height_fit import interpolation
from craftmesh.cracks.in_plane import filled
from craftmesh.cracks.prescription import frame_along
from craftmesh.cracks.sheets import one_crack, sheets
from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.surface.measure import area_vectors
from craftmesh.surface.rounding import ROUNDING, SAME_PLACE
from craftmesh.types import Crack

STEEPEST = np.cos(np.radians(60.0))  # cosine of the steepest slope of two surfaces to their common plane


class SheetPair(NamedTuple):
    """Two surfaces over one plane: a plane, and of each surface points, triangles and outline.

    places (n, 3): u, v and height; triangles (m, 3); outlines: polygons in u and v.
    """

    plane: Plane
    places: tuple[np.ndarray, np.ndarray]
    triangles: tuple[np.ndarray, np.ndarray]
    outlines: tuple[shapely.Polygon, shapely.Polygon]

    @property
    def common(self) -> shapely.Geometry:
        """The region of the plane that both surfaces cover."""
        return shapely.intersection(*self.outlines)

    def heights(self, number: int, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return heights (n,) of a surface at places (n, 2), NaN off it, and triangles (n,), -1 off it."""
        points = self.places[number]
        near = ROUNDING * float(np.ptp(points[:, :2], axis=0).max())
        row, triangle, weights = interpolation(points[:, :2], self.triangles[number], at, near)
        heights, found = np.full(len(at), np.nan), np.full(len(at), -1)
        heights[row], found[row] = weights @ points[:, 2], triangle
        return heights, found


def sheet_pair(first: Crack, second: Crack, reach: float) -> SheetPair | None:
    """Return two surfaces over their mean plane: points as u, v and height, and outlines in the plane.

    reach: largest gap between their bounding boxes along an axis. Returns None if the gap is larger, if a
    triangle is steeper than STEEPEST to the plane, or if an outline is not one polygon.
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
    places = plane.to_uvh(first.points), plane.to_uvh(second.points)
    triangles = first.triangles.astype(np.int64), second.triangles.astype(np.int64)
    outlines = [shapely.union_all(shapely.polygons(at[rows, :2])) for at, rows in zip(places, triangles)]
    if any(outline.geom_type != "Polygon" for outline in outlines):
        return None
    return SheetPair(plane, places, triangles, (outlines[0], outlines[1]))


def feet_in(region: shapely.Geometry, at: np.ndarray) -> np.ndarray:
    """Return the points (n, 2) of a region nearest to places (n, 2)."""
    lines = shapely.shortest_line(region, shapely.points(at))
    feet: np.ndarray = shapely.get_coordinates(shapely.get_point(lines, 0))
    return feet


def grid_points_in(region: shapely.Geometry, spacing: float) -> np.ndarray:
    """Return the points (n, 2) of a square grid with this spacing within a region."""
    x0, y0, x1, y1 = region.bounds
    grid = np.stack(np.meshgrid(np.arange(x0, x1, spacing), np.arange(y0, y1, spacing)), axis=-1)
    grid = grid.reshape(-1, 2)
    inside: np.ndarray = grid[shapely.contains_xy(region, *grid.T)]
    return inside


# Largest gap and largest overlap, in l_min, of surfaces that are joined at a neck, a strip across the gap.
# Measured on two coplanar pennies of radius 7 l_min that were not joined: an overlap of 0.02 left 4 flat
# tets and a bare touch 2; an overlap of 0.05 or a gap of 0.02 left none.
GAP = PROMISED.front
OVERLAP = 0.04
# Widest strip between two fronts that is filled, in l_min; each front then moves by up to half of it.
WIDTH = 2 * PREPARATION.front
# Distance from a neck's corner, in l_min, in which the front loses its points and becomes straight. Points
# kept near the corner would become mesh nodes that are as close to it.
STRAIGHT = 0.5
SAME = 1e-3  # lengths below this are taken as rounding, in WIDTH / 2
ARC = 32  # segments of a quarter circle with the radius WIDTH / 2


def with_neck(pair: SheetPair, l_min: float) -> shapely.Polygon | None:
    """Return the outline of two surfaces that nearly touch, with the strips between them filled.

    Return None if they are farther apart than GAP or overlap by more than OVERLAP. Where a strip becomes
    too wide to fill, both fronts end in one corner half way between them.
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
    """Return a closed ring (k, 2) in which each edge across the open end of a filled strip is a corner.

    The ring is straight up to `straight` from the corner: it loses its points there. reach: half of the
    largest width of a strip; an edge whose middle is farther than half of that from the surfaces `both`
    lies across an end.
    """
    middle = (ring[:-1] + np.roll(ring[:-1], -1, axis=0)) / 2
    across = shapely.distance(both, shapely.points(middle)) > reach / 2
    if not across.any():
        return ring
    corners = shapely.multipoints(middle[across])
    far = shapely.distance(corners, shapely.points(ring[:-1])) > straight
    points = np.where(across[:, None], middle, ring[:-1])[across | far]
    return np.concatenate([points, points[:1]])


def heights_at_neck(pair: SheetPair, at: np.ndarray) -> np.ndarray:
    """Return heights (n,) at places (n, 2): from the first surface, the second, or interpolated between.

    At a place off both surfaces, the heights at the nearest points of both are weighted by their distances.
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


SPACING = 0.25  # spacing, in l_min, of points where surfaces are compared and of the merged surface
CLOSE = 0.1  # surfaces joined at a neck lose their points nearer than this to the other one, in l_min
BLEND = 3.0  # length, in l_min, beyond the first surface over which the second returns to its own height


def merged_sheets(crack: Crack, box: np.ndarray, l_min: float, reach: float) -> Crack:
    """Return the crack with surfaces merged that overlap with a gap of at most `reach`; box (2, 3).

    Where both exist, the merged surface follows the first. Beyond the first, it follows the second, whose
    height is blended with the first's over BLEND l_min. Surfaces that only touch or nearly touch are merged
    with the strip between them. Surfaces that coincide to rounding stay as they are, as do surfaces that
    are farther apart than `reach` somewhere in their overlap.
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
    """Return two surfaces as one; None unless they nearly touch, or overlap at a gap of at most `reach`."""
    pair = sheet_pair(first, second, reach)
    if pair is None:
        return None
    whole = with_neck(pair, l_min)
    if whole is not None:
        return _joined_at_neck(pair, whole, box, l_min, reach)
    common = pair.common
    if common.area < LEAST_AREA_PROMISED * l_min**2:
        return None
    at = np.concatenate([grid_points_in(common, SPACING * l_min), shapely.get_coordinates(common)])
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
    """Return two surfaces that nearly touch as one; None if their nearest points differ more in height.

    whole: outline of the joined surface; reach: largest such difference.
    """
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
    """Return the surface through points (n, 2) of the pair's plane at `heights` (n,) over it."""
    points = pair.plane.lifted(np.column_stack([uv, heights]))
    return crack_from_triangles(points, triangles, None, box)


def _blended(pair: SheetPair, uv: np.ndarray, reach: float) -> np.ndarray:
    """Return heights (n,) of the merged surface at `uv` (n, 2): the first's, or the second's, blended.

    reach: length over which the second surface returns to its own height.
    """
    heights, second = (pair.heights(number, uv)[0] for number in range(2))
    beside = np.flatnonzero(np.isnan(heights))
    common = pair.common
    foot = feet_in(common, uv[beside])
    step = pair.heights(0, foot)[0] - pair.heights(1, foot)[0]
    share = np.clip(1 - shapely.distance(common, shapely.points(uv[beside])) / reach, 0, 1)
    heights[beside] = second[beside] + share * np.where(np.isnan(step), 0.0, step)
    return heights
