"""Crossings of a curved crack that an edge's ends do not tell, and trace edges that leave the crack."""

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from craftmesh.insertion.cut import CutSurface, split_edges
from craftmesh.insertion.guarded_move import guarded_move
from craftmesh.insertion.options import InsertOptions
from craftmesh.insertion.pierce import crossing_at
from craftmesh.insertion.sheet import Sheet
from craftmesh.surface.connectivity import edge_sides, unique_edges
from craftmesh.surface.measure import area_vectors
from craftmesh.surface.patches import is_on_box, patches
from craftmesh.types import Surface

SAMPLES = np.arange(1, 8) / 8  # of an edge's length, where its offset from a curved crack is looked at
BULGE = 0.5  # of an edge's length: a crack farther from both ends is not looked for between them
DEEP = 0.01  # of the least length: a crack that comes less far through an edge stays hidden
OFF = 0.03  # of the least length: trace edges farther off the crack are split
SMALL = (
    0.15  # of the least length: edges near a place where facets met are split, but not shorter than this
)
SHORTEST = 0.35  # of the least length: no trace edge is split into shorter ones
FARTHEST = 0.3  # of an edge's length: its middle moves onto the crack by at most this much
SHORTEST_FLAT = 0.6  # of the least length: the same for edges of facets that lie in the crack
ROUNDS = 6  # of halving trace edges, and as many of giving up those whose middle cannot move
CONTACT = 0.1  # of the least length: nearer than this, a boundary along the crack is moved onto it
GRAZING = 0.25  # of the way within the boundary: where the crack is nearer than this, the two graze


def split_hidden(surface: CutSurface, sheet: Sheet, least: float) -> CutSurface:
    """Split edges that the crack bulges through between ends on one side, where it comes farthest.

    So are edges of facets with all their corners on the crack where they leave it, for a facet that lies in
    the crack becomes part of it. The new points keep their places and get their psi. least: the least
    target length.
    """
    near = np.flatnonzero(np.isfinite(surface.psi[surface.facets]).all(axis=1))
    edges, of_corner, _ = unique_edges(surface.facets[near])
    psi = surface.psi[edges]
    start, step = surface.points[edges[:, 0]], np.diff(surface.points[edges], axis=1)[:, 0]
    length = np.linalg.norm(step, axis=1)
    close = np.abs(psi).min(axis=1) < BULGE * length
    flat = np.zeros(len(edges), bool)
    flat[of_corner[(surface.psi[surface.facets[near]] == 0).all(axis=1)]] = True
    flat &= length > SHORTEST_FLAT * least
    chosen = np.flatnonzero((close & (psi[:, 0] * psi[:, 1] >= 0) & (psi != 0).any(axis=1)) | flat)
    if not len(chosen):
        return surface
    places = start[chosen, None] + SAMPLES[None, :, None] * step[chosen, None]
    side = np.sign(psi[chosen].sum(axis=1))
    depth = -sheet.offset(places.reshape(-1, 3)).reshape(places.shape[:2])
    depth = np.where(side[:, None] == 0, np.abs(depth), side[:, None] * depth)
    deepest = depth.argmax(axis=1)
    row = np.arange(len(chosen))
    through = depth[row, deepest] > np.where(side == 0, OFF, DEEP) * least
    through &= sheet.rim.inside(sheet.uv(places[row, deepest])) > -surface.size[edges[chosen, 0]]
    new, fraction = places[row, deepest][through], SAMPLES[deepest][through]
    edges = edges[chosen[through]]
    if not len(edges):
        return surface
    size = surface.size[edges]
    size = size[:, 0] + fraction * (size[:, 1] - size[:, 0])
    return _with_offsets(split_edges(surface, edges, new, size), sheet, len(surface.points))


def split_near(surface: CutSurface, sheet: Sheet, places: np.ndarray, least: float) -> CutSurface:
    """Split the edges of facets near places (k, 3) that are not too short; no point moves.

    Smaller facets tell better on which side of a curved crack they are. least: the least target length.
    """
    corners = surface.points[surface.facets]
    centre = corners.mean(axis=1)
    reach = np.linalg.norm(corners - centre[:, None], axis=2).max(axis=1)
    rows = np.flatnonzero(cKDTree(places).query(centre)[0] < reach + SMALL * least)
    edges, _, _ = unique_edges(surface.facets[rows])
    step = np.diff(surface.points[edges], axis=1)[:, 0]
    edges = edges[np.linalg.norm(step, axis=1) > 2 * SMALL * least]
    middle = surface.points[edges].mean(axis=1)
    size = surface.size[edges].mean(axis=1) / 2
    return _with_offsets(split_edges(surface, edges, middle, size), sheet, len(surface.points))


def _with_offsets(surface: CutSurface, sheet: Sheet, first: int) -> CutSurface:
    """Return the surface with psi of the points from `first` on, which need not be on the crack."""
    psi = surface.psi.copy()
    psi[first:] = sheet.offset(surface.points[first:])
    return replace(surface, psi=psi)


def follow_traces(surface: CutSurface, sheet: Sheet, least: float, options: InsertOptions) -> CutSurface:
    """Split the trace edges that are too far off the crack, their middles moved onto it in their boundary.

    A middle that cannot be moved soundly is not made. least: the least target length.
    """
    refused = np.zeros((0, 2), np.int64)
    for _ in range(2 * ROUNDS):
        edges, targets = _too_far_off(surface, sheet, least)
        stride = len(surface.points) + 1
        known = np.isin(edges @ np.array([stride, 1]), refused @ np.array([stride, 1]))
        edges, targets = edges[~known], targets[~known]
        if not len(edges):
            break
        middle = surface.points[edges].mean(axis=1)
        split = split_edges(surface, edges, middle, surface.size[edges].mean(axis=1))
        rows = len(surface.points) + np.arange(len(edges))
        points, moved = guarded_move(split, rows, targets, options)
        split = replace(split, points=points)
        stuck = ~np.isin(rows, moved)
        stuck[np.isin(rows, crossing_at(split, sheet, rows[0]))] = True
        if stuck.any():
            refused = np.concatenate([refused, edges[stuck]])
            continue
        surface = split
    return surface


def _too_far_off(surface: CutSurface, sheet: Sheet, least: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the trace edges (k, 2) to be split, and places (k, 3) on the crack near their middles."""
    edges, normals, held = edges_in_walls(surface)
    start, step = surface.points[edges[:, 0]], np.diff(surface.points[edges], axis=1)[:, 0]
    length = np.linalg.norm(step, axis=1)
    long = np.flatnonzero(length > 2 * SHORTEST * least)
    edges, normals, start, step, length = (x[long] for x in (edges, normals, start, step, length))
    held = held[long]
    if not len(edges):
        return edges, np.zeros((0, 3))
    places = (start[:, None] + SAMPLES[None, :, None] * step[:, None]).reshape(-1, 3)
    off = np.abs(sheet.offset(places)) / np.linalg.norm(sheet.gradient(places), axis=1)
    far = np.flatnonzero(off.reshape(-1, len(SAMPLES)).max(axis=1) > OFF * least)
    across = np.cross(normals[far], step[far])
    across *= FARTHEST * length[far, None] / np.linalg.norm(across, axis=1)[:, None]
    middle = start[far] + step[far] / 2
    targets = sheet.nearest_crossing(middle, across)
    ahead = sheet.gradient(middle)
    ahead *= CONTACT * least / np.linalg.norm(ahead, axis=1)[:, None]
    straight = sheet.nearest_crossing(middle, ahead)
    way, shorter = (np.linalg.norm(place - middle, axis=1) for place in (targets, straight))
    with np.errstate(invalid="ignore"):
        grazing = ~held[far] & np.isfinite(shorter) & ~(GRAZING * way < shorter)
    targets[grazing] = straight[grazing]
    found = np.isfinite(targets).all(axis=1)
    return edges[far[found]], targets[found]


def edges_in_walls(surface: CutSurface) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the trace edges (k, 2) inside one boundary or box plane, with an end inside the front.

    And the boundary's normal (k, 3) there, and whether it is a box plane (k,).
    """
    on = surface.psi == 0
    rows = np.flatnonzero(on[surface.facets].sum(axis=1) >= 2)
    near = Surface(surface.points, surface.facets[rows], surface.sides[rows], surface.kind[rows])
    edges, of_corner, count = unique_edges(near.facets)
    patch = patches(near).of_facet
    first, second = (side // 3 for side in edge_sides(of_corner, count == 2))
    edges = edges[count == 2]
    normal = area_vectors(near.points, near.facets)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    cosine = np.einsum("ij,ij->i", normal[first], normal[second])
    with np.errstate(invalid="ignore"):
        phi = surface.phi[edges]
        inside = (phi > 0).any(axis=1) | (phi >= 0).all(axis=1)
    chosen = (patch[first] == patch[second]) & on[edges].all(axis=1) & inside
    normal = normal[first] + np.sign(cosine)[:, None] * normal[second]
    return edges[chosen], normal[chosen], is_on_box(near.kind[first])[chosen]
