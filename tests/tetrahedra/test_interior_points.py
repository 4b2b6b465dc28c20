"""Interior points lie inside, keep their distances and follow the sizing function."""

import numpy as np
import pytest
from scipy.spatial import Delaunay, cKDTree
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.sizing.length_field import LocalSizing
from craftmesh.surface.kernels.bins import cells_of, fill_bins, grid_over
from craftmesh.tetrahedra.grain_surface import grain_surfaces
from craftmesh.tetrahedra.interior_points import (
    APART,
    FROM_FACET,
    FROM_VERTEX,
    interior_points,
    lattice_corners,
)
from craftmesh.tetrahedra.kernels.interior_fill import thin_out


class Graded:
    """Edge lengths that grow from `fine` with the distance from x = 0."""

    def __init__(self, fine, slope):
        self.fine, self.slope = fine, slope

    def at(self, points):
        return self.fine + self.slope * np.abs(np.asarray(points)[:, 0])


def bent_bar(cells=8, crack_at=None):
    """A bar with an L-shaped section, cells of edge 1, and its own tets as first mesh."""

    def label_of(centres):
        return ((centres[:, 1] < cells / 2) | (centres[:, 2] < cells / 2)).astype(int)

    surface, (grain,) = structured_box((cells, cells, cells), label_of, crack_at)
    nodes = np.concatenate([surface.points[grain.nodes], grain.interior])
    return grain_surfaces(surface)[0], nodes, grain.tets


def distance_to_triangle(point, corners):
    """Plain reference: the smallest distance over a fine set of points of the triangle."""
    u, v = np.meshgrid(np.linspace(0, 1, 40), np.linspace(0, 1, 40))
    u, v = u[u + v <= 1], v[u + v <= 1]
    on_it = corners[0] + u[:, None] * (corners[1] - corners[0]) + v[:, None] * (corners[2] - corners[0])
    return np.linalg.norm(on_it - point, axis=1).min()


@pytest.mark.sampled(2)
@pytest.mark.parametrize("sizing", [Graded(1.0, 0.0), Graded(0.4, 0.15)], ids=["uniform", "graded"])
def test_points_keep_their_distances(sizing):
    surface, nodes, tets = bent_bar()
    points = interior_points(surface, nodes, tets, sizing)
    size = sizing.at(points)
    assert len(points) > 100
    # inside, told by the shape itself
    assert ((points > 0) & (points < 8)).all() and (points[:, 1:].min(1) < 4).all()
    assert (cKDTree(surface.points).query(points)[0] >= FROM_VERTEX * size - 1e-12).all()
    # of two points the later one keeps the distance, and lengths differ by the slope over it
    gap, other = (x[:, 1] for x in cKDTree(points).query(points, 2))
    assert (gap >= APART * np.minimum(size, size[other]) - 1e-12).all()
    # over no facet: beside the bar's inner edge, from which its vertices alone keep points away
    beside = (points[:, 1:] < 4).all(1) & (np.linalg.norm(points[:, 1:] - 4, axis=1) < FROM_FACET * size)
    for i in np.flatnonzero(~beside)[::37]:
        near = min(distance_to_triangle(points[i], surface.points[f]) for f in surface.facets)
        assert near >= FROM_FACET * size[i] * 0.99


@pytest.mark.parametrize("fine, slope", [(0.5, 0.1), (0.5, 0.0), (0.7, 0.0), (0.4, 0.15), (0.6, 0.05)])
def test_edges_between_points_are_about_the_target(fine, slope):
    surface, nodes, tets = bent_bar()
    sizing = Graded(fine, slope)
    points = interior_points(surface, nodes, tets, sizing)
    inner = points[(points[:, 0] > 1) & (points[:, 1:].max(1) < 7)]
    edges = Delaunay(inner).simplices[:, [0, 1, 0, 2, 0, 3, 1, 2, 1, 3, 2, 3]].reshape(-1, 2)
    edges = np.unique(np.sort(edges, 1), axis=0)
    length = np.linalg.norm(inner[edges[:, 0]] - inner[edges[:, 1]], axis=1)
    # .88 to 1.05 measured: cells halve, so few fit; the hull's long edges are in it
    assert np.median(length / sizing.at(inner[edges].mean(1))) == pytest.approx(0.96, abs=0.11)


def test_a_layer_stands_on_both_sides_of_a_crack():
    surface, nodes, tets = bent_bar(crack_at=plane_crack(2, 2, hexagon((4, 2), 1.7)))
    assert surface.internal.sum() > 5
    points = interior_points(surface, nodes, tets, Graded(0.5, 0.0))
    over = np.abs(points[:, :2] - [4, 2]).max(1) < 0.6
    height = points[over, 2] - 2
    assert np.abs(height).min() >= FROM_FACET * 0.5 - 1e-12
    for side in (height[height > 0], -height[height < 0]):
        assert side.min() <= 0.5


def plain_choice(points, vertices, apart):
    """Plain reference: the indices of points that stay, each compared with all that do."""
    stay = list(range(vertices))
    for p in range(vertices, len(points)):
        gaps = [np.linalg.norm(points[p] - points[q]) - apart[p, int(q >= vertices)] for q in stay]
        if min(gaps) >= 0:
            stay.append(p)
    return stay


@pytest.mark.parametrize("seed", range(4))
def test_points_are_thinned_out_in_order(seed):
    rng = np.random.default_rng(seed)
    points, vertices = rng.uniform(0, 1, (400, 3)), 30
    apart = rng.uniform(0.02, 0.3, (400, 2))
    grid = grid_over(points.min(0), points.max(0), 0.15)
    cells = cells_of(points, grid)
    stays = thin_out(points, vertices, apart, fill_bins(cells, cells, grid))
    assert np.flatnonzero(stays).tolist() == plain_choice(points, vertices, apart)
    assert 10 < stays[vertices:].sum() < 300


def test_a_grain_smaller_than_the_target_gets_none():
    surface, nodes, tets = bent_bar(cells=2)
    assert interior_points(surface, nodes, tets, Graded(5.0, 0.0)).shape == (0, 3)


def test_without_a_sizing_the_surface_gives_it():
    surface, _, _ = bent_bar()
    length = LocalSizing(surface.points, surface.facets).at(surface.points + 1e-3)
    # edges of the cells' sides and diagonals: 1 and sqrt 2
    assert ((length >= 1.0) & (length <= np.sqrt(2))).all()


def test_every_lattice_cell_has_its_eight_corners_once():
    # at faces to larger cells too, where no neighbour of its own size has them
    cells = np.array([[4, 2, 2], [5, 2, 2], [7, 3, 3]])
    corners = lattice_corners(cells)
    wanted = {tuple(cell + np.array(way)) for cell in cells for way in np.ndindex(2, 2, 2)}
    assert set(map(tuple, corners.tolist())) == wanted
    assert len(corners) == len(wanted) == 20
    assert lattice_corners(cells[:0]).shape == (0, 3)
