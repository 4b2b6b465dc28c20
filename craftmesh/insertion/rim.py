"""The crack's boundary in its parameters (u, v): tests for inside, and positions along its fronts."""

from dataclasses import dataclass

import numpy as np
import shapely

from craftmesh.cracks.polyline import Polyline, polyline
from craftmesh.cracks.triangulated import boundary_loops
from craftmesh.surface.measure import along_segments
from craftmesh.surface.rounding import ON_PLANE
from craftmesh.types import Crack

CORNER = np.cos(np.radians(20.0))  # cosine of the front's turn from which on a corner keeps a node
MOUTH = 0.2  # distance by which the mouth is pushed out of the box, in box diagonals
# Largest distance past the mouth, in box diagonals, at which the crack still exists; farther out, a curved
# crack might come back into the box.
PAST_MOUTH = 1e-3


@dataclass(frozen=True, eq=False)
class Rim:
    """The boundary of a crack in its parameters (u, v): fronts, and the mouth pushed out of the box.

    domain: polygon that the crack covers, with the pushed-out part; given: without it; past: largest
    distance from `given` that counts as crack. segments (k, 2, 2): the boundary, fronts first;
    front_number, front_start (f,): front and starting arc length of the first f segments. tree, front_tree:
    of all and of the first f segments. curves: the fronts; held: masks (j,) of front points that keep a
    node as corners do.
    """

    domain: shapely.Polygon
    given: shapely.Polygon
    past: float
    segments: np.ndarray
    tree: shapely.STRtree
    front_tree: shapely.STRtree
    front_number: np.ndarray
    front_start: np.ndarray
    curves: tuple[Polyline, ...]
    held: tuple[np.ndarray, ...]

    def inside(self, uv: np.ndarray) -> np.ndarray:
        """Return phi (n,): distance in (u, v) from the rim, > 0 on the crack, < 0 beyond its front."""
        points = shapely.points(uv)
        _, distance = self.tree.query_nearest(points, return_distance=True, all_matches=False)
        inside = shapely.contains_xy(self.domain, uv[:, 0], uv[:, 1])
        pushed = np.flatnonzero(inside & ~shapely.contains_xy(self.given, uv[:, 0], uv[:, 1]))
        inside[pushed] = shapely.distance(self.given, points[pushed]) <= self.past
        return np.where(inside, distance, -distance)

    def nearest_front(self, uv: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the nearest front point (n, 2), its front number (n,) and its arc length (n,).

        Without a front these are inf, -1 and NaN.
        """
        if not self.curves:
            return np.full(uv.shape, np.inf), np.full(len(uv), -1), np.full(len(uv), np.nan)
        nearest = self.front_tree.query_nearest(shapely.points(uv), all_matches=False)[1]
        start, step = self.segments[nearest, 0], np.diff(self.segments[nearest], axis=1)[:, 0]
        share = along_segments(uv, start, step)
        arc = self.front_start[nearest] + share * np.linalg.norm(step, axis=1)
        return start + share[:, None] * step, self.front_number[nearest], arc

    def corners(self, front: int) -> np.ndarray:
        """Return arc lengths (k,) of a front's corners: turns over 20 degrees, and points that keep a node.

        The ends of an open front are left out.
        """
        curve = self.curves[front]
        step = np.diff(curve.points, axis=0)
        step /= np.linalg.norm(step, axis=1)[:, None]
        sharp = np.einsum("ij,ij->i", step, np.roll(step, 1, axis=0)) < CORNER
        sharp |= self.held[front][:-1]
        sharp[0] &= curve.closed
        return curve.arc[np.flatnonzero(sharp)]

    def period(self, front: int) -> float:
        """Return the length of a closed front, inf for an open one."""
        return self.curves[front].length if self.curves[front].closed else np.inf

    def corners_ahead(self, front: int) -> np.ndarray:
        """Return arc lengths of a front's corners; on a closed front those plus its length follow."""
        corners = self.corners(front)
        if not self.curves[front].closed:
            return corners
        return np.concatenate([corners, corners + self.period(front)])

    def gaps(self, front: int, arcs: np.ndarray, others: np.ndarray) -> np.ndarray:
        """Return distances (n, k) along a front, the shorter way, from arc lengths (n,) to others (k,)."""
        gap = np.abs(arcs[:, None] - others)
        return np.minimum(gap, self.period(front) - gap)


def rim_of(
    crack: Crack, nodes: np.ndarray, frame: np.ndarray, box: np.ndarray, held: np.ndarray | None = None
) -> Rim:
    """Return the rim of a crack; nodes (n, 2): its points in (u, v); frame (3, 3): rows u, v, normal.

    held (k, 3): points of its fronts that keep a node.
    """
    kept = set() if held is None else set(map(tuple, held.tolist()))
    curves = tuple(polyline(nodes[front]) for front in crack.fronts)
    given = _polygon(boundary_loops(crack.triangles), nodes)
    domain = _push_out_mouth(given, crack, nodes, frame, box)
    segments, front_number, front_start = _segments(domain, curves)
    shapely.prepare(domain)
    shapely.prepare(given)
    return Rim(
        domain=domain,
        given=given,
        past=PAST_MOUTH * float(np.linalg.norm(box[1] - box[0])),
        segments=segments,
        tree=shapely.STRtree(shapely.linestrings(segments)),
        front_tree=shapely.STRtree(shapely.linestrings(segments[: len(front_number)])),
        front_number=front_number,
        front_start=front_start,
        curves=curves,
        held=tuple(np.array([tuple(p) in kept for p in crack.points[f].tolist()]) for f in crack.fronts),
    )


def _polygon(rings: list[np.ndarray], nodes: np.ndarray) -> shapely.Polygon:
    """Return the polygon of the outer ring (the largest) with the other rings as holes."""
    polygons = [shapely.Polygon(nodes[ring]) for ring in rings]
    outer = int(np.argmax([polygon.area for polygon in polygons]))
    holes = [nodes[ring] for i, ring in enumerate(rings) if i != outer]
    return shapely.Polygon(nodes[rings[outer]], holes)


def _push_out_mouth(
    domain: shapely.Polygon, crack: Crack, nodes: np.ndarray, frame: np.ndarray, box: np.ndarray
) -> shapely.Polygon:
    """Return the domain extended past mouth edges on or beyond a box plane, so that its rim is outside.

    Edges beyond the plane are extended too, so that no gap stays between them and edges on it. This occurs
    where a strip that has grown in the plane meets the old crack, which extends past the box.
    """
    diagonal = np.linalg.norm(box[1] - box[0])
    fronts = {
        frozenset(pair) for front in crack.fronts for pair in zip(front[:-1].tolist(), front[1:].tolist())
    }
    strips = []
    for loop in boundary_loops(crack.triangles):
        for a, b in zip(loop[:-1].tolist(), loop[1:].tolist()):
            ends = crack.points[[a, b]]
            beyond = np.stack([ends - box[0], box[1] - ends]).max(axis=1) <= ON_PLANE * diagonal
            if frozenset((a, b)) in fronts or not beyond.any():
                continue
            side, axis = np.argwhere(beyond)[0]
            outward = frame[:2, axis] * (2 * side - 1)
            outward = MOUTH * diagonal * outward / np.linalg.norm(outward)
            strips.append(shapely.Polygon([nodes[a], nodes[b], nodes[b] + outward, nodes[a] + outward]))
    if not strips:
        return domain
    joined = shapely.union_all([domain, *[strip for strip in strips if strip.is_valid]])
    parts = shapely.get_parts(joined)
    return parts[np.argmax(shapely.area(parts))]


def _segments(
    domain: shapely.Polygon, curves: tuple[Polyline, ...]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return boundary segments (k, 2, 2) in (u, v), the f segments of fronts first; front numbers; arcs.

    Front numbers (f,) and starting arc lengths (f,) are those of the first f segments.
    """
    starts, ends, number, arc = [np.zeros((0, 2))], [np.zeros((0, 2))], [], []
    for front, curve in enumerate(curves):
        starts.append(curve.points[:-1])
        ends.append(curve.points[1:])
        number.append(np.full(len(curve.arc) - 1, front))
        arc.append(curve.arc[:-1])
    segments = np.stack([np.concatenate(starts), np.concatenate(ends)], axis=1)
    known = {frozenset(map(tuple, segment)) for segment in segments.tolist()}
    mouth: list[list[list[float]]] = []
    for ring in [domain.exterior, *domain.interiors]:
        line = shapely.get_coordinates(ring)
        for segment in np.stack([line[:-1], line[1:]], axis=1).tolist():
            if frozenset(map(tuple, segment)) not in known:
                mouth.append(segment)
    segments = np.concatenate([segments, np.array(mouth).reshape(-1, 2, 2)])
    none = np.zeros(0)
    return segments, np.concatenate([none.astype(np.int64), *number]), np.concatenate([none, *arc])
