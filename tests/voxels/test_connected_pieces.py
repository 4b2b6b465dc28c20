"""Pieces of a volume are those of a flood from each voxel, numbered in the order in which they are met."""

from itertools import product

import numpy as np
import pytest

from craftmesh.voxels.voxel_graph import find_pieces


def flooded(labels):
    """Return the piece (nx, ny, nz) of each voxel by floods, one after another."""
    of = np.full(labels.shape, -1)
    number = -1
    for start in np.ndindex(labels.shape):
        number += of[start] < 0
        waiting = [start]
        while waiting:
            v = waiting.pop()
            if of[v] >= 0:
                continue
            of[v] = number
            for axis, way in product(range(3), (-1, 1)):
                w = tuple(np.add(v, way * np.eye(3, dtype=int)[axis]))
                if all(0 <= k < n for k, n in zip(w, of.shape)) and labels[w] == labels[v]:
                    waiting.append(w)
    return of


@pytest.mark.parametrize("shape", [(6, 5, 7), (1, 9, 1), (2, 1, 8), (9, 8, 1)])
@pytest.mark.parametrize("kinds", [1, 2, 4])
def test_pieces_are_those_of_floods(shape, kinds):
    rng = np.random.default_rng(kinds)
    for kind in (np.int32, np.int8):
        labels = rng.integers(-1, kinds, shape).astype(kind)
        pieces = find_pieces(labels)
        of = flooded(labels)
        np.testing.assert_array_equal(pieces.of, of)
        np.testing.assert_array_equal(pieces.label[of], labels)
        np.testing.assert_array_equal(pieces.voxels, np.bincount(of.ravel()))
        at_box = [v for v in np.ndindex(shape) if any(k in (0, n - 1) for k, n in zip(v, shape))]
        assert set(np.flatnonzero(pieces.touches_box)) == {of[v] for v in at_box}
