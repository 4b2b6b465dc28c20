"""Edges of the surface at flat tets swapped: parted beside another corner, which the new node becomes.

A facet with a node almost on its long edge has flat tets on both sides wherever its other nodes are. Where
that edge is parted and the two nodes are one the facet is no more, and the tets along the edge have
the node between as a corner.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from craftmesh.tetrahedra.surface_partings import Parting, inner_edges
from craftmesh.tetrahedra.whole_mesh import Model

# Nodes within this part of an edge from its ends are not beside it.
ASIDE = 0.05


@dataclass(frozen=True)
class Swap:
    """An edge parted at one place, and the node of the surface that the new node is to become."""

    parting: Parting
    node: int


def swaps_at(model: Model, rows: np.ndarray) -> Iterator[Swap]:
    """Yield swaps at each of the tets in `rows`: its edges of the surface, not of the front.

    With each a node of the tet on the surface that lies beside the edge, the nearest first.
    """
    points, count = model.points, len(model.surface.points)
    edges = set(map(tuple, inner_edges(model).tolist())) if len(rows) else set()
    for corners in np.sort(model.tets[rows], axis=1).tolist():
        found = []
        for edge in filter(edges.__contains__, combinations(corners, 2)):
            start, way = points[edge[0]], points[edge[1]] - points[edge[0]]
            for node in corners:
                share = float((points[node] - start) @ way / (way @ way))
                if node < count and node not in edge and ASIDE < share < 1 - ASIDE:
                    height = float(np.linalg.norm(start + share * way - points[node]))
                    found.append((height, edge, node, share))
        for _, edge, node, share in sorted(found):
            yield Swap(Parting(np.array([edge]), np.array([share])), node)
