"""Rules of integration are exact to their degree; slopes are those of the shape functions."""

from itertools import product
from math import factorial

import numpy as np
import pytest

from craftmesh.mesh.integration import shape_slopes, tet_rule
from craftmesh.mesh.tet_connectivity import EDGE_CORNERS


def exact(powers) -> float:
    """The integral of L1^a L2^b L3^c L4^d over the unit tetrahedron."""
    return np.prod([factorial(p) for p in powers]) / factorial(sum(powers) + 3)


@pytest.mark.parametrize(("points", "degree"), [(1, 1), (4, 2), (14, 5)])
def test_rules_are_exact_to_their_degree_and_no_further(points, degree):
    places, weights = tet_rule(points)
    assert places.shape == (points, 4) and np.allclose(places.sum(axis=1), 1) and (places > 0).all()
    off = {d: 0.0 for d in range(degree + 2)}
    for powers in product(range(degree + 2), repeat=4):
        if sum(powers) in off:
            found = weights @ np.prod(places ** np.array(powers), axis=1)
            off[sum(powers)] = max(off[sum(powers)], abs(found / exact(powers) - 1))
    assert max(off[d] for d in range(degree + 1)) < 1e-12 and off[degree + 1] > 1e-3


@pytest.mark.parametrize("width", [4, 10])
def test_slopes_carry_polynomials_of_the_elements_order(width):
    rng = np.random.default_rng(0)
    corners = np.concatenate([np.zeros((1, 3)), np.eye(3)])
    nodes = corners if width == 4 else np.concatenate([corners, corners[EDGE_CORNERS].mean(axis=1)])
    places = rng.dirichlet(np.ones(4), size=5)
    linear, square = rng.normal(size=3), rng.normal(size=(3, 3))
    square = (square + square.T) * (width == 10)
    values = nodes @ linear + np.einsum("ni,ij,nj->n", nodes, square, nodes)
    found = np.einsum("n,qni->qi", values, shape_slopes(places, width))
    assert np.allclose(found, linear + 2 * (places @ corners) @ square)
