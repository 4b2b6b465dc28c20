"""The tetrahedra of all grains on common nodes: the surface's points, then the interior points by grain."""

from collections.abc import Sequence

import numpy as np

from craftmesh.types import GrainTets, Surface


def common_points(surface: Surface, grain_tets: Sequence[GrainTets]) -> np.ndarray:
    """Return the coordinates (n, 3) of all nodes: the surface's points, then interior points by grain."""
    return np.concatenate([surface.points, *(one.interior for one in grain_tets)])


def common_tets(surface: Surface, grain_tets: Sequence[GrainTets]) -> np.ndarray:
    """Return the tets (m, 4) of all grains, by ids of `common_points`, one grain after another."""
    first, blocks = len(surface.points), []
    for one in grain_tets:
        ids = np.concatenate([one.nodes, first + np.arange(len(one.interior))])
        blocks.append(ids[one.tets])
        first += len(one.interior)
    return np.concatenate(blocks)


def grain_of_tets(grain_tets: Sequence[GrainTets]) -> np.ndarray:
    """Return the grain id (m,) of each tet of `common_tets`."""
    return np.repeat([one.grain for one in grain_tets], [len(one.tets) for one in grain_tets])
