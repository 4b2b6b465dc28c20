"""The crack as a function: offset from its surface, parameters, and inside or outside of its front."""

from dataclasses import dataclass

import numpy as np
import shapely

from craftmesh.cracks.triangulated import ON_PLANE, best_fit_frame, boundary_loops
from craftmesh.errors import CraftmeshError
from craftmesh.types import Crack

MOUTH = 0.2  # of the box's diagonal, by which the mouth is pushed out of it
PLANAR = 1e-9  # offsets below this share of the extent make a crack planar


@dataclass(frozen=True, eq=False)
class Sheet:
    """A crack as a height over its best-fit plane; lengths in model units.

    origin (3,), frame (3, 3) rows u, v, normal. nodes (n, 2) and height (n,), triangles (m, 3).
    domain: polygon of the parameters that the crack covers, its mouth pushed out of the box.
    rim (k, 2, 2): the domain's boundary segments, those of fronts first; front_number, front_start (f,):
    front and arc length at the start of the first f. curves: (j, 3) rows u, v, arc length per front.
    """

    origin: np.ndarray
    frame: np.ndarray
    nodes: np.ndarray
    height: np.ndarray
    slope: np.ndarray
    triangles: np.ndarray
    planar: bool
    domain: shapely.Polygon
    cells: shapely.STRtree
    rim: np.ndarray
    rim_tree: shapely.STRtree
    front_tree: shapely.STRtree
    front_number: np.ndarray
    front_start: np.ndarray
    curves: tuple[np.ndarray, ...]
    closed: tuple[bool, ...]

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

    def inside(self, uv: np.ndarray) -> np.ndarray:
        """Return phi (n,): the distance in (u, v) to the rim, > 0 on the crack and < 0 past its front."""
        points = shapely.points(uv)
        _, distance = self.rim_tree.query_nearest(points, return_distance=True, all_matches=False)
        return np.where(shapely.contains_xy(self.domain, uv[:, 0], uv[:, 1]), distance, -distance)

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

    def nearest_front(self, uv: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return foot (n, 2), front number (n,) and arc length (n,) of the nearest front point."""
        segment = self.front_tree.query_nearest(shapely.points(uv), all_matches=False)[1]
        start, step = self.rim[segment, 0], self.rim[segment, 1] - self.rim[segment, 0]
        square = np.einsum("ij,ij->i", step, step)
        t = np.clip(np.einsum("ij,ij->i", uv - start, step) / square, 0, 1)
        along = self.front_start[segment] + t * np.sqrt(square)
        return start + t[:, None] * step, self.front_number[segment], along

    def on_front(self, front: int, arc: np.ndarray) -> np.ndarray:
        """Return the parameters (n, 2) at arc lengths (n,) along a front."""
        curve = self.curves[front]
        if self.closed[front]:
            arc = np.mod(arc, curve[-1, 2])
        return np.stack([np.interp(arc, curve[:, 2], curve[:, i]) for i in range(2)], axis=1)


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
    curves = tuple(_with_arc_length(nodes[front]) for front in crack.fronts)
    domain = _polygon(boundary_loops(triangles), nodes)
    domain = _push_out_mouth(domain, crack, nodes, frame, box)
    rim, front_number, front_start = _rim(domain, curves)
    shapely.prepare(domain)
    return Sheet(
        origin=origin, frame=frame, nodes=nodes, height=height,
        slope=_slopes(nodes, height, triangles),
        triangles=triangles, planar=planar, domain=domain,
        cells=shapely.STRtree(shapely.polygons(nodes[triangles])),
        rim=rim, rim_tree=shapely.STRtree(shapely.linestrings(rim)),
        front_tree=shapely.STRtree(shapely.linestrings(rim[: len(front_number)])),
        front_number=front_number, front_start=front_start,
        curves=curves, closed=tuple(bool(front[0] == front[-1]) for front in crack.fronts),
    )  # fmt: skip


def _with_arc_length(uv: np.ndarray) -> np.ndarray:
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(uv, axis=0), axis=1))])
    return np.column_stack([uv, arc])


def _polygon(rings: list[np.ndarray], nodes: np.ndarray) -> shapely.Polygon:
    """Return the polygon of the outer ring (the largest) with the other rings as holes."""
    polygons = [shapely.Polygon(nodes[ring]) for ring in rings]
    outer = int(np.argmax([polygon.area for polygon in polygons]))
    holes = [nodes[ring] for i, ring in enumerate(rings) if i != outer]
    return shapely.Polygon(nodes[rings[outer]], holes)


def _push_out_mouth(
    domain: shapely.Polygon, crack: Crack, nodes: np.ndarray, frame: np.ndarray, box: np.ndarray
) -> shapely.Polygon:
    """Extend the domain past mouth edges that lie on a box plane, so that the mouth is outside the box."""
    diagonal = np.linalg.norm(box[1] - box[0])
    fronts = {
        frozenset(pair) for front in crack.fronts for pair in zip(front[:-1].tolist(), front[1:].tolist())
    }
    strips = []
    for loop in boundary_loops(crack.triangles):
        for a, b in zip(loop[:-1].tolist(), loop[1:].tolist()):
            ends = crack.points[[a, b]]
            near = np.abs(ends[:, None] - box[None]).max(axis=0) <= ON_PLANE * diagonal
            if frozenset((a, b)) in fronts or not near.any():
                continue
            side, axis = np.argwhere(near)[0]
            outward = frame[:2, axis] * (2 * side - 1)
            outward = MOUTH * diagonal * outward / np.linalg.norm(outward)
            strips.append(shapely.Polygon([nodes[a], nodes[b], nodes[b] + outward, nodes[a] + outward]))
    if not strips:
        return domain
    joined = shapely.union_all([domain, *[strip for strip in strips if strip.is_valid]])
    parts = shapely.get_parts(joined)
    return parts[np.argmax(shapely.area(parts))]


def _rim(
    domain: shapely.Polygon, curves: tuple[np.ndarray, ...]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the domain's boundary segments, fronts first, and of those front and arc length."""
    starts, ends, number, arc = [np.zeros((0, 2))], [np.zeros((0, 2))], [], []
    for front, curve in enumerate(curves):
        starts.append(curve[:-1, :2])
        ends.append(curve[1:, :2])
        number.append(np.full(len(curve) - 1, front))
        arc.append(curve[:-1, 2])
    segments = np.stack([np.concatenate(starts), np.concatenate(ends)], axis=1)
    known = {frozenset(map(tuple, segment)) for segment in segments.tolist()}
    mouth: list[list[list[float]]] = []
    for ring in [domain.exterior, *domain.interiors]:
        line = shapely.get_coordinates(ring)
        for segment in np.stack([line[:-1], line[1:]], axis=1).tolist():
            if frozenset(map(tuple, segment)) not in known:
                mouth.append(segment)
    segments = np.concatenate([segments, np.array(mouth).reshape(-1, 2, 2)])
    return segments, np.concatenate(number), np.concatenate(arc)


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
