"""The crack as a function: offset from its surface, and parameters on it."""

from dataclasses import dataclass

import numpy as np
import shapely

from craftmesh.cracks.frame import best_fit_frame
from craftmesh.errors import CraftmeshError
from craftmesh.insertion.rim import Rim, rim_of
from craftmesh.types import Crack

PLANAR = 1e-9  # offsets below this share of the extent make a crack planar


@dataclass(frozen=True, eq=False)
class Sheet:
    """A crack as a height over its best-fit plane; lengths in model units.

    origin (3,), frame (3, 3) rows u, v, normal. nodes (n, 2), height (n,) and its slope (n, 2) there,
    triangles (m, 3), cells: the triangles as polygons. rim: where the crack ends, in the same parameters.
    """

    origin: np.ndarray
    frame: np.ndarray
    nodes: np.ndarray
    height: np.ndarray
    slope: np.ndarray
    triangles: np.ndarray
    planar: bool
    cells: shapely.STRtree
    rim: Rim

    def uv(self, points: np.ndarray) -> np.ndarray:
        """Return the parameters (n, 2) of points (n, 3)."""
        return (points - self.origin) @ self.frame[:2].T

    def offset(self, points: np.ndarray) -> np.ndarray:
        """Return psi (n,): the offset of points (n, 3) from the extended surface, > 0 ahead of it."""
        above = (points - self.origin) @ self.frame[2]
        return above if self.planar else above - self.height_at(self.uv(points))

    def lift(self, uv: np.ndarray) -> np.ndarray:
        """Return the points (n, 3) of the surface at parameters (n, 2)."""
        points = self.origin + uv @ self.frame[:2]
        return points if self.planar else points + self.height_at(uv)[:, None] * self.frame[2]

    def height_at(self, uv: np.ndarray) -> np.ndarray:
        """Return the height (n,) at parameters (n, 2), continued past the rim with its slope."""
        points = shapely.points(uv)
        row, cell = self.cells.query(points, predicate="intersects")
        row, first = np.unique(row, return_index=True)
        height = np.empty(len(uv))
        height[row] = _interpolate(self.nodes, self.height, self.triangles[cell[first]], uv[row])
        past = np.setdiff1d(np.arange(len(uv)), row)
        if len(past):
            foot, cell = self._nearest_on_surface(points[past])
            base = _interpolate(self.nodes, self.height, self.triangles[cell], foot)
            slope = np.stack(
                [_interpolate(self.nodes, self.slope[:, i], self.triangles[cell], foot) for i in range(2)],
                axis=1,
            )
            height[past] = base + np.einsum("ij,ij->i", slope, uv[past] - foot)
        return height

    def _nearest_on_surface(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return foot (n, 2) and triangle (n,) nearest to shapely points (n,) off the surface."""
        cell = self.cells.query_nearest(points, all_matches=False)[1]
        lines = shapely.shortest_line(self.cells.geometries[cell], points)
        return shapely.get_coordinates(lines).reshape(-1, 2, 2)[:, 0], cell


def sheet_of(crack: Crack, box: np.ndarray) -> Sheet:
    """Return the evaluator of `crack` in the box (2, 3); planar cracks are exact.

    Raises CraftmeshError for a crack without a front.
    """
    box = np.asarray(box, float)
    if not crack.fronts:
        raise CraftmeshError("the crack has no front; expected one: make it with craftmesh crack")
    points, triangles = crack.points, crack.triangles.astype(np.int64)
    frame = best_fit_frame(points, triangles)
    origin = points[np.unique(triangles)].mean(axis=0)
    nodes = (points - origin) @ frame[:2].T
    height = (points - origin) @ frame[2]
    planar = bool(np.abs(height).max() <= PLANAR * np.ptp(nodes, axis=0).max())
    return Sheet(
        origin=origin,
        frame=frame,
        nodes=nodes,
        height=height,
        slope=_slopes(nodes, height, triangles),
        triangles=triangles,
        planar=planar,
        cells=shapely.STRtree(shapely.polygons(nodes[triangles])),
        rim=rim_of(crack, nodes, frame, box),
    )


def _slopes(nodes: np.ndarray, height: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the area-weighted mean gradient (n, 2) of the height at the nodes."""
    a, b, c = (nodes[triangles[:, i]] for i in range(3))
    u, v = b - a, c - a
    twice = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    hu, hv = (height[triangles[:, i]] - height[triangles[:, 0]] for i in (1, 2))
    times_area = np.stack([hu * v[:, 1] - hv * u[:, 1], hv * u[:, 0] - hu * v[:, 0]], axis=1)
    slope, weight = np.zeros((len(nodes), 2)), np.full(len(nodes), 1e-300)
    for i in range(3):
        np.add.at(slope, triangles[:, i], times_area)
        np.add.at(weight, triangles[:, i], twice)
    return slope / weight[:, None]


def _interpolate(
    nodes: np.ndarray, values: np.ndarray, triangles: np.ndarray, uv: np.ndarray
) -> np.ndarray:
    """Return `values` interpolated in the given triangle of each row of uv (n, 2)."""
    a, b, c = (nodes[triangles[:, i]] for i in range(3))
    u, v, w = b - a, c - a, uv - a
    twice = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    s = (w[:, 0] * v[:, 1] - w[:, 1] * v[:, 0]) / twice
    t = (u[:, 0] * w[:, 1] - u[:, 1] * w[:, 0]) / twice
    va, vb, vc = (values[triangles[:, i]] for i in range(3))
    return va + s * (vb - va) + t * (vc - va)
