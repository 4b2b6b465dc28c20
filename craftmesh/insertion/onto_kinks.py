"""Crack facets of a split volume's surface with edges along the kinks of the true crack."""

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from craftmesh.cracks.near_sheet import NearSheet
from craftmesh.insertion.contract import contracted, is_sound, swap_at
from craftmesh.insertion.cut import CutSurface, split_edges
from craftmesh.insertion.guarded_move import forced, settled
from craftmesh.insertion.onto_sheets import carried_along, is_of, places_on_sheets, plain
from craftmesh.insertion.options import InsertOptions
from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.kernels.distances import nearest_on_edges
from craftmesh.surface.patches import held_by_box
from craftmesh.types import CRACK

NEAR = 0.25  # of the local size: points this near a kink move onto it
ON = 1e-6  # of the local size: a point this near a kink is on it
TURN = np.cos(np.radians(7.5))  # between the ends of an edge across a kink, which turns by twice as much
STEPS = 8  # from an edge to the kink and back, towards where they are closest
AT_END = 0.1  # of an edge: where it crosses a kink this near to an end, that goes onto the kink
ROUNDS = 4  # of parting: points that move bring others across
SHARES = (1.0, 0.5, 1.0, 0.5, 1.0)  # of the way that is left, round after round
# Of its length: an edge farther from the kink does not cross it. Even across a fold of 110 degrees, where
# both ends are as far from it, this is 0.71.
APART = 1.0


def onto_kinks(surface: CutSurface, number: int, look: NearSheet, options: InsertOptions) -> CutSurface:
    """Return the surface whose edges of a sheet's facets follow its kinks, as far as it stays sound.

    Points near kinks go onto these, edges across are parted there: a facet across a kink is off the sheet
    however short its edges are. Points of the fronts stay.
    """
    if not len(look.kinks):
        return surface
    rows = np.unique(surface.facets[is_of(surface, number)])
    rows = rows[surface.phi[rows] != 0]
    targets = _on_kinks(surface, rows, look)
    away = np.linalg.norm(targets - surface.points[rows], axis=1)
    near = (away < NEAR * surface.size[rows]) & (away > ON * surface.size[rows])
    surface, _ = settled(surface, rows[near], targets[near], options)
    for _ in range(ROUNDS):
        edges, share = _across(surface, number, look)
        swapped = _swapped(surface, edges, number, look)
        if swapped is not surface:
            surface = swapped
            edges, share = _across(surface, number, look)
        if not len(edges):
            break
        surface = _parted(surface, edges, share, look, options)
    return surface


def _swapped(surface: CutSurface, edges: np.ndarray, number: int, look: NearSheet) -> CutSurface:
    """Return the surface with edges (k, 2) across a kink swapped for those between two points on it."""
    facets, mine = surface.facets.copy(), is_of(surface, number)
    changed = np.zeros(len(facets), bool)
    for a, b in edges.tolist():
        found = swap_at(facets, surface.sides, surface.kind, a, b)
        if found is None or not mine[found[0]].all() or changed[found[0]].any():
            continue
        rows, after = found
        ends = np.setdiff1d(after, [a, b])
        off = nearest_on_edges(surface.points[ends], look.points, look.kinks) - surface.points[ends]
        on_kink = (np.linalg.norm(off, axis=1) <= ON * surface.size[ends]).all()
        if on_kink and is_sound(surface.points, facets, rows, after):
            facets[rows] = after
            changed[rows] = True
    return replace(surface, facets=facets) if changed.any() else surface


def _parted(
    surface: CutSurface, edges: np.ndarray, share: np.ndarray, look: NearSheet, options: InsertOptions
) -> CutSurface:
    """Return the surface with edges (k, 2) parted at shares (k,), or with their ends there, on kinks."""
    at_end = np.abs(share - 0.5) > 0.5 - AT_END
    ends = np.unique(np.where(share < 0.5, *edges.T)[at_end])
    edges, share = edges[~at_end], share[~at_end]
    count = len(surface.points)
    start, end = surface.points[edges[:, 0]], surface.points[edges[:, 1]]
    places = start + share[:, None] * (end - start)
    surface = split_edges(surface, edges, places, surface.size[edges].mean(axis=1))
    rows = np.concatenate([ends[surface.phi[ends] != 0], count + np.arange(len(edges))])
    return _moved(surface, rows, look, options)


def _moved(surface: CutSurface, rows: np.ndarray, look: NearSheet, options: InsertOptions) -> CutSurface:
    """Return the surface with points onto kinks, those of boundaries around along with them.

    Points that cannot get there go onto the sheet, or become one of those beside them.
    """
    targets = _on_kinks(surface, rows, look)
    known = np.isfinite(targets).all(axis=1)
    rows, targets = rows[known], targets[known]
    on_crack = np.unique(surface.facets[surface.kind >= CRACK])
    for share in SHARES:
        steps = np.zeros((len(on_crack), 3))
        steps[np.searchsorted(on_crack, rows)] = share * (targets - surface.points[rows])
        surface = carried_along(surface, on_crack, steps, options)
    surface, left = forced(surface, rows, targets, options)
    on_sheet = places_on_sheets(surface, (look,), left, np.ones((len(left), 1), bool), False)
    surface, left = forced(surface, left, on_sheet, options)
    return contracted(surface, left, np.zeros((len(left), 3)), short=0.0) if len(left) else surface


def _on_kinks(surface: CutSurface, rows: np.ndarray, look: NearSheet) -> np.ndarray:
    """Return the places on kinks (k, 3) nearest to points (k,); within their plane of the box.

    Infinity for points on several planes, and where no kink meets the plane.
    """
    places = surface.points[rows]
    result = nearest_on_edges(places, look.points, look.kinks)
    held = held_by_box(plain(surface))[rows]
    result[held.sum(axis=1) > 1] = np.inf
    start, end = look.points[look.kinks[:, 0]], look.points[look.kinks[:, 1]]
    for axis in range(3):
        mine = np.flatnonzero(held[:, axis] & (held.sum(axis=1) == 1))
        for plane in np.unique(places[mine, axis]).tolist():
            here = mine[places[mine, axis] == plane]
            below, above = start[:, axis] - plane, end[:, axis] - plane
            meets = (below * above <= 0) & (below != above)
            share = below[meets] / (below - above)[meets]
            crossings = start[meets] + share[:, None] * (end - start)[meets]
            result[here] = np.inf
            if len(crossings):
                result[here] = crossings[cKDTree(crossings).query(places[here])[1]]
                result[here, axis] = plane
    return result


def _across(surface: CutSurface, number: int, look: NearSheet) -> tuple[np.ndarray, np.ndarray]:
    """Return the sheet's edges (k, 2) that cross a kink, and the shares of their lengths where (k,)."""
    edges, _, _ = unique_edges(surface.facets[is_of(surface, number)])
    edges = edges[~(surface.phi[edges] == 0).all(axis=1)]
    start, end = surface.points[edges[:, 0]], surface.points[edges[:, 1]]
    normals = look.look(start).normal, look.look(end).normal
    length = np.linalg.norm(end - start, axis=1)
    turned = np.einsum("ij,ij->i", *normals) < TURN
    for one in (start, end):
        off = np.linalg.norm(nearest_on_edges(one, look.points, look.kinks) - one, axis=1)
        turned &= off > ON * surface.size[edges].min(axis=1)
    edges, start, step, length = edges[turned], start[turned], (end - start)[turned], length[turned]
    share = np.full(len(edges), 0.5)
    for _ in range(STEPS):
        place = start + share[:, None] * step
        foot = nearest_on_edges(place, look.points, look.kinks)
        share = np.clip(np.einsum("ij,ij->i", foot - start, step) / length**2, 0, 1)
    crosses = np.linalg.norm(foot - start - share[:, None] * step, axis=1) < APART * length
    return edges[crosses], share[crosses]
