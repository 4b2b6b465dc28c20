"""Multi-material marching cubes: topology and volumes on noise, scikit-image as oracle on two labels."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_topology import tied_vertices
from skimage.measure import marching_cubes

from craftmesh.remeshing.kernels.marching import march
from craftmesh.surface.check_surface import check_surface
from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.measure import side_volumes
from craftmesh.types import INTERFACE, Surface

SEEDS = st.integers(0, 2**32 - 1)


def noise(seed, lowest=1):
    """A random volume of 1..7 voxels a side, half of them with blocks of 2 x 2 x 2 equal voxels."""
    rng = np.random.default_rng(seed)
    labels = rng.integers(lowest, rng.integers(2, 14), rng.integers(1, 6, 3)).astype(np.int32)
    if rng.random() < 0.5:
        labels = np.kron(labels, np.ones((2, 2, 2), np.int32))
    labels[0, 0, 0] = 1
    return labels


@settings(max_examples=60)
@given(SEEDS)
def test_noise_gives_closed_untied_grains_that_fill_the_box(seed):
    labels = noise(seed)
    surface = Surface(*march(labels))
    assert check_surface(surface) == []
    assert tied_vertices(surface) == {}
    volumes = side_volumes(surface.points, surface.facets, surface.sides)
    assert sorted(volumes) == np.unique(labels).tolist()
    assert sum(volumes.values()) == pytest.approx(labels.size, rel=1e-12)


@settings(max_examples=30)
@given(SEEDS)
def test_every_edge_of_a_grain_has_two_facets(seed):
    surface = Surface(*march(noise(seed)))
    for grain in surface.grains:
        mine = surface.facets[(surface.sides == grain).any(axis=1)]
        assert (unique_edges(mine)[2] == 2).all()


@settings(max_examples=30)
@given(SEEDS)
def test_open_exterior_keeps_the_grains_closed(seed):
    labels = noise(seed, lowest=0)
    surface = Surface(*march(labels))
    assert check_surface(surface) == []
    assert (surface.sides.max(axis=1) > 0).all() and (surface.sides >= 0).all()


def test_box_planes_are_exact_and_their_facets_say_so():
    labels = noise(7)
    points, facets, sides, kind = march(labels)
    outside = sides.min(axis=1) == 0
    assert (outside == (kind != INTERFACE)).all()
    for plane in range(1, 7):
        axis, upper = divmod(plane - 1, 2)
        level = labels.shape[axis] if upper else 0
        on_plane = points[facets[kind == plane]]
        assert len(on_plane) and (on_plane[:, :, axis] == level).all()
        area = np.cross(on_plane[:, 1] - on_plane[:, 0], on_plane[:, 2] - on_plane[:, 0])[:, axis] / 2
        assert np.abs(area).sum() == pytest.approx(labels.size / labels.shape[axis], rel=1e-12)


def test_an_enclosed_void_keeps_its_label():
    labels = np.ones((6, 6, 6), np.int32)
    labels[2:4, 2:4, 2:4] = -3
    surface = Surface(*march(labels))
    assert check_surface(surface) == []
    void = (surface.sides == -3).any(axis=1)
    assert void.any() and (surface.kind[void] == INTERFACE).all()


@settings(max_examples=40)
@given(SEEDS)
def test_two_labels_agree_with_scikit_image(seed):
    """On ambiguous faces `lorensen` cuts off the larger values, we the label with more voxels: 1."""
    rng = np.random.default_rng(seed)
    labels = np.ones((8, 8, 8), np.int32)
    inner = rng.random((6, 6, 6)) < rng.uniform(0.1, 0.4)
    labels[1:-1, 1:-1, 1:-1][inner] = 2
    if not inner.any():
        return
    points, facets, _, kind = march(labels)
    between = facets[kind == INTERFACE]
    theirs = marching_cubes((labels == 1).astype(float), 0.5, method="lorensen")
    ours = np.unique(points[np.unique(between)], axis=0)
    vertices = np.unique(np.round(theirs[0].astype(float) + 0.5, 6), axis=0)
    assert np.array_equal(ours, vertices) and len(between) == len(theirs[1])
    assert euler_number(between) == euler_number(theirs[1])


def euler_number(facets):
    return len(np.unique(facets)) - len(unique_edges(facets)[0]) + len(facets)


def test_results_do_not_depend_on_the_numbering_of_grains():
    """Grains of distinct volumes, with ambiguous faces, under two numberings."""
    rng = np.random.default_rng(5)
    labels = np.searchsorted([0.1, 0.25, 0.45, 0.7], rng.random((9, 8, 7))).astype(np.int32) + 1
    assert len(set(np.bincount(labels.ravel())[1:])) == 5
    points, facets, sides, kind = march(labels)
    renamed = march(100 - 7 * labels)
    assert np.array_equal(points, renamed[0]) and np.array_equal(facets, renamed[1])
    assert np.array_equal(np.where(sides > 0, 100 - 7 * sides, 0), renamed[2])
    assert np.array_equal(kind, renamed[3])
