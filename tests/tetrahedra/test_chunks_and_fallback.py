"""Chunks share the grains; the last rung meshes nothing anew unless grains are left."""

import numpy as np
import pytest
from structured_box import structured_box

from craftmesh.errors import CraftmeshError
from craftmesh.tetrahedra.fallback import Completion, completed
from craftmesh.tetrahedra.options import TetrahedralizeOptions
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


def no_sizing():
    raise AssertionError("the sizing is asked for, although nothing is meshed anew")


def test_nothing_is_meshed_anew_where_no_grain_is_left():
    given = Completion(row_of_grains(2), ())
    for record in ({}, {"left": [], "mesher": "tetgen"}):
        assert completed(given, record, no_sizing, TetrahedralizeOptions()) is given


def test_without_a_fallback_the_first_failure_is_named():
    left = list(range(2, 10))
    record = {
        "mesher": "tetgen",
        "left": left,
        "failed": {str(grain): {"reason": f"reason {grain}"} for grain in reversed(left)},
    }
    given = Completion(row_of_grains(2), ())
    with pytest.raises(CraftmeshError, match=r"2, 3, 4, 5, 6, 7 and 2 more \(grain 2: reason 2\)"):
        completed(given, record, no_sizing, TetrahedralizeOptions(fallback="none"))
