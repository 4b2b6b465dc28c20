"""Connected components (pieces) of a volume, by union-find."""

import numpy as np

from craftmesh.jit import kernel
from craftmesh.surface.kernels.union_find import root_of


@kernel
def number_pieces(labels):
    """Return the piece (nx, ny, nz) of each voxel, numbered from 0 in scan order of their first voxels.

    Voxels of equal labels (nx, ny, nz) that share a face are in one piece. Before the second pass, `of`
    refers to the same or an earlier voxel of the piece; only the first voxel refers to itself.
    """
    flat = labels.ravel()
    of = np.arange(labels.size)
    strides = (labels.shape[1] * labels.shape[2], labels.shape[2], 1)
    for v in range(labels.size):
        for axis in range(3):
            before = v - strides[axis]
            if (v // strides[axis]) % labels.shape[axis] and flat[before] == flat[v]:
                a, b = root_of(of, before), root_of(of, v)
                of[max(a, b)] = min(a, b)
    count = 0
    for v in range(labels.size):
        if of[v] == v:
            of[v] = count
            count += 1
        else:
            of[v] = of[of[v]]
    return of.reshape(labels.shape)
