"""Vertices that have left the grain boundaries of a reference come back onto those of their labels."""

from dataclasses import replace

import numpy as np
import pytest
from models import with_voids

from craftmesh.gradation.patch_reference import REACH, _boundaries, put_on_patches
from craftmesh.sizing.sizing import Sizing
from craftmesh.surface.classification import Classification
from craftmesh.surface.measure import nearest_facet
from craftmesh.types import BORDER, CRACK

PLAIN = with_voids(16, 5, 4, 1.8, (0.0, 0.0, 0.0))
FREE = Classification(PLAIN).free


def sizes(length):
    return Sizing(length, length, length, 1.0, 2.0, 1.0, np.zeros((0, 3)))


def off_patches(surface):
    """Each vertex' largest distance from the facets of PLAIN between the labels of one of its patches."""
    off = np.zeros(len(surface.points))
    given = _boundaries(PLAIN)
    for labels, facets in _boundaries(surface).items():
        rows = np.unique(facets)
        away = nearest_facet(surface.points[rows], PLAIN.points, given[labels])[1]
        off[rows] = np.maximum(off[rows], away)
    return off


@pytest.fixture(scope="module")
def moved():
    way = np.random.default_rng(1).normal(0, 0.04, PLAIN.points.shape)
    return replace(PLAIN, points=PLAIN.points + np.where(FREE, way, 0))


def test_vertices_come_back_onto_the_patches_of_their_labels(moved):
    before, after = off_patches(moved), off_patches(put_on_patches(moved, PLAIN, sizes(1.0)))
    rank = Classification(PLAIN).rank
    assert {label for labels in _boundaries(PLAIN) for label in labels} >= {-1, -2}
    for k in range(3):
        chosen = (rank == k) & (before > 0)
        assert after[chosen].mean() < 0.2 * before[chosen].mean()


def test_what_is_on_the_patches_stays_and_no_move_is_over_the_reach(moved):
    back = put_on_patches(PLAIN, PLAIN, sizes(1.0))
    assert np.allclose(back.points, PLAIN.points, atol=1e-12)
    way = put_on_patches(moved, PLAIN, sizes(0.1)).points - moved.points
    assert np.linalg.norm(way, axis=1).max() == pytest.approx(0.1 * REACH)


@pytest.mark.parametrize("kind", [CRACK, BORDER])
def test_box_planes_the_crack_and_the_border_are_kept(moved, kind):
    kinds = moved.kind.copy()
    kinds[(moved.sides == 1).any(axis=1) & (kinds == 0)] = kind
    part = replace(moved, kind=kinds)
    back = put_on_patches(part, PLAIN, sizes(1.0))
    stays = np.unique(part.facets[kinds == kind])
    assert len(stays) and np.array_equal(back.points[stays], moved.points[stays])
    assert (back.points != moved.points).any()
    assert np.array_equal(back.points[~FREE], moved.points[~FREE])
