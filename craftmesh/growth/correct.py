"""Lay the last strip of a grown crack again, by the kinks and rates found at its end."""

from dataclasses import replace

import numpy as np
import scipy

from craftmesh.cracks.polyline import polyline
from craftmesh.cracks.sheets import sheets
from craftmesh.errors import CraftmeshError
from craftmesh.growth.front_step import FrontStep, Step
from craftmesh.growth.grow import SHORTENED, grow, nearest_feet
from craftmesh.growth.options import SmoothingOptions
from craftmesh.growth.relaxation import over_step_again, rows_along
from craftmesh.growth.trust import or_all
from craftmesh.types import Crack

# Largest fraction of the kink at a step's end by which the step is turned. The step began along the path's
# tangent; the chord of an evenly turning path makes equal angles with its tangents at both ends.
SHARE = 0.5
NEAREST = 2  # nearest trusted points from which a kink is interpolated


def corrected(last: Step, reached: Step, box: np.ndarray, options: SmoothingOptions) -> Step:
    """Return the step `reached` as it would start if the step `last` before it were the chord of the path.

    The strip of `last`, the crack surface that it added, is laid again in the box (2, 3). Each point's move
    is turned by a share of the kink found where the point arrived (`_turned`), and its length follows the
    rate found there. The points of the result are the nearest to the points of `reached` on the new front,
    with the kinks that are left. Raise CraftmeshError if the crack is not valid (`grow`), if the strip,
    whose cycles are counted already, would be shorter, if the number of surfaces or fronts changes, or if
    the new front is farther away than the largest extension.
    """
    before, after = last.along, reached.along
    found = np.column_stack([after.kink_angle, after.rate, after.stretch])
    kink, rate, stretch = _found_at(after, before.points + before.moves, found).T
    lines = [polyline(last.crack.points[front]) for front in last.crack.fronts]
    fronts = rows_along(lines, before.points, before.binormal)
    power = float(np.median(before.power))
    extension = over_step_again(before.rate, before.extension, rate, power, fronts)
    turn, _ = _turned(kink, stretch, before.extension)
    laid = replace(before, kink_angle=before.kink_angle + turn, extension=extension)
    crack, repairs, _ = grow(last.crack, laid, box, options)
    if repairs[SHORTENED]:
        raise CraftmeshError("the corrected strip folds unless it is shorter than the step")
    parts = [len(sheets(each)) for each in (crack, reached.crack) if each is not None]
    if crack is None or parts[0] != parts[1] or len(crack.fronts) != len(reached.crack.fronts):
        raise CraftmeshError("the corrected crack would have another number of surfaces or fronts")
    kink, _, stretch = _found_at(after, after.points, found).T
    turn, left = _turned(kink, stretch, float(np.median(before.extension)))
    sine, cosine = np.sin(turn)[:, None], np.cos(turn)[:, None]
    turned = replace(
        after,
        points=_onto_fronts(crack, after),
        normal=cosine * after.normal - sine * after.binormal,
        binormal=cosine * after.binormal + sine * after.normal,
        kink_angle=left,
    )
    return Step(crack, turned)


def _turned(
    kink: np.ndarray, stretch: np.ndarray, extension: np.ndarray | float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the angles (n,) by which a step is turned, and the kinks (n,) that are then left at its end.

    A step that is off the path by an angle ends with a kink of 1 - 2 sqrt(8 s / pi) T / K_I times it
    (Cotterell & Rice 1980); the step is turned by this angle, or by SHARE of the kink if that is less.
    stretch (n,): T / K_I at the end; extension: s.
    """
    gain = np.maximum(1 - 2 * np.sqrt(8 / np.pi * extension) * stretch, 0.0)
    share = np.minimum(SHARE, 1 / np.maximum(gain, 1.0))
    return share * kink, (1 - share * gain) * kink


def _found_at(along: FrontStep, places: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return values (k, m) at places (k, 3), interpolated from the nearest trusted rows of `values` (n, m).

    The NEAREST rows are weighted by inverse distance. If no row is trusted, all rows count.
    """

    rows = or_all(along.trusted, np.ones(len(values), bool))
    points, values = along.points[rows], values[rows]
    off, row = scipy.spatial.cKDTree(points).query(places, range(1, min(NEAREST, len(points)) + 1))
    weight = 1 / np.maximum(off, np.finfo(float).tiny ** 0.5)
    weight /= weight.sum(axis=1, keepdims=True)
    return (weight[:, None] @ values[row])[:, 0]


def _onto_fronts(crack: Crack, along: FrontStep) -> np.ndarray:
    """Return the points (n, 3) of the crack's fronts nearest to the points of the rows.

    Raise CraftmeshError if one is farther away than the largest extension.
    """
    lines = [polyline(crack.points[front]) for front in crack.fronts]
    nearest, arc, off = nearest_feet(lines, along.points)
    far, step = int(np.argmax(off)), along.extension.max()
    if off[far] > step:
        raise CraftmeshError(
            f"the corrected front would lie {off[far]:.4g} from the front before at row {far + 1}, farther "
            f"than the largest extension {step:.4g}"
        )
    places = np.empty_like(along.points)
    for number, line in enumerate(lines):
        own = nearest == number
        places[own] = line.at(arc[own])
    return places
