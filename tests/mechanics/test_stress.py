"""Stresses at the nodes are those of the grain, and the files that carry them read back."""

import numpy as np
import pytest
from structured_box import structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.errors import CraftmeshError
from craftmesh.io import vtk_xml
from craftmesh.io.npz import write_arrays
from craftmesh.io.stage_npz import read_solution, write_solution_vtu, write_solutions
from craftmesh.mechanics.model import elastic_model
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.mechanics.orientation import random_orientations
from craftmesh.mechanics.stress import grain_stress, mean_stress
from craftmesh.types import Solution


def copper(element: str):
    mesh = assemble(*structured_box((2, 2, 2), lambda centres: np.where(centres[:, 0] < 1, 4, 7)))[0]
    options = ModelOptions(element=element, material=("cubic:168.4,121.4,75.4",))
    return elastic_model(mesh, options, random_orientations(8, np.random.default_rng(1)))[0]


@pytest.mark.parametrize("element", ["C3D4", "C3D10"])
def test_uniform_strain_gives_each_grain_its_own_stress(element):
    model = copper(element)
    strain = np.array([[1.0, 0.3, -0.2], [0.3, -0.5, 0.4], [-0.2, 0.4, 0.8]])
    found = grain_stress(model, model.mesh.points @ strain)
    pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]
    six = np.array([strain[i, j] * (1 if i == j else 2) for i, j in pairs])
    assert (found.node[found.tets] == model.mesh.tets).all()
    for grain, stiffness in zip(model.grains, model.stiffness()):
        points = np.unique(found.tets[model.mesh.grain == grain])
        assert np.allclose(found.stress[points], stiffness @ six)
    shared = np.intersect1d(*(model.mesh.tets[model.mesh.grain == grain] for grain in (4, 7)))
    assert len(found.node) == len(model.mesh.points) + len(shared) > len(model.mesh.points)


def test_a_quadratic_field_has_its_linear_stress_at_the_nodes():
    model = copper("C3D10")
    x, y, z = model.mesh.points.T
    found = grain_stress(model, np.column_stack([x * x, x * y, np.zeros_like(z)]))
    x, y, _ = model.mesh.points[found.node].T
    strain = np.stack([2 * x, x, 0 * x, y, 0 * x, 0 * x])
    for grain, stiffness in zip(model.grains, model.stiffness()):
        points = np.unique(found.tets[model.mesh.grain == grain])
        assert np.allclose(found.stress[points], (stiffness @ strain).T[points])


@pytest.mark.parametrize("stress", [[3.0, 0, 0, 0, 0, 0], [0, 0, -2.0, 0, 0, 0], [0, 0, 0, 4.0, 0, 0]])
def test_the_mean_stress_of_even_tension_compression_and_shear_is_that(stress):
    mesh = assemble(*structured_box((2, 2, 2), lambda centres: np.ones(len(centres), int)))[0]
    model = elastic_model(mesh, ModelOptions(material=("isotropic:70000,0.3",)))[0]
    xx, yy, zz, xy, xz, yz = np.linalg.solve(model.stiffness()[0], stress) / [1, 1, 1, 2, 2, 2]
    gradient = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    assert mean_stress(model, model.mesh.points @ gradient) == pytest.approx(np.abs(stress).max())


def test_solutions_read_back_bit_for_bit(tmp_path):
    rng = np.random.default_rng(0)
    record = {"solver": "builtin", "residual": 1e-9, "iterations": 12}
    solution = Solution(rng.normal(size=(9, 3)), rng.normal(size=(9, 3)), record)
    write_solutions(tmp_path / "a.npz", {"": solution})
    write_solutions(tmp_path / "b.npz", {"": solution})
    again = read_solution(tmp_path / "a.npz")
    assert (again.displacement == solution.displacement).all() and dict(again.record) == record
    assert (again.reactions == solution.reactions).all()
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    write_arrays(tmp_path / "c.npz", {"displacement": solution.displacement})
    with pytest.raises(CraftmeshError, match="is not a solution"):
        read_solution(tmp_path / "c.npz")
    with pytest.raises(CraftmeshError, match="Solution.reactions has shape"):
        Solution(np.zeros((3, 3)), np.zeros((2, 3)))


def test_paraview_gets_points_of_each_grain(tmp_path):
    model = copper("C3D10")
    field = np.random.default_rng(0).normal(size=model.mesh.points.shape)
    found = grain_stress(model, field)
    points, node = model.mesh.points[found.node], found.node + 1
    stress = np.tile([1.0, 2, 3, 4, 5, 6], (len(points), 1))
    path = tmp_path / "solution.vtu"
    write_solution_vtu(path, points, found.tets, model.mesh.grain, node, field[found.node], stress)
    grid = vtk_xml.read_dataset(path, "UnstructuredGrid")
    data = grid.at_points
    assert data.keys() == set(ARRAYS)
    assert (data["displacement"] == field[data["node"] - 1]).all()
    assert (data["stress"] == [1, 2, 3, 4, 6, 5]).all()  # yz before xz
    assert data["von_mises"] == pytest.approx(np.sqrt(3 + 3 * (16 + 25 + 36)))
    assert (grid.points == points).all()


ARRAYS = ("node", "displacement", "stress", "von_mises")
