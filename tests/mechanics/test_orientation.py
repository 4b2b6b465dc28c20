"""Orientations: the conversions mean what they say, and agree with scipy's Rotation."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from craftmesh.mechanics.orientation import (
    angle_between,
    bunge_to_quaternion,
    matrix_to_quaternion,
    mean_by_grain,
    normalized,
    quaternion_to_matrix,
    random_orientations,
    rodrigues_to_quaternion,
)

ANGLES = np.array([[0.0, 0.0, 0.0], [0.3, 0.7, 1.1], [2.0, 1.0, 4.0], [5.0, 2.5, 0.2]])


def as_rotation(quaternions):
    return Rotation.from_quat(quaternions, scalar_first=True)


def test_bunge_angles_against_the_matrix_of_bunge():
    phi1, Phi, phi2 = ANGLES[3]

    def about(axis, angle):
        i, j = [k for k in range(3) if k != axis]
        g = np.eye(3)
        g[i, i] = g[j, j] = np.cos(angle)
        g[i, j], g[j, i] = np.sin(angle), -np.sin(angle)
        return g

    g = about(2, phi2) @ about(0, Phi) @ about(2, phi1)  # sample to crystal
    np.testing.assert_allclose(quaternion_to_matrix(bunge_to_quaternion(ANGLES[3])), g.T, atol=1e-14)


def test_rodrigues_vector_turns_about_its_axis():
    quarter_turn = quaternion_to_matrix(rodrigues_to_quaternion([0, 0, 1.0]))
    np.testing.assert_allclose(quarter_turn @ [1, 0, 0], [0, 1, 0], atol=1e-15)


def test_normalizing_again_changes_no_bit():
    q = random_orientations(2000, np.random.default_rng(2))
    np.testing.assert_array_equal(normalized(q), q)


def test_mean_orientation_ignores_the_sign_of_quaternions():
    q = random_orientations(2, np.random.default_rng(1))
    table, spread = mean_by_grain(np.array([1, 1, 3]), np.stack([q[0], -q[0], q[1]]))
    np.testing.assert_allclose(table[[1, 3]], q, atol=1e-12)
    assert np.isnan(table[[0, 2]]).all()
    assert spread < 1e-5


def test_matrices_of_two_decimals_are_rotations_and_others_are_not():
    turns = quaternion_to_matrix(random_orientations(50, np.random.default_rng(3)))
    found = quaternion_to_matrix(matrix_to_quaternion(turns))
    np.testing.assert_allclose(found, turns, atol=1e-12)
    # rounding of 0.0005 in nine places
    np.testing.assert_allclose(quaternion_to_matrix(matrix_to_quaternion(turns.round(3))), turns, atol=2e-3)
    others = [-turns, turns[:, ::-1], 1.02 * turns, turns + [[0, 0.03, 0], [0, 0, 0], [0, 0, 0]]]
    for each in others:  # reflections, lengths of 1.02, axes 1.7 degrees off their right angle
        assert np.isnan(matrix_to_quaternion(each)).all(axis=1).mean() > 0.9
    assert matrix_to_quaternion(np.zeros((0, 3, 3))).shape == (0, 4)


@pytest.mark.parametrize("degrees", [0.5, 4.0, 30.0])
def test_the_spread_is_the_angle_by_which_two_halves_of_a_grain_are_off_their_mean(degrees):
    turns = Rotation.from_quat(bunge_to_quaternion(ANGLES[1]), scalar_first=True)
    axis = np.array([1.0, -2.0, 2.0]) / 3
    halves = [turns * Rotation.from_rotvec(np.radians(sign * degrees) * axis) for sign in (-1, 1)]
    q = np.stack([half.as_quat(scalar_first=True) for half in halves])
    table, spread = mean_by_grain(np.array([0, 1, 1]), np.concatenate([q[:1], q]))
    assert as_rotation(table[1]).as_matrix() == pytest.approx(turns.as_matrix(), abs=1e-12)
    assert spread == pytest.approx(degrees)


def test_conversions_agree_with_scipy():
    rng = np.random.default_rng(4)
    angles = np.concatenate([ANGLES, rng.uniform(0, [2 * np.pi, np.pi, 2 * np.pi], (500, 3))])
    quaternions = bunge_to_quaternion(angles)
    wanted = Rotation.from_euler("ZXZ", angles)
    np.testing.assert_allclose(quaternion_to_matrix(quaternions), wanted.as_matrix(), atol=1e-12)
    np.testing.assert_allclose(quaternions, wanted.as_quat(canonical=True, scalar_first=True), atol=1e-12)
    vectors = rng.normal(size=(500, 3))
    half = np.arctan(np.linalg.norm(vectors, axis=1))
    turned = Rotation.from_rotvec(2 * half[:, None] * vectors / np.linalg.norm(vectors, axis=1)[:, None])
    np.testing.assert_allclose(
        quaternion_to_matrix(rodrigues_to_quaternion(vectors)), turned.as_matrix(), atol=1e-12
    )


@pytest.mark.parametrize("degrees", [0.0, 1e-7, 1e-3, 1.0, 90.0, 179.9])
def test_the_angle_is_that_of_the_turn_between(degrees):
    first = random_orientations(50, np.random.default_rng(5))
    turn = Rotation.from_rotvec(np.radians(degrees) * np.array([2 / 3, -1 / 3, 2 / 3]))
    second = -(as_rotation(first) * turn).as_quat(scalar_first=True)  # q and -q are one rotation
    np.testing.assert_allclose(angle_between(first, second), degrees, rtol=1e-12, atol=1e-10)


def test_random_orientations_have_no_preferred_direction():
    matrices = quaternion_to_matrix(random_orientations(20000, np.random.default_rng(6)))
    assert np.abs(matrices.mean(axis=0)).max() < 4 / np.sqrt(3 * 20000)
    trace = np.trace(matrices, axis1=1, axis2=2)
    assert trace.mean() == pytest.approx(0, abs=4 / np.sqrt(20000))
