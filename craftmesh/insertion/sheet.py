"""The crack as a function: signed distance from its surface, and parameters (u, v) on it."""

from dataclasses import dataclass

import numpy as np
import shapely

from craftmesh.cracks.height_parts import best_fit_frame
from craftmesh.cracks.in_plane import doubled_areas
from craftmesh.cracks.near_sheet import closest_points_on_triangles, weights_in_triangles
from craftmesh.insertion.rim import Rim, rim_of
from craftmesh.surface.kernels.bins import Bins
from craftmesh.surface.kernels.holding import bins_of, holding
from craftmesh.surface.rounding import EXACT, ROUNDING, SAME_PLACE
from craftmesh.types import Crack

STEPS = 40  # most false-position iterations for a segment that crosses a curved crack
STRETCHES = 8  # intervals on each side of a point, along its direction, in which a sign change is searched


@dataclass(frozen=True, eq=False)
class Sheet:
    """A crack as a single-valued surface over a plane; lengths in model units.

    origin (3,), frame (3, 3): rows u, v, normal. nodes (n, 2): points in (u, v), with height (n,) and mean
    slope node_slope (n, 2); triangles (m, 3), with slope (m, 2). cells, bins: search tree and grid of the
    triangles; rim: the crack's boundary in the same parameters.
    """

    origin: np.ndarray
    frame: np.ndarray
    nodes: np.ndarray
    height: np.ndarray
    node_slope: np.ndarray
    triangles: np.ndarray
    slope: np.ndarray
    planar: bool
    cells: shapely.STRtree
    bins: Bins
    rim: Rim

    def uv(self, points: np.ndarray) -> np.ndarray:
        """Return parameters (n, 2) of points (n, 3): lengths along the sheet's first two axes."""
        return (points - self.origin) @ self.frame[:2].T

    def offset(self, points: np.ndarray) -> np.ndarray:
        """Return psi (n,): height of points (n, 3) over the extrapolated surface, > 0 ahead of it."""
        above = (points - self.origin) @ self.frame[2]
        return above if self.planar else above - self.height_at(self.uv(points))

    def lift(self, uv: np.ndarray) -> np.ndarray:
        """Return points (n, 3) of the surface at parameters (n, 2)."""
        points = self.origin + uv @ self.frame[:2]
        return points if self.planar else points + self.height_at(uv)[:, None] * self.frame[2]

    def height_at(self, uv: np.ndarray) -> np.ndarray:
        """Return heights (n,) at parameters (n, 2), extrapolated past the rim with the slope there."""
        cell, weight, step = self._feet(uv)
        height = np.einsum("ij,ij->i", weight, self.height[self.triangles[cell]])
        return height + np.einsum("ij,ij->i", self._slope_at(cell, weight, step), step)

    def gradient(self, points: np.ndarray) -> np.ndarray:
        """Return the gradient (n, 3) of the offset psi at points (n, 3); its length is 1 if planar."""
        if self.planar:
            return np.tile(self.frame[2], (len(points), 1))
        return self.frame[2] - self._slope_at(*self._feet(self.uv(points))) @ self.frame[:2]

    def crossings(self, start: np.ndarray, end: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return positions (n,), 0 to 1 from start to end (n, 3), where psi changes sign, and psi there.

        psi must have opposite signs at start and end, or be 0 at one (not checked). The method is false
        position with the Illinois rule (Dowell & Jarratt 1971), at most STEPS iterations. psi at the result
        is not 0 where the extrapolation past the rim jumps.
        """
        low, high = np.zeros(len(start)), np.ones(len(start))
        at_low, at_high = self.offset(start), self.offset(end)
        span = at_low - at_high
        root = at_low / np.where(span == 0, 1, span)
        if self.planar:
            return root, np.zeros(len(start))
        step = end - start
        value = self.offset(start + root[:, None] * step)
        for _ in range(STEPS):
            if np.abs(value).max(initial=0) <= EXACT * np.abs(step).max(initial=0):
                break
            right = value * at_high > 0
            at_low, at_high = np.where(right, 0.5 * at_low, value), np.where(right, value, 0.5 * at_high)
            low, high = np.where(right, low, root), np.where(right, root, high)
            span = at_low - at_high
            root = np.where(value == 0, root, low + (high - low) * at_low / np.where(span == 0, 1, span))
            root = np.clip(root, low, high)
            value = self.offset(start + root[:, None] * step)
        return root, value

    def nearest_crossing(self, points: np.ndarray, direction: np.ndarray) -> np.ndarray:
        """Return the crack points (n, 3) nearest to points (n, 3) on segments points +- direction (n, 3).

        NaN where none is found: psi there must be at most SAME_PLACE of the direction's length. STRETCHES
        intervals on either side are searched for a sign change, because psi is not monotonic in a plane
        that a curved crack crosses obliquely, and Newton's method may fail.
        """
        share = np.linspace(-1, 1, 2 * STRETCHES + 1)
        places = points[:, None] + share[None, :, None] * direction[:, None]
        psi = self.offset(places.reshape(-1, 3)).reshape(places.shape[:2])
        changes = np.sign(psi[:, :-1]) * np.sign(psi[:, 1:]) <= 0
        far = np.where(changes, np.abs(share[:-1] + share[1:]), np.inf)
        nearest = np.argmin(far, axis=1)
        found = np.flatnonzero(changes.any(axis=1))
        start, end = places[found, nearest[found]], places[found, nearest[found] + 1]
        fraction, off = self.crossings(start, end)
        good = np.abs(off) <= SAME_PLACE * np.linalg.norm(direction[found], axis=1)
        result = np.full(points.shape, np.nan)
        result[found[good]] = (start + fraction[:, None] * (end - start))[good]
        return result

    def _feet(self, uv: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the crack triangle (n,) nearest to each parameter pair (n, 2), and the nearest point.

        That point is given by barycentric coordinates (n, 3) and by the step (n, 2) from it to the
        parameters, 0 on the crack.
        """
        cell, step = (
            holding(np.ascontiguousarray(uv), self.nodes, self.triangles, self.bins),
            np.zeros_like(uv),
        )
        past = np.flatnonzero(cell < 0)
        if len(past):
            cell[past] = self.cells.query_nearest(shapely.points(uv[past]), all_matches=False)[1]
        corners = self.nodes[self.triangles[cell]]
        weight = weights_in_triangles(uv, corners)
        foot, weight[past] = closest_points_on_triangles(uv[past], corners[past])
        step[past] = uv[past] - foot
        return cell, weight, step

    def _slope_at(self, cell: np.ndarray, weight: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Return the slope (n, 2) for the results of `_feet`; past the rim it is averaged at the nodes."""
        slope, past = self.slope[cell], step.any(axis=1)
        slope[past] = np.einsum("nk,nkd->nd", weight[past], self.node_slope[self.triangles[cell[past]]])
        return slope


def sheet_of(crack: Crack, box: np.ndarray, held: np.ndarray | None = None) -> Sheet:
    """Return `crack` as a Sheet in the box (2, 3); planar cracks are exact.

    held (k, 3): points of its fronts that keep a node. Not checked: the crack must be single-valued over
    its best-fit plane.
    """
    box = np.asarray(box, float)
    points, triangles = crack.points, crack.triangles.astype(np.int64)
    frame = best_fit_frame(points, triangles)
    origin = points[np.unique(triangles)].mean(axis=0)
    nodes = (points - origin) @ frame[:2].T
    height = (points - origin) @ frame[2]
    slope, node_slope = _slopes(nodes, height, triangles)
    planar = bool(np.abs(height).max() <= ROUNDING * np.ptp(nodes, axis=0).max())
    return Sheet(
        origin=origin,
        frame=frame,
        nodes=nodes,
        height=height,
        node_slope=node_slope,
        triangles=triangles,
        slope=slope,
        planar=planar,
        cells=shapely.STRtree(shapely.polygons(nodes[triangles])),
        bins=bins_of(nodes, triangles),
        rim=rim_of(crack, nodes, frame, box, held),
    )


def _slopes(nodes: np.ndarray, height: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the height's slopes (m, 2) in triangles, and area-weighted mean slopes (n, 2) at nodes."""
    a, b, c = (nodes[triangles[:, i]] for i in range(3))
    u, v = b - a, c - a
    hu, hv = (height[triangles[:, i]] - height[triangles[:, 0]] for i in (1, 2))
    times_area = np.stack([hu * v[:, 1] - hv * u[:, 1], hv * u[:, 0] - hu * v[:, 0]], axis=1)
    twice = doubled_areas(nodes, triangles)
    slope, weight = np.zeros((len(nodes), 2)), np.full(len(nodes), 1e-300)
    np.add.at(slope, triangles, times_area[:, None])
    np.add.at(weight, triangles, twice[:, None])
    return times_area / np.maximum(twice, 1e-300)[:, None], slope / weight[:, None]
