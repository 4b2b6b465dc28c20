"""Connected pieces of a volume, by union-find."""

import numpy as np

from craftmesh.jit import kernel
from craftmesh.surface.kernels.union_find import root_of


@kernel
def number_pieces(labels):
    """Return the 6-connected piece (nx, ny, nz) of each voxel, 0.. in scan order of their first voxels.

    labels (nx, ny, nz): voxels of a piece have the same. Up to the second pass `of` is a voxel of the same
    piece, no later one: the first voxel is its own.
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
