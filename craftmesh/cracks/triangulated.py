"""Cracks from triangulated surfaces: check the surface, orient it, and clip its fronts to the box."""

from collections.abc import Sequence

import numpy as np
import shapely

from craftmesh.arguments import as_array, typed
from craftmesh.cracks.height_parts import best_fit_frame, height_parts
from craftmesh.cracks.one_sheet import (
    clean_triangles,
    near_box,
    sides_apart,
    without_slivers,
)
from craftmesh.cracks.within_box import is_in
from craftmesh.errors import CraftmeshError, rounded_values
from craftmesh.surface.connectivity import compact, pieces, unique_edges
from craftmesh.surface.kernels.distances import nearest_on_edges
from craftmesh.surface.kernels.triangle_pairs import intersecting_pairs
from craftmesh.surface.measure import area_vectors, meets_box, span_of
from craftmesh.surface.rounding import ON_PLANE
from craftmesh.surface.side_data import spans_told, unit_hint
from craftmesh.types import Crack

ALONG = 0.25  # largest distance of a front edge's middle from the given front, in lengths of the edge


@typed
def crack_from_triangles(
    points: np.ndarray,
    triangles: np.ndarray,
    fronts: Sequence[np.ndarray] | None,
    box: np.ndarray,
    frame: np.ndarray | None = None,
) -> Crack:
    """Return the crack of a disc- or annulus-like triangulated surface, with front ends exactly on the box.

    points (n, 3); triangles (m, 3); box (2, 3). fronts: polylines (k, 3) along the surface's boundary;
    None: all boundary edges within the box are front. A surface without any such edge severs the body.
    frame (3, 3): rows u, v, normal of a planar crack; None: the surface must be single-valued over a plane,
    whole or in parts. If it folds, only its part near the box must be. Raise CraftmeshError for bad
    numbers, for surfaces that are non-manifold, folded, self-intersecting, thin shells or in pieces, and
    for cracks outside the box.
    """
    box = as_array("box", box, float, (2, 3))
    if fronts is not None:
        fronts = [as_array("a front of the crack", front, float, (None, 3)) for front in fronts]
        if min(map(len, fronts), default=0) < 2:
            raise CraftmeshError("a front of the crack is too short; give polylines of 2 points or more")
    points, triangles = clean_triangles(points, triangles)
    if frame is None:
        triangles = _one_piece(points, triangles, box)
        points, triangles, frame = _heights(points, triangles, box)
        _refuse_two_sided(points, triangles, box)
    else:
        frame = as_array("frame", frame, float, (3, 3))
        turned = area_vectors(points, triangles) @ frame[2] < 0
        triangles = np.where(turned[:, None], triangles[:, ::-1], triangles)
    loops = boundary_loops(triangles)
    if frame is None:
        _refuse_crossing(points, triangles)
    else:
        _check_simple((points - points.mean(axis=0)) @ frame[:2].T, loops)
    crack = with_fronts(points, triangles, loops, fronts, box)
    if not crack.fronts:
        _refuse_no_crack(crack.points[crack.triangles], fronts, box)
    return crack


def with_fronts(
    points: np.ndarray,
    triangles: np.ndarray,
    loops: list[np.ndarray],
    fronts: Sequence[np.ndarray] | None,
    box: np.ndarray,
) -> Crack:
    """Return a crack whose boundary edges are split at the box planes (2, 3), with its fronts.

    loops: the boundary from `boundary_loops`. fronts: polylines (k, 3) along it; None: all boundary edges
    within the box are front.
    """
    points, triangles, loops = _split_at_box(points, triangles, loops, box)
    return Crack(points, triangles, tuple(_fronts_within(points, loops, box, fronts)))


def boundary_loops(triangles: np.ndarray) -> list[np.ndarray]:
    """Return closed loops of point ids along the boundary, first id repeated, the surface on their left.

    Raise CraftmeshError if the boundary touches itself at a point.
    """
    _, of_corner, count = unique_edges(triangles)
    corner, side = np.nonzero(count[of_corner] == 1)
    start, end = triangles[corner, side], triangles[corner, (side + 1) % 3]
    if len(np.unique(start)) < len(start):
        raise CraftmeshError(
            "the crack surface is not a manifold: its boundary touches itself at a point; "
            "give a disc or an annulus"
        )
    following = dict(zip(start.tolist(), end.tolist()))
    loops = []
    while following:
        loop = [min(following)]
        while loop[-1] in following:
            loop.append(following.pop(loop[-1]))
        loops.append(np.array(loop))
    return loops


def _heights(
    points: np.ndarray, triangles: np.ndarray, box: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Return points, triangles and frame (3, 3) of a surface, or of its part near the box if it folds.

    The frame is None if the surface is single-valued only in parts. Raise CraftmeshError if the part near
    the box folds as well.
    """
    triangles = without_slivers(points, triangles)
    while True:
        points, triangles, _ = compact(points, triangles)
        parts, fault = height_parts(points, triangles)
        if not fault:
            return points, triangles, best_fit_frame(points, triangles) if len(parts) == 1 else None
        near = near_box(points, triangles, box)
        if not len(near) or len(near) == len(triangles):
            raise CraftmeshError(fault)
        triangles = triangles[near]


def _one_piece(points: np.ndarray, triangles: np.ndarray, box: np.ndarray) -> np.ndarray:
    """Return the triangles of the one piece that meets the box, or all if none does; reject several."""
    piece = pieces(triangles)
    if piece.max() == 0:
        return triangles
    corner = points[triangles]
    found = np.unique(piece[meets_box(corner, box)])
    if len(found) > 1:
        places = [rounded_values(corner[piece == k].mean(axis=(0, 1))) for k in found[:2].tolist()]
        raise CraftmeshError(
            f"the crack surface has {len(found)} pieces in the box, at {places[0]} and {places[1]}; "
            "expected one connected surface: join the pieces or keep only one"
        )
    return triangles[piece == found[0]] if len(found) else triangles


def _refuse_two_sided(points: np.ndarray, triangles: np.ndarray, box: np.ndarray) -> None:
    """Raise CraftmeshError if consistently oriented triangles (m, 3) form a thin shell.

    It is one if the sum of area vectors is below half of the area, and `sides_apart` finds two close sides.
    """
    vectors = area_vectors(points, triangles)
    is_turned = np.linalg.norm(vectors.sum(axis=0)) < np.linalg.norm(vectors, axis=1).sum() / 2
    if is_turned and (apart := sides_apart(points, triangles, box)) is not None:
        raise CraftmeshError(
            f"the crack surface is a thin shell whose sides are {apart:.4g} apart; expected a single "
            "surface: give the middle surface, as `craftmesh crack` does"
        )


def _refuse_crossing(points: np.ndarray, triangles: np.ndarray) -> None:
    """Raise CraftmeshError if triangles (m, 3) intersect other than in shared corners and edges."""
    pairs = intersecting_pairs(points, np.asarray(triangles, np.int64))
    if len(pairs):
        place = rounded_values(points[triangles[pairs[0]]].mean(axis=(0, 1)))
        raise CraftmeshError(
            f"the crack surface intersects itself near {place}; split it there into surfaces that do not"
        )


def _check_simple(uv: np.ndarray, loops: list[np.ndarray]) -> None:
    """Raise CraftmeshError if a boundary loop of points uv (n, 2) crosses itself."""
    for loop in loops:
        if not shapely.LinearRing(uv[loop]).is_simple:
            raise CraftmeshError("the crack front crosses itself; give a front without crossings")


def _refuse_no_crack(corners: np.ndarray, fronts: Sequence[np.ndarray] | None, box: np.ndarray) -> None:
    """Raise CraftmeshError if fronts were given, none of which was found, or the triangles miss the box.

    corners (m, 3, 3): of the triangles; box (2, 3). Called for a crack without fronts.
    """
    span = span_of(corners)
    if fronts is not None:
        front = span_of(np.concatenate(fronts))
        hint = unit_hint(front, span) or unit_hint(front, box)
        raise CraftmeshError(
            f"no boundary edge of the crack in the box {rounded_values(box)} lies along the given front; "
            f"{spans_told(('the front goes', 'the crack'), front, span)}{hint}; give a front on "
            "the surface's boundary, or none for a crack that severs the body"
        )
    spans = f"the crack spans {rounded_values(span)}{unit_hint(span, box)}"
    if not is_in(corners, box):
        raise CraftmeshError(
            f"the crack lies outside the box {rounded_values(box)}: {spans}; move it into the box"
        )


def _split_at_box(
    points: np.ndarray, triangles: np.ndarray, loops: list[np.ndarray], box: np.ndarray
) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """Return points, triangles and loops with boundary edges split where they cross box planes.

    The new points lie exactly on the planes.
    """
    places, rings = list(points), []
    for loop in loops:
        ring: list[int] = []
        for a, b in zip(loop[:-1].tolist(), loop[1:].tolist()):
            ring.append(a)
            for place in _crossings(places[a], places[b], box):
                triangles = split_boundary_edge(triangles, ring[-1], b, len(places))
                ring.append(len(places))
                places.append(place)
        rings.append(np.array(ring + ring[:1]))
    return np.array(places), triangles, rings


def split_boundary_edge(triangles: np.ndarray, a: int, b: int, new: int) -> np.ndarray:
    """Return triangles (m + 1, 3): the one on the directed boundary edge a-b is split at point id `new`."""
    row, side = np.argwhere((triangles == a) & (np.roll(triangles, -1, axis=1) == b))[0]
    apex = triangles[row, (side + 2) % 3]
    triangles = np.concatenate([triangles, [[new, b, apex]]])
    triangles[row] = a, new, apex
    return triangles


def _crossings(a: np.ndarray, b: np.ndarray, box: np.ndarray) -> list[np.ndarray]:
    """Return the points where the segment a-b crosses box planes, within the box, in order from a."""
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
    points: np.ndarray, loops: list[np.ndarray], box: np.ndarray, wanted: Sequence[np.ndarray] | None
) -> list[np.ndarray]:
    """Return fronts as polylines of ids: boundary edges in the box, along `wanted` polylines if given."""
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


def _along(points: np.ndarray, a: np.ndarray, b: np.ndarray, wanted: Sequence[np.ndarray]) -> np.ndarray:
    """Return a mask (k,) of edges a-b whose middles lie within ALONG edge lengths of a wanted polyline."""
    middle = (points[a] + points[b]) / 2
    length = np.linalg.norm(points[b] - points[a], axis=1)
    nearest = np.full(len(a), np.inf)
    for polyline in wanted:
        start = np.arange(len(polyline) - 1)
        foot = nearest_on_edges(middle, polyline, np.column_stack([start, start + 1]))
        nearest = np.minimum(nearest, np.linalg.norm(middle - foot, axis=1))
    return nearest <= ALONG * length


def _runs(loop: np.ndarray, front: np.ndarray) -> list[np.ndarray]:
    """Return the maximal runs of edges marked `front` (k,) of a closed loop, as polylines of point ids."""
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
