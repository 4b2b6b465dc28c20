"""Poor tetrahedra are listed with the facets, wedges and edges of the surface that force them."""

import numpy as np
import pytest

from craftmesh.tetrahedra.grain_surface import GrainSurface
from craftmesh.tetrahedra.record import poor_tets

OUTWARD = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])


def lone_tet(height):
    """A grain that is one tet with `height` over its base; its facets have the ids 10 to 13."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.3, 0.3, height]], float)
    surface = GrainSurface(5, np.arange(4), points, OUTWARD, np.zeros(4, bool), np.arange(10, 14))
    return poor_tets(surface, points, np.array([[0, 1, 2, 3]]))


def test_a_flat_tet_is_listed_with_what_its_surface_forces():
    (row,) = lone_tet(0.03)
    low = np.degrees(np.arctan2(0.03, 0.3))
    assert row["wedge"] == pytest.approx(row["dihedrals"][0], abs=0.01)
    assert row["wedge"] == pytest.approx(low, abs=0.01) and row["dihedrals"][1] > 160
    assert row["facets"] == [10, 11, 12, 13]
    assert row["edge"] == pytest.approx(np.hypot(np.hypot(0.3, 0.3), 0.03), abs=1e-6)
    assert row["centre"] == pytest.approx([0.325, 0.325, 0.0075])


def test_a_good_tet_is_not_listed():
    assert lone_tet(0.8) == []


def test_the_worst_comes_first_and_inner_tets_name_no_facets():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    surface = GrainSurface(5, np.arange(4), points, OUTWARD, np.zeros(4, bool), np.arange(4))
    flat = np.array([[0.1, 0.1, 0.1], [0.3, 0.1, 0.1], [0.1, 0.3, 0.1], [0.15, 0.15, 0.11]])
    flatter = flat + [0, 0, 0.2]
    flatter[3, 2] -= 0.005
    nodes = np.concatenate([points, flat, flatter])
    rows = poor_tets(surface, nodes, np.array([[0, 1, 2, 3], [4, 5, 6, 7], [8, 9, 10, 11]]))
    assert [row["centre"][2] > 0.2 for row in rows] == [True, False]
    assert rows[0]["facets"] == [] and rows[0]["wedge"] is None and rows[0]["edge"] is None
