"""Frames along the front: smooth tangents, normals of the crack at its front, grains, ends, sizes."""

from dataclasses import fields

import numpy as np
import pytest
from structured_box import plane_crack, structured_box
from warped_cracks import cap_crack, disc_crack, moved

from craftmesh.assembly.assemble import assemble
from craftmesh.mesh.cubic_basis import CubicBasis, graded_basis
from craftmesh.mesh.front_curve import front_curve
from craftmesh.mesh.front_frames import front_frames
from craftmesh.mesh.second_order import raise_order


def angles(first, second):
    sine = np.linalg.norm(np.cross(first, second), axis=1)
    return np.degrees(np.arctan2(sine, (first * second).sum(axis=1)))


def test_normals_of_a_cap_are_those_at_its_rim():
    tilt = np.radians(30)
    frames = front_frames(cap_crack(10, 2, 2, tilt))
    outward = frames.points[:, :2] / np.linalg.norm(frames.points[:, :2], axis=1, keepdims=True)
    exact = np.column_stack([np.sin(tilt) * outward, np.full(len(outward), np.cos(tilt))])
    # facets that touch the front are tilted by 1.6 degrees less; the quadric leaves out cubic terms
    assert angles(frames.normal, exact).max() < 0.15
    assert angles(frames.tangent, np.column_stack([-outward[:, 1], outward[:, 0], 0 * tilt * outward[:, 0]])
                  ).max() < 0.1  # fmt: skip


def test_a_kink_behind_the_front_does_not_turn_its_normals():
    mesh = disc_crack(10, 2, 2)
    r = np.linalg.norm(mesh.points[:, :2], axis=1)
    kink = np.array(mesh.points)
    kink[:, 2] += np.maximum(r - 0.75, 0)  # 45 degrees, 2.5 edges behind the front
    frames = front_frames(moved(mesh, kink))
    out = frames.points[:, :2] / np.linalg.norm(frames.points[:, :2], axis=1, keepdims=True)
    exact = np.column_stack([-out, np.ones(len(out))]) / np.sqrt(2)
    assert angles(frames.normal, exact).max() < 0.5


@pytest.mark.parametrize("closed", [True, False])
def test_curves_follow_a_circle_of_uneven_nodes(closed):
    rng = np.random.default_rng(1)
    spacing = rng.uniform(0.4, 1.6, 63)
    angle = 2 * np.pi * np.cumsum(spacing) / spacing.sum() * (1 if closed else 0.5)
    points = 10 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    normals = np.tile([0.0, 0.0, 1.0], (63, 1))
    curve = front_curve(points, normals, closed)
    at = np.linspace(0, curve.length, 500)
    place, tangent, normal, binormal = curve.frames(at)
    assert np.abs(np.linalg.norm(place, axis=1) - 10).max() < 0.01  # of an edge of 1
    radial = place / 10
    assert angles(tangent, np.cross([0, 0, 1], radial)).max() < 0.3
    assert np.allclose(normal, [0, 0, 1]) and np.allclose(binormal, np.cross(tangent, normal))
    if not closed:
        assert np.allclose(place[[0, -1]], points[[0, -1]], atol=1e-4)


def test_curves_follow_the_sharp_ends_of_an_ellipse():
    """Ellipse 25:6 with nodes about a third of its least radius apart, as fine as where it is blunt."""
    rng = np.random.default_rng(3)
    fine = np.linspace(0, 2 * np.pi, 20001)
    line = np.stack([12.5 * np.cos(fine), 3 * np.sin(fine), 0 * fine], axis=1)
    arc = np.append(0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1)))
    steps = rng.uniform(0.8, 1.2, 220)
    angle = np.interp(np.cumsum(steps) / steps.sum() * arc[-1], arc, fine)
    points = np.stack([12.5 * np.cos(angle), 3 * np.sin(angle), 0 * angle], axis=1)
    curve = front_curve(points, np.tile([0.0, 0.0, 1.0], (220, 1)), True)
    place, tangent, _, _ = curve.frames(np.linspace(0, curve.length, 2000))
    turn = np.arctan2(place[:, 1] / 3, place[:, 0] / 12.5)
    exact = np.stack([-12.5 * np.sin(turn), 3 * np.cos(turn), 0 * turn], axis=1)
    exact /= np.linalg.norm(exact, axis=1)[:, None]
    # 1.6 degrees; 2.4 with pieces as long as where the front is blunt
    assert angles(tangent, exact).max() < 2.0


@pytest.mark.parametrize("count", [2, 3, 4])
def test_short_fronts_have_curves(count):
    points = np.stack([np.arange(count), np.zeros(count), np.zeros(count)], axis=1).astype(float)
    curve = front_curve(points, np.tile([0.0, 0.0, 1.0], (count, 1)), False)
    place, tangent, normal, _ = curve.frames(np.arange(count, dtype=float))
    assert np.allclose(place, points, atol=1e-5) and np.allclose(tangent, [1, 0, 0], atol=1e-5)
    assert np.allclose(normal, [0, 0, 1])


def test_splines_are_smooth_across_the_seam_and_their_pieces_are_themselves():
    basis = CubicBasis(np.array([0.0, 1.0, 2.5, 3.0, 4.2, 5.0]), True)
    values = np.random.default_rng(0).normal(size=(basis.size, 1))
    pieces = basis.pieces(values)
    steps = np.diff(basis.breaks)
    for slope in range(3):
        ends = np.array([np.polyval(np.polyder(c, slope), h) for c, h in zip(pieces.c[:, :, 0].T, steps)])
        assert np.allclose(ends, np.roll(pieces(basis.breaks[:-1], slope)[:, 0], -1))
    at = basis.breaks[:-1] + 0.3 * steps
    assert np.allclose(basis.design(at) @ values, pieces(at))


def test_pieces_follow_the_local_sizes():
    s = np.array([0.0, 1, 2, 3, 4, 4.5, 5, 5.5, 6])
    sizes = np.where(s < 4, 1.0, 0.5)
    steps = np.diff(graded_basis(s, sizes, 6.0, False, 2.0).breaks)
    assert steps[0] == pytest.approx(2.0, rel=0.2) and steps[-1] == pytest.approx(1.0, rel=0.2)


def edge_crack():
    """A crack from x = 0 to x = 2 through a box of two grains that meet in y = 2."""
    inside = plane_crack(2, 2, lambda c: c[:, 0] < 2)
    return assemble(*structured_box((4, 4, 4), lambda c: np.where(c[:, 1] < 2, 7, 3), inside))[0]


def test_grains_pierce_points_and_ends_are_told():
    frames = front_frames(edge_crack())
    y = frames.points[:, 1]
    along = np.append(y[1:] + y[:-1], y[-1] + y[-2]) / 2
    assert (frames.grain == np.where(along < 2, 7, 3)).all()
    assert (frames.pierce == (y == 2)).all()
    assert frames.end.tolist() == [1, 0, 0, 0, 1]
    assert set(frames.face[[0, -1]]) == {"YMIN", "YMAX"} and (frames.face[1:-1] == "").all()
    assert np.allclose(frames.size, 1)


def test_an_end_on_a_void_names_it():
    def label_of(centres):
        return np.where((abs(centres - [3, 5, 2]) < 1).all(axis=1), -4, 1)

    inside = plane_crack(2, 2, lambda c: c[:, 0] < 3)
    frames = front_frames(assemble(*structured_box((5, 6, 4), label_of, inside))[0])
    assert "VOID_4" in frames.face.tolist()


def test_mid_nodes_lie_between_the_corners():
    linear = disc_crack(3, 1, 1)
    assert (front_frames(linear).mid_node == -1).all()
    mesh = raise_order(linear)
    frames = front_frames(mesh)
    ahead = np.roll(frames.points, -1, axis=0)
    assert np.allclose(mesh.points[frames.mid_node], (frames.points + ahead) / 2)
    assert (frames.columns()["mid_node"] == frames.mid_node + 1).all()
    open_ended = front_frames(raise_order(edge_crack()))
    assert open_ended.columns()["mid_node"][-1] == 0


def test_without_a_crack_there_is_no_row():
    mesh, _ = assemble(*structured_box((2, 2, 2), lambda c: np.ones(len(c), int)))
    frames = front_frames(mesh)
    assert all(len(getattr(frames, field.name)) == 0 for field in fields(frames))
