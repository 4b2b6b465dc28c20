"""Crack facets of a split volume's surface clipped at the crack's fronts, and halved where too coarse."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from craftmesh.cracks.near_sheet import NearSheet
from craftmesh.cracks.split_voxels import first_sheet
from craftmesh.insertion.cut import CutSurface, SizeAt, split_edges
from craftmesh.insertion.guarded_move import forced, guarded_move, settled
from craftmesh.insertion.onto_sheets import bits_of, is_of, places_on_sheets, plain
from craftmesh.insertion.options import InsertOptions
from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.front import ears
from craftmesh.surface.patches import held_by_box
from craftmesh.types import CRACK, INTERFACE

SECANTS = 5  # towards where an edge crosses the front
ON = 1e-9  # of the local size: a point this near the front counts as on it
OFF_FRONT = 0.018  # of the target length: front edges farther off the given front are halved
SHARES = np.array([0.25, 0.5, 0.75])  # of an edge, where that is looked at
OFF_SHEET = 0.028  # of the least length: edges of crack facets farther off the given crack are halved
SHORTEST = 0.3  # of the target length: no edge is halved into shorter ones
# Of the local size, and of its length: an edge on another sheet too, this near the sheet's own end and
# with feet there this far apart, is the sheet's end. Where fronts cross the other sheet feet are together.
SEAM, ALONG = 0.8, 0.7
HALVINGS = 5  # rounds of either

PlaceOf = Callable[[CutSurface, np.ndarray], np.ndarray]  # places (k, 3) of a surface's points (k,)


def clipped(surface: CutSurface, number: int, look: NearSheet, options: InsertOptions) -> CutSurface:
    """Return the surface without what of the sheet's facets is past its fronts; phi = 0 on these.

    Facets past the fronts are left out where one grain is on both sides, and are grain boundary elsewhere.
    """
    surface = replace(surface, phi=_phi(surface, number, look))
    _close_seams(surface, number, look)
    surface = _snapped(surface, number, look, options)
    edges, share = _crossings(surface, number, look)
    if len(edges):
        start, end = surface.points[edges[:, 0]], surface.points[edges[:, 1]]
        places = start + share[:, None] * (end - start)
        count = len(surface.points)
        surface = split_edges(surface, edges, places, surface.size[edges].mean(axis=1))
        rows = count + np.arange(len(edges))
        surface.phi[rows] = 0.0
        surface, _ = settled(surface, rows, on_front(surface, rows, look), options)
    mine = np.flatnonzero(is_of(surface, number))
    phi = surface.phi[surface.facets[mine]]
    total = phi.sum(axis=1)
    flat = np.flatnonzero((phi == 0).all(axis=1))
    if len(flat):
        total[flat] = look.look(surface.points[surface.facets[mine[flat]]].mean(axis=1)).phi
    past = mine[total <= 0]
    kind = surface.kind.copy()
    bits = kind[past].astype(np.int64) - CRACK + 1 - (1 << number)
    kind[past] = np.where(bits > 0, CRACK + bits - 1, INTERFACE)
    kept = (surface.sides[:, 0] != surface.sides[:, 1]) | (kind != INTERFACE)
    return replace(surface, facets=surface.facets[kept], sides=surface.sides[kept], kind=kind[kept])


def _phi(surface: CutSurface, number: int, look: NearSheet) -> np.ndarray:
    """Return the distance inside the fronts (n,) of the points of a sheet's facets, NaN elsewhere."""
    phi = np.full(len(surface.points), np.nan)
    rows = np.unique(surface.facets[is_of(surface, number)])
    if len(rows):
        phi[rows] = look.look(surface.points[rows]).phi
        phi[rows[np.abs(phi[rows]) < ON * surface.size[rows]]] = 0.0
    return phi


def _close_seams(surface: CutSurface, number: int, look: NearSheet) -> None:
    """Set phi to 0 where the sheet ends along another one: at edges on both that run along its end."""
    mine = is_of(surface, number)
    edges, of_corner, _ = unique_edges(surface.facets)
    shared = np.zeros((2, len(edges)), bool)
    shared[0, of_corner[mine]] = shared[1, of_corner[(surface.kind >= CRACK) & ~mine]] = True
    ends = edges[shared.all(axis=0)]
    ends = ends[(np.abs(surface.phi[ends]) < SEAM * surface.size[ends]).all(axis=1)]
    if len(ends):
        places = surface.points[ends]
        feet = look.nearest_on_front(places.reshape(-1, 3)).reshape(places.shape)
        way, length = (np.linalg.norm(x[:, 1] - x[:, 0], axis=1) for x in (feet, places))
        surface.phi[ends[way > ALONG * length]] = 0.0


def _crossings(surface: CutSurface, number: int, look: NearSheet) -> tuple[np.ndarray, np.ndarray]:
    """Return the sheet's edges (k, 2) that cross the front between their ends, and where (k,)."""
    edges, _, _ = unique_edges(surface.facets[is_of(surface, number)])
    phi = surface.phi[edges]
    edges = edges[np.sign(phi[:, 0]) * np.sign(phi[:, 1]) < 0]
    if not len(edges):
        return edges, np.zeros(0)
    start, step = surface.points[edges[:, 0]], np.diff(surface.points[edges], axis=1)[:, 0]
    low, high = np.zeros(len(edges)), np.ones(len(edges))
    at_low, at_high = surface.phi[edges].T.copy()
    for _ in range(SECANTS):
        share = low + (high - low) * at_low / (at_low - at_high)
        value = look.look(start + share[:, None] * step).phi
        right = value * at_high > 0
        low, at_low = np.where(right, low, share), np.where(right, 0.5 * at_low, value)
        high, at_high = np.where(right, share, high), np.where(right, value, 0.5 * at_high)
        at_low, at_high = np.where(right | (value == 0), at_low, value), np.where(right, value, at_high)
    return edges, share


def _snapped(surface: CutSurface, number: int, look: NearSheet, options: InsertOptions) -> CutSurface:
    """Return the surface with points near the front moved onto it along edges that cross it."""
    edges, share = _crossings(surface, number, look)
    if not len(edges):
        return surface
    held = _holds(surface, number)
    nearest = share < 0.5
    point = np.where(nearest, edges[:, 0], edges[:, 1])
    other = np.where(nearest, edges[:, 1], edges[:, 0])
    part = np.minimum(share, 1 - share)
    # along an edge in all that holds the point alone: the other end lies on as much
    free = (held[point] & ~held[other]) == 0
    chosen = np.flatnonzero((part < options.snap_front) & free)
    order = chosen[np.lexsort([part[chosen], point[chosen]])]
    order = order[np.r_[True, point[order][1:] != point[order][:-1]]] if len(order) else order
    rows = point[order]
    places = surface.points[rows] + part[order, None] * (
        surface.points[other[order]] - surface.points[rows]
    )
    moved_to = replace(surface, points=surface.points.copy())
    moved_to.points[rows] = places
    targets = on_front(moved_to, rows, look)
    points, moved = guarded_move(surface, rows, targets, options)
    phi = surface.phi.copy()
    phi[moved] = 0.0
    return replace(surface, points=points, phi=phi)


def _holds(surface: CutSurface, number: int) -> np.ndarray:
    """Return bits (n,) of what holds points: box planes, other sheets, grain boundaries by their sides."""
    held = np.zeros(len(surface.points), np.int64)
    sides = surface.sides.astype(np.int64)
    low, high = sides.min(axis=1), sides.max(axis=1)
    name = np.where(surface.kind == INTERFACE, 6 + (high * 7919 + low * 104729) % 56, surface.kind - 1)
    name = np.where(surface.kind >= CRACK, 62, name).astype(np.int64)
    walls = ~is_of(surface, number)
    for k in range(3):
        np.bitwise_or.at(held, surface.facets[walls, k], np.int64(1) << name[walls])
    return held


def on_front(surface: CutSurface, rows: np.ndarray, look: NearSheet) -> np.ndarray:
    """Return the places (k, 3) on the fronts nearest to points `rows`, in the box planes that hold them."""
    box = held_by_box(plain(surface))
    start = surface.points[rows]
    place = look.nearest_on_front(start)
    return np.where(box[rows], start, place)


def halved_fronts(
    surface: CutSurface, look: NearSheet, target: SizeAt, options: InsertOptions
) -> CutSurface:
    """Return the surface with the edges of a sheet's front halved that leave the given front.

    Points near corners of that move onto them first, where halves would be too short.
    """
    surface = _at_corners(surface, look, options)
    for _ in range(HALVINGS):
        edges = _front(surface)
        ends = surface.points[edges]
        middle = ends.mean(axis=1)
        if not len(edges):
            break
        place = look.nearest_on_front(middle)
        length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        place = look.at_corners(place, length / 2)
        wished = target(middle)
        along = ends[:, :1] + SHARES[:, None] * (ends[:, 1:] - ends[:, :1])
        feet = look.nearest_on_front(along.reshape(-1, 3)).reshape(along.shape)
        off = np.linalg.norm(feet - along, axis=2).max(axis=1) > OFF_FRONT * wished
        off &= length > 2 * SHORTEST * wished
        if not off.any():
            break
        surface = _halved(surface, edges[off], _in_planes_of(place[off]), options, 0.0)
    return surface


def _in_planes_of(places: np.ndarray) -> PlaceOf:
    """Return what gives points their places (k, 3), in the planes of the box that hold them."""

    def in_planes(surface: CutSurface, rows: np.ndarray) -> np.ndarray:
        return np.where(held_by_box(plain(surface))[rows], surface.points[rows], places)

    return in_planes


def _on_sheet(look: NearSheet) -> PlaceOf:
    """Return what gives points their places on a sheet, in the planes of the box that hold them."""

    def on_sheet(surface: CutSurface, rows: np.ndarray) -> np.ndarray:
        return places_on_sheets(surface, (look,), rows, np.ones((len(rows), 1), bool), False)

    return on_sheet


def _at_corners(surface: CutSurface, look: NearSheet, options: InsertOptions) -> CutSurface:
    """Return the surface with the front point nearest to each corner of the front on it, if near enough."""
    rows = np.unique(_front(surface))
    if not len(rows) or not len(look.corners):
        return surface
    box = held_by_box(plain(surface))[rows].any(axis=1)
    distance, nearest = cKDTree(surface.points[rows]).query(look.corners)
    near = (distance < options.snap_front * surface.size[rows[nearest]]) & ~box[nearest]
    _, first = np.unique(nearest[near], return_index=True)
    return settled(surface, rows[nearest[near][first]], look.corners[near][first], options)[0]


def _front(surface: CutSurface) -> np.ndarray:
    """Return the edges (k, 2) at which the crack ends on the front of the sheet that phi is of."""
    edges, _, count = unique_edges(surface.facets[surface.kind >= CRACK])
    return edges[(count == 1) & (surface.phi[edges] == 0).all(axis=1)]


def _halved(
    surface: CutSurface, edges: np.ndarray, place_of: PlaceOf, options: InsertOptions, phi: float
) -> CutSurface:
    """Return the surface with edges (k, 2) halved and the middles at their places where that is sound."""
    count = len(surface.points)
    surface = split_edges(
        surface, edges, surface.points[edges].mean(axis=1), surface.size[edges].mean(axis=1)
    )
    rows = count + np.arange(len(edges))
    surface.phi[rows] = phi
    return forced(surface, rows, place_of(surface, rows), options)[0]


def halved_facets(
    surface: CutSurface, number: int, look: NearSheet, least: float, options: InsertOptions
) -> CutSurface:
    """Return the surface with the edges of a sheet's facets halved that leave the given crack, and ears.

    Edges with an end off the crack stay: where that could not be moved, halves would be no nearer.
    """
    for _ in range(HALVINGS):
        facets = surface.facets[first_sheet(bits_of(surface)) == number]
        edges, _, count = unique_edges(facets)
        front = (count == 1) & (surface.phi[edges] == 0).all(axis=1)
        at_front = np.zeros(len(surface.points), bool)
        at_front[edges[front]] = True
        edges = edges[~front]
        ends = surface.points[edges]
        middle, length = ends.mean(axis=1), np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        if not len(edges):
            break
        off = np.abs(look.look(middle).psi) > OFF_SHEET * least
        off &= length > 2 * SHORTEST * least
        off &= np.abs(look.look(ends.reshape(-1, 3)).psi.reshape(-1, 2)).max(axis=1) < OFF_SHEET * least
        stride = np.array([len(surface.points), 1])
        off |= np.isin(edges @ stride, ears(facets, at_front) @ stride)
        if not off.any():
            break
        surface = _halved(surface, edges[off], _on_sheet(look), options, np.nan)
    return surface
