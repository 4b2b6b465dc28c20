"""The model that deck and solver share."""

import numpy as np
import pytest
from structured_box import structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.materials import Material, turned
from craftmesh.mechanics.model import elastic_model
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.mechanics.orientation import quaternion_to_matrix, random_orientations

PAIRS = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]


def block():
    return assemble(*structured_box((2, 2, 2), lambda c: np.where(c[:, 0] < 1, 3, 5)))[0]


def fourth_order(stiffness):
    c = np.zeros((3, 3, 3, 3))
    for a, (i, j) in enumerate(PAIRS):
        for b, (k, l) in enumerate(PAIRS):
            for first, second in ((i, j), (j, i)):
                c[first, second, k, l] = c[first, second, l, k] = stiffness[a, b]
    return c


def test_stiffness_turns_as_a_tensor():
    rng = np.random.default_rng(1)
    root = rng.normal(size=(6, 6))
    material = root @ root.T + np.eye(6)
    (matrix,) = quaternion_to_matrix(random_orientations(1, rng))
    plain = np.einsum("ia,jb,kc,ld,abcd->ijkl", *[matrix] * 4, fourth_order(material))
    found = fourth_order(turned(material, matrix))
    assert np.allclose(found, plain, atol=1e-12 * np.abs(plain).max())


def test_grains_have_the_stiffness_of_their_crystal_and_phase():
    orientations = random_orientations(6, np.random.default_rng(2))
    texts = ("1=cubic:168.4,121.4,75.4", "2=isotropic:70,0.3")
    phases = np.array([0, 0, 0, 1, 0, 2])
    model, report = elastic_model(block(), ModelOptions(material=texts), orientations, phases)
    copper, isotropic = model.stiffness()
    matrix = quaternion_to_matrix(orientations[3])
    expected = turned(Material("cubic", (168.4, 121.4, 75.4)).stiffness(), matrix)
    assert np.allclose(copper, expected) and not np.allclose(copper[0, 0], 168.4)
    # to the bit, so that no boundary within one isotropic material changes it
    assert (isotropic == Material("isotropic", (70, 0.3)).stiffness()).all()
    assert report["grains"] == 2 and report["element"] == "C3D10"


def test_a_crystal_without_orientation_is_refused_and_no_load_is_none():
    with pytest.raises(CraftmeshError, match="cubic needs an orientation"):
        elastic_model(block(), ModelOptions(material=("cubic:168.4,121.4,75.4",)))
    assert elastic_model(block(), ModelOptions(load="none"))[0].load is None


def test_eigenstrains_by_phase_are_turned_with_the_crystals_and_those_of_a_table_are_the_samples():
    rng = np.random.default_rng(7)
    turns, phases = random_orientations(6, rng), np.array([0, 0, 0, 1, 0, 2])
    texts = ("1=isotropic:1e-3", "2=anisotropic:1e-3,-5e-4,2e-3,1e-3,3e-4,-7e-4")
    own = np.array([[1.0, 1.0, 0.3], [1.0, -0.5, -0.7], [0.3, -0.7, 2.0]]) * 1e-3
    (turn,) = quaternion_to_matrix(turns[5:])
    model, _ = elastic_model(block(), ModelOptions(load="none", eigenstrain=texts), turns, phases)
    found = model.eigenstrain()
    assert (found[0] == 1e-3 * np.eye(3)).all() and found[1] == pytest.approx(
        turn @ own @ turn.T, abs=1e-17
    )
    table = {grain: (lambda e: e + e.T)(rng.normal(size=(3, 3))) * 1e-3 for grain in (3, 5)}
    options = ModelOptions(load="none", eigenstrain_file="strains.csv")
    model, _ = elastic_model(block(), options, turns, grain_strains=table)
    assert model.eigenstrain() == pytest.approx(np.stack([table[3], table[5]]), abs=1e-17)
    cold = elastic_model(block(), ModelOptions(load="strain"), turns)[0]
    assert cold.eigenstrain().shape == (2, 3, 3) and not cold.eigenstrain().any()
