"""Sheets of a crack that lie over each other, almost in one surface: they become one sheet."""

from itertools import combinations

import numpy as np
import shapely

from craftmesh.cracks.in_plane import filled
from craftmesh.cracks.necks import heights_at_neck, with_neck
from craftmesh.cracks.sheet_pair import SheetPair, feet_in, places_in, sheet_pair
from craftmesh.cracks.sheets import joined, sheets
from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.types import Crack

SPACING = 0.25  # of l_min: places at which the sheets are held against each other, and the new triangles
LEAST_AREA = 0.01  # of l_min squared: sheets that lie over each other on less only touch
MERGED = 0.02  # of l_min: given cracks that overlap within this, what a front may be off, become one
EXACT = 1e-6  # of l_min: sheets this near each other lie in one surface already, and stay two
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
    return crack if parts is given else joined(parts)


def _merged(first: Crack, second: Crack, box: np.ndarray, l_min: float, reach: float) -> Crack | None:
    """Return two sheets as one, None where they are not to be merged."""
    pair = sheet_pair(first, second, reach)
    if pair is None:
        return None
    whole = with_neck(pair, l_min)
    if whole is not None:
        return _joined_at_neck(pair, whole, box, l_min, reach)
    if pair.common.area < LEAST_AREA * l_min**2:
        return None
    common = pair.common
    at = np.concatenate([places_in(common, SPACING * l_min), shapely.get_coordinates(common)])
    most = float(np.nanmax(np.abs(pair.heights(1, at)[0] - pair.heights(0, at)[0]), initial=0.0))
    whole = shapely.union(*pair.outlines)
    if not EXACT * l_min < most <= reach or whole.geom_type != "Polygon":
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
