"""Nearest points, normals and offsets of a crack surface of any shape; no plane or parameters needed."""

from typing import NamedTuple

import numpy as np

from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.kernels.distances import nearest_on_edges
from craftmesh.surface.measure import along_segments, facet_angles, nearest_facet, unit_normals
from craftmesh.surface.rounding import ON_PLANE, SAME_PLACE
from craftmesh.types import Crack


class SheetProjection(NamedTuple):
    """The relation of a surface to points, called places (n, 3).

    foot (n, 3): nearest point of the surface. normal (n, 3): unit normal there; at an edge or corner the
    mean of the adjoining normals, by angle (Baerentzen & Aanaes 2005), so that its sign gives the side. psi
    (n,): signed distance from the surface, or beyond its boundary from its straight continuation. phi (n,):
    distance of the foot from the fronts, inf if there are none; beyond the boundary, minus the distance
    from it along the continuation. A mouth in box planes does not count as boundary.
    """

    foot: np.ndarray
    normal: np.ndarray
    psi: np.ndarray
    phi: np.ndarray


class NearSheet:
    """A crack surface in a box (2, 3), prepared for queries from nearby points."""

    def __init__(self, sheet: Crack, box: np.ndarray) -> None:
        self.points = np.array(sheet.points, float, order="C")
        self.triangles = sheet.triangles.astype(np.int64)
        self.fronts = sheet.front_edges
        edges, self.of_corner, count = unique_edges(self.triangles)
        self.ends = (count == 1) & ~self._on_box(edges, box)
        self.ends_at = np.zeros(len(self.points), bool)
        self.ends_at[edges[self.ends]] = True
        self.of_facet = unit_normals(self.points, self.triangles)
        self.of_edge = np.zeros((len(edges), 3))
        self.of_point = np.zeros((len(self.points), 3))
        angle = np.radians(facet_angles(self.points, self.triangles))
        for k in range(3):
            np.add.at(self.of_edge, self.of_corner[:, k], self.of_facet)
            np.add.at(self.of_point, self.triangles[:, k], angle[:, k, None] * self.of_facet)

    def _on_box(self, edges: np.ndarray, box: np.ndarray) -> np.ndarray:
        """Return a mask (e,) of edges (e, 2) in a box plane, where the crack continues out of the box."""
        near = ON_PLANE * np.linalg.norm(box[1] - box[0])
        planes = np.concatenate([np.abs(self.points - corner) <= near for corner in box], axis=1)
        on_box: np.ndarray = planes[edges].all(axis=1).any(axis=1)
        return on_box

    def look(self, places: np.ndarray) -> SheetProjection:
        """Return nearest points, normals and offsets of the surface for places (n, 3), n >= 1."""
        places = np.ascontiguousarray(places)
        facet = nearest_facet(places, self.points, self.triangles)[0]
        foot, weight = closest_points_on_triangles(places, self.points[self.triangles[facet]])
        gone = weight < SAME_PLACE  # one such corner weight: the foot is on an edge; two: at a corner
        number = gone.sum(axis=1)
        normal, past = self.of_facet[facet].copy(), np.zeros(len(places), bool)
        rows = np.flatnonzero(number == 1)
        edge = self.of_corner[facet[rows], (gone[rows].argmax(axis=1) + 1) % 3]
        normal[rows], past[rows] = self.of_edge[edge], self.ends[edge]
        rows = np.flatnonzero(number == 2)
        point = self.triangles[facet[rows], weight[rows].argmax(axis=1)]
        normal[rows], past[rows] = self.of_point[point], self.ends_at[point]
        normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
        psi = np.einsum("ij,ij->i", places - foot, normal)
        inside = np.linalg.norm(self.nearest_on_front(foot) - foot, axis=1)
        along = np.linalg.norm(places - foot - psi[:, None] * normal, axis=1)
        return SheetProjection(foot, normal, psi, np.where(past, -along, inside))

    def nearest_on_front(self, places: np.ndarray) -> np.ndarray:
        """Return the front points (n, 3) nearest to places (n, 3); inf if there is no front."""
        if not len(self.fronts):
            return np.full(places.shape, np.inf)
        return nearest_on_edges(np.ascontiguousarray(places), self.points, self.fronts)


def weights_in_triangles(places: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return barycentric coordinates (n, 3) of places (n, d) in triangles with corners (n, 3, d)."""
    u, v, w = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], places - corners[:, 0]
    uu, uv, vv, wu, wv = (np.einsum("ij,ij->i", x, y) for x, y in ((u, u), (u, v), (v, v), (w, u), (w, v)))
    area = np.maximum(uu * vv - uv**2, 1e-300)
    s, t = (vv * wu - uv * wv) / area, (uu * wv - uv * wu) / area
    return np.stack([1 - s - t, s, t], axis=1)


def closest_points_on_triangles(places: np.ndarray, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the point (n, d) of each triangle (n, 3, d) nearest to its place, and that point's weights.

    The weights (n, 3) are barycentric coordinates.
    """
    weight = weights_in_triangles(places, corners)
    least = np.full(len(places), np.inf)
    outside = (weight < 0).any(axis=1)
    for k in range(3):
        p, q = corners[:, k], corners[:, (k + 1) % 3]
        share = along_segments(places, p, q - p)
        distance = np.linalg.norm(p + share[:, None] * (q - p) - places, axis=1)
        nearer = outside & (distance < least)
        least[nearer] = distance[nearer]
        weight[nearer] = 0.0
        weight[nearer, k], weight[nearer, (k + 1) % 3] = 1 - share[nearer], share[nearer]
    return np.einsum("nk,nkd->nd", weight, corners), weight
