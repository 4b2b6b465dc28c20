"""Residual stress: its files, its values between points, and the tractions and fields that it makes."""

import numpy as np
import pytest
from test_lips import cracked_box

from craftmesh.deck.options import DeckOptions
from craftmesh.deck.write_deck import write_model
from craftmesh.errors import CraftmeshError
from craftmesh.io.point_fields import read_stress_field
from craftmesh.io.vtk import tets_alone
from craftmesh.io.vtk_xml import write_dataset
from craftmesh.mechanics.lips import LipField, loaded_lips
from craftmesh.mechanics.load import nodal_forces
from craftmesh.mechanics.model import elastic_model
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.mechanics.point_fields import PointField
from craftmesh.mechanics.residual_stress import residual_lips
from craftmesh.solve.options import SolveOptions
from craftmesh.solve.solve import solve, solve_model

STEEL = ("isotropic:210000,0.3",)
ROLLED = {"load": "stress", "magnitude": 80.0, "material": STEEL}
GRID = np.moveaxis(np.mgrid[0:7, 0:3.1:0.5, 0:8.1:2], 0, -1).reshape(-1, 3)
BOX = np.array([[0.0, 0, 0], [6, 3, 8]])


def linear(places):
    """A stress (n, 6) linear in the place."""
    slope = np.random.default_rng(3).uniform(-1, 1, (3, 6))
    return 20 + places @ slope


def test_a_linear_stress_puts_its_tractions_on_the_lips():
    """The crack lies across z: lips A, above it, bear s_zz, s_xz and s_yz, and lips B their opposite."""
    mesh = cracked_box()
    stress = linear(GRID)
    found = nodal_forces(residual_lips(mesh, PointField(GRID, (0, 1, 2), stress)), mesh)
    places = GRID[GRID[:, 2] == 4]
    plane = linear(places)
    field = LipField(places, plane[:, 2], np.column_stack([plane[:, 4], plane[:, 5], 0 * plane[:, 0]]))
    expected = nodal_forces(loaded_lips(mesh, 0.0, field=field), mesh)
    assert np.abs(expected).max() > 1
    # interpolated along z too, whose neighbours a value may be clipped to
    assert found == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("axes", [(), (0,), (0, 1), (1, 2)])
def test_a_stress_may_be_uniform_along_axes(axes):
    places = np.random.default_rng(4).uniform([1, 0.5, 1], [5, 2.5, 7], (40, 3))
    points = np.unique(GRID[:, axes], axis=0)
    full = np.zeros((len(GRID), 3))
    full[:, axes] = GRID[:, axes]
    of_points = np.zeros((len(points), 3))
    of_points[:, axes] = points
    still = np.zeros_like(places)
    still[:, axes] = places[:, axes]
    found = PointField(points, axes, linear(of_points)).at(places, "", BOX, "")
    exact = linear(still)
    assert found == pytest.approx(exact, abs=0.05)


@pytest.mark.parametrize(
    ("points", "size", "said"),
    [
        (GRID[GRID[:, 0] < 3], 1.0, r"residual_stress: has no value at \[.*\], the farthest"),
        (GRID / 1000, 1.0, r"about 1000 times as small \(mm beside um\?\)"),
        (GRID + 50, 1.0, "residual_stress: .* in the unit and position of the body"),
        (GRID, 1e6, "residual_stress: a stress of .* is larger than the stiffness .* in one unit"),
    ],
)
def test_a_stress_that_does_not_fit_the_body_is_refused(points, size, said):
    options = ModelOptions(residual_stress="s.csv", **ROLLED)
    field = PointField(points, (0, 1, 2), size * linear(points))
    with pytest.raises(CraftmeshError, match=said):
        elastic_model(cracked_box(), options, residual_stress=field)


def test_a_residual_stress_acts_in_each_load_and_alone(tmp_path):
    """Its field is that of its tractions on the lips, under the supports of the load."""
    mesh, exact = cracked_box(), SolveOptions(tolerance=1e-10, contact=False)
    field = PointField(np.zeros((1, 0)), (), np.array([[9.0, 5, 30, 2, 10, -4]]))
    model, _ = elastic_model(mesh, ModelOptions(residual_stress="s", **ROLLED), residual_stress=field)
    found, _ = solve_model(model, exact)
    assert list(found) == ["load", "residual_stress"]
    for name, pull in (("load", 80.0), ("residual_stress", 0.0)):
        options = ModelOptions(lip_traction=(10, -4, 30), **ROLLED | {"magnitude": pull})
        alone, _ = solve(elastic_model(mesh, options)[0], exact)
        off = np.abs(found[name].displacement - alone.displacement).max()
        assert off <= 1e-8 * np.abs(alone.displacement).max()
    write_model(tmp_path / "a.inp", model, DeckOptions(residual_stress="s", **ROLLED))
    assert (tmp_path / "a.inp").read_text().count("*STEP") == 2


def test_sums_name_a_share_of_the_residual_stress():
    faces = ("ZMIN.z=fixed", "pull/ZMAX.z=stress:5")
    options = ModelOptions(
        faces=faces, residual_stress="s", combine=("a=pull:2", "b=pull:1,residual_stress:0")
    )
    shares = {one.name: one.factors["residual_stress"] for one in options.combinations}
    assert shares == {"a": 1, "b": 0, "residual_stress": 1}
    with pytest.raises(CraftmeshError, match="only one of these holds or moves ZMIN.x"):
        ModelOptions(faces=(*faces, "other/ZMIN.x=fixed"), residual_stress="s")
    with pytest.raises(CraftmeshError, match="residual_stress is 's', but steps scale it"):
        _ = DeckOptions(residual_stress="s", steps=("load/ramp:0.5",), **ROLLED).history


def test_tables_and_grids_of_stresses_are_read(tmp_path):
    path = tmp_path / "s.csv"
    path.write_text("z,syy [MPa],sxy [MPa]\n0,1,2\n5,3,4\n")
    points, axes, stress = read_stress_field(path)
    assert points.tolist() == [[0], [5]] and axes == (2,)
    assert stress.tolist() == [[0, 1, 0, 2, 0, 0], [0, 3, 0, 4, 0, 0]]
    path.write_text("szz\n7\n")
    assert read_stress_field(path)[0].shape == (1, 0)
    for text in ("x,y,z\n1,2,3\n", "szz\n7\n8\n"):
        path.write_text(text)
        with pytest.raises(CraftmeshError, match=r"expected x, y, z, those along which .* sxx, syy, szz"):
            read_stress_field(path)
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 4]])
    tensor = np.array([[1.0, 4, 5], [4, 2, 6], [5, 6, 3]])
    grids = {
        "stress": ({"at_points": {"stress": np.tile([1.0, 2, 3, 4, 6, 5], (4, 1))}}, corners),
        "full": ({"at_cells": {"residual_stress": tensor.reshape(1, 9)}}, corners.mean(axis=0)[None]),
    }
    for arrays, wanted in grids.values():
        write_dataset(
            tmp_path / "s.vtu", "UnstructuredGrid", tets_alone(corners, np.arange(4)[None], **arrays)
        )
        points, axes, stress = read_stress_field(tmp_path / "s.vtu")
        assert points == pytest.approx(wanted) and axes == (0, 1, 2)
        assert stress.tolist() == [[1, 2, 3, 4, 5, 6]] * len(points)
    tensor[0, 1] = 4.1
    data = tets_alone(corners, np.arange(4)[None], at_cells={"stress": tensor.reshape(1, 9)})
    write_dataset(tmp_path / "s.vtu", "UnstructuredGrid", data)
    with pytest.raises(CraftmeshError, match="the tensor 0 is not symmetric by 0.1"):
        read_stress_field(tmp_path / "s.vtu")
