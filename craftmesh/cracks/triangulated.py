"""Cracks from triangulated surfaces: checks, orientation, and fronts clipped to the box."""

from collections.abc import Sequence

import numpy as np
import shapely

from craftmesh.errors import CraftmeshError
from craftmesh.surface.connectivity import compact, unique_edges
from craftmesh.surface.measure import area_vectors
from craftmesh.types import Crack

MERGE = 1e-9  # points closer than this share of the crack's extent are one
ON_PLANE = 1e-7  # share of the box's diagonal within which a point counts as on a box plane
STEEPEST = 0.05  # least cosine between a triangle's normal and the best-fit normal
COVERED = 1e-6  # share of the projected area that may be covered twice, by rounding, before it is a fold
ALONG = 0.25  # of its length: a boundary edge whose middle is this near a given front is front


def crack_from_triangles(
    points: np.ndarray,
    triangles: np.ndarray,
    fronts: Sequence[np.ndarray] | None,
    box: np.ndarray,
    frame: np.ndarray | None = None,
) -> Crack:
    """Return the crack of a disc- or annulus-like triangulated surface.

    points (n, 3); triangles (m, 3); fronts: polylines (k, 3) along the surface's boundary, or None:
    every boundary edge within the box (2, 3) is front. frame (3, 3): rows u, v, normal; None takes the
    best-fit plane. The surface has to be one-to-one over that plane. Front ends lie exactly on the box.
    Raises CraftmeshError for bad numbers, non-manifold or folded surfaces and cracks outside the box.
    """
    points, triangles = _clean(points, triangles)
    box = np.asarray(box, float)
    frame = best_fit_frame(points, triangles) if frame is None else np.asarray(frame, float)
    uv = (points - points.mean(axis=0)) @ frame[:2].T
    triangles = _one_to_one(points, triangles, uv, frame)
    loops = boundary_loops(triangles)
    _check_simple(uv, loops)
    wanted = None if fronts is None else [np.asarray(front, float).reshape(-1, 3) for front in fronts]
    points, triangles, loops = _split_at_box(points, triangles, loops, box)
    polylines = _fronts_within(points, loops, box, wanted)
    if not polylines:
        raise CraftmeshError(
            f"the crack has no front within the box {box.tolist()}; expected a crack that ends inside, "
            "not in a face: move it or make it smaller"
        )
    return Crack(points, triangles, tuple(polylines))


def best_fit_frame(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return rows u, v, normal (3, 3) of the best-fit plane of triangles (m, 3) on points (n, 3).

    Triangles count by their area; the normal is on the side of most of theirs.
    """
    vectors = area_vectors(points, triangles)
    weight = np.linalg.norm(vectors, axis=1)
    corners = points[triangles].reshape(-1, 3)
    corner_weight = np.repeat(weight, 3)
    centred = corners - np.average(corners, axis=0, weights=corner_weight)
    _, axes = np.linalg.eigh((centred * corner_weight[:, None]).T @ centred)
    normal = axes[:, 0]
    mean = vectors.sum(axis=0)
    lead = mean @ normal
    if abs(lead) < 1e-12 * weight.sum():
        lead = normal[np.argmax(np.abs(normal))]
    normal = normal * np.sign(lead)
    return frame_along(normal, axes[:, 2])


def frame_along(normal: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Return rows u, v, normal, right-handed: u is `axis` made perpendicular to `normal`."""
    normal = normal / np.linalg.norm(normal)
    u = axis - (axis @ normal) * normal
    u = u / np.linalg.norm(u)
    return np.stack([u, np.cross(normal, u), normal])


def boundary_loops(triangles: np.ndarray) -> list[np.ndarray]:
    """Return closed loops of point ids (first id repeated) along the boundary, surface on the left."""
    edges, of_corner, count = unique_edges(triangles)
    if (count > 2).any():
        a, b = edges[np.flatnonzero(count > 2)[0]]
        raise CraftmeshError(
            f"the crack surface is not a manifold: {count.max()} triangles share the edge {a}-{b}; "
            "expected at most 2, give one sheet"
        )
    corner, side = np.nonzero(count[of_corner] == 1)
    start, end = triangles[corner, side], triangles[corner, (side + 1) % 3]
    if len(np.unique(start)) < len(start):
        raise CraftmeshError(
            "the crack surface is not a manifold: its boundary touches itself at a point; "
            "expected a disc or an annulus"
        )
    following = dict(zip(start.tolist(), end.tolist()))
    loops = []
    while following:
        loop = [min(following)]
        while loop[-1] in following:
            loop.append(following.pop(loop[-1]))
        loops.append(np.array(loop))
    return loops


def _clean(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Merge coincident points, drop degenerate triangles and unused points."""
    points = np.asarray(points, float).reshape(-1, 3)
    triangles = np.asarray(triangles, np.int64).reshape(-1, 3)
    if not np.isfinite(points).all():
        row = int(np.flatnonzero(~np.isfinite(points).all(axis=1))[0])
        raise CraftmeshError(f"crack point {row} is {points[row].tolist()}; expected three finite numbers")
    if not len(triangles):
        raise CraftmeshError("the crack surface has no triangles; expected a triangulated sheet")
    step = max(np.ptp(points, axis=0).max(), 1e-300) * MERGE
    _, first, inverse = np.unique(np.round(points / step), axis=0, return_index=True, return_inverse=True)
    triangles = first[inverse.ravel()[triangles]]
    distinct = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    points, triangles, _ = compact(points, triangles[distinct])
    return points, triangles


def _one_to_one(points: np.ndarray, triangles: np.ndarray, uv: np.ndarray, frame: np.ndarray) -> np.ndarray:
    """Return the triangles oriented along the frame's normal, or refuse a folded surface."""
    vectors = area_vectors(points, triangles)
    true = np.linalg.norm(vectors, axis=1)
    seen = vectors @ frame[2]
    flat = true <= 1e-12 * true.sum()
    steep = (np.abs(seen) < STEEPEST * true) & ~flat
    area = np.abs(seen).sum()
    covered = shapely.union_all(shapely.polygons(uv[triangles[~flat]]), grid_size=None).area
    if steep.any() or covered < area * (1 - COVERED):
        raise CraftmeshError(
            f"the crack surface is folded: {int(steep.sum())} steep triangles, covered/projected area "
            f"{covered / max(area, 1e-300):.6f}; expected a surface one-to-one over its best-fit plane"
        )
    triangles = triangles.copy()
    triangles[seen < 0] = triangles[seen < 0][:, ::-1]
    return triangles


def _check_simple(uv: np.ndarray, loops: list[np.ndarray]) -> None:
    for loop in loops:
        if not shapely.LinearRing(uv[loop]).is_simple:
            raise CraftmeshError("the crack front crosses itself; expected a front without crossings")


def _split_at_box(
    points: np.ndarray, triangles: np.ndarray, loops: list[np.ndarray], box: np.ndarray
) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """Split boundary edges where they cross box planes; the new points lie exactly on the planes."""
    places, rings = list(points), []
    for loop in loops:
        ring: list[int] = []
        for a, b in zip(loop[:-1].tolist(), loop[1:].tolist()):
            ring.append(a)
            for place in _crossings(places[a], places[b], box):
                triangles = _split_boundary_edge(triangles, ring[-1], b, len(places))
                ring.append(len(places))
                places.append(place)
        rings.append(np.array(ring + ring[:1]))
    return np.array(places), triangles, rings


def _split_boundary_edge(triangles: np.ndarray, a: int, b: int, new: int) -> np.ndarray:
    """Return the triangles with the one on the directed boundary edge a-b split at the point `new`."""
    row, side = np.argwhere((triangles == a) & (np.roll(triangles, -1, axis=1) == b))[0]
    apex = triangles[row, (side + 2) % 3]
    triangles = np.concatenate([triangles, [[new, b, apex]]])
    triangles[row] = a, new, apex
    return triangles


def _crossings(a: np.ndarray, b: np.ndarray, box: np.ndarray) -> list[np.ndarray]:
    """Return the points of the segment a-b on box planes, those outside the box left out, in order."""
    near = ON_PLANE * np.linalg.norm(box[1] - box[0])
    found = []
    for axis in range(3):
        for plane in box[:, axis]:
            da, db = a[axis] - plane, b[axis] - plane
            if da * db >= 0 or min(abs(da), abs(db)) <= near:
                continue
            t = da / (da - db)
            point = a + t * (b - a)
            point[axis] = plane
            if (point >= box[0] - near).all() and (point <= box[1] + near).all():
                found.append((t, np.clip(point, box[0], box[1])))
    return [point for _, point in sorted(found, key=lambda item: item[0])]


def _fronts_within(
    points: np.ndarray, loops: list[np.ndarray], box: np.ndarray, wanted: list[np.ndarray] | None
) -> list[np.ndarray]:
    """Chain the boundary edges that lie within the box, and on the wanted polylines where given."""
    near = ON_PLANE * np.linalg.norm(box[1] - box[0])
    low, high = points <= box[0] + near, points >= box[1] - near
    outside = ((points < box[0] - near) | (points > box[1] + near)).any(axis=1)
    polylines = []
    for loop in loops:
        a, b = loop[:-1], loop[1:]
        on_box = ((low[a] & low[b]) | (high[a] & high[b])).any(axis=1)
        front = ~on_box & ~outside[a] & ~outside[b]
        if wanted is not None:
            front &= _along(points, a, b, wanted)
        polylines += _runs(loop, front)
    return polylines


def _along(points: np.ndarray, a: np.ndarray, b: np.ndarray, wanted: list[np.ndarray]) -> np.ndarray:
    """Tell which edges a-b lie along the wanted polylines (their middles within ALONG of their length)."""
    middle = (points[a] + points[b]) / 2
    length = np.linalg.norm(points[b] - points[a], axis=1)
    nearest = np.full(len(a), np.inf)
    for polyline in wanted:
        start, step = polyline[:-1], np.diff(polyline, axis=0)
        square = np.maximum((step**2).sum(axis=1), 1e-300)
        t = np.clip(np.einsum("nkj,kj->nk", middle[:, None] - start[None], step) / square, 0, 1)
        foot = start[None] + t[..., None] * step[None]
        nearest = np.minimum(nearest, np.linalg.norm(middle[:, None] - foot, axis=2).min(axis=1))
    return nearest <= ALONG * length


def _runs(loop: np.ndarray, front: np.ndarray) -> list[np.ndarray]:
    """Return the maximal runs of consecutive front edges of a closed loop as polylines of point ids."""
    if front.all():
        return [loop]
    if not front.any():
        return []
    turn = int(np.flatnonzero(~front)[0]) + 1
    nodes, flags = np.roll(loop[:-1], -turn), np.roll(front, -turn)
    runs: list[np.ndarray] = []
    current: list[int] = []
    for i, flag in enumerate(flags.tolist()):
        if flag:
            current = current or [nodes[i]]
            current.append(nodes[(i + 1) % len(nodes)])
        elif current:
            runs.append(np.array(current))
            current = []
    return runs + ([np.array(current)] if current else [])
