"""Caps of crack facets go by a swap of their longest edge, where nothing stands in its way."""

from dataclasses import replace

import numpy as np
import pytest

from craftmesh.insertion.contract import CAP, without_caps
from craftmesh.insertion.cut import uncut
from craftmesh.surface.measure import area_vectors, facet_angles
from craftmesh.types import CRACK, Surface

HEIGHT = 0.01  # of the cap's longest edge: it has an angle of 177.7 degrees


def quad(turned: bool, sides=((1, 1), (1, 1))):
    """A cap on the edge (0, 1), in the plane of the facet below it or square to that."""
    out = [0, 0, HEIGHT] if turned else [0, HEIGHT, 0]
    points = np.array([[-0.5, 0, 0], [0.5, 0, 0], out, [0, -0.8, 0]])
    facets = np.array([[0, 1, 2], [1, 0, 3]], np.int32)
    return uncut(Surface(points, facets, np.array(sides, np.int32), np.full(2, CRACK)))


@pytest.mark.parametrize("turned", [False, True])
def test_a_cap_shares_its_room_with_the_facet_across_its_longest_edge(turned):
    before = quad(turned)
    after = without_caps(before)
    assert facet_angles(before.points, before.facets).max() > CAP
    assert facet_angles(after.points, after.facets).max() < 120
    assert np.array_equal(after.points, before.points)
    assert sorted(map(sorted, after.facets.tolist())) == [[0, 2, 3], [1, 2, 3]]
    assert (area_vectors(after.points, after.facets)[:, 2] > 0).all()


def test_a_cap_that_another_grain_begins_at_stays():
    before = quad(False, ((1, 1), (1, 2)))
    assert np.array_equal(without_caps(before).facets, before.facets)


def test_no_diagonal_goes_through_another_facet():
    before = quad(False)
    points = np.concatenate([before.points, [[-0.1, -0.4, -0.3], [0.1, -0.4, -0.3], [0, -0.4, 0.3]]])
    wall = replace(
        before,
        points=points,
        facets=np.concatenate([before.facets, [[4, 5, 6]]]),
        sides=np.concatenate([before.sides, [[1, 2]]]),
        kind=np.concatenate([before.kind, [0]]).astype(before.kind.dtype),
    )
    assert np.array_equal(without_caps(wall).facets, wall.facets)
