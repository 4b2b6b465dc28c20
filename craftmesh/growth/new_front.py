"""The front after one extension, and the strip of new crack surface between old and new front."""

from collections import Counter
from typing import NamedTuple

import numpy as np
import scipy

from craftmesh.cracks.polyline import Polyline, polyline
from craftmesh.surface.rounding import ON_PLANE

# Smallest distance of successive points, in units of the new front's spacing; nearer points are dropped
# before a spline is fitted.
CLOSE = 0.1
# Smallest distance by which a moved front end lies outside its box plane, in lengths of the end's move. If
# an end lay in the plane, the strip's edge from old to new end would lie in it too. Where such an edge met
# a box edge, the crack's traces on the two faces did not join.
BEYOND = 0.25


def with_front_points(
    points: np.ndarray, triangles: np.ndarray, front: np.ndarray, spacing: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points, triangles and a front (k,), ids of points, whose edges are at most `spacing` long.

    New points come after the given ones. points (n, 3); triangles (m, 3): each directed edge of the front
    belongs to one. Triangles on longer edges are split; the surface does not move.
    """
    places, rows, ids = list(points), triangles.tolist(), [int(front[0])]
    row_of = {(t[k - 1], t[k]): row for row, t in enumerate(rows) for k in range(3)}
    for a, b in zip(front[:-1].tolist(), front[1:].tolist()):
        parts = int(np.ceil(np.linalg.norm(points[b] - points[a]) / spacing))
        tail = a
        for share in np.arange(1, parts) / parts:
            row, new = row_of[tail, b], len(places)
            apex = next(id for id in rows[row] if id not in (tail, b))
            places.append(points[a] + share * (points[b] - points[a]))
            rows[row] = [tail, new, apex]
            rows.append([new, b, apex])
            row_of |= {(tail, new): row, (new, b): len(rows) - 1, (b, apex): len(rows) - 1}
            ids.append(new)
            tail = new
        ids.append(b)
    return np.array(places), np.array(rows), np.array(ids)


def strip_triangles(old: np.ndarray, arc: np.ndarray, new: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """Return triangles (m, 3) between the fronts `old` and `new`, oriented as the surface behind `old`.

    old, new: ids of the fronts' points, in order. arc: arc lengths of the old front's points; origin: arc
    lengths on the old front from which the new front's points come, ascending. Each triangle takes the next
    point of the front whose point comes first along the old front. There is no triangle where both fronts
    share points, and none with all corners on the old front.
    """
    rows, shared = [], set(old.tolist()) & set(new.tolist())
    i, j = 0, 0
    while i < len(old) - 1 or j < len(new) - 1:
        if j == len(new) - 1 or i == len(old) - 1:
            ahead = i < len(old) - 1
        elif old[i] == new[j]:
            ahead = False
        elif new[j + 1] in shared:
            ahead = old[i] != new[j + 1]
        else:
            ahead = arc[i + 1] + arc[i] <= origin[j + 1] + origin[j]
        if ahead:
            rows.append((old[i + 1], old[i], new[j]))
            i += 1
        else:
            rows.append((old[i], new[j], new[j + 1]))
            j += 1
    strip = np.array(rows)
    return strip[(strip != np.roll(strip, 1, axis=1)).all(axis=1)]


class NewFront(NamedTuple):
    """The points (m, 3) of a new front, in order.

    origin (m,): arc lengths on the old front from which the points come; stays (m,) bool: True at points of
    the old front that did not move. A closed front ends with its first point.
    """

    points: np.ndarray
    origin: np.ndarray
    stays: np.ndarray


def stopped_outside(points: np.ndarray, moves: np.ndarray, box: np.ndarray) -> np.ndarray:
    """Return moves (k, 3), shortened so that each point stops just outside the box (2, 3).

    A point gets at most BEYOND times its move's length outside. points (k, 3): places in the box before.
    """
    beyond = BEYOND * np.linalg.norm(moves, axis=1, keepdims=True)
    room = np.where(moves > 0, box[1] - points, points - box[0]) + beyond
    share = (room / np.maximum(np.abs(moves), room)).min(axis=1)
    return share[:, None] * moves


def new_front(
    old: Polyline, moves: np.ndarray, box: np.ndarray, frame: np.ndarray, spacing: float
) -> tuple[NewFront, Counter[str]]:
    """Return the front to which `moves` (k, 3) take the points of `old`, sampled about every `spacing`.

    box (2, 3); frame (3, 3): rows u, v, normal; loops are found in the plane (u, v). Ends of an open front
    that lie on a box plane move beyond it. A concave front that moves farther than its radius forms loops;
    they are cut off. Points without a move stay. No spline runs through the corners that this leaves.
    Also return the counts of `loops` and `ends` that are cut off.
    """
    points, origin, ends_cut = old.points + moves, old.arc, 0
    if old.closed:
        points[-1] = points[0]
    else:
        for order in (slice(None), slice(None, None, -1)):
            start = old.at(origin[order])
            *found, is_cut = _carried_out(points[order], origin[order], start, box, frame[2])
            points, origin = (part[order] for part in found)
            ends_cut += is_cut
    points, origin, loops = without_loops(points, origin, frame[:2], old.closed)
    cut = Counter(loops=loops, ends=ends_cut)
    stays = np.isin(origin, old.arc[~moves.any(axis=1)])
    ends = old.arc[:0] if old.closed else old.arc[[0, -1]]
    kept = stays | ~np.isin(origin, old.arc) | np.isin(origin, ends)
    if old.closed and not kept.any():
        points, origin = _sampled(points, origin, True, spacing)
        return NewFront(points, origin, np.zeros(len(points), bool)), cut
    return _sampled_between(points, origin, stays, kept, spacing), cut


def broken_through(
    points: np.ndarray, box: np.ndarray, normal: np.ndarray, width: float
) -> tuple[np.ndarray, int]:
    """Return front points (k, 3) without thin ligaments at faces of the box, and the number of these.

    Tetrahedra in a ligament would be flat. Points in the box between two points outside one plane are put
    on the straight line between these, if none is deeper than `width`. Points that follow a point outside
    and stay within half a width of the plane over more than two widths move out of the box (2, 3),
    perpendicular to the crack's normal (3,).
    """
    ligaments, depths = 0, _depths(points, box)
    outside = np.flatnonzero(depths.min(axis=1) < 0)
    result = points.copy()
    for i, j in zip(outside[:-1].tolist(), outside[1:].tolist()):
        thin = j > i + 1 and depths[i:j].min(axis=1).max() < width
        if thin and (depths[[i, j]] < 0).all(axis=0).any():
            result[i : j + 1] = np.linspace(points[i], points[j], j - i + 1)
            ligaments += 1
    for i in outside.tolist():
        for ahead in (result[i:], result[i::-1]):
            moved = _off_face(ahead, box, normal, width)
            ahead[1 : len(moved) + 1] = moved
            ligaments += len(moved) > 0
    return result, ligaments


def _depths(points: np.ndarray, box: np.ndarray) -> np.ndarray:
    """Return the depths (k, 6) of points (k, 3) inside the planes of a box (2, 3), first the low ones."""
    return np.concatenate([points - box[0], box[1] - points], axis=1)


def _off_face(points: np.ndarray, box: np.ndarray, normal: np.ndarray, width: float) -> np.ndarray:
    """Return places (j, 3) outside the box for the j points after the first that stay near a face.

    The first of the points (k, 3) is outside. The j points are less than half a `width` deep. j is 0 if the
    front is near the face over no more than two widths, never gets deeper than half a width, comes out
    again, or if a new place would be farther than two widths away.
    """
    depths = _depths(points, box)
    plane = int(depths[0].argmin())
    depth = depths[1:, plane]
    deep = depth >= width / 2
    count = int(np.argmax(deep)) if deep.any() else 0
    thin = points[1 : count + 1]
    is_long = count and np.linalg.norm(points[count + 1] - points[1]) > 2 * width
    if not is_long or (depths[1 : count + 1] < 0).any():
        return thin[:0]
    outward, beyond = np.sign(plane - 2.5) * np.eye(3)[plane % 3], BEYOND * width / 2
    moved = [_aside(place, far + beyond, outward, normal, 2 * width) for place, far in zip(thin, depth)]
    return thin[:0] if any(place is None for place in moved) else np.array(moved, float)


def _carried_out(
    points: np.ndarray, origin: np.ndarray, start: np.ndarray, box: np.ndarray, normal: np.ndarray
) -> tuple[np.ndarray, np.ndarray, bool]:
    """Return points and origin of a moved front that begins beyond a box plane, and whether it was cut.

    start (k, 3), origin (k,): place on the old front from which each point has moved, and its arc length.
    The first, the old end, lies on one or more planes of the box; else the front is returned unchanged. If
    within one length of the end's move the front leaves the box again or, before it enters the box, turns
    back against the old front, the points before it leaves the last time are dropped. If its first point is
    then not beyond one of the end's planes, a point beyond the nearest of them is put first: the front goes
    straight on, or perpendicular to `normal` (3,) if the point is outside the box at another plane. If this
    takes more than one length of the move, the end's move is instead turned parallel to its planes, BEYOND
    lengths of the move outside them; the turn fades along the front over one such length.
    """
    end = start[0]
    sides, axes = np.nonzero(np.abs(end - box) <= ON_PLANE * np.linalg.norm(box[1] - box[0]))
    size = float(np.linalg.norm(points[0] - end))
    if not size or not len(sides):
        return points, origin, False
    outside = ((points < box[0]) | (points > box[1])).any(axis=1)
    near = outside[:-1] & (np.abs(origin[:-1] - origin[0]) <= size)
    last = int(np.flatnonzero(near).max(initial=0))
    turns = (np.diff(points[: last + 1], axis=0) * np.diff(start[: last + 1], axis=0)).sum(axis=1) < 0
    is_cut = not outside[:last].all() or (bool(turns.any()) and not outside[last:].all())
    if is_cut:
        points, origin = points[last:], np.append(origin[0], origin[last + 1 :])
    outward, move = np.where(sides, 1.0, -1.0), points[0] - end
    depths = (box[sides, axes] - points[:, axes]) * outward
    if (depths[0] < -BEYOND * size).any():
        return points, origin, is_cut
    past = np.delete((points[0] < box[0]) | (points[0] > box[1]), axes).any()
    found = [
        _aside(points[0], depth[0] + BEYOND * size, way, normal, size)
        if past
        else _straight_on(points, depth, size)
        for depth, way in zip(depths.T, outward[:, None] * np.eye(3)[axes])
    ]
    reached = [place for place in found if place is not None]
    if reached:
        nearest = min(reached, key=lambda place: float(np.linalg.norm(place - points[0])))
        return np.concatenate([nearest[None], points]), np.append(origin[0], origin), is_cut
    within = move.copy()
    within[axes] = 0.0
    if not within.any():
        return points, origin, is_cut
    within *= size / np.linalg.norm(within)
    within[axes] = BEYOND * size * outward
    fading = np.clip(1 - np.abs(origin - origin[0]) / size, 0, 1)
    return points + fading[:, None] * (within - move), origin, is_cut


def _straight_on(points: np.ndarray, depth: np.ndarray, size: float) -> np.ndarray | None:
    """Return the point (3,) past a plane where a front (k, 3) arrives, continued straight from its start.

    depth (k,): distance of its points inside the plane; size: length of the end's move. The front's first
    `size` gives the direction. The point lies BEYOND times size past the plane; None if the plane is
    farther than size or the front leads away from it.
    """
    away = np.linalg.norm(points - points[0], axis=1)
    far = int(np.argmax(away >= size)) or len(points) - 1
    rise = (depth[far] - depth[0]) / away[far]
    if not max(depth[0], 0.0) <= size * rise:
        return None
    way = (points[0] - points[far]) / away[far]
    return points[0] + way * (max(depth[0] / rise, 0.0) + BEYOND * size)


def _aside(
    place: np.ndarray, depth: float, outward: np.ndarray, normal: np.ndarray, size: float
) -> np.ndarray | None:
    """Return the point (3,) that lies `depth` farther along `outward` than `place` (3,).

    The step to it is perpendicular to the crack's `normal`. None if the step is longer than `size`.
    """
    way = outward - (outward @ normal) * normal
    step = depth / max(float(way @ outward), np.finfo(float).tiny) * way
    return place + step if np.linalg.norm(step) <= size else None


def without_loops(
    points: np.ndarray, origin: np.ndarray, axes: np.ndarray, closed: bool
) -> tuple[np.ndarray, np.ndarray, int]:
    """Return points (k, 3) and origin (k,) without loops in projection on `axes` (2, 3), and their number.

    origin: arc length on the old front from which each point has moved. The piece between the two passages
    of a crossing is removed; of a closed front's two pieces, the one with fewer points. The crossing
    becomes one point halfway between the passages, whose heights may differ. Nearby points are shifted too,
    less with distance, over a length of the old front equal to the removed one; a jump in height would fold
    the crack surface between old and new front.
    """
    loops = 0
    while len(points) > 3:
        i, j, shares = _first_crossing(points @ axes.T, closed)
        if i < 0:
            break
        loops += 1
        passed = points[[i, j]] + shares[:, None] * (points[[i + 1, j + 1]] - points[[i, j]])
        meet, half = passed.mean(axis=0), (passed[1] - passed[0]) / 2
        at = origin[i] + shares[0] * (origin[i + 1] - origin[i])
        if not closed or j - i <= len(points) - 1 - (j - i):
            lost = origin[j + 1] - origin[i]
            before = _drawn(points[: i + 1], (at - origin[: i + 1]) / lost, half)
            after = _drawn(points[j + 1 :], (origin[j + 1 :] - origin[j]) / lost, -half)
            points = np.concatenate([before, [meet], after])
            origin = np.concatenate([origin[: i + 1], [at], origin[j + 1 :]])
        else:
            kept, own = points[i + 1 : j + 1], origin[i + 1 : j + 1]
            lost = origin[-1] - (own[-1] - own[0])
            kept = _drawn(_drawn(kept, (own - at) / lost, half), (origin[j + 1] - own) / lost, -half)
            points = np.concatenate([[meet], kept, [meet]])
            origin = np.concatenate([[at], own, [origin[j]]])
    return points, origin, loops


def _drawn(points: np.ndarray, away: np.ndarray, shift: np.ndarray) -> np.ndarray:
    """Return points (k, 3) moved by `shift` (3,) times 1 - `away` (k,), clipped to [0, 1]."""
    return points + np.clip(1 - away, 0, 1)[:, None] * shift


def _first_crossing(uv: np.ndarray, closed: bool) -> tuple[int, int, np.ndarray]:
    """Return two segments i < j of a polyline (k, 2) that cross, and fractions (2,) along i and j there.

    i is the first segment that crosses a later one, j the last segment that it crosses; both are -1 if no
    two segments cross.
    """
    start, step = uv[:-1], np.diff(uv, axis=0)
    count = len(start)
    for i in range(count - 2):
        others = slice(i + 2, count - 1 if closed and i == 0 else count)
        off, way = start[others] - start[i], step[others]
        turn = step[i, 0] * way[:, 1] - step[i, 1] * way[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            here = (off[:, 0] * way[:, 1] - off[:, 1] * way[:, 0]) / turn
            there = (off[:, 0] * step[i, 1] - off[:, 1] * step[i, 0]) / turn
        crosses = np.flatnonzero((here >= 0) & (here <= 1) & (there >= 0) & (there <= 1))
        if len(crosses):
            last = int(crosses[-1])
            return i, i + 2 + last, np.array([here[last], there[last]])
    return -1, -1, np.zeros(2)


def _sampled_between(
    points: np.ndarray, origin: np.ndarray, stays: np.ndarray, kept: np.ndarray, spacing: float
) -> NewFront:
    """Return the front through points (k, 3): the points in the mask `kept` (k,), and samples between them.

    Samples are about every `spacing` on splines between kept points. origin (k,): arc lengths on the old
    front from which the points come; stays (k,): mask of points that did not move.
    """
    breaks = np.unique([0, *np.flatnonzero(kept), len(points) - 1])
    found = [NewFront(points[:1], origin[:1], stays[:1])]
    for i, j in zip(breaks[:-1].tolist(), breaks[1:].tolist()):
        places, arcs = points[[i, j]], origin[[i, j]]
        if j > i + 1:
            places, arcs = _sampled(points[i : j + 1], origin[i : j + 1], False, spacing)
        ends = np.append(np.zeros(len(places) - 2, bool), stays[j])
        found.append(NewFront(places[1:], arcs[1:], ends))
    return NewFront(*map(np.concatenate, zip(*found)))


def _sampled(
    points: np.ndarray, origin: np.ndarray, closed: bool, spacing: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return samples about every `spacing` of the cubic spline through points (k, 3), and their origins.

    origin (k,): arc lengths on the old front from which the points come. An open front of three or more
    points gets at least three samples.
    """
    arc = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    keep, least = [0], CLOSE * spacing
    for row in range(1, len(arc) - 1):
        if arc[row] - arc[keep[-1]] >= least and arc[-1] - arc[row] >= least:
            keep.append(row)
    keep.append(len(arc) - 1)
    line = polyline(points[keep])
    origin = origin[keep]
    parts = max(round(line.length / spacing), 3 if closed else min(len(points) - 1, 2))
    places = np.linspace(0, line.length, parts + 1)
    if len(line.points) < 4:
        sampled = line.at(places[:-1] if closed else places)
        sampled = np.concatenate([sampled, line.points[-1:]]) if closed else sampled
    else:
        ends = "periodic" if closed else "not-a-knot"
        sampled = scipy.interpolate.CubicSpline(line.arc, line.points, bc_type=ends)(places)
    sampled[0], sampled[-1] = line.points[0], line.points[-1]
    return sampled, np.interp(places, line.arc, origin)
