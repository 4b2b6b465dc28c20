"""The insertion's report of what it moved."""

import numpy as np
import pytest
from structured_box import structured_box

from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.series import prescribed_crack
from craftmesh.insertion.insert import insert_crack

BOX = np.array([[0.0, 0, 0], [8, 8, 8]])


def report(normal, centre) -> dict:
    model, _ = structured_box((8, 8, 8), lambda c: 1 + (c[:, 2] > 4).astype(int))
    crack = prescribed_crack(BOX, CrackOptions(centre=centre, normal=normal, radius=2.4))
    return insert_crack(model, crack, None)[1]


def test_a_crack_across_a_boundary_moves_it_only_within_itself():
    found = report((1, 0.2, 0), (4.07, 4, 4))
    assert found["boundary_points_moved"] == 0
    assert found["boundary_moved_most"] < 1e-12
    assert found["crack_facets_on_grain_boundaries"] == 0


@pytest.mark.parametrize("above", [0.05, 0.12])
def test_a_boundary_that_is_moved_onto_the_crack_is_told(above):
    """The boundary is `above` from the crack, less than the fifth of an edge from which points move."""
    found = report((0, 0, 1), (4, 4, 4 + above))
    assert found["boundary_moved_most"] == pytest.approx(above)
    # the points of the grid within the circle, and of its front
    assert 18 <= found["boundary_points_moved"] < 80
    assert found["boundary_facets_moved"] > found["crack_facets_on_grain_boundaries"] > 20
    assert found["crack_moved_most"] < 1e-12
