"""Kink angles by the near field of the crystal: isotropic ones are known, crystals have symmetries."""

import numpy as np
import pytest

from craftmesh.errors import CraftmeshError
from craftmesh.growth.extension import kinks_and_extensions
from craftmesh.growth.front_points import FrontPoints
from craftmesh.growth.kink_angle import (
    kink_angles,
    largest_near_stress,
    opened,
    tangential_intensity,
    tangential_stress,
)
from craftmesh.growth.options import GrowthOptions
from craftmesh.mechanics.materials import Material, turned
from craftmesh.mechanics.orientation import quaternion_to_matrix, random_orientations

COPPER = Material("cubic", (168.4, 121.4, 75.4)).stiffness()
ISOTROPIC = Material("isotropic", (70.0, 0.3)).stiffness()
HALF_TURN = np.diag([1.0, -1.0, -1.0])  # about the binormal


def test_in_isotropic_materials_it_is_the_known_angle():
    k = np.array([[1, 0, 0], [1, 0.5, 0.3], [0.2, -1, 0], [0, 1, 0], [0, 0, 0.0]])
    angle, driving = largest_near_stress(k, np.repeat(ISOTROPIC[None], len(k), axis=0))
    known = kink_angles(k, "tangential_stress", 0.3)
    # the search steps by 0.25 degrees, and a parabola leaves 1e-3
    assert np.abs(np.degrees(angle - known)).max() < 5e-3
    assert driving == pytest.approx(tangential_intensity(opened(k), known), abs=1e-4)


def test_a_crack_turned_over_kinks_the_other_way():
    turns = quaternion_to_matrix(random_orientations(5, np.random.default_rng(4)))
    stiffness = turned(COPPER, turns)
    over = np.concatenate([turned(c, HALF_TURN[None]) for c in stiffness])
    k = np.random.default_rng(5).uniform(0.2, 1, (5, 3))
    angle, driving = largest_near_stress(k, stiffness)
    # lips and front change direction: the stress along the normal and its shears keep K_I and turn K_II
    mirrored, same = largest_near_stress(k * [1, -1, 1], over)
    assert angle == pytest.approx(-mirrored, abs=1e-6) and driving == pytest.approx(same)
    isotropic = kink_angles(k, "tangential_stress", 0.3)
    assert np.abs(np.degrees(angle - isotropic)).max() > 1  # copper is far from isotropic


def test_opening_on_a_mirror_plane_of_the_cube_pulls_alike_on_both_sides():
    angles, stress = tangential_stress(np.array([[1.0, 0, 0], [0, 1, 0]]), np.stack([COPPER, COPPER]))
    # Runge-Kutta steps leave 1e-8
    assert stress[0] == pytest.approx(stress[0, ::-1], abs=1e-7)
    assert stress[1] == pytest.approx(-stress[1, ::-1], abs=1e-7)
    assert stress[0, len(angles) // 2] == pytest.approx(1.0, abs=1e-9)


def test_growth_takes_it_and_closed_cracks_count_as_without_opening():
    options = GrowthOptions(criterion="near_field", share=0.25)
    stiffness = np.repeat(COPPER[None], 2, axis=0)
    k, exact = np.array([[-1e-9, 1, 0], [0, 1, 0.0]]), np.full(2, 1e-6)
    front = FrontPoints.of(k, 4.0, points=np.eye(2, 3), doubt=exact, contact=True, stiffness=stiffness)
    found, _ = kinks_and_extensions(front, options)
    assert found.kink_angle[0] == found.kink_angle[1] < 0
    assert (found.extension == 1.0).all()
    with pytest.raises(CraftmeshError, match="near_field"):
        kinks_and_extensions(FrontPoints.of(np.ones((2, 3)), 4.0), options)
