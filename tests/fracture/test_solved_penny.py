"""K of a penny by the built-in solver, with exact displacements on the outer faces."""

from dataclasses import replace

import numpy as np
from near_fields import POISSON, YOUNG, penny_in_tension
from warped_cracks import disc_crack

from craftmesh.fracture.parameters import fracture_parameters
from craftmesh.mechanics.load import Fixed, Load
from craftmesh.mechanics.model import elastic_model
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.solve.solve import SolveOptions, solve
from craftmesh.types import BOX_PLANES


def test_a_penny_has_its_k_at_every_node():
    material = (f"isotropic:{YOUNG},{POISSON}",)
    options = ModelOptions(material=material, load="none", quarter_points=True)
    model, _ = elastic_model(disc_crack(5, 3, 4), options)
    mesh = model.mesh
    outer = np.unique(np.concatenate([mesh.node_sets[name] for name in BOX_PLANES]))
    moved = penny_in_tension(mesh.points[outer], mesh.points[outer, 2] > 0)
    load = Load(tuple(Fixed(outer, axis, moved[:, axis]) for axis in range(3)))
    solution, _ = solve(replace(model, load=load), SolveOptions(tolerance=1e-5))
    found, report = fracture_parameters(mesh, solution.displacement, model.grains, model.stiffness())
    exact = 2 / np.sqrt(np.pi)
    # edges are a fifth of the radius: measured 0.3 %
    assert np.abs(found.K_I / exact - 1).max() < 0.01
    assert np.abs([found.K_II, found.K_III]).max() < 0.01 * exact
    k = np.column_stack([found.K_I, found.K_II, found.K_III])
    assert (np.abs(k - [exact, 0, 0]).max(axis=1) < found.error).mean() >= 0.95
    # measured 1.9 %, for the root of J is 1.3 % off in elements this uneven
    assert report["fronts"][0]["error"][1] < 0.03
    assert (found.flags == "").all()
