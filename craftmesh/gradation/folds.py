"""Sharp folds of the crack, which bound patches.

A strip, the part of the crack between a fold and another line of the crack, gets edges that are short
relative to its width.
"""

from dataclasses import replace

import numpy as np

from craftmesh.sizing.sizing import PER_WIDTH, Sizing, where_short
from craftmesh.surface.connectivity import edge_sides, joined, unique_edges
from craftmesh.surface.measure import facet_angles
from craftmesh.surface.patches import Patches, feature_edges, patches
from craftmesh.types import CRACK, Surface

# Degrees: smallest angle between the normals of two neighbouring crack facets that makes their edge a fold.
# A normal averaged across a sharper fold would differ from the normals of both sides by the normal
# tolerance, so that no operation could change the facets next to it.
FOLD = 50.0
# Degrees: smallest angle of a facet whose normal is meaningful.
FLATTEST = 1.0
# Fraction of an edge: a facet's apex, the corner opposite the edge, gives a width of the strip if its
# projection onto the edge is at least this far from the edge's ends.
ASIDE = 0.05


def folded_patches(surface: Surface, plain: Patches | None = None) -> Patches:
    """Return the patches of a surface, with crack patches split at folds of over FOLD degrees.

    plain: the patches without these splits; None computes them.

    A fold that ends within a patch does not split it. The part with the patch's first facet keeps the
    patch's number; the other parts get new numbers after all patches, in the order of their first facets.
    """
    plain = patches(surface) if plain is None else plain
    crack = np.flatnonzero(surface.kind == CRACK)
    if not len(crack):
        return plain
    piece = _between_folds(surface, crack, plain.of_facet[crack])
    _, first = np.unique(piece, return_index=True)
    # the first part of each patch keeps the patch's number
    heads = np.isin(crack[first], plain.first_facet)
    number = np.where(heads, plain.of_facet[crack[first]], 0)
    number[~heads] = len(plain.first_facet) + np.arange(int((~heads).sum()))
    of_facet = plain.of_facet.copy()
    of_facet[crack] = number[piece]
    return Patches(of_facet, np.concatenate([plain.first_facet, crack[first[~heads]]]))


def _between_folds(surface: Surface, crack: np.ndarray, patch: np.ndarray) -> np.ndarray:
    """Return the number (k,) of each crack facet's part: connected within a patch without crossing folds.

    crack (k,): rows of the crack facets; patch (k,): their patches. Parts are numbered by first facets.
    """
    facets = surface.facets[crack].astype(np.int64)
    edges, of_corner, count = unique_edges(facets)
    f, g = (side // 3 for side in edge_sides(of_corner, count == 2))
    ends = edges[count == 2]
    across = [_across(surface.points, ends, facets[row].sum(axis=1) - ends.sum(axis=1)) for row in (f, g)]
    cosine = -np.einsum("ij,ij->i", *across)
    flat = facet_angles(surface.points, facets).min(axis=1) < FLATTEST
    smooth = (cosine > np.cos(np.radians(FOLD))) | flat[f] | flat[g]
    together = smooth & (patch[f] == patch[g])
    return joined(len(crack), f[together], g[together])


def _across(points: np.ndarray, edges: np.ndarray, apex: np.ndarray) -> np.ndarray:
    """Return unit vectors (k, 3) in facets, perpendicular to edges (k, 2), towards the apexes (k,)."""
    start = points[edges[:, 0]]
    along, way = points[edges[:, 1]] - start, points[apex] - start
    square = np.maximum(np.einsum("ij,ij->i", along, along), np.finfo(float).tiny)
    way = way - (np.einsum("ij,ij->i", way, along) / square)[:, None] * along
    return way / np.maximum(np.linalg.norm(way, axis=1), np.finfo(float).tiny)[:, None]


def short_beside_folds(surface: Surface, sizing: Sizing) -> Sizing:
    """Return the sizing with shorter lengths in strips between folds and other lines of the crack.

    The target length is PER_WIDTH times the strip's width, at least l_min. Without folds that split a
    patch, the sizing is returned unchanged.
    """
    if not (surface.kind == CRACK).any():
        return sizing
    plain = patches(surface)
    parted = folded_patches(surface, plain)
    if len(parted.first_facet) == len(plain.first_facet):
        return sizing
    at_crack = np.zeros(len(surface.points), bool)
    at_crack[surface.facets[surface.kind == CRACK]] = True
    near = at_crack[surface.facets].sum(axis=1) > 1
    beside = Surface(surface.points, surface.facets[near], surface.sides[near], surface.kind[near])
    edges, of_corner, _, is_line = feature_edges(beside, parted.of_facet[near])
    is_fold = is_line & ~feature_edges(beside, plain.of_facet[near]).is_feature
    is_line &= ~is_fold & at_crack[edges].all(axis=1)
    on_fold, on_line = np.zeros((2, len(surface.points)), bool)
    on_fold[edges[is_fold]], on_line[edges[is_line]] = True, True
    crack = np.flatnonzero(beside.kind == CRACK)
    edge = of_corner[crack].ravel()
    apex = np.roll(beside.facets[crack], -2, axis=1).ravel()
    across = (is_fold[edge] & on_line[apex] & ~on_fold[apex]) | (
        is_line[edge] & on_fold[apex] & ~on_line[apex]
    )
    places, widths = _widths(surface.points, edges[edge[across]], apex[across])
    strips = where_short(places, np.maximum(PER_WIDTH * widths, sizing.l_min), sizing)
    return sizing if strips is None else replace(sizing, others=(*sizing.others, strips))


def _widths(points: np.ndarray, edges: np.ndarray, apex: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, 3) of strips, and the strip's width (n,) at each.

    The points are the apexes (k,) that project onto the inside of their edges (k, 2), and then their
    projections. The width is the distance between an apex and its projection, and is repeated for both.
    """
    start, way = points[edges[:, 0]], np.diff(points[edges], axis=1)[:, 0]
    share = np.einsum("ij,ij->i", points[apex] - start, way) / np.einsum("ij,ij->i", way, way)
    feet = start + share[:, None] * way
    height = np.linalg.norm(points[apex] - feet, axis=1)
    over = (share > ASIDE) & (share < 1 - ASIDE)
    return np.concatenate([points[apex[over]], feet[over]]), np.tile(height[over], 2)
