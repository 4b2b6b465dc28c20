"""K, T and J of bodies whose temperature varies: strains that it causes freely do not count."""

from functools import cache

import numpy as np
import pytest
from near_fields import YOUNG
from structured_box import plane_crack, structured_box
from test_exact_fields import ISOTROPIC, LOADED, k_of, one_grain

from craftmesh.assembly.assemble import assemble
from craftmesh.fracture.options import FractureOptions
from craftmesh.fracture.parameters import fracture_parameters
from craftmesh.mechanics.materials import Material, turned
from craftmesh.mechanics.orientation import quaternion_to_matrix, random_orientations
from craftmesh.mesh.second_order import as_elements

SLOPES = 0.2 * np.vstack([np.eye(3), [0.6, -0.4, 0.5]])
EXPANSION = np.array([[1.0, 0.3, -0.2], [0.3, 0.5, 0.4], [-0.2, 0.4, 1.7]]) / YOUNG
CRYSTAL = turned(
    Material("cubic", (1.6 * YOUNG, 1.1 * YOUNG, 0.7 * YOUNG)).stiffness(),
    quaternion_to_matrix(random_orientations(1, np.random.default_rng(2)))[0],
)
# K of a stress of 1 on a crack of 5; restrained strains would make stresses that change by about 1 on it
SCALE = 4.0


@cache
def straight():
    """A crack behind x = 0 in z = 0 with edges of one, without quarter points."""
    crack = plane_crack(2, 5, lambda c: c[:, 0] < 5)
    mesh, _ = assemble(*structured_box((10, 14, 10), one_grain, crack, origin=(-5, 0, -5)))
    return as_elements(mesh, "C3D10")[0]


def free_expansion(points, expansion, slope):
    """Displacements (n, 3) of strain expansion * (1 + slope . x), which leaves a body without stress."""
    along = points @ expansion
    bent = (points @ slope)[:, None] * along
    return along + bent - 0.5 * (points * along).sum(axis=1)[:, None] * slope


@pytest.mark.parametrize("slope", SLOPES)
@pytest.mark.parametrize(
    ("expansion", "stiffness"),
    [(np.eye(3) / YOUNG, ISOTROPIC), (EXPANSION, CRYSTAL)],
    ids=["even", "crystal"],
)
def test_a_linear_temperature_has_no_k_t_or_j(slope, expansion, stiffness):
    mesh = straight()
    found, _ = fracture_parameters(
        mesh,
        free_expansion(mesh.points, expansion, slope),
        np.array([1]),
        stiffness[None],
        FractureOptions(probe=2.0),
        LOADED,
        eigenstrain=expansion[None],
        temperature=1 + mesh.points @ slope,
    )
    assert np.abs(k_of(found)).max() < 0.001 * SCALE
    assert np.abs(found.T).max() < 0.005  # the largest are at the front's ends
    assert np.abs(found.J).max() < 1e-9 * SCALE**2 / YOUNG
    assert np.nanmax(np.abs(found.probe_stress)) < 1e-9
