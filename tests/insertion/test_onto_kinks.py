"""Edges of crack facets follow the kinks of the true crack: swapped or parted, nothing turned over."""

from dataclasses import replace

import numpy as np
import pytest

from craftmesh.cracks.near_sheet import NearSheet
from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.insertion.cut import uncut
from craftmesh.insertion.onto_kinks import onto_kinks
from craftmesh.insertion.options import InsertOptions
from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.measure import area_vectors
from craftmesh.types import CRACK, Surface

BOX = np.array([[-9.0, -9, -9], [9, 9, 9]])


def fold(degrees: float) -> NearSheet:
    """A sheet folded by so many degrees along the y axis, up on both sides."""
    x, z = np.cos(np.radians(degrees / 2)), np.sin(np.radians(degrees / 2))
    points = np.array([[4 * s * abs(x), y, 4 * abs(s) * z] for s in (-1, 0, 1) for y in (-4, 4)])
    triangles = np.array([[0, 2, 1], [1, 2, 3], [2, 4, 3], [3, 4, 5]])
    return NearSheet(crack_from_triangles(points, triangles, None, BOX, heights=False), BOX)


def facets_across(look: NearSheet, off: float):
    """Two facets on an edge across the fold, whose other corners are `off` the kink on either limb."""
    up, down = (look.points[[5, 1]] - look.points[3]) / 4.0  # a limb is 4 long
    points = np.array([0.5 * down, 0.5 * up, [0, -0.6, 0], [0, 0.6, 0]])
    points[2:] += off * up
    surface = Surface(
        points, np.array([[0, 1, 2], [1, 0, 3]], np.int32), np.ones((2, 2), np.int32), np.full(2, CRACK)
    )
    return replace(uncut(surface), size=np.ones(4))


def edges_of(surface) -> list:
    return unique_edges(surface.facets)[0].tolist()


def farthest(surface, look: NearSheet) -> float:
    corners = surface.points[surface.facets]
    return float(np.abs(look.look(np.concatenate([corners.mean(axis=1), *corners])).psi).max())


@pytest.mark.parametrize("degrees", [20.0, 60.0, 110.0])
def test_an_edge_between_points_on_the_kink_takes_the_place_of_one_across(degrees):
    look = fold(degrees)
    before = facets_across(look, 0.0)
    assert look.kinks.tolist() == [[2, 3]] and [0, 1] in edges_of(before)
    assert farthest(before, look) > 0.02
    after = onto_kinks(before, 0, look, InsertOptions())
    assert np.array_equal(after.points, before.points)
    assert [2, 3] in edges_of(after) and [0, 1] not in edges_of(after)
    assert farthest(after, look) < 1e-12
    up = [area_vectors(s.points, s.facets)[:, 2] for s in (before, after)]
    assert (np.sign(up[0]) == np.sign(up[1])).all()


@pytest.mark.parametrize("degrees", [20.0, 60.0, 110.0])
def test_an_edge_across_is_parted_on_the_kink(degrees):
    look = fold(degrees)
    before = facets_across(look, 0.4)
    after = onto_kinks(before, 0, look, InsertOptions())
    assert len(after.facets) > 2 and np.array_equal(after.points[:4], before.points)
    assert np.abs(after.points[4:][:, [0, 2]]).max() < 1e-12
    assert farthest(after, look) < 1e-12 < 0.02 < farthest(before, look)
    up = [np.sign(area_vectors(s.points, s.facets)[:, 2]) for s in (before, after)]
    assert len(np.unique(np.concatenate(up))) == 1


def test_a_smooth_sheet_has_no_kinks():
    look = fold(10.0)
    before = facets_across(look, 0.0)
    assert not len(look.kinks)
    assert onto_kinks(before, 0, look, InsertOptions()) is before
