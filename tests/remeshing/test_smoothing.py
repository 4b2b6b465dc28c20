"""Remeshing: classes of vertices, exact boxes, no intersections whatever the volume and the spacing."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from models import voronoi
from scipy.sparse import csr_array

from craftmesh.errors import CraftmeshError
from craftmesh.remeshing.kernels.marching import march
from craftmesh.remeshing.remesh import RemeshOptions, remesh, smooth
from craftmesh.surface.check_surface import check_surface
from craftmesh.surface.classification import Classification
from craftmesh.surface.kernels.ranks import AT_JUNCTION, IN_PATCH, ON_LINE
from craftmesh.surface.measure import area_vectors, facet_angles
from craftmesh.surface.smoothing import lapped, smoothing_neighbours
from craftmesh.types import INTERFACE, Surface, Voxels


def polycrystal(seed=0, grains=7, **grid) -> Voxels:
    return voronoi(seed, grains, (14, 12, 10), **grid)


def test_classes_of_four_columns():
    """Four columns meet in one vertical line; it ends on the box with a junction at either end."""
    labels = np.ones((4, 4, 4), np.int32)
    labels[2:, :2], labels[:2, 2:], labels[2:, 2:] = 2, 3, 4
    surface = Surface(*march(labels))
    points, classes = surface.points, Classification(surface)
    corners = classes.held.all(axis=1)
    assert np.array_equal(
        np.sort(points[corners], axis=0),
        np.sort(np.array(np.meshgrid(*[[0, 4]] * 3)).reshape(3, 8).T, axis=0),
    )
    inside = (points > 0).all(axis=1) & (points < 4).all(axis=1)
    middle = inside & (np.abs(points[:, :2] - 2).max(axis=1) < 1e-9)
    assert (classes.rank[middle] == ON_LINE).all() and middle.sum() >= 3
    assert (classes.rank[inside & ~middle] == IN_PATCH).all()
    end = (np.abs(points - (2, 2, 0)) < 1e-9).all(axis=1)
    assert classes.rank[end] == [AT_JUNCTION] and classes.held[end].tolist() == [[False, False, True]]


def test_points_are_drawn_to_the_mean_of_their_neighbours():
    """Sawtooth smoothing of the paper's Eq. 1 goes half of the way along a line."""
    points = np.array([[0, 0, 0], [1, 1, 0], [2, -1, 0], [3, 0, 0]], float)
    drawn = csr_array((np.ones(4), ([1, 1, 2, 2], [0, 2, 1, 3])), (4, 4))
    expected = points.copy()
    for i in (1, 2):
        expected[i] = (points[i - 1] + points[i + 1]) / 4 + points[i] / 2
    stays = np.zeros(points.shape, bool)
    assert np.allclose(lapped(points, [0.5], drawn, stays), expected, atol=1e-15)


def test_lines_are_drawn_along_lines_only():
    voxels = polycrystal()
    classes = Classification(Surface(*march(voxels.labels)))
    drawn = smoothing_neighbours(classes)
    line_edges = {tuple(e) for e in classes.features.lines.tolist()}
    for v in np.flatnonzero(classes.rank == ON_LINE):
        ends = drawn[[v]].nonzero()[1].tolist()
        assert len(ends) == 2
        assert all((min(v, w), max(v, w)) in line_edges for w in ends)


@settings(max_examples=15)
@given(st.integers(0, 2**32 - 1))
def test_noise_ends_free_of_intersections_with_exact_planes(seed):
    rng = np.random.default_rng(seed)
    labels = np.kron(rng.integers(1, 9, rng.integers(2, 5, 3)), np.ones((2, 2, 2))).astype(np.int32)
    holes = rng.random(labels.shape) < 0.1
    labels[holes] = rng.integers(0, 9, holes.sum())
    labels[0, 0, 0] = 1
    voxels = Voxels(labels, rng.random(3) + 0.3, rng.normal(size=3))
    surface, _ = remesh(voxels)
    assert check_surface(surface) == []
    for plane in range(1, 7):
        axis, upper = divmod(plane - 1, 2)
        used = surface.facets[surface.kind == plane]
        assert (surface.points[used, axis] == voxels.box[upper, axis]).all()


def test_smoothing_flattens_the_steps_of_a_plane():
    """Raw facets of the tilted plane are up to 45 degrees off; 4 degrees is the mean in polycrystals."""
    x, y, z = np.indices((16, 16, 16)) + 0.5
    normal = np.array([0.2, 0.35, 1]) / np.linalg.norm([0.2, 0.35, 1])
    labels = np.where(0.2 * x + 0.35 * y + z < 12, 1, 2)
    surface, _ = remesh(Voxels(labels, [1, 1, 1], [0, 0, 0]))
    inside = surface.kind == INTERFACE
    centre = surface.points[surface.facets].mean(axis=1)
    inside &= (centre > 2).all(axis=1) & (centre < 14).all(axis=1)
    vectors = area_vectors(surface.points, surface.facets)[inside]
    cosine = np.abs(vectors @ normal) / np.linalg.norm(vectors, axis=1)
    assert np.degrees(np.arccos(cosine.clip(max=1))).mean() < 4


def test_smoothing_does_not_depend_on_spacing_and_origin():
    options = RemeshOptions(volume_rounds=0)
    plain, _ = remesh(polycrystal(), options)
    stretched, _ = remesh(polycrystal(spacing=(2, 0.5, 1), origin=(5, -3, 1)), options)
    assert np.array_equal(plain.facets, stretched.facets)
    assert np.allclose(plain.points * (2, 0.5, 1) + (5, -3, 1), stretched.points, atol=1e-12)


def test_without_laps_the_raw_surface_comes_back():
    raw = Surface(*march(polycrystal().labels))
    smoothed, frozen = smooth(raw, RemeshOptions(laplace_laps=0, taubin_laps=0))
    assert np.array_equal(raw.points, smoothed) and frozen == 0


def test_slivers_go_back_to_the_checkpoint():
    """With a high limit many facets go back; those left are no worse than raw facets or the limit."""
    voxels = polycrystal(3, grains=30)
    surface, report = remesh(voxels, RemeshOptions(sliver_quality=0.5, volume_rounds=0))
    assert report["frozen_points"] > 0
    # Raw facets have angles from 25 degrees on; q = 0.5 still admits one of 16 degrees.
    assert facet_angles(surface.points, surface.facets).min() > 12


def test_same_input_same_bytes():
    first, second = (remesh(polycrystal(1))[0] for _ in range(2))
    assert first.points.tobytes() == second.points.tobytes()
    assert first.facets.tobytes() == second.facets.tobytes()


def test_a_volume_without_grains_is_refused():
    with pytest.raises(CraftmeshError, match="no label > 0"):
        remesh(Voxels(np.zeros((3, 3, 3)), [1, 1, 1], [0, 0, 0]))


def test_steel_with_anisotropic_voxels(shared_data):
    data = np.load(shared_data / "al6xn/prisms_al6xn_68x64x46.npz")
    voxels = Voxels(data["labels"][:34, :32], data["spacing"], data["origin"])
    surface, report = remesh(voxels)
    assert check_surface(surface) == []
    assert report["volumes"]["worst_drift_after"] < 0.03


def test_voids_open_to_the_outside_do_not_keep_the_smoothing_from_ending():
    """Such a void's facets are not all kept, so its volume by the divergence theorem may be negative."""
    labels = np.random.default_rng(4).choice([-2, -1, 0, 1, 2, 3], (8, 2, 4)).astype(np.int32)
    surface, report = remesh(Voxels(labels, [1, 1, 1], [0, 0, 0]))
    assert len(surface.grains) == 3
    assert report["volumes"]["worst_drift_after"] < 0.03


def test_points_that_smoothing_takes_far_off_their_voxels_are_noted():
    voxels = voronoi(2, 3, (16, 16, 16))
    _, usual = remesh(voxels)
    _, far = remesh(voxels, RemeshOptions(laplace_laps=150, taubin_laps=0))
    assert usual["largest_move_voxels"] < 1 and "notes" not in usual
    assert far["largest_move_voxels"] > 1.75 and "over 1.75, a voxel's diagonal" in far["notes"][0]
