"""Parts of the grains, for jobs that share the tetrahedra of one surface."""

import numpy as np

from craftmesh.types import Surface


def grains_of_chunk(surface: Surface, part: int, parts: int) -> list[int]:
    """Return the grain ids of one part; the parts hold all grains and about equally many facets."""
    labels, facets = np.unique(surface.sides, return_counts=True)
    facets, labels = facets[labels > 0], labels[labels > 0]
    load = np.zeros(parts, np.int64)
    mine = []
    for index in np.argsort(-facets, kind="stable"):
        lightest = int(np.argmin(load))
        load[lightest] += facets[index]
        if lightest == part - 1:
            mine.append(int(labels[index]))
    return sorted(mine)
