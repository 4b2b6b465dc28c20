"""Target lengths given at points: a scalar field, its gradation limit, and lengths from curvature."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
from scipy.sparse import coo_matrix

from craftmesh.arguments import Frozen, as_array
from craftmesh.errors import CraftmeshError
from craftmesh.surface.connectivity import edge_sides, unique_edges
from craftmesh.surface.measure import area_vectors, mean_edges
from craftmesh.surface.patches import feature_edges, oriented, patches
from craftmesh.types import CRACK, Surface

_AVERAGED = 4  # samples that a length between the samples is made of
LINKED = 26  # neighbours of a sample over which the gradation limit acts
_CURVATURE_LAPS = 3  # averages over neighbours that take the noise out of the curvature


@dataclass(frozen=True)
class LengthField(Frozen):
    """Target edge lengths (k,) at sample points (k, 3).

    growth 0: elsewhere the mean of the nearest samples weighted by 1/distance^2. growth > 0: elsewhere
    the least of the nearest samples' lengths, each grown by `growth` per distance.
    Raises CraftmeshError when there is no sample or a length is not a finite number > 0.
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
                "expected one value for each of at least one point"
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
        """Return the (n,) target edge lengths at `points` (n, 3)."""
        points = as_array("points", points, float, (None, 3))
        most = LINKED + 1 if self.growth else _AVERAGED
        near = range(1, min(most, len(self.points)) + 1)
        distance, sample = self._tree.query(points, k=list(near))
        if self.growth:
            return (self.lengths[sample] + self.growth * distance).min(axis=1)
        # a point on a sample takes that sample's length alone
        scale = np.maximum(distance, 1e-9 * np.maximum(distance[:, -1:], np.finfo(float).tiny))
        weight = (scale[:, :1] / scale) ** 2
        return (weight * self.lengths[sample]).sum(axis=1) / weight.sum(axis=1)

    def limited(self, growth: float) -> "LengthField":
        """Return the field with lengths that grow by at most `growth` per distance between neighbours.

        Each length becomes the least of all lengths plus `growth` times the way there, along lines
        between neighbouring samples.
        """
        k = len(self.points)
        near = range(1, min(LINKED + 1, k) + 1)
        distance, sample = self._tree.query(self.points, k=list(near))
        source = np.repeat(np.arange(k), len(near))
        step = np.maximum(growth * distance.ravel(), 1e-300)
        row = np.concatenate([source, np.full(k, k)])
        column = np.concatenate([sample.ravel(), np.arange(k)])
        # the same link from both ends would add up in a sparse matrix; the graph is made undirected later
        graph = coo_matrix((np.concatenate([step, self.lengths]), (row, column)), shape=(k + 1, k + 1))
        graph = graph.tocsr()
        lengths = scipy.sparse.csgraph.dijkstra(graph.maximum(graph.T), directed=False, indices=k)[:k]
        return LengthField(self.points, np.minimum(lengths, self.lengths), growth)


def curvature_lengths(surface: Surface, turn: float, shortest: float, growth: float) -> LengthField:
    """Return lengths over which the normal of `surface` turns by `turn` degrees, at least `shortest`.

    The curvature at a vertex is the largest principal one of the tensor of Cohen-Steiner and Morvan
    (2003) over its facets, averaged over neighbours; vertices of junction lines and of the crack give none.
    Raises CraftmeshError when no vertex lies inside a patch.
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
            "the surface has no vertex inside a patch to measure curvature at; leave it out"
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
    """Return (n, 3, 3) curvature tensors from the turns between facets `f` and `g` over edges `ends`."""
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
    # half of each edge and a third of each facet belong to a vertex
    return 0.5 * total / np.maximum(around / 3, 1e-300)[:, None, None]


def _averaged(tensor: np.ndarray, edges: np.ndarray) -> np.ndarray:
    for _ in range(_CURVATURE_LAPS):
        total, count = tensor.copy(), np.ones(len(tensor))
        for a, b in (edges.T, edges[:, ::-1].T):
            np.add.at(total, a, tensor[b])
            np.add.at(count, a, 1.0)
        tensor = total / count[:, None, None]
    return tensor


class LocalSizing:
    """Target edge lengths that follow those of the facets (m, 3) on points (n, 3)."""

    def __init__(self, points: np.ndarray, facets: np.ndarray):
        edges, _, _ = unique_edges(facets)
        self.length = mean_edges(points, edges)
        self.tree = scipy.spatial.cKDTree(points)

    def at(self, points: np.ndarray) -> np.ndarray:
        """Return the mean length (n,) of the edges at the surface's node nearest to each point (n, 3)."""
        return self.length[self.tree.query(points)[1]]
