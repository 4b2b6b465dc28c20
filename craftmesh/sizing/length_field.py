"""Target lengths at points: a scalar field, a limit on its growth, and lengths from curvature."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from craftmesh.arguments import Frozen, as_array
from craftmesh.errors import CraftmeshError
from craftmesh.surface.connectivity import edge_sides, unique_edges
from craftmesh.surface.measure import area_vectors, mean_edges
from craftmesh.surface.patches import feature_edges, oriented, patches
from craftmesh.types import CRACK, Surface

_AVERAGED = 4  # nearest samples that are averaged for a length between them
LINKED = 26  # nearest neighbours of a sample for which the limit on growth is enforced
_CURVATURE_LAPS = 3  # smoothing passes that remove the noise of the curvature


@dataclass(frozen=True)
class LengthField(Frozen):
    """Target edge lengths (k,) at sample points (k, 3).

    Between samples, if growth is 0, lengths are means of the nearest samples weighted by 1/distance^2. If
    growth > 0, they are the smallest of the nearest samples' lengths, each plus growth times its distance.
    Raise CraftmeshError if there is no sample or a length is not a finite number > 0.
    """

    points: np.ndarray
    lengths: np.ndarray
    growth: float = 0.0

    def __post_init__(self) -> None:
        points = as_array("points", self.points, float, (None, 3))
        lengths = as_array("lengths", self.lengths, float, (None,))
        if not len(points) or len(points) != len(lengths):
            raise CraftmeshError(
                f"the field of lengths has {len(points)} points and {len(lengths)} values; "
                "give one value per point, and at least one point"
            )
        for bad in np.flatnonzero(lengths <= 0).tolist():
            raise CraftmeshError(
                f"lengths[{bad}] is {lengths[bad]} at {points[bad].tolist()}; expected lengths > 0"
            )
        for name, array in (("points", points), ("lengths", lengths)):
            object.__setattr__(self, name, array)

    def __repr__(self) -> str:
        least, most = self.lengths.min(), self.lengths.max()
        return f"LengthField({len(self.points)} points, lengths {least:.6g} to {most:.6g})"

    @cached_property
    def _tree(self) -> "scipy.spatial.cKDTree":
        return scipy.spatial.cKDTree(self.points)

    def at(self, points: np.ndarray) -> np.ndarray:
        """Return target edge lengths (n,) at `points` (n, 3)."""
        points = as_array("points", points, float, (None, 3))
        most = LINKED + 1 if self.growth else _AVERAGED
        near = range(1, min(most, len(self.points)) + 1)
        distance, sample = self._tree.query(points, k=list(near))
        if self.growth:
            return (self.lengths[sample] + self.growth * distance).min(axis=1)
        # a point that coincides with a sample gets that sample's length
        scale = np.maximum(distance, 1e-9 * np.maximum(distance[:, -1:], np.finfo(float).tiny))
        weight = (scale[:, :1] / scale) ** 2
        return (weight * self.lengths[sample]).sum(axis=1) / weight.sum(axis=1)

    def limited(self, growth: float) -> "LengthField":
        """Return the field with lengths that grow by at most `growth` per distance between neighbours.

        Each length becomes the smallest sum of a sample's length and `growth` times the distance from it,
        measured along lines between neighbouring samples.
        """
        k = len(self.points)
        near = range(1, min(LINKED + 1, k) + 1)
        distance, sample = self._tree.query(self.points, k=list(near))
        source = np.repeat(np.arange(k), len(near))
        step = np.maximum(growth * distance.ravel(), 1e-300)
        row = np.concatenate([source, np.full(k, k)])
        column = np.concatenate([sample.ravel(), np.arange(k)])
        # A link stored from both ends would be summed in the matrix; `maximum` makes it symmetric instead.
        graph = scipy.sparse.coo_matrix(
            (np.concatenate([step, self.lengths]), (row, column)), shape=(k + 1, k + 1)
        )
        graph = graph.tocsr()
        lengths = scipy.sparse.csgraph.dijkstra(graph.maximum(graph.T), directed=False, indices=k)[:k]
        return LengthField(self.points, np.minimum(lengths, self.lengths), growth)


def curvature_lengths(surface: Surface, turn: float, shortest: float, growth: float) -> LengthField:
    """Return lengths over which the normal of `surface` turns by `turn` degrees, at least `shortest`.

    growth: of the field. The curvature at a vertex is the largest principal value of the tensor of
    Cohen-Steiner and Morvan (2003) over its facets, averaged over neighbours. Vertices on junction lines
    and the crack are no samples. Raise CraftmeshError if no vertex lies inside a patch.
    """
    facets, _ = oriented(surface)
    facets = facets.astype(np.int64)
    patch = patches(surface).of_facet
    edges, of_corner, _, is_feature = feature_edges(surface, patch)
    f, g = (side // 3 for side in edge_sides(of_corner, ~is_feature))
    ends = edges[~is_feature]
    free = np.zeros(len(surface.points), bool)
    free[facets] = True
    free[edges[is_feature]] = False
    free[facets[surface.kind == CRACK]] = False
    if not free.any():
        raise CraftmeshError(
            "the surface has no vertex inside a patch to measure curvature at; remove option curvature"
        )
    tensor = _curvature_tensors(surface.points, facets, f, g, ends)
    tensor = _averaged(tensor, edges[free[edges].all(axis=1)])
    bend = np.abs(np.linalg.eigvalsh(tensor[free])).max(axis=1)
    length = np.radians(turn) / np.maximum(bend, 1e-12)
    size = np.ptp(surface.points, axis=0).max()
    return LengthField(surface.points[free], np.clip(length, shortest, max(size, shortest)), growth)


def _curvature_tensors(
    points: np.ndarray, facets: np.ndarray, f: np.ndarray, g: np.ndarray, ends: np.ndarray
) -> np.ndarray:
    """Return curvature tensors (n, 3, 3) at points (n, 3), from the angles between neighbouring facets.

    f, g (k,): the two facets at each edge; ends (k, 2): the edge's points.
    """
    area = area_vectors(points, facets)
    size = np.linalg.norm(area, axis=1)
    normal = area / np.maximum(size, 1e-300)[:, None]
    centre = points[facets].mean(axis=1)
    along = points[ends[:, 1]] - points[ends[:, 0]]
    length = np.maximum(np.linalg.norm(along, axis=1), 1e-300)
    sine = np.linalg.norm(np.cross(normal[f], normal[g]), axis=1)
    turn = np.arctan2(sine, np.einsum("ij,ij->i", normal[f], normal[g]))
    turn *= np.sign(np.einsum("ij,ij->i", normal[f], centre[f] - centre[g]))
    part = (turn / length)[:, None, None] * along[:, :, None] * along[:, None, :]
    total = np.zeros((len(points), 3, 3))
    for end in ends.T:
        np.add.at(total, end, part)
    around = np.zeros(len(points))
    np.add.at(around, facets, size[:, None])
    # a vertex gets half of each of its edges and a third of each of its facets
    return 0.5 * total / np.maximum(around / 3, 1e-300)[:, None, None]


def _averaged(tensor: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return tensors (n, 3, 3) averaged with those at the other ends of edges (k, 2), several times."""
    for _ in range(_CURVATURE_LAPS):
        total, count = tensor.copy(), np.ones(len(tensor))
        for a, b in (edges.T, edges[:, ::-1].T):
            np.add.at(total, a, tensor[b])
            np.add.at(count, a, 1.0)
        tensor = total / count[:, None, None]
    return tensor


class LocalSizing:
    """Target edge lengths equal to the mean edge lengths of facets (m, 3) on points (n, 3)."""

    def __init__(self, points: np.ndarray, facets: np.ndarray):
        edges, _, _ = unique_edges(facets)
        self.length = mean_edges(points, edges)
        self.tree = scipy.spatial.cKDTree(points)

    def at(self, points: np.ndarray) -> np.ndarray:
        """Return the mean edge length (n,) at the surface's node nearest to each point (n, 3)."""
        return self.length[self.tree.query(points)[1]]
