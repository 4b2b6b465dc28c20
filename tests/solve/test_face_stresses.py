"""Tractions on faces give the uniform stress that they are."""

import numpy as np
import pytest
from structured_box import structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.mechanics.model import elastic_model
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.mechanics.orientation import random_orientations
from craftmesh.mechanics.stress import grain_stress
from craftmesh.solve.options import SolveOptions
from craftmesh.solve.solve import solve

COPPER = ("cubic:168.4e3,121.4e3,75.4e3",)
STRESS = np.array([[50.0, 20.0, -15.0], [20.0, -30.0, 40.0], [-15.0, 40.0, 80.0]])
PLACES = ([0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2])


def rows_of(stress):
    """The rows that bear a uniform stress (3, 3): each component on both faces of its axis."""
    return tuple(
        f"{'XYZ'[a]}{end}.{'xyz'[b]}=stress:{stress[a, b]}"
        for a in range(3)
        for b in range(3)
        for end in ("MIN", "MAX")
    )


@pytest.mark.parametrize("element", ["C3D4", "C3D10"])
@pytest.mark.parametrize("component", [*range(6), "all"])
def test_a_crystal_has_the_stress_of_its_faces(element, component):
    mesh, _ = assemble(*structured_box((3, 4, 3), lambda c: np.ones(len(c), int), None, (0.5, 0.3, 0.4)))
    stress = STRESS
    if component != "all":
        only = np.zeros((3, 3), bool)
        only[PLACES[0][component], PLACES[1][component]] = True
        stress = np.where(only | only.T, STRESS, 0.0)
    options = ModelOptions(element=element, material=COPPER, faces=rows_of(stress))
    model, _ = elastic_model(mesh, options, random_orientations(2, np.random.default_rng(1)))
    solution, _ = solve(model, SolveOptions(tolerance=1e-12))
    found = grain_stress(model, solution.displacement).stress
    # the residual is a share of all forces, in the two norm
    assert np.abs(found - stress[PLACES]).max() <= 1e-9 * np.abs(stress).max()
    assert np.abs(solution.reactions).max() <= 1e-9 * np.abs(stress).max()  # what holds it bears nothing


def test_a_moved_face_shears_the_body_by_the_strain():
    mesh, _ = assemble(*structured_box((2, 3, 4), lambda c: np.ones(len(c), int), None, (0.5, 0.4, 0.3)))
    rows = [f"Z{end}.{axis}=fixed" for end in ("MIN", "MAX") for axis in "yz"]
    rows += ["ZMIN.x=fixed", "ZMAX.x=strain:0.001", "XMIN.z=fixed", "XMAX.z=fixed"]
    model, _ = elastic_model(mesh, ModelOptions(faces=tuple(rows)))
    solution, _ = solve(model, SolveOptions(tolerance=1e-12))
    exact = 0.001 * model.mesh.points[:, [2]] * [1, 0, 0]
    assert np.abs(solution.displacement - exact).max() <= 1e-12
