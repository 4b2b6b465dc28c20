"""Crossings of a curved crack that an edge's ends do not tell: such edges are split."""

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from craftmesh.insertion.cut import CutSurface, split_edges
from craftmesh.insertion.sheet import Sheet
from craftmesh.insertion.traces import OFF, SAMPLES
from craftmesh.surface.connectivity import unique_edges

BULGE = 0.5  # of an edge's length: a crack farther from both ends is not looked for between them
DEEP = 0.01  # of the least length: a crack that comes less far through an edge stays hidden
SMALL = (
    0.15  # of the least length: edges near a place where facets met are split, but not shorter than this
)
SHORTEST_FLAT = (
    0.6  # of the least length: edges of facets that lie in the crack are not split into halves of less
)


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
