"""References for the crack: triangles for its vertices, the curve of its front, and its area."""

import numpy as np

from craftmesh.cracks.crack_tolerances import GRADATION
from craftmesh.cracks.polyline import Polyline, feet, polyline
from craftmesh.cracks.within_box import area_off, area_within, segments_of
from craftmesh.surface.front import front_edges
from craftmesh.surface.kernels.bins import cells_of, fill_bins, grid_over
from craftmesh.surface.kernels.distances import nearest_on_edges
from craftmesh.surface.measure import area_vectors, meets_box, total_area
from craftmesh.surface.rounding import ROUNDING
from craftmesh.types import CRACK, Crack, Surface

# Most bins of the search grid; a bin is at least as wide as the mean of the triangles' longest extents.
MOST_BINS = 2_000_000


def crack_triangles(surface: Surface, given: Crack | None) -> dict[str, np.ndarray]:
    """Return the arrays `crack_*` of Guards: crack triangles near the crack of `surface`, and their bins.

    The triangles are of the `given` crack, or of the surface's own crack if `given` is None. There are none
    if the crack of `surface` is flat, because its vertices then stay in its plane without a projection.
    """
    inserted = surface.facets[surface.kind == CRACK].astype(np.int64)
    if not len(inserted) or _is_flat(surface.points, inserted):
        return _binned(np.zeros((0, 3)), np.zeros((0, 3), np.int64))
    if given is None:
        return _binned(surface.points, inserted)
    return _binned(given.points, _near(given, surface.points[inserted]))


def _near(given: Crack, inserted: np.ndarray) -> np.ndarray:
    """Return the given crack's triangles (t, 3) that meet the bounding box of the inserted triangles.

    inserted (k, 3, 3): corners. The box is enlarged by the largest extent of one of them along an axis.
    """
    longest = np.ptp(inserted, axis=1).max()
    reach = np.stack([inserted.min(axis=(0, 1)) - longest, inserted.max(axis=(0, 1)) + longest])
    triangles = given.triangles.astype(np.int64)
    return triangles[meets_box(given.points[triangles], reach)]


def _is_flat(points: np.ndarray, facets: np.ndarray) -> bool:
    normal = area_vectors(points, facets)
    total = normal.sum(0)
    if not np.linalg.norm(total) > 0:
        return False
    total /= np.linalg.norm(total)
    height = points[np.unique(facets)] @ total
    return bool(np.ptp(height) <= ROUNDING * max(1.0, np.ptp(points, axis=0).max()))


def _binned(points: np.ndarray, triangles: np.ndarray) -> dict[str, np.ndarray]:
    """Return the arrays `crack_*` of Guards for triangles (t, 3), with the bins of their bounding boxes."""
    corners = points[triangles].reshape(-1, 3, 3)
    lower, upper = corners.min(axis=1), corners.max(axis=1)
    low, high = (lower.min(axis=0), upper.max(axis=0)) if len(triangles) else np.zeros((2, 3))
    width = max((upper - lower).max(axis=1).mean(), 1e-300) if len(triangles) else 1.0
    while np.prod((high - low) / width + 1) > MOST_BINS:
        width *= 1.25
    grid = grid_over(low, high, width)
    bins = fill_bins(cells_of(lower, grid), cells_of(upper, grid), grid)
    return {
        # a copy, because the points of Crack and Surface are read-only, and numba compiles a kernel again
        # for read-only arrays
        "crack_points": np.array(points, float, order="C"),
        "crack_triangles": triangles,
        "crack_bin_start": bins.start,
        "crack_bin_items": bins.items,
        "crack_bin_low": bins.grid.low,
        "crack_bin_width": np.array([bins.grid.width]),
        "crack_bin_shape": bins.grid.shape,
    }


# Relative to a front edge's length: largest distance of its ends from a given front that it follows, and
# largest arc length between them (an arc of 90 degrees is 1.11 times as long as its chord).
NEAR = 0.15
LONGER = 1.15
# Most equal segments of a bent edge; their number keeps the segments within GRADATION.front edge lengths of
# the curve. The given front's own points divide the edge further.
MOST_PIECES = 8


def front_segments(surface: Surface, crack: Crack | None) -> np.ndarray:
    """Return segments (s, 2, 3) of the front of `surface`, bent along the fronts of the given `crack`.

    A front edge with both ends within NEAR of one given front gets the shape of that front between the two
    ends, shifted to start and end at them. Other edges stay straight; without a `crack` all edges do.
    """
    edges = surface.points[front_edges(surface)].reshape(-1, 2, 3)
    if crack is None or not len(edges):
        return edges
    length = np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1)
    best, pieces = np.full(len(edges), np.inf), list(edges[:, None])
    for front in crack.fronts:
        curve = polyline(crack.points[front])
        arc, off = feet(curve, edges.reshape(-1, 3))
        arc, off = arc.reshape(-1, 2), off.reshape(-1, 2).max(axis=1)
        way = arc[:, 1] - arc[:, 0]
        if curve.closed:
            way -= curve.length * np.round(way / curve.length)
        follows = (off < NEAR * length) & (np.abs(way) < LONGER * length) & (off < best)
        for row in np.flatnonzero(follows):
            pieces[row] = _bent(curve, edges[row], (arc[row, 0], way[row]))
        best[follows] = off[follows]
    return np.concatenate(pieces)


def _bent(curve: Polyline, ends: np.ndarray, part: tuple[float, float]) -> np.ndarray:
    """Return segments (k, 2, 3) between two ends (2, 3), shaped as a part of the curve.

    part: the arc length at which the part begins, and its signed length. A bent part with at most
    MOST_PIECES points of the given front within it gets segment ends at these points too.
    """
    share = np.arange(MOST_PIECES + 1) / MOST_PIECES
    bulge = _shaped(curve, ends, part, share) - (ends[0] + share[:, None] * (ends[1] - ends[0]))
    height = np.linalg.norm(bulge, axis=1).max() / np.linalg.norm(ends[1] - ends[0])
    count = int(np.clip(np.ceil(np.sqrt(height / GRADATION.front)), 1, MOST_PIECES))
    share = np.arange(count + 1) / count
    arc, way = part
    ahead = (curve.arc - arc) * np.sign(way)
    within = (np.mod(ahead, curve.length) if curve.closed else ahead) / max(abs(way), np.finfo(float).tiny)
    within = within[(within > 0) & (within < 1)]
    if count > 1 and len(within) <= MOST_PIECES:
        share = np.unique(np.concatenate([share, within]))
    line = _shaped(curve, ends, part, share)
    return np.stack([line[:-1], line[1:]], axis=1)


def _shaped(curve: Polyline, ends: np.ndarray, part: tuple[float, float], share: np.ndarray) -> np.ndarray:
    """Return points (k, 3) on a part of the curve, shifted so that the first and last meet the two `ends`.

    share (k,): fractions of the part's arc length, from 0 to 1.
    """
    arc, way = part
    line = curve.at(arc + share * way)
    return line + (1 - share[:, None]) * (ends[0] - line[0]) + share[:, None] * (ends[1] - line[-1])


class HeldArea:
    """The crack area that the gradation must keep; l_min in model units.

    This target is the given crack's area within the surface's bounding box. If the area in the input
    surface differs from it by more than the allowed error (`area_off`), for example because parts of the
    crack lie in voids, the input's area is the target.
    """

    def __init__(self, surface: Surface, given: Crack | None, l_min: float) -> None:
        self.l_min = l_min
        front = front_edges(surface)
        self.points, self.fronts = np.array(surface.points, float, order="C"), front
        self.area = _area(surface)
        if given is None or not len(surface.points):
            return
        lines = [np.column_stack([line[:-1], line[1:]]) for line in given.fronts]
        self.points = np.array(given.points, float, order="C")
        self.fronts = np.concatenate([np.zeros((0, 2)), *lines]).astype(np.int64)
        box = np.stack([surface.points.min(axis=0), surface.points.max(axis=0)])
        whole = area_within(given, box)
        if area_off(self.area, whole, self._segments(surface, front), l_min) <= 1:
            self.area = whole

    def times_off(self, surface: Surface) -> float:
        """Return the error of the crack area of `surface` over the allowed error; 0 without a crack."""
        if not self.area:
            return 0.0
        return area_off(
            _area(surface), self.area, self._segments(surface, front_edges(surface)), self.l_min
        )

    def _segments(self, surface: Surface, front: np.ndarray) -> float:
        if not len(front) or not len(self.fronts):
            return 0.0
        chords = surface.points[front]
        middles = np.ascontiguousarray(chords.mean(axis=1))
        foot = nearest_on_edges(middles, self.points, self.fronts)
        return segments_of(chords, np.linalg.norm(foot - middles, axis=1))


def _area(surface: Surface) -> float:
    return total_area(surface.points, surface.facets[surface.kind == CRACK])
