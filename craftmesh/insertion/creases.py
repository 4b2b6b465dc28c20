"""The creases of a given crack, where its triangles meet at an angle: points of the patch go onto them."""

from typing import NamedTuple

import numpy as np
import shapely

from craftmesh.insertion.rim import feet_on_segments
from craftmesh.insertion.sheet import Sheet
from craftmesh.surface.connectivity import edge_sides, unique_edges
from craftmesh.surface.measure import area_vectors

SHARP = np.cos(np.radians(5.0))  # edges at which the crack turns by less are no creases


class Creases(NamedTuple):
    """Creases as segments (k, 2, 2) in (u, v), and a tree of them."""

    segments: np.ndarray
    tree: shapely.STRtree

    def feet(self, uv: np.ndarray) -> np.ndarray:
        """Return the nearest places (n, 2) on a crease; far away where there is none."""
        if not len(self.segments) or not len(uv):
            return np.full(uv.shape, np.inf)
        return feet_on_segments(self.segments, self.tree, uv)[1]


def creases_of(sheet: Sheet) -> Creases:
    """Return the edges at which the triangles of a sheet turn by more than SHARP."""
    points = np.column_stack([sheet.nodes, sheet.height])
    normal = area_vectors(points, sheet.triangles)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    edges, of_corner, count = unique_edges(sheet.triangles)
    f, g = edge_sides(of_corner, count == 2)
    turned = np.einsum("ij,ij->i", normal[f // 3], normal[g // 3]) < SHARP
    segments = sheet.nodes[edges[count == 2][turned]]
    return Creases(segments, shapely.STRtree(shapely.linestrings(segments)))
