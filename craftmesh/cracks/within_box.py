"""The part of a crack in a box: clipped triangles, area, tilt to the faces, and whether in grains."""

import numpy as np

from craftmesh.cracks.crack_tolerances import AREA_KEPT, AREA_PROMISED, LEAST_AREA_PROMISED
from craftmesh.surface.facet_subdivision import bisected
from craftmesh.surface.measure import area_vectors, meets_box, total_area
from craftmesh.surface.rounding import EXACT
from craftmesh.types import Crack, Voxels


def area_within(crack: Crack, box: np.ndarray) -> float:
    """Return the area of the part of a crack that lies in the box (2, 3)."""
    corners = crack.points[crack.triangles]
    whole = ((corners >= box[0]) & (corners <= box[1])).all(axis=(1, 2))
    across = ~whole & meets_box(corners, box)
    inside = total_area(crack.points, crack.triangles[whole])
    parts = (clipped(triangle, box) for triangle in corners[across])
    return float(inside + sum(polygon_area(part) for part in parts if len(part) > 2))


def is_in_material(crack: Crack, voxels: Voxels) -> bool:
    """Return whether any part of a crack in the box lies in a grain, sampled at the spacing of voxels.

    True also if no part of the crack lies in the box.
    """
    pieces = bisected(crack.points[crack.triangles], voxels.box, voxels.spacing.min())
    places = pieces.mean(axis=1)
    cells = np.floor((places - voxels.origin) / voxels.spacing).astype(int)
    cells = cells[((cells >= 0) & (cells < voxels.labels.shape)).all(axis=1)]
    return not len(cells) or bool((voxels.labels[tuple(cells.T)] > 0).any())


def clipped(polygon: np.ndarray, slab: np.ndarray) -> np.ndarray:
    """Return the part (k, 3) of a convex polygon (j, 3) that lies in the axis-aligned box `slab` (2, 3)."""
    for axis in range(3):
        for inward, plane in ((1.0, slab[0, axis]), (-1.0, slab[1, axis])):
            depth = inward * (polygon[:, axis] - plane)
            if (depth >= 0).all():
                continue
            after, depth_after = np.roll(polygon, -1, axis=0), np.roll(depth, -1)
            pieces = []
            for a, b, at_a, at_b in zip(polygon, after, depth, depth_after):
                if at_a >= 0:
                    pieces.append(a)
                if at_a * at_b < 0:
                    pieces.append(a + at_a / (at_a - at_b) * (b - a))
            polygon = np.array(pieces).reshape(-1, 3)
    return polygon


def is_in(corners: np.ndarray, box: np.ndarray) -> bool:
    """Return whether any triangle (m, 3, 3) has area inside the box (2, 3); touching it does not count."""
    least = EXACT * float(((box[1] - box[0]) ** 2).sum())
    parts = (clipped(triangle, box) for triangle in corners[meets_box(corners, box)])
    return any(len(part) > 2 and polygon_area(part) > least for part in parts)


def polygon_area(polygon: np.ndarray) -> float:
    """Return the area of a convex polygon (k, 3)."""
    spokes = polygon[1:] - polygon[0]
    return float(np.linalg.norm(np.cross(spokes[:-1], spokes[1:]).sum(axis=0)) / 2)


def tilts(crack: Crack) -> np.ndarray:
    """Return angles (m, 3) in degrees of a crack's triangles to the box faces normal to x, y and z."""
    vectors = area_vectors(crack.points, crack.triangles)
    size = np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), np.finfo(float).tiny)
    return np.degrees(np.arccos(np.minimum(np.abs(vectors) / size, 1.0)))


def area_off(area: float, given: float, segments: float, unit: float) -> float:
    """Return the error of an area in units of the error that insertion and gradation are allowed.

    given: expected area; segments: area between the front and its chords, which `area` may lack at no cost;
    unit: smallest target length. 1 is the largest allowed error.
    """
    off = min(abs(area - given), abs(area - given + segments))
    return off / (AREA_KEPT * max(AREA_PROMISED * given, LEAST_AREA_PROMISED * unit**2))


def segments_of(chords: np.ndarray, off: np.ndarray) -> float:
    """Return the area between a front and its chords (k, 2, 3), as if each piece of it were a parabola.

    off (k,): distances of the chords' middles from the front.
    """
    length = np.linalg.norm(chords[:, 1] - chords[:, 0], axis=1)
    return float((2 / 3 * length * off).sum()) if len(chords) else 0.0
