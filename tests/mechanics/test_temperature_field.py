"""A temperature that varies: its files, the strains and stresses that it makes, and its lines in decks."""

import io
from dataclasses import replace

import numpy as np
import pytest
from structured_box import structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.assembly.boundary_layers import boundary_layers, grain_pairs
from craftmesh.deck.options import DeckOptions
from craftmesh.deck.write_deck import write_model
from craftmesh.errors import CraftmeshError
from craftmesh.io.point_fields import read_temperature
from craftmesh.io.vtk import tets_alone
from craftmesh.io.vtk_xml import write_dataset
from craftmesh.mechanics.model import elastic_model
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.mechanics.orientation import random_orientations
from craftmesh.mechanics.point_fields import PointField
from craftmesh.mechanics.stress import grain_stress, mean_stresses
from craftmesh.solve.options import SolveOptions
from craftmesh.solve.solve import solve

EXACT = SolveOptions(tolerance=1e-12)
COPPER = ("cubic:168400,121400,75400",)
SHEARED = ("anisotropic:1e-5,-5e-6,2e-5,1e-5,3e-6,-7e-6",)
GRID = np.moveaxis(np.mgrid[-1:3, -1:4, -1:3], 0, -1).reshape(-1, 3).astype(float)
LINEAR = PointField(GRID, (0, 1, 2), 100 + GRID @ [[20.0], [-30], [50]])


HEATED = {"temperature": "T.csv", "load": "none", "eigenstrain": ("isotropic:1e-5",)}


def block(label_of):
    return assemble(*structured_box((2, 2, 3), label_of, None, (0.5, 1.0, 0.25)))[0]


def model_of(temperature, orientations=None, options=ModelOptions, **chosen):
    mesh = block(lambda c: np.ones(len(c), int))
    return elastic_model(mesh, options(**HEATED | chosen), orientations, temperature=temperature)[0]


def test_a_free_body_takes_a_linear_temperature_without_stress():
    turns = np.tile(random_orientations(1, np.random.default_rng(3)), (2, 1))
    model = model_of(LINEAR, turns, eigenstrain=SHEARED, material=COPPER)
    field = solve(model, EXACT)[0].displacement
    stress = grain_stress(model, field).stress
    assert np.abs(stress).max() < 1e-6 * 168400 * 1e-3
    uniform = solve(replace(model, temperature=None), EXACT)[0].displacement
    assert np.abs(field).max() > 50 * np.abs(uniform).max()


@pytest.mark.parametrize("element", ["C3D4", "C3D10"])
def test_one_temperature_everywhere_is_a_factor_of_the_eigenstrain(element):
    held = {"load": "strain", "magnitude": 0.0, "element": element}
    point = PointField(np.zeros((1, 0)), (), np.array([[250.0]]))
    fields = [
        (model, solve(model, EXACT)[0].displacement)
        for model in (
            model_of(point, **held),
            replace(model_of(point, eigenstrain=("isotropic:2.5e-3",), **held), temperature=None),
        )
    ]
    (_, one), (_, other) = fields
    assert one == pytest.approx(other, abs=1e-9 * np.abs(other).max())
    for model, field in fields:
        assert mean_stresses(model, field)[2] == pytest.approx(-70000 * 2.5e-3, rel=1e-9)


def test_a_deck_has_the_temperature_of_each_node():
    faces = ("ZMIN.z=fixed", "pull/ZMAX.z=stress:5")
    for chosen in ({}, {"faces": faces}, {"steps": ("ramp:1",)}):
        model = model_of(LINEAR, options=DeckOptions, **chosen)
        deck = io.StringIO()
        write_model(deck, model, DeckOptions(**HEATED | chosen))
        blocks = [part.partition("\n")[2] for part in deck.getvalue().split("\n*TEMPERATURE")[1:]]
        rows = [line.split(", ") for line in blocks[-1].partition("\n*")[0].splitlines()]
        assert [int(node) for node, _ in rows] == list(range(1, len(model.mesh.points) + 1))
        exact = 100 + model.mesh.points @ [20.0, -30, 50]
        assert [float(value) for _, value in rows] == pytest.approx(exact, rel=1e-6)
        assert len(blocks) == 1 + bool("faces" in chosen)
        assert len(blocks) == 1 or blocks[0].startswith("NALL, 0.0\n")


def test_copies_of_nodes_keep_the_temperature():
    mesh, options = block(lambda c: np.where(c[:, 0] < 1, 1, 2)), ModelOptions(**HEATED)
    model, _ = elastic_model(mesh, options, temperature=LINEAR)
    opened, _ = boundary_layers(model.mesh, grain_pairs(model.mesh))
    assert len(opened.points) > len(model.mesh.points)
    exact = 100 + opened.points @ [20.0, -30, 50]
    assert model.on_copies(opened).temperature == pytest.approx(exact)


def test_tables_and_grids_of_temperatures_are_read(tmp_path):
    path = tmp_path / "T.csv"
    path.write_text("z,temperature [K]\n0,1\n5,3\n")
    points, axes, values = read_temperature(path)
    assert points.tolist() == [[0], [5]] and axes == (2,) and values.tolist() == [[1], [3]]
    for text in ("x,y,z\n1,2,3\n", "temperature\n7\n8\n"):
        path.write_text(text)
        with pytest.raises(
            CraftmeshError, match="those along which the temperature varies, and temperature"
        ):
            read_temperature(path)
    corners, tet = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 4]]), np.arange(4)[None]
    for arrays, wanted in (
        ({"at_points": {"temperature": np.arange(4.0)}}, corners),
        ({"at_cells": {"temperature": np.array([7.0])}}, corners.mean(axis=0)[None]),
    ):
        write_dataset(tmp_path / "T.vtu", "UnstructuredGrid", tets_alone(corners, tet, **arrays))
        points, axes, values = read_temperature(tmp_path / "T.vtu")
        assert points == pytest.approx(wanted) and axes == (0, 1, 2)
        assert (
            values.shape == (len(points), 1)
            and values[-1] == next(iter(arrays.values()))["temperature"][-1]
        )
    data = tets_alone(corners, tet, at_points={"temperature": np.ones((4, 3))})
    write_dataset(tmp_path / "T.vtu", "UnstructuredGrid", data)
    with pytest.raises(CraftmeshError, match=r"an array \(4, 3\) of temperatures, .*expected one finite"):
        read_temperature(tmp_path / "T.vtu")


def test_temperatures_that_do_not_fit_are_refused():
    with pytest.raises(
        CraftmeshError, match="temperature is 'T.csv', but no grain expands; give the coeff"
    ):
        ModelOptions(temperature="T.csv")

    with pytest.raises(CraftmeshError, match=r"temperature: has no value at .*, the farthest.* whole body"):
        model_of(PointField(0.2 * GRID, (0, 1, 2), LINEAR.values))
    with pytest.raises(CraftmeshError, match="is a strain of .*, over 1; give eigenstrains per degree"):
        model_of(LINEAR, eigenstrain=("isotropic:0.1",))
    with pytest.raises(CraftmeshError, match="temperature is 'T.csv', but the model reads no file"):
        model_of(None)
