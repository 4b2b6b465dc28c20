"""Attempts at a crack, with smaller facets or other choices where one is unsound, until one is sound."""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from craftmesh.errors import CraftmeshError, told
from craftmesh.insertion.cut import SHORTEST, CutSurface, split_edges
from craftmesh.insertion.misfit import Given, Inserted, Misfit
from craftmesh.insertion.options import InsertOptions
from craftmesh.insertion.sheet import Sheet
from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.kernels.triangle_pairs import intersecting_pairs
from craftmesh.surface.measure import meets_box, span_of
from craftmesh.types import CRACK, Surface


def split_near(surface: CutSurface, sheet: Sheet, places: np.ndarray, least: float) -> CutSurface:
    """Split the edges of facets near places (k, 3) that are not too short; no point moves.

    Smaller facets tell better on which side of a curved crack they are. least: the least target length.
    """
    corners = surface.points[surface.facets]
    centre = corners.mean(axis=1)
    reach = np.linalg.norm(corners - centre[:, None], axis=2).max(axis=1)
    rows = np.flatnonzero(cKDTree(places).query(centre)[0] < reach + SHORTEST * least)
    edges, _, _ = unique_edges(surface.facets[rows])
    step = np.diff(surface.points[edges], axis=1)[:, 0]
    edges = edges[np.linalg.norm(step, axis=1) > 2 * SHORTEST * least]
    middle = surface.points[edges].mean(axis=1)
    size = surface.size[edges].mean(axis=1) / 2
    result = split_edges(surface, edges, middle, size)
    result.psi[len(surface.points) :] = sheet.offset(middle)
    return result


# Each later one has smaller facets where the one before is unsound; where they are as small as they get, or
# no crack came in, it has half of snap and snap_front. Wavy cracks along a boundary need six.
ATTEMPTS = 8
# Times farther off the given crack than is promised, from which one is refused: a part of it is lost.
GROSS = 10.0


class Attempt(NamedTuple):
    """What an attempt made, of which surface, and how it is off the given crack."""

    made: Inserted
    cut: CutSurface
    off: Misfit


def soundest(
    cut: CutSurface,
    sheet: Sheet,
    given: Given,
    options: InsertOptions,
    insert: Callable[[CutSurface, InsertOptions], Inserted],
) -> Attempt:
    """Return the first sound attempt at inserting a crack, or else the one that is least off.

    Raises CraftmeshError where none ends in a crack, and where facets meet others or lie far off the given
    crack in every one.
    """
    best, refusal = None, CraftmeshError("")
    for _ in range(ATTEMPTS):
        try:
            attempt = _judged(insert(cut, options), cut, given)
        except CraftmeshError as error:
            refusal = error
        else:
            best = attempt if best is None else min(best, attempt, key=lambda one: one.off.promised)
            if best.off.times <= 1:
                return best
            finer = split_near(cut, sheet, attempt.off.places, given.least)
            if len(finer.points) > len(cut.points):
                cut = finer
                continue
        options = replace(options, snap=options.snap / 2, snap_front=options.snap_front / 2)
    if best is None:
        raise refusal
    if np.isinf(best.off.times):
        refuse_intersections(best.made.surface)
    refuse_gross(best.off)
    return best


def refuse_gross(off: Misfit) -> None:
    """Raise where a crack is off by GROSS times what is promised."""
    if off.promised > GROSS:
        raise CraftmeshError(
            f"the crack cannot be inserted as it is given: near {told(off.places[0])} what is in the mesh "
            f"would be {off.promised:.0f} times farther off it than it may be; move the crack a little, or "
            "give a shorter l_min"
        )


def _judged(made: Inserted, cut: CutSurface, given: Given) -> Attempt:
    """Return the attempt, infinitely off where facets meet others."""
    pairs = crack_intersections(made.surface)
    if len(pairs):
        places = made.surface.points[made.surface.facets[pairs]].mean(axis=(1, 2))
        return Attempt(made, cut, Misfit(places, np.inf, np.inf))
    return Attempt(made, cut, given.misfit(made))


def refuse_intersections(surface: Surface) -> None:
    """Raise where crack facets meet facets beyond the corners and edges they share."""
    pairs = crack_intersections(surface)
    if len(pairs):
        place = told(surface.points[surface.facets[pairs[0]]].mean(axis=(0, 1)))
        raise CraftmeshError(
            f"the crack's facets meet others near {place} ({len(pairs)} pairs): it runs along the box "
            "or a grain boundary there; move it a little, turn it or give a shorter l_min"
        )


def crack_intersections(surface: Surface) -> np.ndarray:
    """Return the pairs (k, 2) of facets, one of the crack or both, that meet beyond what they share."""
    crack = surface.kind == CRACK
    corners = surface.points[surface.facets]
    rows = np.flatnonzero(meets_box(corners, span_of(corners[crack])))
    pairs = rows[intersecting_pairs(surface.points, surface.facets[rows])]
    return pairs[crack[pairs].any(axis=1)]
