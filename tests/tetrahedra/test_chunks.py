"""Chunks share the grains."""

import numpy as np
import pytest
from structured_box import structured_box

from craftmesh.tetrahedra.tetrahedralize import grains_of_chunk


def row_of_grains(count):
    """Grains 1..count in a row, each longer than the one before."""
    ends = np.cumsum(np.arange(1, count + 1))
    return structured_box((int(ends[-1]), 1, 1), lambda c: 1 + np.searchsorted(ends, c[:, 0]))[0]


@pytest.mark.parametrize("parts", [1, 2, 3, 9])
def test_chunks_hold_every_grain_once_and_like_numbers_of_facets(parts):
    surface = row_of_grains(6)
    chunks = [grains_of_chunk(surface, part, parts) for part in range(1, parts + 1)]
    assert sorted(sum(chunks, [])) == [1, 2, 3, 4, 5, 6]
    facets = [sum((surface.sides == grain).any(axis=1).sum() for grain in chunk) for chunk in chunks]
    largest = max((surface.sides == grain).any(axis=1).sum() for grain in range(1, 7))
    assert max(facets) - min(facets) <= largest
