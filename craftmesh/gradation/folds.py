"""Sharp folds of the crack bound patches: their lines stay, as those between grains do."""

import numpy as np

from craftmesh.surface.connectivity import edge_sides, joined, unique_edges
from craftmesh.surface.measure import facet_angles
from craftmesh.surface.patches import Patches, patches
from craftmesh.types import CRACK, Surface

# Degrees by which the crack turns at a fold that bounds patches, as its sheets are parted along such
# kinks. Normals averaged across a fold of 80 are the normal tolerance off both its sides, so that next to
# it nothing could be changed.
FOLD = 30.0
# Degrees: the normal of a flatter facet says nothing.
FLATTEST = 1.0


def folded_patches(surface: Surface) -> Patches:
    """Return the patches of a surface, those of the crack parted where it is folded by over FOLD degrees.

    A fold that ends within a patch parts nothing. Of each patch the first part keeps its number; the others
    come after all patches, in the order of their first facets.
    """
    plain = patches(surface)
    crack = np.flatnonzero(surface.kind == CRACK)
    if not len(crack):
        return plain
    piece = _between_folds(surface, crack, plain.of_facet[crack])
    _, first = np.unique(piece, return_index=True)
    # of each patch the piece that comes first keeps its number
    heads = np.isin(crack[first], plain.first_facet)
    number = np.where(heads, plain.of_facet[crack[first]], 0)
    number[~heads] = len(plain.first_facet) + np.arange(int((~heads).sum()))
    of_facet = plain.of_facet.copy()
    of_facet[crack] = number[piece]
    return Patches(of_facet, np.concatenate([plain.first_facet, crack[first[~heads]]]))


def _between_folds(surface: Surface, crack: np.ndarray, patch: np.ndarray) -> np.ndarray:
    """Return each crack facet's piece (k,), by first ones: what hangs together in a patch without folds."""
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
    """Return unit vectors (k, 3) in facets, square to their edges (k, 2), towards their apexes (k,)."""
    start = points[edges[:, 0]]
    along, way = points[edges[:, 1]] - start, points[apex] - start
    square = np.maximum(np.einsum("ij,ij->i", along, along), np.finfo(float).tiny)
    way = way - (np.einsum("ij,ij->i", way, along) / square)[:, None] * along
    return way / np.maximum(np.linalg.norm(way, axis=1), np.finfo(float).tiny)[:, None]
