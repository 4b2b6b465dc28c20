"""Triangles become pixels: the nearest shows, each covers its area, and all is as a plain loop has it."""

import numpy as np
import pytest

from craftmesh.report.kernels.raster import draw
from craftmesh.report.shaded import shaded, view_from

TOP = np.array([0.0, 0.0, 1.0])


def plain(corners, colours, size):
    """Draw as `draw` does without lines: for each pixel's centre, the nearest triangle that holds it."""
    picture = np.zeros((*size, 3))
    for i, j in np.ndindex(size):
        best = -np.inf
        for triangle, shades in zip(corners, colours):
            matrix = np.vstack([triangle[:, :2].T, np.ones(3)])
            if abs(np.linalg.det(matrix)) < 1e-12:
                continue
            share = np.linalg.solve(matrix, [j + 0.5, i + 0.5, 1.0])
            if (share >= 0).all() and share @ triangle[:, 2] > best:
                best = share @ triangle[:, 2]
                picture[i, j] = share @ shades
    return picture


@pytest.mark.parametrize("seed", range(4))
def test_pixels_are_those_of_a_plain_loop(seed):
    rng = np.random.default_rng(seed)
    corners, colours = rng.random((12, 3, 3)) * [24, 18, 5] - [2, 2, 0], rng.random((12, 3, 3))
    corners[3, 2] = corners[3, 1]  # without area
    size = (14, 20)
    picture, depth = np.zeros((*size, 3)), np.full(size, -np.inf)
    draw(corners, colours, np.zeros(12), picture, depth)
    assert np.allclose(picture, plain(corners, colours, size), atol=1e-9)


def test_lines_darken_the_edges_alone():
    corners = np.array([[[0.0, 0, 0], [40, 0, 0], [0, 40, 0]]])
    picture, depth = np.zeros((40, 40, 3)), np.full((40, 40), -np.inf)
    draw(corners, np.ones((1, 3, 3)), np.full(1, 2.0), picture, depth)
    assert picture[0, 5, 0] == pytest.approx(0.25) and picture[10, 10, 0] == 1.0


def test_a_square_covers_its_share_of_the_picture():
    points = np.array([[0.0, 0, 0], [4, 0, 0], [4, 2, 0], [0, 2, 0]])
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    view = view_from(TOP, points)
    picture = shaded(points, triangles, np.ones((2, 3, 3)), view, 200, lined=False)
    size = view.high - view.low
    assert picture[..., 3].mean() == pytest.approx(8 / np.prod(size), abs=0.01)  # a row of 100
    assert np.allclose(view.frame @ view.frame.T, np.eye(3)) and np.linalg.det(view.frame) > 0


def test_what_is_above_hides_what_is_below():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]])
    colours = np.zeros((2, 3, 3))
    colours[0, :, 0], colours[1, :, 2] = 1, 1
    triangles = np.array([[0, 1, 2], [3, 4, 5]])
    for towards, seen in ((TOP, 2), (-TOP, 0)):
        picture = shaded(points, triangles, colours, view_from(towards, points), 50, lined=False)
        colour = picture[picture[..., 3] == 1][:, :3]
        assert (colour[:, seen] > 0.4).all() and np.delete(colour, seen, axis=1).max() == 0
