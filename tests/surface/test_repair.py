"""A surface whose facets intersect is repaired once for all grains that share it."""

import numpy as np
import pytest
from structured_box import structured_box

from craftmesh.remeshing.remesh import RemeshOptions, remesh
from craftmesh.surface.check_surface import check_surface
from craftmesh.surface.classification import Classification
from craftmesh.surface.kernels.ranks import AT_JUNCTION
from craftmesh.surface.repair import faulty_facets, repair_surface
from craftmesh.tetrahedra.options import TetrahedralizeOptions
from craftmesh.tetrahedra.tetrahedralize import tetrahedralize
from craftmesh.types import CRACK, Surface
from craftmesh.voxels.generate import GenerateOptions, generate


@pytest.fixture(scope="module")
def sound():
    surface, _ = remesh(generate(GenerateOptions(shape=(16, 15, 14), grains=6)), RemeshOptions())
    assert check_surface(surface) == []
    return surface


def with_points(surface, points):
    return Surface(points, surface.facets, surface.sides, surface.kind)


def pulled(surface, rank, seed, by=1.5):
    """The surface with a vertex of the rank, off the box, pulled so far that facets intersect."""
    rng = np.random.default_rng(seed)
    classes = Classification(surface)
    candidates = np.flatnonzero((classes.rank == rank) & ~classes.held.any(axis=1))
    for _ in range(200):
        points = surface.points.copy()
        vertex, way = rng.choice(candidates), rng.normal(size=3)
        points[vertex] += by * way / np.linalg.norm(way)
        if faulty_facets(points, surface.facets.astype(np.int64)).any():
            return with_points(surface, points), vertex
    raise AssertionError("nothing intersects")


def test_a_sound_surface_comes_back_as_it_is(sound):
    repaired, report = repair_surface(sound)
    assert repaired is sound and report == {"faults": 0}


@pytest.mark.parametrize("rank", [0, 1])
@pytest.mark.parametrize("seed", range(4))
def test_a_pulled_vertex_goes_back_and_all_grains_mesh(sound, rank, seed):
    broken, vertex = pulled(sound, rank, seed)
    repaired, report = repair_surface(broken)
    assert report["faults"] > 0 and report["faults_left"] == 0
    assert check_surface(repaired) == []
    moved = np.flatnonzero((repaired.points != broken.points).any(axis=1))
    largest = np.linalg.norm(repaired.points - broken.points, axis=1).max()
    assert report["largest_move"] == largest and 0.5 * largest < report["largest_move_edges"] < 3 * largest
    # a few vertices around the pulled one, and no other
    assert vertex in moved and len(moved) == report["points_moved"] < 60
    near = np.linalg.norm(sound.points[moved] - sound.points[vertex], axis=1)
    assert near.max() < 6
    classes = Classification(sound)
    assert np.array_equal(repaired.points[classes.held], broken.points[classes.held])
    assert not (classes.rank[vertex] == AT_JUNCTION)
    again, _ = repair_surface(broken)
    assert again.points.tobytes() == repaired.points.tobytes()
    if seed == 0:
        options = TetrahedralizeOptions(optimise=False, interior_points=False)
        done, _ = tetrahedralize(repaired, None, options)
        assert len(done) == len(sound.grains)


def test_degenerate_facets_get_an_area():
    surface = structured_box((3, 3, 3), lambda c: np.where(c[:, 0] < 1, 1, 2))[0]
    points = surface.points.copy()
    centre, beside = (np.flatnonzero((points == [1, y, 1]).all(axis=1))[0] for y in (1, 2))
    points[centre] = points[beside]
    broken = with_points(surface, points)
    repaired, report = repair_surface(broken)
    assert report["faults"] > 0 and report["faults_left"] == 0
    assert check_surface(repaired) == []


def test_points_of_the_crack_stay(sound):
    surface = structured_box(
        (4, 4, 4),
        lambda c: np.where(c[:, 0] < 2, 1, 2),
        lambda centres, normals: (normals[:, 2] > 0.9) & (centres[:, 2] == 2) & (centres[:, 1] < 2),
    )[0]
    crack = np.unique(surface.facets[surface.kind == CRACK])
    points = surface.points.copy()
    boundary = np.flatnonzero((points == [2, 3, 1]).all(axis=1))[0]
    points[boundary] = [2.6, 1.4, 2.5]
    broken = with_points(surface, points)
    repaired, report = repair_surface(broken)
    assert len(crack) and report["faults"] > 0 and report["faults_left"] == 0
    assert np.array_equal(repaired.points[crack], broken.points[crack])


def test_what_cannot_be_repaired_comes_back_with_its_faults(sound):
    surface = structured_box((1, 1, 1), lambda c: np.ones(len(c), int))[0]
    points = np.concatenate([surface.points, [[0.5, 0.4, 0.5], [1.5, 0.5, 0.4], [0.6, 0.6, 0.6]]])
    facets = np.concatenate([surface.facets, [[8, 9, 10]]])
    sides, kind = np.concatenate([surface.sides, [[1, 1]]]), np.append(surface.kind, CRACK)
    broken = Surface(points, facets, sides, kind)
    repaired, report = repair_surface(broken)
    assert report["faults_left"] == report["faults"] > 0
    assert repaired.points.tobytes() == broken.points.tobytes()
