"""Two sheets whose fronts all but touch: the strip between them, too narrow for elements, is crack too."""

import numpy as np
import shapely

from craftmesh.cracks.sheet_pair import SheetPair, feet_in

# Of l_min, two coplanar pennies of 7 l_min: 0.02 of overlap left 4 flat tets, the bare touch 2; 0.05 of
# overlap and 0.02 of a gap none. Where fronts are farther apart than the first, or overlap by more than
# the second, they stay as they are.
GAP = 0.02
OVERLAP = 0.04
# Of l_min: as far as it is narrower than this a strip is filled, so that no front is moved by 0.02.
WIDTH = 0.036
# Of l_min: so far on from there the front is straight. Where it kept its points, as near to the corner as
# they stood, its nodes stood as near.
STRAIGHT = 0.5
ROUNDING = 1e-3  # of WIDTH: what differs by less is the same
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
    near = ROUNDING * reach
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
