"""The last strip of a grown crack laid again, by the kinks and the rates found at its end."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from craftmesh.cracks.polyline import polyline
from craftmesh.cracks.sheets import sheets
from craftmesh.errors import CraftmeshError
from craftmesh.growth.grow import grow, nearest_feet
from craftmesh.growth.moves import FrontExtensions
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


class Step(NamedTuple):
    """A crack and where the points of its fronts go: what a strip is laid from.

    rate (n,): what their extensions go with, da/dN over its median; power: d ln(rate) / d ln(K). Without
    them all points go equally far.
    """

    crack: Crack
    along: FrontExtensions
    rate: np.ndarray | None = None
    power: float = 0.0


def corrected(last: Step, reached: Step, box: np.ndarray, options: SmoothingOptions) -> Step:
    """Return the step `reached` by `last` from where it had begun if that one were a path's chord.

    The strip of `last` is laid again in the box (2, 3), turned at each point by SHARE of the kink found
    where that point came to, and as long as the rate there says. The points of the new front lie beside
    those of `reached` and kink by LEFT of what those do. Raises CraftmeshError as grow does, and where the
    crack has other sheets or fronts then, or a front farther off than it goes.
    """
    before, after = last.along, reached.along
    ends = before.points + before.moves
    kink, extension = before.kink_angle + SHARE * _found_at(after, ends, after.kink_angle), before.extension
    if last.rate is not None and reached.rate is not None:
        lines = [polyline(last.crack.points[front]) for front in last.crack.fronts]
        fronts = rows_along(lines, before.points, before.binormal)
        rate = _found_at(after, ends, reached.rate)
        extension = over_step_again(last.rate, extension, rate, last.power, fronts)
    laid = replace(before, kink_angle=kink, extension=extension)
    crack = grow(last.crack, laid, box, options)
    parts = [len(sheets(each)) for each in (crack, reached.crack) if each is not None]
    if crack is None or parts[0] != parts[1] or len(crack.fronts) != len(reached.crack.fronts):
        raise CraftmeshError("its sheets and fronts would be others; expected those of the crack as it is")
    along = _turned(after, _found_at(after, after.points, after.kink_angle))
    return reached._replace(crack=crack, along=replace(along, points=_onto_fronts(crack, along)))


def _found_at(along: FrontExtensions, places: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the values (n,) of trusted rows, of all where none is, next to places (k, 3): (k,)."""
    rows = or_all(along.trusted, np.ones(len(values), bool))
    points, values = along.points[rows], values[rows]
    off, row = cKDTree(points).query(places, range(1, min(NEAREST, len(points)) + 1))
    weight = 1 / np.maximum(off, np.finfo(float).tiny ** 0.5)
    return (weight * values[row]).sum(axis=1) / weight.sum(axis=1)


def _turned(along: FrontExtensions, kink: np.ndarray) -> FrontExtensions:
    """Return rows whose frames are turned by SHARE of kinks (n,), of which LEFT is left."""
    sine, cosine = np.sin(SHARE * kink)[:, None], np.cos(SHARE * kink)[:, None]
    return replace(
        along,
        normal=cosine * along.normal - sine * along.binormal,
        binormal=cosine * along.binormal + sine * along.normal,
        kink_angle=LEFT * kink,
    )


def _onto_fronts(crack: Crack, along: FrontExtensions) -> np.ndarray:
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
