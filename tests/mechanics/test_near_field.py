"""Fields round a front: Williams' in isotropic materials, Stroh's in crystals, lips free of traction."""

import numpy as np
import pytest
from near_fields import POISSON, SHEAR, YOUNG, stroh, williams

from craftmesh.mechanics.materials import Material, turned
from craftmesh.mechanics.near_field import as_tensor, near_field
from craftmesh.mechanics.orientation import quaternion_to_matrix, random_orientations

ISOTROPIC = Material("isotropic", (YOUNG, POISSON)).stiffness()
COPPER = Material("cubic", (168.4, 121.4, 75.4)).stiffness()


def crystals(count=3, crystal=COPPER):
    turns = quaternion_to_matrix(random_orientations(count, np.random.default_rng(3)))
    return turned(crystal, turns)


def gradients(displacement, angles):
    """Gradients (a, 3, 2) at r = 1 of u = r^(1/2) g(theta), by differences of `displacement(r, theta)`."""
    r, step = np.ones_like(angles), 1e-5
    u = displacement(r, angles)
    turned = (displacement(r, angles + step) - displacement(r, angles - step)) / (2 * step)
    cos, sin = np.cos(angles)[:, None], np.sin(angles)[:, None]
    return np.stack([cos * u / 2 - sin * turned, sin * u / 2 + cos * turned], axis=2)


@pytest.mark.parametrize(("column", "mode"), [(0, 2), (1, 1), (2, 3)])
def test_isotropic_fields_are_those_of_williams(column, mode):
    field = near_field(ISOTROPIC[None])
    exact = gradients(lambda r, t: williams(r, t, mode), field.angles)
    # differences with steps of 1e-5 have some ten digits; fields are of the order 1e-2
    assert np.abs(field.value[0, :, column] - exact).max() < 1e-9


@pytest.mark.parametrize(("column", "mode"), [(0, 2), (1, 1), (2, 3)])
def test_crystals_fields_are_those_of_stroh(column, mode):
    found = near_field(crystals())
    inner = np.abs(found.angles) < np.pi - 0.1  # the roots jump at the lips
    for value, tensor in zip(found.value, as_tensor(crystals())):
        exact = gradients(lambda r, t: stroh(tensor, r, t, mode), found.angles[inner])  # noqa: B023
        assert np.abs(value[inner, column] - exact).max() < 1e-8


def stresses(found, stiffness):
    whole = np.zeros((*found.value.shape[:-1], 3))
    whole[..., :2] = found.value
    return np.einsum("kijcd,kamcd->kamij", as_tensor(stiffness), whole)


def test_lips_are_free_and_k_is_that_of_the_stress_ahead():
    titanium = Material("hexagonal", (162.4, 92.0, 69.0, 180.7, 46.7)).stiffness()
    stiffness = np.concatenate([ISOTROPIC[None], crystals(), crystals(crystal=titanium)])
    found = near_field(stiffness)
    stress = stresses(found, stiffness)
    for lip in (-np.pi, np.pi):
        (place,) = np.flatnonzero(np.isclose(found.angles, lip))
        assert np.abs(stress[:, place, :, :, 1]).max() < 1e-7 * np.abs(stress).max()
    (ahead,) = np.flatnonzero(np.isclose(found.angles, 0))
    assert np.allclose(stress[:, ahead, :3, :, 1] * np.sqrt(2 * np.pi), np.eye(3), atol=1e-9)


def test_the_other_fields_are_those_of_unit_forces():
    stiffness = crystals()
    found = near_field(stiffness)
    ring = np.abs(found.angles) < np.pi + 1e-9
    angles = found.angles[ring]
    out = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    pull = np.einsum("kamij,aj->kami", stresses(found, stiffness)[:, ring, 3:], out)
    weight = np.full(len(angles), angles[1] - angles[0])
    weight[[0, -1]] /= 2
    total = np.einsum("kami,a->kmi", pull, weight)
    assert np.allclose(total, [[-1, 0, 0], [0, 0, -1]], atol=1e-3)  # the trapezoidal rule


def test_slopes_are_those_of_the_values():
    found = near_field(crystals())
    step = found.angles[1] - found.angles[0]
    differences = (found.value[:, 2:] - found.value[:, :-2]) / (2 * step)
    size = np.abs(differences).max(axis=(1, 3, 4), keepdims=True)
    assert np.abs((differences - found.slope[:, 1:-1]) / size).max() < 0.08  # of the order of step squared


def test_j_of_unit_k():
    opening = near_field(ISOTROPIC[None]).opening[0]
    plane = (1 - POISSON**2) / YOUNG
    assert np.allclose(opening / 2, np.diag([plane, plane, 1 / (2 * SHEAR)]), rtol=1e-9)
