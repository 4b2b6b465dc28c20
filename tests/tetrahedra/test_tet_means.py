"""Means at points are those of the tets one by one."""

import numpy as np
import pytest
from test_optimise_tets import random_ball

from craftmesh.mesh.shape_measures import shape_measures
from craftmesh.mesh.tet_connectivity import tet_edges
from craftmesh.tetrahedra.kernels.tet_means import mean_edges, mean_ratios


def plain_means(values, corners, count):
    """Return the mean of the values (m,) of things at each of their corners (m, k), point by point."""
    return [values[(corners == v).any(axis=1)].sum() / max((corners == v).sum(), 1) for v in range(count)]


def test_means_of_edges_and_of_ratios_are_those_of_the_tets_one_by_one():
    points, tets, _ = random_ball(seed=4)
    count, mean = np.empty(len(points), np.int64), np.empty(len(points))
    mean_edges(points, tets, mean, count)
    edges = tet_edges(tets)
    lengths = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    assert mean == pytest.approx(plain_means(lengths, edges, len(points)))

    expected, ratio = shape_measures(points, tets)[:, 1], np.empty(len(tets))
    assert mean_ratios(points, tets, ratio, mean, count) == pytest.approx(expected.mean())
    assert ratio == pytest.approx(expected)
    assert mean == pytest.approx(plain_means(expected, tets, len(points)))
    # dead tets count nowhere
    dead = tets.copy()
    dead[::3, 0] = -1
    alive = np.arange(len(tets)) % 3 > 0
    assert mean_ratios(points, dead, ratio, mean, count) == pytest.approx(expected[alive].mean())
    assert (ratio[~alive] == 0).all()
    assert mean == pytest.approx(plain_means(expected[alive], tets[alive], len(points)))
