"""The label of a place is that of the cell in which it lies, wherever the surface's facets point."""

import numpy as np
import pytest
from few_facets import sheet
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.surface.labels import labels_at


def label_of(centres):
    """Three grains, a void in one, a grain in another, and a corner that is outside."""
    labels = np.where(centres[:, 0] < 3, 4, np.where(centres[:, 1] < 2, 11, 7))
    labels[(np.abs(centres - [1.5, 1.5, 1.5]) < 0.6).all(axis=1)] = -2
    labels[(np.abs(centres - [4.5, 0.5, 1.5]) < 0.6).all(axis=1)] = 9
    labels[(centres[:, 0] > 5) & (centres[:, 2] > 3)] = 0
    return labels


@pytest.mark.parametrize("cracked", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_places_have_the_label_of_their_cell_in_sheared_and_turned_boxes(seed, cracked):
    rng = np.random.default_rng(seed)
    crack = plane_crack(2, 2, hexagon((3, 3), 2)) if cracked else None
    surface = structured_box((6, 6, 4), label_of, crack, (1, 1, 1))[0]
    places = rng.uniform(-1, [7, 7, 5], (3000, 3))
    places = places[np.abs(places - places.round()).min(axis=1) > 1e-6]
    inside = ((places > 0) & (places < [6, 6, 4])).all(axis=1)
    known = np.where(inside, label_of(np.floor(places) + 0.5), 0)
    sheared = np.linalg.qr(rng.normal(size=(3, 3)))[0] @ np.array([[2, 0.3, 0], [0, 1, -0.4], [0, 0, 0.5]])
    if np.linalg.det(sheared) < 0:
        sheared[0] *= -1
    points = surface.points @ sheared.T + [5, -3, 1]
    found = labels_at(places @ sheared.T + [5, -3, 1], points, surface.facets, surface.sides)
    np.testing.assert_array_equal(found, known)


def test_without_a_closed_surface_no_place_has_a_label():
    low = sheet([[0, 1, 2], [0, 2, 3]], points=[[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]], sides=(0, 0))
    assert labels_at(np.array([[1, 2, 1.0], [1, 2, -1.0]]), low.points, low.facets, low.sides).tolist() == [
        0,
        0,
    ]
