"""The last strip of a grown crack laid again, by the kinks and the rates found at its end."""

from dataclasses import replace

import numpy as np
import scipy

from craftmesh.cracks.polyline import polyline
from craftmesh.cracks.sheets import sheets
from craftmesh.errors import CraftmeshError
from craftmesh.growth.front_step import FrontStep, Step
from craftmesh.growth.grow import grow, nearest_feet
from craftmesh.growth.options import SmoothingOptions
from craftmesh.growth.relaxation import over_step_again, rows_along
from craftmesh.growth.trust import or_all
from craftmesh.types import Crack

# Of the kink at a step's end by which the step itself is turned: the chord of a path that turns evenly
# makes equal angles with it at both ends, and the step began along it.
SHARE = 0.5
# Of that kink: what is left of it where the step has been turned. A half if the direction at the tip were
# all that counts (Cotterell & Rice 1980), nothing if the crack turned as a whole; corrected cracks of an
# inclined penny, meshed and solved for themselves, had 0.25 after the first step and 0.09 after the third.
# With a half the next strip goes too far: it kinks back by 11 degrees where with a quarter it is 4.
LEFT = 0.25
NEAREST = 2  # trusted points of a front between which a kink is taken


def corrected(last: Step, reached: Step, box: np.ndarray, options: SmoothingOptions) -> Step:
    """Return the step `reached` by `last` from where it had begun if that one were a path's chord.

    The strip of `last` is laid again in the box (2, 3), turned at each point by SHARE of the kink found
    where that point came to, and as long as the rate there says. The points of the new front lie beside
    those of `reached` and kink by LEFT of what those do. Raises CraftmeshError as grow does, and where the
    crack has other sheets or fronts then, or a front farther off than it goes.
    """
    before, after = last.along, reached.along
    found = np.column_stack([after.kink_angle, after.rate])
    kink, rate = _found_at(after, before.points + before.moves, found).T
    lines = [polyline(last.crack.points[front]) for front in last.crack.fronts]
    fronts = rows_along(lines, before.points, before.binormal)
    power = float(np.median(before.power))
    extension = over_step_again(before.rate, before.extension, rate, power, fronts)
    laid = replace(before, kink_angle=before.kink_angle + SHARE * kink, extension=extension)
    crack = grow(last.crack, laid, box, options)
    parts = [len(sheets(each)) for each in (crack, reached.crack) if each is not None]
    if crack is None or parts[0] != parts[1] or len(crack.fronts) != len(reached.crack.fronts):
        raise CraftmeshError("its sheets and fronts would be others; expected those of the crack as it is")
    kink = _found_at(after, after.points, after.kink_angle[:, None])
    sine, cosine = np.sin(SHARE * kink), np.cos(SHARE * kink)
    turned = replace(
        after,
        points=_onto_fronts(crack, after),
        normal=cosine * after.normal - sine * after.binormal,
        binormal=cosine * after.binormal + sine * after.normal,
        kink_angle=LEFT * kink[:, 0],
    )
    return Step(crack, turned)


def _found_at(along: FrontStep, places: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the values (k, m) of trusted rows, of all where none is, next to places (k, 3)."""

    rows = or_all(along.trusted, np.ones(len(values), bool))
    points, values = along.points[rows], values[rows]
    off, row = scipy.spatial.cKDTree(points).query(places, range(1, min(NEAREST, len(points)) + 1))
    weight = 1 / np.maximum(off, np.finfo(float).tiny ** 0.5)
    weight /= weight.sum(axis=1, keepdims=True)
    return (weight[:, None] @ values[row])[:, 0]


def _onto_fronts(crack: Crack, along: FrontStep) -> np.ndarray:
    """Return the points (n, 3) of the crack's fronts next to the rows' points."""
    lines = [polyline(crack.points[front]) for front in crack.fronts]
    nearest, arc, off = nearest_feet(lines, along.points)
    far, step = int(np.argmax(off)), along.extension.max()
    if off[far] > step:
        raise CraftmeshError(
            f"its front would lie {off[far]:.4g} off, at row {far + 1}; expected less than the "
            f"step of {step:.4g}"
        )
    places = np.empty_like(along.points)
    for number, line in enumerate(lines):
        own = nearest == number
        places[own] = line.at(arc[own])
    return places
