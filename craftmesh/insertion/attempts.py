"""Repeat the insertion of a crack until one attempt is sound; measure its deviation and what it moved."""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import scipy

from craftmesh.cracks.crack_tolerances import AREA_KEPT, INSERTION, PROMISED
from craftmesh.cracks.near_sheet import NearSheet
from craftmesh.cracks.within_box import area_off, area_within, segments_of
from craftmesh.errors import CraftmeshError, rounded_values
from craftmesh.insertion.cut import SHORTEST, CutSurface, on_border, split_edges
from craftmesh.insertion.options import InsertOptions
from craftmesh.insertion.sheet import Sheet
from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.front import front_edges, front_of
from craftmesh.surface.kernels.distances import nearest_on_edges
from craftmesh.surface.kernels.triangle_pairs import intersecting_pairs
from craftmesh.surface.measure import meets_box, nearest_facet, span_of, total_area
from craftmesh.surface.patches import is_on_box
from craftmesh.surface.rounding import SAME_PLACE
from craftmesh.types import CRACK, Crack, Surface


class Inserted(NamedTuple):
    """A surface with a crack in it, and the report's numbers.

    own (m,): mask of this crack's facets; hidden: area of the crack's parts that lie in voids, on void
    facets or in another crack.
    """

    surface: Surface
    own: np.ndarray
    hidden: float
    numbers: dict[str, int | float]


class Misfit(NamedTuple):
    """Places (k, 3) where an inserted crack is farther from the given one than insertion allows.

    times, promised: largest deviation of places, front and area, as a multiple of what the tolerances
    INSERTION and PROMISED (`cracks/crack_tolerances`) allow; both are inf if crack facets intersect others.
    """

    places: np.ndarray
    times: float
    promised: float


class Given:
    """The given crack in a box (2, 3), with which inserted cracks are compared.

    least: smallest target length, the unit of allowed deviations; held (k, 3): points of its fronts at
    which an inserted front must have a node, None if there are none. look finds the closest points of the
    given crack; area is the given crack's area in the box.
    """

    def __init__(self, crack: Crack, box: np.ndarray, least: float, held: np.ndarray | None = None) -> None:
        self.crack, self.box, self.least, self.held = crack, box, least, held
        self.look = NearSheet(crack, box)
        self.area = area_within(crack, box)

    def misfit(self, inserted: Inserted) -> Misfit:
        """Return the places where an inserted crack deviates too far from the given one, and how far.

        If only its area deviates, which is compared only if the body fills its box, the places are centres
        of given triangles that no inserted facet is near, or else midpoints of the inserted crack's
        boundary edges.
        """
        surface, own = inserted.surface, inserted.surface.facets[inserted.own].astype(np.int64)
        points = surface.points
        edges, _, count = unique_edges(own)
        middles = points[edges].mean(axis=1)
        places = np.concatenate([points[np.unique(own)], middles, points[own].mean(axis=1)])
        off = np.linalg.norm(self.look.look(places).foot - places, axis=1)
        ends = (surface.sides <= 0).any(axis=1) | ((surface.kind == CRACK) & ~inserted.own)
        free = surface.facets[ends]
        front = front_of(own, free.astype(np.int64))
        nodes = points[np.unique(front)]
        off_front = self._off_front(nodes)
        times, promised = (
            np.concatenate([off / share.facets, off_front / share.front]) / self.least
            for share in (INSERTION, PROMISED)
        )
        bad, most = np.concatenate([places, nodes])[times > 1], float(times.max(initial=0.0))
        farthest = float(promised.max(initial=0.0))
        if fills_box(surface):
            area = inserted.hidden + total_area(points, own)
            segments = segments_of(points[front], self._off_front(points[front].mean(axis=1)))
            by = area_off(area, self.area, segments, self.least)
            if by > 1 and not len(bad):
                lacking = self._lacking(points, own)
                bad = lacking if len(lacking) else middles[count == 1]
            most, farthest = max(most, by), max(farthest, by * AREA_KEPT)
        return Misfit(bad, most, farthest)

    def _lacking(self, points: np.ndarray, facets: np.ndarray) -> np.ndarray:
        """Return centres (k, 3) of given triangles in the box that are farther than allowed from facets."""
        centres = self.crack.points[self.crack.triangles].mean(axis=1)
        centres = centres[((centres > self.box[0]) & (centres < self.box[1])).all(axis=1)]
        return centres[nearest_facet(centres, points, facets)[1] > INSERTION.facets * self.least]

    def _off_front(self, places: np.ndarray) -> np.ndarray:
        return np.linalg.norm(self.look.nearest_on_front(places) - places, axis=1)


class Fronts(NamedTuple):
    """The given fronts, of a new crack and of earlier ones: edges (k, 2) between points (n, 3)."""

    points: np.ndarray
    edges: np.ndarray


def fronts_of(surface: Surface, crack: Crack) -> Fronts:
    """Return the fronts of a crack and of the cracks that are already in the surface."""
    there = front_edges(surface) + len(crack.points)
    points = np.concatenate([crack.points, surface.points])
    return Fronts(points, np.concatenate([crack.front_edges, there]))


def misfit_of_fronts(surface: Surface, fronts: Fronts, least: float) -> Misfit:
    """Return the misfit of a surface's front nodes to the given fronts; least: smallest target length.

    The misfit has the nodes that are too far off and the largest distance, relative to the tolerances.
    """
    nodes = surface.points[np.unique(front_edges(surface))]
    if not len(nodes):
        return Misfit(nodes, 0.0, 0.0)
    off = np.full(len(nodes), np.inf)
    if len(fronts.edges):
        off = np.linalg.norm(nearest_on_edges(nodes, fronts.points, fronts.edges) - nodes, axis=1)
    times, promised = (off / (share.front * least) for share in (INSERTION, PROMISED))
    return Misfit(nodes[times > 1], float(times.max()), float(promised.max()))


def fills_box(surface: Surface) -> bool:
    """Return True if the body is bounded only by the planes of its box and by voids."""
    ends = (surface.sides == 0).any(axis=1)
    return bool(is_on_box(surface.kind[ends]).all())


def moved(before: CutSurface, after: Surface, sheet: Sheet, least: float) -> dict[str, int | float]:
    """Return numbers for the report: boundary points, facets and crack facets moved, and how far at most.

    Distances are in model units. Boundary points that moved within the given boundary are not counted.
    least: smallest target length.
    """
    on_crack = after.kind == CRACK
    shared = on_crack & (after.sides[:, 0] != after.sides[:, 1]) & ~_among(before, after, least)
    boundary = after.facets[~on_crack | shared]
    rows = np.unique(boundary)
    given = {tuple(row) for row in before.points.tolist()}
    rows = rows[[tuple(row) not in given for row in after.points[rows].tolist()]]
    near = before.facets[np.isfinite(before.psi[before.facets]).any(axis=1)]
    off = np.zeros(len(after.points))
    if len(rows):
        off[rows] = nearest_facet(after.points[rows], before.points, near)[1]
    is_moved = off > SAME_PLACE * least
    corners = after.points[after.facets[shared]]
    middles = (corners + np.roll(corners, 1, axis=1)) / 2
    places = np.concatenate([corners.mean(axis=1), middles.reshape(-1, 3)])
    height = np.abs(sheet.offset(places)) / np.linalg.norm(sheet.gradient(places), axis=1)
    return {
        "boundary_points_moved": int(is_moved.sum()),
        "boundary_facets_moved": int(is_moved[boundary].any(axis=1).sum()),
        "boundary_moved_most": float(off.max(initial=0.0)),
        "crack_facets_on_grain_boundaries": int(shared.sum()),
        "crack_moved_most": float(height.max(initial=0.0)),
    }


def unmoved(facets: int) -> dict[str, int | float]:
    """Return the numbers of `moved` for a crack that consists of `facets` unmoved grain boundary facets."""
    return {
        "boundary_points_moved": 0,
        "boundary_facets_moved": 0,
        "boundary_moved_most": 0.0,
        "crack_facets_on_grain_boundaries": facets,
        "crack_moved_most": 0.0,
    }


def _among(before: CutSurface, after: Surface, least: float) -> np.ndarray:
    """Return a mask (m,) of facets of `after` whose centres lie on crack facets of `before`."""
    known = before.facets[before.kind == CRACK]
    if not len(known):
        return np.zeros(len(after.facets), bool)
    centres = after.points[after.facets].mean(axis=1)
    return nearest_facet(centres, before.points, known)[1] <= SAME_PLACE * least


def split_near(surface: CutSurface, sheet: Sheet, places: np.ndarray, least: float) -> CutSurface:
    """Split edges of facets near places (k, 3), unless an edge is too short; no point moves.

    With smaller facets there, the next cut follows a curved crack more closely. least: smallest target
    length; edges up to 2 SHORTEST times as long stay whole.
    """

    corners = surface.points[surface.facets]
    centre = corners.mean(axis=1)
    reach = np.linalg.norm(corners - centre[:, None], axis=2).max(axis=1)
    rows = np.flatnonzero(scipy.spatial.cKDTree(places).query(centre)[0] < reach + SHORTEST * least)
    edges, _, _ = unique_edges(surface.facets[rows])
    step = np.diff(surface.points[edges], axis=1)[:, 0]
    edges = edges[(np.linalg.norm(step, axis=1) > 2 * SHORTEST * least) & ~on_border(surface, edges)]
    middle = surface.points[edges].mean(axis=1)
    size = surface.size[edges].mean(axis=1) / 2
    result = split_edges(surface, edges, middle, size)
    result.psi[len(surface.points) :] = sheet.offset(middle)
    return result


# Most attempts. Each has smaller facets where the last one deviated too far. If they cannot get smaller, or
# the insertion failed, options.snap and snap_front are halved. Rough cracks along a boundary need eleven.
ATTEMPTS = 12
# Largest deviation from the given crack, as a multiple of the promised one; beyond it a part of the crack
# is lost, which is an error.
GROSS = 10.0


class Attempt(NamedTuple):
    """An attempt at inserting a crack: the surface made, the cut surface before, and the misfit `off`."""

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
    """Return the first sound attempt at inserting a crack, or else the one that deviates least.

    An attempt is sound if no crack facet intersects another facet and the inserted crack's places and area
    deviate from the given crack by no more than INSERTION allows. The deviation compared is
    Misfit.promised. insert: makes one attempt on a surface. Raise CraftmeshError if every one of ATTEMPTS
    attempts fails, or if in the best one facets intersect or deviate by more than GROSS times what PROMISED
    allows.
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
    """Raise CraftmeshError if a crack deviates by more than GROSS times what PROMISED allows."""
    if off.promised > GROSS:
        raise CraftmeshError(
            f"the crack cannot be inserted as it is given: near {rounded_values(off.places[0])} the mesh "
            f"would "
            f"deviate by {off.promised:.0f} times the allowed distance; move the crack a little, or give a "
            "shorter l_min"
        )


def _judged(made: Inserted, cut: CutSurface, given: Given) -> Attempt:
    """Return the attempt with its misfit, which is inf if crack facets intersect others."""
    pairs = crack_intersections(made.surface)
    if len(pairs):
        places = made.surface.points[made.surface.facets[pairs]].mean(axis=(1, 2))
        return Attempt(made, cut, Misfit(places, np.inf, np.inf))
    return Attempt(made, cut, given.misfit(made))


def refuse_intersections(surface: Surface) -> None:
    """Raise CraftmeshError if crack facets intersect facets other than in shared corners and edges."""
    pairs = crack_intersections(surface)
    if len(pairs):
        place = rounded_values(surface.points[surface.facets[pairs[0]]].mean(axis=(0, 1)))
        raise CraftmeshError(
            f"the crack's facets intersect others near {place} ({len(pairs)} pairs): the crack runs along "
            "the box or a grain boundary there; move it a little, turn it or give a shorter l_min"
        )


def crack_intersections(surface: Surface) -> np.ndarray:
    """Return pairs (k, 2) of facets that intersect other than in shared corners and edges.

    At least one of each pair is a crack facet.
    """
    crack = surface.kind == CRACK
    corners = surface.points[surface.facets]
    rows = np.flatnonzero(meets_box(corners, span_of(corners[crack])))
    pairs = rows[intersecting_pairs(surface.points, surface.facets[rows])]
    return pairs[crack[pairs].any(axis=1)]
