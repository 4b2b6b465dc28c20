"""The creases of a given crack, where its triangles meet at an angle: points of the patch go onto them."""

from typing import NamedTuple

import numpy as np
import shapely

from craftmesh.insertion.rim import feet_on_segments
from craftmesh.insertion.sheet import Sheet
from craftmesh.surface.connectivity import beside_edges, edge_sides, unique_edges
from craftmesh.surface.measure import area_vectors

SHARP = np.radians(2.5)  # edges at which the crack turns by less are no creases
ALONE = 3.0  # a kink turns by this many times what the edges beside it do; chosen by hand


class Creases(NamedTuple):
    """Creases as segments (k, 2, 2) in (u, v), their ends (k, 2, 3) on the crack, and a tree of them."""

    segments: np.ndarray
    ends: np.ndarray
    tree: shapely.STRtree

    def near(self, uv: np.ndarray, reach: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return rows of places (n, 2) and of creases nearer than reach (n,), one pair after another."""
        place, crease = self.tree.query(shapely.points(uv), "dwithin", reach)
        return place, crease

    def feet(self, uv: np.ndarray) -> np.ndarray:
        """Return the nearest places (n, 2) on a crease; far away where there is none."""
        if not len(self.segments) or not len(uv):
            return np.full(uv.shape, np.inf)
        return feet_on_segments(self.segments, self.tree, uv)[1]

    def distance(self, uv: np.ndarray) -> np.ndarray:
        """Return how far places (n, 2) are from the nearest crease, infinitely where there is none."""
        away: np.ndarray = np.linalg.norm(self.feet(uv) - uv, axis=1)
        return away


def creases_of(sheet: Sheet, apart: float | None = None, turn_by: float = SHARP) -> Creases:
    """Return the edges at which the triangles of a sheet turn by more than `turn_by` radians.

    apart: only kinks, at which they turn ALONE times as much as at the edges beside, and edges whose
    triangles are at least this high over them; the fine triangles of a curved crack turn everywhere.
    """
    points = np.column_stack([sheet.nodes, sheet.height])
    vectors = area_vectors(points, sheet.triangles)
    size = np.maximum(np.linalg.norm(vectors, axis=1), 1e-300)
    edges, of_corner, count = unique_edges(sheet.triangles)
    inner = np.flatnonzero(count == 2)
    f, g = edge_sides(of_corner, count == 2)
    turn = np.zeros(len(edges))
    cosine = np.einsum("ij,ij->i", vectors[f // 3], vectors[g // 3]) / (size[f // 3] * size[g // 3])
    turn[inner] = np.arccos(np.clip(cosine, -1, 1))
    chosen = turn > turn_by
    if apart is not None:
        beside = np.concatenate([beside_edges(turn[of_corner], side) for side in (f, g)], axis=1).max(
            axis=1
        )
        length = np.linalg.norm(np.diff(points[edges[inner]], axis=1)[:, 0], axis=1)
        height = 2 * np.minimum(size[f // 3], size[g // 3]) / length
        chosen[inner] &= (turn[inner] > ALONE * beside) | (height > apart)
    segments = sheet.nodes[edges[chosen]]
    ends = sheet.origin + points[edges[chosen]] @ sheet.frame
    return Creases(segments, ends, shapely.STRtree(shapely.linestrings(segments)))
