"""Growth of a crack by one increment: move every front, and join old and new front by a strip."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import scipy

from craftmesh.cracks.height_parts import best_fit_frame, fold_of, kinks_of
from craftmesh.cracks.merged_sheets import merged_sheets
from craftmesh.cracks.polyline import Polyline, feet, polyline
from craftmesh.cracks.sheets import one_crack, sheets
from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.errors import CraftmeshError
from craftmesh.growth.front_step import FrontStep
from craftmesh.growth.moves import beside_rest, moves_along, points_at_rest
from craftmesh.growth.new_front import (
    NewFront,
    broken_through,
    new_front,
    stopped_outside,
    strip_triangles,
    with_front_points,
)
from craftmesh.growth.options import WIDEST_IN_CRYSTALS, SmoothingOptions
from craftmesh.types import Crack

# Points of the new front per row of the old one (a row is a front node with K). The chords of a front with
# a radius of ten row spacings are then within 0.001 spacings of it, and the next mesh's tangents follow the
# curve. Also samples per row in `relaxation`: linear interpolation between them loses under 0.1 % of a wave
# of ten rows.
FINENESS = 4
MET = 0.5  # distance, in row spacings, within which the fronts of two surfaces have met
# Distance, in row spacings, from a point where two fronts have met, within which rows are ignored. There
# one front turns into the other at a corner, and directions belong to neither.
CORNER = 3.0
# Distance, in row spacings, within which two surfaces one above the other become one. Parallel surfaces
# 0.1 l_min apart left slivers and facets 0.1 l_min off; surfaces 0.3 l_min apart left none.
MERGED = 0.3
SHORTENED = "shortened"
# Attempts at a valid surface, in turn: the repair, the factor on the fit's smoothing length, the fraction
# of the step, and whether points that leave the box stop just outside it, where the surface may fold. A
# front that leaves the box whole then goes straight on.
ATTEMPTS = (
    ("", 1, 1.0, False),
    ("stopped", 1, 1.0, True),
    *(("smoothed", coarser, 1.0, True) for coarser in (2, 4, 8)),
    *((SHORTENED, 1, share, True) for share in (1 / 2, 1 / 4)),
)
# Numbers of rows of a strip; the first with the fewest kinks counts. Between fronts that are twisted
# against each other long triangles make a washboard, whose kinks are the twist within a row.
ROWS = (1, 2, 4, 8)
FOLDED = WIDEST_IN_CRYSTALS  # angle between triangles over which a strip is folded: no kink is larger
# What was done to a new front or strip, for the report; the keys of `GrownCrack.repairs`.
REPAIRS = {
    "loops": "a front crossed itself; the loop is cut off",
    "ends": "a front came back into the body or turned back at its end; the end is cut off",
    "ligaments": "a ligament thinner than an edge of the front is broken through",
    "stopped": "a strip folded outside the body; it ends just outside",
    "smoothed": "a strip folded; its moves are smoothed over a longer length",
    SHORTENED: "a strip folded; it is half or a quarter of the step",
}
LEAST_ROWS = 3  # fewest rows of a surface or front that grows; fewer give no spacing, and it soon vanishes


class GrownCrack(NamedTuple):
    """A crack whose fronts have moved.

    crack: None if no front is left inside the box; repairs: count of each repair, a key of REPAIRS;
    extension (n,): the extension laid at each row, the row's own times the fraction that `beside_rest` and
    shorter attempts leave. Smoothing, cut loops and ends outside the box do not change it.
    """

    crack: Crack | None
    repairs: Counter[str]
    extension: np.ndarray


def grow(crack: Crack, along: FrontStep, box: np.ndarray, options: SmoothingOptions) -> GrownCrack:
    """Return the crack with its fronts moved, in the box (2, 3).

    along: a row for each front node with K, with the node's move. The moves are smoothed along each front
    (the paper, section 2). Front ends on the box move to it or beyond. A strip joins old and new front. In
    a crack of several surfaces each grows by the rows of its own fronts, and stays if it has too few.
    Surfaces that almost coincide become one. Surfaces that coincide exactly stay two: the part of a front
    inside the other surface has no rows, and moves like the rest. Raise CraftmeshError for rows that lie on
    no front, and if the last of the ATTEMPTS, with smoother and shorter moves, is still no crack (folded,
    torn).
    """
    parts, repairs, extension = sheets(crack), Counter[str](), along.extension.copy()
    if len(parts) == 1:
        grown, repairs, extension = _grown(crack, along, box, options)
    else:
        lines = [polyline(part.points[front]) for part in parts for front in part.fronts]
        of_line = np.repeat(np.arange(len(parts)), [len(part.fronts) for part in parts])
        owner = of_line[nearest_feet(lines, along.points)[0]]
        clear = _clear_of_meetings(parts, along.points)
        for k, part in enumerate(parts):
            rows = np.flatnonzero((owner == k) & clear)
            if len(rows) < LEAST_ROWS:
                extension[owner == k] = 0.0
                continue
            parts[k], found, extension[rows] = _grown(part, along.rows(rows), box, options)
            repairs += found
        length = row_spacing(along.points)
        grown = merged_sheets(one_crack(parts), np.asarray(box, float), length, MERGED * length)
    meets = any(_meets(grown.points[front], box) for front in grown.fronts)
    return GrownCrack(grown if meets else None, repairs, extension)


def _clear_of_meetings(parts: list[Crack], places: np.ndarray) -> np.ndarray:
    """Return a mask (n,) of places (n, 3) farther than CORNER row spacings from where fronts have met.

    These are the points where fronts of two of the `parts`, the surfaces of the crack, are close (MET).
    """

    spacing = row_spacing(places)
    lines = [[polyline(part.points[front]) for front in part.fronts] for part in parts]
    met = [np.zeros((0, 3))]
    for k, own in enumerate(lines):
        points = [line.at(np.arange(0, line.length, MET * spacing)) for line in own]
        for other in (line for j, group in enumerate(lines) if j != k for line in group):
            met += [place[feet(other, place)[1] < MET * spacing] for place in points]
    corners = np.concatenate(met)
    if not len(corners):
        return np.ones(len(places), bool)
    return scipy.spatial.cKDTree(corners).query(places)[0] > CORNER * spacing


def _grown(
    crack: Crack, along: FrontStep, box: np.ndarray, options: SmoothingOptions
) -> tuple[Crack, Counter[str], np.ndarray]:
    """Return one surface of a crack with its fronts moved, and repairs and extension as in `GrownCrack`.

    The surface has no fronts if none is left in the box. ATTEMPTS, which repair and smooth differently,
    follow each other until the result is a valid crack without new kinks over FOLDED or a new fold. If
    all have these, the first valid one counts. Attempts that smooth more are skipped unless
    options.smoothing is fit.
    """
    box = np.asarray(box, float)
    rows = _rows_by_front(crack, along.points)
    allowed = max(FOLDED, kinks_of(crack.points, crack.triangles).sharpest)
    folded: CraftmeshError | None = None
    kinked: tuple[Crack, Counter[str], np.ndarray] | None = None
    for repair, coarser, share, stops in ATTEMPTS:
        if coarser > 1 and options.smoothing != "fit":
            continue
        own = replace(along, extension=share * along.extension)
        points, triangles, fronts, done, laid = _with_strips(
            crack, own, rows, box, options, (coarser, stops)
        )
        done.update([repair] if repair else [])
        try:
            if not any(_meets(front, box) for front in fronts):
                result = Crack(points, triangles, ())
            else:
                result = crack_from_triangles(points, triangles, fronts, box)
        except CraftmeshError as error:
            folded = folded or error
            continue
        kinked = kinked or (result, done, laid)
        smooth = kinks_of(points, triangles).sharpest <= allowed
        if smooth and (not fold_of(points, triangles) or fold_of(crack.points, crack.triangles)):
            kinked = result, done, laid
            break
    if kinked is None:
        assert folded is not None
        raise folded
    return kinked


def _with_strips(
    crack: Crack,
    along: FrontStep,
    rows: list[tuple[np.ndarray, np.ndarray]],
    box: np.ndarray,
    options: SmoothingOptions,
    how: tuple[float, bool],
) -> tuple[np.ndarray, np.ndarray, list[np.ndarray], Counter[str], np.ndarray]:
    """Return points, triangles and new fronts (k, 3) of a surface with a strip ahead of each front.

    A strip is the new crack surface between old and new front. Where front nodes do not move, the front
    stays and there is no strip. Repairs and extension (n,) follow, as in `GrownCrack`. rows: ids and arc
    lengths of each front's nodes with K; how: factor on the smoothing length, and whether points stop just
    outside the box.
    """
    spacing = row_spacing(along.points) / FINENESS
    frame = best_fit_frame(crack.points, crack.triangles)
    points, triangles = crack.points, crack.triangles.astype(np.int64)
    fronts, repairs, extension = [], Counter[str](), along.extension.copy()
    for front, (row, s) in zip(crack.fronts, rows):
        own = along.rows(row)
        if not (own.extension > 0).any():
            fronts.append(crack.points[front])
            continue
        points, triangles, ids = with_front_points(points, triangles, front, spacing)
        old = polyline(points[ids])
        moves, extension[row] = _moves(old, s, own, box, options, how)
        moved, cut = new_front(old, moves, box, frame, spacing)
        places, ligaments = broken_through(moved.points, box, frame[2], FINENESS * spacing)
        repairs += cut + Counter(ligaments=ligaments)
        moved = moved._replace(points=np.where(moved.stays[:, None], moved.points, places))
        points, strip = min(
            (_strip(points, ids, old, moved, count) for count in ROWS),
            key=lambda laid: len(kinks_of(*laid).edges),
        )
        triangles = np.concatenate([triangles, strip])
        fronts.append(moved.points)
    return points, triangles, fronts, repairs, extension


def _moves(
    old: Polyline,
    s: np.ndarray,
    own: FrontStep,
    box: np.ndarray,
    options: SmoothingOptions,
    how: tuple[float, bool],
) -> tuple[np.ndarray, np.ndarray]:
    """Return the moves (k, 3) of the points of a front `old`, and the extension (n,) that its rows keep.

    own, s (n,): the front's rows and their arc lengths; how: as in `_with_strips`.
    """
    coarser, stops = how
    rest = points_at_rest(old, s, own.extension > 0)
    moves = moves_along(old, s, own, options, coarser)
    share = beside_rest(old, rest, moves)
    if stops and not _meets(old.points + share[:, None] * moves, box):
        straight = replace(own, kink_angle=np.zeros_like(own.kink_angle))
        moves = moves_along(old, s, straight, options, coarser)
        share = beside_rest(old, rest, moves)
    kept = own.extension * np.interp(s, old.arc, share)
    moves = share[:, None] * moves
    return stopped_outside(old.points, moves, box) if stops else moves, kept


def _strip(
    points: np.ndarray, ids: np.ndarray, old: Polyline, moved: NewFront, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return points, the strip's new ones last, and triangles (m, 3) of a strip between two fronts.

    The strip leads from the front `old`, with points `ids`, to the front `moved`. It has `count` rows of
    points, evenly spaced from old to new front. Points of the old front that did not move are not repeated.
    """
    start = old.at(moved.origin)
    added = ~moved.stays[: len(moved.points) - old.closed]  # a closed front ends with its first point
    at_rest = ids[np.searchsorted(old.arc, moved.origin[: len(added)][~added])]
    behind, arc, rows = ids, old.arc, []
    for share in np.arange(1, count + 1) / count:
        new = len(points) + np.cumsum(added) - 1
        new[~added] = at_rest
        new = np.append(new, new[:1]) if old.closed else new
        rows.append(strip_triangles(behind, arc, new, moved.origin))
        places = start + share * (moved.points - start) if share < 1 else moved.points
        points = np.concatenate([points, places[: len(added)][added]])
        behind, arc = new, moved.origin
    return points, np.concatenate(rows)


def _rows_by_front(crack: Crack, places: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return for each front the indices of the places (n, 3) on it, and their ascending arc lengths.

    places: the places of the rows of sif.csv. Raise CraftmeshError for a row farther than the row spacing
    from all fronts, and for a front without rows.
    """
    lines = [polyline(crack.points[front]) for front in crack.fronts]
    nearest, arc, off = nearest_feet(lines, places)
    spacing = row_spacing(places)
    if (off > spacing).any():
        worst = int(off.argmax())
        raise CraftmeshError(
            f"row {worst + 1} of sif.csv lies {off[worst]:.4g} away from the crack's fronts, but at most "
            f"{spacing:.4g} is allowed; give the crack from which this front was meshed"
        )
    result = in_order(nearest, arc, len(lines))
    for number, (row, _) in enumerate(result, 1):
        if not len(row):
            raise CraftmeshError(
                f"front {number} of the crack has no row of stress intensities; give rows on each front"
            )
    return result


def in_order(nearest: np.ndarray, arc: np.ndarray, count: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return for each of `count` fronts the indices (k,) of its rows, by arc length, and these lengths.

    nearest, arc (n,): each row's nearest front and arc length on it.
    """
    rows = [np.flatnonzero(nearest == number) for number in range(count)]
    rows = [row[np.argsort(arc[row], kind="stable")] for row in rows]
    return [(row, arc[row]) for row in rows]


def nearest_feet(
    lines: Sequence[Polyline], places: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return for places (n, 3) the index of the nearest front, arc length on it, and distance (n,) from it.

    lines: the fronts.
    """
    arcs, distances = map(np.array, zip(*(feet(line, places) for line in lines)))
    nearest = distances.argmin(axis=0)
    row = np.arange(len(places))
    return nearest, arcs[nearest, row], distances[nearest, row]


def row_spacing(places: np.ndarray) -> float:
    """Return the median distance of successive front nodes at `places` (n, 3): their edge length."""
    return float(np.median(np.linalg.norm(np.diff(places, axis=0), axis=1)))


def _meets(front: np.ndarray, box: np.ndarray) -> bool:
    """Return True if a point of the front (k, 3) lies inside the box."""
    return bool(((front > box[0]) & (front < box[1])).all(axis=1).any())
