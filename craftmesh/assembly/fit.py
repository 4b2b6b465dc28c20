"""Whether grains' tetrahedra were made of a surface, before anything is computed with both."""

from collections.abc import Sequence

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.types import GrainTets, Surface


def refuse_other_surface(surface: Surface, grain_tets: Sequence[GrainTets]) -> None:
    """Raise CraftmeshError unless each grain of tets has the points that the surface gives that grain.

    Kernels that take both read beyond their arrays otherwise: chunks of an older surface ended the process.
    Grains without tets are left to others.
    """
    sides = surface.sides.ravel()
    order = np.argsort(sides, kind="stable")
    ascending = sides[order]
    for one in grain_tets:
        first, last = np.searchsorted(ascending, (one.grain, one.grain + 1))
        expected = np.unique(surface.facets[order[first:last] // 2])
        if not np.array_equal(np.sort(one.nodes), expected):
            raise CraftmeshError(
                f"grain {one.grain}: its tetrahedra have {len(one.nodes)} points of a surface that gives"
                f" it {len(expected)}, or others; expected those of this surface: run tetrahedralize again"
            )
