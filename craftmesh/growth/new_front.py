"""The front after one extension: moved, carried to the box's faces, freed of loops, sampled anew."""

from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from craftmesh.cracks.polyline import Polyline, polyline

# Of the box's diagonal: a front's end this near to a plane of the box lies on it.
ON_PLANE = 1e-7
# Of the spacing: points of the new front nearer than that say nothing about its course.
CLOSE = 0.1
# Of an end's move: how far its front goes on straight at most, to reach the end's box plane from there.
REACH = 1.0


class NewFront(NamedTuple):
    """The new front's points (m, 3), in order, and the arc lengths (m,) of the old front they come from.

    A closed one ends with its first point, at the old front's length.
    """

    points: np.ndarray
    origin: np.ndarray


def new_front(
    old: Polyline, moves: np.ndarray, box: np.ndarray, frame: np.ndarray, spacing: float
) -> NewFront:
    """Return the front to which the points of `old` go by `moves` (k, 3), sampled about every `spacing`.

    box (2, 3); frame (3, 3): rows u, v, normal of a plane over which the new front has no loops. An open
    front's ends stay in the planes of the box that they lie on, or leave the box. Where the front is
    concave and goes farther than its radius it would form loops; those are cut off.
    """
    moves = moves.copy()
    if old.closed:
        moves[-1] = moves[0]
    else:
        _carry_ends(old, moves, box)
    points, origin = old.points + moves, old.arc
    if not old.closed:
        points, origin = _without_overrun(points, origin, box)
    points, origin = without_loops(points, origin, frame[:2], old.closed)
    moved = _sampled(points, origin, old.closed, spacing)
    # the curve through the points may swing a little beyond the planes that they lie in
    return moved if old.closed else NewFront(*_without_overrun(*moved, box))


def _carry_ends(old: Polyline, moves: np.ndarray, box: np.ndarray) -> None:
    """Change the moves of both ends so that they stay in the box planes they lie on.

    A front that meets its plane at a low angle has its next end far from the last. Where it leaves the box,
    its end goes its way, and the front ends where it crosses the plane; else the end's move is turned into
    the plane, and the turn fades over one such move.
    """
    near = ON_PLANE * np.linalg.norm(box[1] - box[0])
    tangent = old.tangents()
    for end, along in ((0, old.arc), (-1, old.length - old.arc)):
        on_planes = np.abs(old.points[end] - box) <= near
        axes = np.flatnonzero(on_planes.any(axis=0))
        size = np.linalg.norm(moves[end])
        within = moves[end].copy()
        within[axes] = 0.0
        if not len(axes) or not np.linalg.norm(within) > 0:
            continue
        reached = _along_plane(moves[end], tangent[end], axes[0]) if len(axes) == 1 else None
        if reached is not None:
            moves[end] = reached
        elif not ((moves[end] < 0) & on_planes[0] | (moves[end] > 0) & on_planes[1]).any():
            turn = within / np.linalg.norm(within) * size - moves[end]
            moves += np.clip(1 - along / size, 0, 1)[:, None] * turn


def _along_plane(move: np.ndarray, tangent: np.ndarray, axis: int) -> np.ndarray | None:
    """Return where an end goes in the plane square to `axis`, None where the front does not reach it.

    move (3,), taken square to the front, and tangent (3,) there: a straight front that goes by the move
    meets the plane in that place.
    """
    square = move - (move @ tangent) * tangent
    length = np.linalg.norm(square)
    if not length > 0:
        return None
    square *= np.linalg.norm(move) / length
    if abs(square[axis]) > REACH * np.linalg.norm(move) * abs(tangent[axis]):
        return None
    reached = square - square[axis] / tangent[axis] * tangent
    reached[axis] = 0.0
    return reached


def _without_overrun(
    points: np.ndarray, origin: np.ndarray, box: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the front without the points next to its ends that lie beyond the ends' box planes."""
    near = ON_PLANE * np.linalg.norm(box[1] - box[0])
    keep = np.ones(len(points), bool)
    for order in (np.arange(len(points)), np.arange(len(points))[::-1]):
        end = points[order[0]]
        low, high = np.abs(end - box[0]) <= near, np.abs(end - box[1]) <= near
        beyond = ((points < box[0] + near) & low).any(axis=1) | ((points > box[1] - near) & high).any(
            axis=1
        )
        run = np.flatnonzero(~beyond[order][1:])
        keep[order[1 : 1 + (run[0] if len(run) else len(points) - 2)]] = False
    return points[keep], origin[keep]


def without_loops(
    points: np.ndarray, origin: np.ndarray, axes: np.ndarray, closed: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Return points (k, 3) and origin (k,) without the loops that they form seen along `axes` (2, 3).

    The piece between a crossing's two passages goes; of a closed front's two pieces the one with the fewer
    points. The crossing itself becomes a point.
    """
    while len(points) > 3:
        i, j, share = _first_crossing(points @ axes.T, closed)
        if i < 0:
            break
        meet = points[i] + share * (points[i + 1] - points[i])
        at = origin[i] + share * (origin[i + 1] - origin[i])
        if not closed or j - i <= len(points) - 1 - (j - i):
            points = np.concatenate([points[: i + 1], [meet], points[j + 1 :]])
            origin = np.concatenate([origin[: i + 1], [at], origin[j + 1 :]])
        else:
            points = np.concatenate([[meet], points[i + 1 : j + 1], [meet]])
            origin = np.concatenate([[at], origin[i + 1 : j + 1], [origin[j]]])
    return points, origin


def _first_crossing(uv: np.ndarray, closed: bool) -> tuple[int, int, float]:
    """Return the first two segments i < j of a polyline (k, 2) that cross, and where on i; -1 for none."""
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
            return i, i + 2 + int(crosses[-1]), float(here[crosses[-1]])
    return -1, -1, 0.0


def _sampled(points: np.ndarray, origin: np.ndarray, closed: bool, spacing: float) -> NewFront:
    """Return the cubic spline through the points by arc length, sampled about every `spacing`."""
    arc = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    keep = _spaced(arc, CLOSE * spacing)
    line = polyline(points[keep])
    origin = origin[keep]
    places = np.linspace(0, line.length, max(round(line.length / spacing), 3 if closed else 1) + 1)
    if len(line.points) < 4:
        sampled = line.at(places[:-1] if closed else places)
        sampled = np.concatenate([sampled, line.points[-1:]]) if closed else sampled
    else:
        sampled = CubicSpline(line.arc, line.points, bc_type="periodic" if closed else "not-a-knot")(places)
    sampled[0], sampled[-1] = line.points[0], line.points[-1]
    return NewFront(sampled, np.interp(places, line.arc, origin))


def _spaced(arc: np.ndarray, least: float) -> np.ndarray:
    """Return rows of ascending arc lengths (k,) at least `least` apart, with the first and the last."""
    kept = [0]
    for row in range(1, len(arc) - 1):
        if arc[row] - arc[kept[-1]] >= least and arc[-1] - arc[row] >= least:
            kept.append(row)
    return np.array([*kept, len(arc) - 1])
