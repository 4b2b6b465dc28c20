"""Nearly incompressible materials are refused before the solution, with their grain."""

import numpy as np
import pytest
from test_solve import block

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.materials import Material
from craftmesh.mechanics.model import elastic_model
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.solve.solve import MOST_POISSON, check_compressible, poisson_ratios, solve


def test_the_ratio_of_an_isotropic_stiffness_is_its_own():
    given = np.array([-0.5, 0.0, 0.3, 0.49, 0.4999])
    stiffness = np.array([Material("isotropic", (70e3, nu)).stiffness() for nu in given])
    assert np.abs(poisson_ratios(stiffness) - given).max() < 1e-9


def test_the_ratio_of_a_crystal_does_not_depend_on_its_axes():
    crystal = Material("cubic", (168.4e3, 121.4e3, 75.4e3)).stiffness()
    turned = crystal[[1, 2, 0, 5, 3, 4]][:, [1, 2, 0, 5, 3, 4]]
    assert np.ptp(poisson_ratios(np.stack([crystal, turned]))) < 1e-12
    assert 0.3 < poisson_ratios(crystal[None])[0] < 0.4


def test_a_nearly_incompressible_phase_is_refused_before_the_solution_by_name():
    options = ModelOptions(material=("1=isotropic:70e3,0.3", "2=isotropic:1e3,0.4999"))
    model, _ = elastic_model(block(), options, phases=np.array([0, 2, 1]))
    with pytest.raises(CraftmeshError, match=r"^material 2=isotropic:1000.0,0.4999 \(grain 1\): .*0.4999"):
        solve(model)


def test_the_largest_ratio_itself_is_taken():
    material = (f"isotropic:70e3,{MOST_POISSON!r}",)
    check_compressible(elastic_model(block(), ModelOptions(material=material))[0])
