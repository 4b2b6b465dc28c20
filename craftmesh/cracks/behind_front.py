"""The cracked part of a plane: within closed fronts, or behind an open front as far as the box."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.ops import split

from craftmesh.cracks.near_faces import ALONG
from craftmesh.errors import CraftmeshError, rounded_values
from craftmesh.surface.rounding import ROUNDING
from craftmesh.types import BOX_PLANES

MARGIN = 0.05  # distance by which the crack's surface extends past the box, in box diagonals
# Largest distance of an open front's end from the box, relative to the front's length; the front is then
# extended to the box.
END_TO_BOX = 0.1


@dataclass(frozen=True, eq=False)
class Plane:
    """A plane with coordinates (u, v) and height: origin (3,), rows u, v, normal (3, 3)."""

    origin: np.ndarray
    frame: np.ndarray

    def to_uvh(self, points: np.ndarray) -> np.ndarray:
        """Return coordinates u, v and height (k, 3) of points (k, 3)."""
        return (points - self.origin) @ self.frame.T

    def lifted(self, uvh: np.ndarray) -> np.ndarray:
        """Return the points (k, 3) at u, v and height (k, 3)."""
        return self.origin + uvh @ self.frame


def cracked_part(
    fronts: Sequence[np.ndarray], plane: Plane, box: np.ndarray, witnesses: np.ndarray, heights: np.ndarray
) -> shapely.Polygon:
    """Return the polygon in (u, v) that the fronts (k, 3) bound, in the box (2, 3) and a margin around it.

    Closed fronts bound the area within the largest one; the others are holes. One open front, whose ends
    are on the box or near it, divides the box: the side with most of the witnesses (j, 3), points of the
    crack, is cracked, or without witnesses the smaller side. heights: all given points' heights over the
    plane; the box is sectioned between the smallest and largest. Raise CraftmeshError for any other set of
    fronts, for fronts that cross themselves, and for an open front whose end is too far from the box.
    """
    closed = [front for front in fronts if is_closed(front)]
    if len(closed) == len(fronts):
        return _within(closed, plane)
    if len(fronts) > 1:
        raise CraftmeshError(
            f"the crack has {len(fronts)} fronts, {len(fronts) - len(closed)} of them open; give "
            "only closed fronts, or one open front that ends on the box"
        )
    section = _section(plane, box, heights)
    region = section.buffer(MARGIN * np.linalg.norm(box[1] - box[0]), join_style="mitre")
    line = shapely.LineString(_carried_on(fronts[0], plane, box))
    if not line.is_simple:
        raise CraftmeshError("the crack's front crosses itself; expected a front without crossings")
    parts = [part for part in split(region, line).geoms if part.area > ROUNDING * region.area]
    if len(parts) != 2:
        raise CraftmeshError(
            f"the crack's front divides the box into {len(parts)} pieces; expected two: give a front that "
            "ends on the box"
        )
    if not len(witnesses):
        return min(parts, key=lambda part: shapely.intersection(part, section).area)
    uv = plane.to_uvh(witnesses)
    return max(parts, key=lambda part: shapely.contains_xy(part, uv[:, 0], uv[:, 1]).sum())


def is_closed(front: np.ndarray) -> bool:
    """Return whether the last point of a front (k, 3) repeats its first."""
    return bool((front[0] == front[-1]).all())


def _within(fronts: Sequence[np.ndarray], plane: Plane) -> shapely.Polygon:
    """Return the area in (u, v) within the largest of closed fronts, minus the areas within the others.

    Raise CraftmeshError if a front crosses itself or the fronts bound several areas.
    """
    rings = [shapely.Polygon(plane.to_uvh(front)[:, :2]) for front in fronts]
    if any(not ring.is_valid for ring in rings):
        raise CraftmeshError("the crack's front crosses itself; expected a front without crossings")
    outer = int(np.argmax([ring.area for ring in rings]))
    holes = [ring for k, ring in enumerate(rings) if k != outer]
    left = shapely.difference(rings[outer], shapely.union_all(holes))
    if not isinstance(left, shapely.Polygon) or any(not rings[outer].contains(hole) for hole in holes):
        raise CraftmeshError("the crack's fronts bound several areas; give one outline and its holes")
    return left


def _section(plane: Plane, box: np.ndarray, heights: np.ndarray) -> shapely.Polygon:
    """Return the convex hull in (u, v) of sections of the box: at the plane and at the extreme `heights`.

    Raise CraftmeshError if none of these sections cuts the box.
    """
    corner = np.stack(np.meshgrid(*box.T, indexing="ij"), axis=-1).reshape(-1, 3)
    ends = [(i, i | bit) for bit in (1, 2, 4) for i in range(8) if not i & bit]
    a, b = (plane.to_uvh(corner[[end[k] for end in ends]]) for k in range(2))
    found = [np.zeros((0, 2))]
    for height in (heights.min(), heights.max(), 0.0):
        below, above = a[:, 2] - height, b[:, 2] - height
        crosses = below * above <= 0
        share = np.clip(below / np.where(below == above, 1.0, below - above), 0, 1)[:, None]
        found.append((a + share * (b - a))[crosses, :2])
    hull = shapely.MultiPoint(np.concatenate(found)).convex_hull
    if hull.area == 0:
        raise CraftmeshError(f"the crack lies outside the box {rounded_values(box)}; move it into the box")
    return hull


def _carried_on(front: np.ndarray, plane: Plane, box: np.ndarray) -> np.ndarray:
    """Return the front in (u, v) with both ends extended to the box and straight out of it."""
    reach = END_TO_BOX * float(np.linalg.norm(np.diff(front, axis=0), axis=1).sum())
    head = _way_out(front[0], front[0] - front[1], plane, box, reach)
    tail = _way_out(front[-1], front[-1] - front[-2], plane, box, reach)
    return np.concatenate([head[::-1], plane.to_uvh(front)[:, :2], tail])


def _way_out(
    end: np.ndarray, heading: np.ndarray, plane: Plane, box: np.ndarray, reach: float
) -> np.ndarray:
    """Return points (k, 2), in u and v, that extend a front from its end (3,) to a box face and beyond it.

    The first lies on the face nearest to the end, in the direction `heading` (3,) of the front there; it is
    left out if the end is on the face. The last lies far outside, so that the line divides the box. Raise
    CraftmeshError if the end is more than `reach` from the face or the crack lies along the face.
    """
    inward = np.stack([end - box[0], box[1] - end], axis=1).ravel()  # from XMIN, XMAX, YMIN, ...
    face = int(np.argmin(inward))
    axis, sign = face // 2, 1.0 if face % 2 else -1.0
    where = f"the crack's front ends at {rounded_values(end)}"
    if inward[face] > reach:
        raise CraftmeshError(
            f"{where}, {inward[face]:.4g} inside the box face {BOX_PLANES[face]}; end it on the box, or "
            "close the front by repeating its first point"
        )
    out = sign * plane.frame[:2, axis]
    if np.linalg.norm(out) < ALONG:
        raise CraftmeshError(
            f"{where} on the box face {BOX_PLANES[face]}, but the crack lies along that face; give a crack "
            "that meets the face at an angle"
        )
    out = out / np.linalg.norm(out)
    place, far = plane.to_uvh(end[None])[0, :2], 2 * np.linalg.norm(box[1] - box[0])
    if inward[face] <= 0:
        return (place + far * out)[None]
    pace = sign * heading[axis] / np.linalg.norm(heading)
    ahead = plane.frame[:2] @ heading / np.linalg.norm(heading) if pace > ALONG else ALONG * out
    on_face = place + inward[face] / max(pace, ALONG) * ahead
    return np.stack([on_face, on_face + far * out])
