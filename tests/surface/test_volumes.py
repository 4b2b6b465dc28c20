"""Restored volumes: every grain gets its own, and nothing else gets worse."""

import numpy as np
import pytest
from few_facets import lens
from scipy.spatial import ConvexHull

from craftmesh.errors import CraftmeshError
from craftmesh.remeshing.kernels.marching import march
from craftmesh.remeshing.remesh import RemeshOptions, remesh, voxel_volumes
from craftmesh.surface.check_surface import check_surface
from craftmesh.surface.guarded_move import MoveBounds
from craftmesh.surface.measure import area_vectors, side_volumes
from craftmesh.surface.volumes import restore_volumes
from craftmesh.surface.wedges import sharp_wedges
from craftmesh.types import CRACK, Surface, Voxels

UNRESTORED = RemeshOptions(volume_rounds=0)


def ball_in_a_box(radius=3.0, label=2, size=12):
    """A grain (or void) that smoothing shrinks, off the middle of another grain."""
    centre = np.array([size / 2 - 0.5, size / 2, size / 2])
    offset = np.moveaxis(np.indices((size,) * 3), 0, -1) + 0.5 - centre
    labels = np.where((offset**2).sum(axis=-1) < radius**2, label, 1)
    return Voxels(labels, [1.0, 1.5, 0.5], [3, -2, 0])


def drifts(surface, targets):
    volumes = side_volumes(surface.points, surface.facets, surface.sides)
    return np.array([volumes[g] / targets[g] - 1 for g in sorted(targets) if g > 0])


@pytest.mark.parametrize("radius", [1.0, 2.0, 3.0])
def test_a_small_grain_gets_its_volume_back(radius):
    """From a grain of three voxels, whose raw surface has a quarter of their volume, to 113 voxels."""
    voxels = ball_in_a_box(radius)
    surface, _ = remesh(voxels, UNRESTORED)
    targets = voxel_volumes(voxels)
    assert np.abs(drifts(surface, targets)).max() > 0.02
    restored, report = restore_volumes(surface, targets, MoveBounds(quality=0.05))
    assert np.abs(drifts(restored, targets)).max() <= 5e-4
    assert report["worst_drift_after"] <= 5e-4 < report["worst_drift_before"]
    assert check_surface(restored) == []


def test_the_displacement_is_the_same_normal_offset_all_over_a_ball():
    voxels = Voxels(ball_in_a_box(4).labels, [1, 1, 1], [0, 0, 0])
    surface, _ = remesh(voxels, UNRESTORED)
    targets = {2: side_volumes(surface.points, surface.facets, surface.sides)[2] * 1.01}
    restored, _ = restore_volumes(surface, targets, rounds=1)
    ball = np.unique(surface.facets[(surface.sides == 2).any(axis=1)])
    radius = np.cbrt(targets[2] * 3 / 4 / np.pi)
    offset = np.linalg.norm(restored.points[ball] - surface.points[ball], axis=1)
    # dV / V = 3 dr / r; facets of unequal size leave a scatter of 7% round it.
    assert offset.mean() == pytest.approx(radius * 0.01 / 3, rel=0.05)
    assert offset.std() < 0.15 * offset.mean()


def test_a_void_gets_its_volume_back():
    voxels = ball_in_a_box(2.5, label=-1)
    surface, report = remesh(voxels)
    void = surface.facets[(surface.sides == -1).any(axis=1)]
    sign = np.where(surface.sides[(surface.sides == -1).any(axis=1), 0] == -1, 1, -1)
    centred = surface.points - surface.points.mean(axis=0)
    swept = np.einsum("ij,ij->i", centred[void].mean(axis=1), area_vectors(surface.points, void)) / 3
    assert (sign * swept).sum() == pytest.approx(voxel_volumes(voxels)[-1], rel=1e-3)
    assert report["volumes"]["worst_drift_after"] <= 5e-4


def test_voids_open_to_the_outside_are_left_out():
    labels = np.ones((6, 6, 6), np.int32)
    labels[0, 2, 2], labels[3, 3, 3] = -1, -2
    assert sorted(voxel_volumes(Voxels(labels, [1, 1, 1], [0, 0, 0]))) == [-2, 1]


def test_box_planes_stay_exact_and_a_plane_boundary_moves_as_one():
    labels = np.ones((6, 6, 6), np.int32)
    labels[3:] = 2
    points, facets, sides, kind = march(labels)
    restored, _ = restore_volumes(Surface(points, facets, sides, kind), {1: 112.0, 2: 104.0})
    boundary = np.unique(facets[kind == 0])
    inner = boundary[(points[boundary, 1:] > 0).all(axis=1) & (points[boundary, 1:] < 6).all(axis=1)]
    assert np.allclose(restored.points[inner, 0], 112 / 36, atol=0.05)
    assert check_surface(restored) == []
    assert side_volumes(restored.points, facets, sides)[1] == pytest.approx(112, rel=5e-4)


def test_crack_facets_do_not_move():
    """Part of a grain boundary is marked as crack; the rest of it makes up for the volume."""
    labels = np.ones((6, 6, 6), np.int32)
    labels[3:] = 2
    points, facets, sides, kind = march(labels)
    cracked = (kind == 0) & (points[facets].mean(axis=1)[:, 1] < 3)
    kind[cracked] = CRACK
    restored, report = restore_volumes(Surface(points, facets, sides, kind), {1: 109.0, 2: 107.0})
    held = np.unique(facets[cracked])
    assert np.array_equal(restored.points[held], points[held])
    assert report["worst_drift_after"] <= 5e-4
    assert check_surface(restored) == []


def test_what_cannot_be_reached_is_left_without_damage():
    voxels = ball_in_a_box(3.0)
    surface, _ = remesh(voxels, UNRESTORED)
    restored, report = restore_volumes(surface, {2: 20 * voxels.spacing.prod() * 113}, rounds=4)
    assert check_surface(restored) == []
    assert report["worst_drift_after"] < report["worst_drift_before"]


def test_no_vertex_leaves_its_reach():
    voxels = ball_in_a_box(2.0)
    surface, _ = remesh(voxels, UNRESTORED)
    reach = np.full(len(surface.points), 0.02)
    restored, report = restore_volumes(surface, voxel_volumes(voxels), reach=reach)
    moved = np.linalg.norm(restored.points - surface.points, axis=1)
    assert 0.019 < moved.max() <= 0.02 * (1 + 1e-9)
    assert 5e-4 < report["worst_drift_after"] < report["worst_drift_before"]


def test_no_wedge_gets_sharp_where_wedges_are_kept():
    """A flat lens of 15 degrees at its rim is to lose half its volume: its rim may come to 12 degrees."""
    surface = lens(np.tan(np.radians(15)))
    volume = side_volumes(surface.points, surface.facets, surface.sides)[1]
    kept, _ = restore_volumes(surface, {1: 0.5 * volume}, MoveBounds(quality=0.0))
    assert len(sharp_wedges(surface).angle) == len(sharp_wedges(kept).angle) == 0
    assert side_volumes(kept.points, kept.facets, kept.sides)[1] < 0.95 * volume


def flat_body(seed):
    """A convex grain of 12 points, ten times as wide as high."""
    points = np.random.default_rng(seed).normal(size=(12, 3))
    points *= [1, 1, 0.1] / np.linalg.norm(points, axis=1)[:, None]
    hull = ConvexHull(points)
    inwards = np.einsum("ij,ij->i", area_vectors(points, hull.simplices), hull.equations[:, :3]) < 0
    facets = np.where(inwards[:, None], hull.simplices[:, ::-1], hull.simplices)
    return Surface(points, facets, np.tile([1, 0], (len(facets), 1)), np.zeros(len(facets)))


def test_no_facet_turns_by_more_than_60_degrees_in_a_round():
    """Flat bodies are to get four times their volume: some of them take all that a facet may turn."""
    turns = []
    for seed in range(12):
        body = flat_body(seed)
        target = 4 * side_volumes(body.points, body.facets, body.sides)[1]
        moved, _ = restore_volumes(body, {1: target}, MoveBounds(quality=0.0), rounds=1)
        before, after = (area_vectors(points, body.facets) for points in (body.points, moved.points))
        size = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
        turns.append(np.degrees(np.arccos((np.einsum("ij,ij->i", before, after) / size).min())))
    # measured: 59.3, and 73.7 without the limit
    assert 55 < max(turns) <= 60 + 1e-9


def test_nothing_to_do_returns_the_same_points():
    surface, _ = remesh(ball_in_a_box(3.0), UNRESTORED)
    volumes = side_volumes(surface.points, surface.facets, surface.sides)
    restored, report = restore_volumes(surface, volumes)
    assert np.array_equal(restored.points, surface.points) and report["rounds"] == 0


@pytest.mark.parametrize("targets", [{99: 1.0}, {1: 0.0}, {1: float("nan")}])
def test_wrong_targets_are_refused(targets):
    surface, _ = remesh(ball_in_a_box(2.0), UNRESTORED)
    with pytest.raises(CraftmeshError, match=f"grain {next(iter(targets))}"):
        restore_volumes(surface, targets)
