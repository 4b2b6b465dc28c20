"""Edges along a crack's fold that comes near a face of the box; where it is far or steep there are none."""

import numpy as np
import pytest

from craftmesh.sizing.folds import NEAR, fold_edges, fold_lengths
from craftmesh.sizing.sizing import Sizing
from craftmesh.sizing.strips import PER_WIDTH, SHORTEST_IN_SLIVERS
from craftmesh.types import Crack

BOX = np.array([[0.0, 0, 0], [40, 40, 20]])
L_MIN = 0.5


def ridge(start: float, end: float, slope: float = 1.5) -> Crack:
    """Two limbs that come down from the top to a fold along y, from a depth under the top to another."""
    y = np.linspace(-5.0, 45.0, 11)
    depth = start + (end - start) * y / 40
    line = np.stack([np.full(11, 20.0), y, 20 - depth], axis=1)
    limbs = [line + [side * 4, 0, 4 * slope] for side in (-1, 1)]
    points = np.concatenate([limbs[0], line, limbs[1]])
    a = (11 * np.arange(2)[:, None] + np.arange(10)).ravel()
    triangles = np.concatenate([np.stack([a, a + 11, a + 12], 1), np.stack([a, a + 12, a + 1], 1)])
    return Crack(points, triangles, ())


def sizing() -> Sizing:
    return Sizing(L_MIN, 6.0, 6.0, 4.0, 8.0, 1.0, np.zeros((0, 3)))


@pytest.mark.parametrize("slope", [0.5, 1.5])  # kinks of 53 and 113 degrees: the sharper one is parted
@pytest.mark.parametrize("depth", [0.01, 0.05, 0.2])
def test_edges_along_a_fold_are_a_share_of_its_distance_from_a_face(depth, slope):
    found = fold_lengths(ridge(depth, depth, slope), BOX, sizing())
    wished = max(PER_WIDTH * depth, SHORTEST_IN_SLIVERS * L_MIN)
    assert np.allclose(found.lengths, wished)
    along = np.column_stack([np.full(50, 20.0), np.linspace(0.5, 39.5, 50), np.full(50, 20.0 - depth)])
    # no place is farther than l_min from the next one, and lengths grow by half the distance
    assert (found.at(along) < wished + L_MIN / 2).all()


@pytest.mark.parametrize(
    "ends", [(2 * NEAR * L_MIN, 2 * NEAR * L_MIN), (-10.0, 10.0)], ids=["deep", "steep"]
)
def test_a_fold_that_is_deep_or_goes_steeply_out_of_the_face_asks_for_none(ends):
    crack = ridge(*ends)
    assert len(fold_edges(crack))
    assert fold_lengths(crack, BOX, sizing()) is None


def test_a_crack_without_folds_asks_for_none():
    gentle = ridge(0.05, 0.05, slope=0.2)
    assert not len(fold_edges(gentle)) and fold_lengths(gentle, BOX, sizing()) is None


def test_a_rough_crack_has_no_folds():
    """It has kinks everywhere; edges at all of them would be short along its whole mouth."""
    x, y = (places.ravel() for places in np.mgrid[10:31, 10:31])
    points = np.column_stack([x, y, 19.9 - np.random.default_rng(0).uniform(0, 2, len(x))]).astype(float)
    a = (21 * np.arange(20)[:, None] + np.arange(20)).ravel()
    triangles = np.concatenate([np.stack([a, a + 21, a + 22], 1), np.stack([a, a + 22, a + 1], 1)])
    assert not len(fold_edges(Crack(points, triangles, ())))
