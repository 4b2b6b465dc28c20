"""A front that lies in a grain boundary has its parameters as any other, and says what they are."""

from dataclasses import replace

import numpy as np
import pytest
from near_fields import POISSON, YOUNG, penny_in_tension
from warped_cracks import disc_crack

from craftmesh.fracture.options import FractureOptions
from craftmesh.fracture.parameters import fracture_parameters
from craftmesh.mechanics.load import Fixed, Load
from craftmesh.mechanics.model import ModelOptions, elastic_model
from craftmesh.mechanics.orientation import random_orientations
from craftmesh.solve.solve import SolveOptions, solve
from craftmesh.types import BOX_PLANES

COPPER = "cubic:168.4,121.4,75.4"


@pytest.fixture(scope="module")
def bicrystal():
    return disc_crack(4, 3, 4, lambda centres: np.where(centres[:, 2] > 4, 2, 1))


def parameters(mesh, material, turns, radii):
    """Return the parameters with each radius, the outer faces moved as by the exact isotropic crack."""
    options = ModelOptions(material=(material,), load="none", quarter_points=True)
    model, _ = elastic_model(mesh, options, turns)
    outer = np.unique(np.concatenate([model.mesh.node_sets[name] for name in BOX_PLANES]))
    moved = penny_in_tension(model.mesh.points[outer], model.mesh.points[outer, 2] > 0)
    load = Load(tuple(Fixed(outer, axis, moved[:, axis]) for axis in range(3)))
    solution, _ = solve(replace(model, load=load), SolveOptions(tolerance=1e-5))
    return [
        fracture_parameters(
            model.mesh,
            solution.displacement,
            model.grains,
            model.stiffness(),
            FractureOptions(radius=radius),
        )[0]
        for radius in radii
    ]


def test_between_equal_grains_k_is_that_of_one_body(bicrystal):
    assert set(np.unique(bicrystal.grain)) == {1, 2}
    material = f"isotropic:{YOUNG},{POISSON}"
    (found,) = parameters(bicrystal, material, None, [3.0])
    one = replace(bicrystal, grain=np.ones_like(bicrystal.grain))
    (whole,) = parameters(one, material, None, [3.0])
    exact = 2 / np.sqrt(np.pi)
    # edges are a quarter of the radius: measured 0.7 %
    assert np.abs(found.K_I / exact - 1).max() < 0.015
    for name in ("K_I", "K_II", "K_III", "J"):
        assert getattr(found, name) == pytest.approx(getattr(whole, name), abs=1e-9 * exact)
    assert [flags.split("+")[1:] for flags in found.flags] == [
        one.split("+") if one else [] for one in whole.flags
    ]
    assert all(flags.startswith("pierce") for flags in found.flags)


def test_between_two_crystals_every_node_says_so_and_j_does_not_depend_on_the_path(bicrystal):
    turns = random_orientations(3, np.random.default_rng(5))
    near, far = parameters(bicrystal, COPPER, turns, [2.5, 3.0])
    for found in (near, far):
        assert all("interface" in flags.split("+") for flags in found.flags)
        assert np.isfinite([found.K_I, found.K_II, found.K_III, found.J]).all()
    # a quarter of the radius is coarse: measured 0.3 % for J and 0.2 % for K; the benchmark has 0.2 at most
    # between three edges and four
    assert near.J.mean() == pytest.approx(far.J.mean(), rel=0.005)
    for name in ("K_I", "K_II", "K_III"):
        assert getattr(near, name) == pytest.approx(getattr(far, name), abs=0.005 * far.K_I.max())
