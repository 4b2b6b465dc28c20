"""Loads on the lips of cracks: their size, their balance, and fields between points."""

import numpy as np
import pytest
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.mechanics.lips import LipField, loaded_lips, mean_traction
from craftmesh.mechanics.load import Load, nodal_forces


def cracked_box():
    crack = plane_crack(2, 2, hexagon((3, 3), 2))
    return assemble(*structured_box((6, 6, 4), lambda c: np.ones(len(c), int), crack, (1.0, 0.5, 2.0)))[0]


@pytest.mark.parametrize(
    ("pressure", "traction", "size"),
    [
        (3.0, (), 3.0),
        (0.0, (0.0, -4.0, 0.0), 4.0),
        (-2.0, (), 2.0),
        (0.0, (2.0, 6.0, -3.0), 7.0),
        (3.0, (0.0, -4.0, 0.0), 5.0),  # the crack lies across z, along which the pressure acts
    ],
)
def test_the_mean_traction_is_the_size_of_an_even_one(pressure, traction, size):
    mesh = cracked_box()
    load = Load((), pulled=loaded_lips(mesh, pressure, traction))
    assert mean_traction(load, mesh) == pytest.approx(size)
    assert mean_traction(Load(()), mesh) == mean_traction(None, mesh) == 0.0


def test_a_pressure_opens_lips_and_a_traction_acts_on_both_against_each_other():
    mesh = cracked_box()
    lips = {name: mesh.face_sets[name] for name in ("CRACK_LIP_A", "CRACK_LIP_B")}
    own = {name: np.unique(mesh.tets[faces[:, 0]]) for name, faces in lips.items()}
    above = {name: np.sign(mesh.points[nodes, 2].mean() - 4.0) for name, nodes in own.items()}
    for pressure, traction in ((3.0, ()), (0.0, (1.0, 0.0, -2.0))):
        tractions = loaded_lips(mesh, pressure, traction)
        assert np.abs(nodal_forces(tractions, mesh).sum(axis=0)).max() < 1e-12
        for name in lips:
            force = nodal_forces([one for one in tractions if one.name == name], mesh).sum(axis=0)
            area = 24 * 0.5 * 1.0 * 0.5  # 24 facets, each half of a face of 1 by 0.5
            sign = 1 if name.endswith("A") else -1
            expected = [0, 0, 3.0 * above[name]] if pressure else sign * np.array(traction)
            assert force == pytest.approx(np.multiply(expected, area), abs=1e-12)


def test_an_even_field_loads_lips_as_its_numbers_do_and_a_slope_by_its_mean():
    mesh = cracked_box()
    grid = np.moveaxis(np.mgrid[0:6.1:0.5, 0:3.1:0.25], 0, -1).reshape(-1, 2)
    points = np.column_stack([grid, np.full(len(grid), 4.0)])
    pull = np.array([1.0, -2.0, 0.5])
    even = LipField(points, np.full(len(points), 3.0), np.tile(pull, (len(points), 1)))
    found = nodal_forces(loaded_lips(mesh, 0.0, field=even), mesh)
    assert found == pytest.approx(nodal_forces(loaded_lips(mesh, 3.0, pull), mesh), abs=1e-12)
    # the lips are symmetric about x = 3, where the sloping pressure is 3 too
    sloping = LipField(points, points[:, 0], 0 * even.traction)
    for name in ("CRACK_LIP_A", "CRACK_LIP_B"):
        force, mean = (
            nodal_forces([one for one in tractions if one.name == name], mesh).sum(axis=0)
            for tractions in (loaded_lips(mesh, 0.0, field=sloping), loaded_lips(mesh, 3.0))
        )
        assert force == pytest.approx(mean, abs=1e-9)


def test_fields_linear_in_the_place_come_out_between_their_points():
    rng = np.random.default_rng(2)
    points = np.column_stack([rng.uniform(-1, 1, (400, 2)), np.zeros(400)])
    slope = np.array([[0.5, 2.0], [1.0, -1.0], [0.0, 3.0], [-2.0, 0.0]])
    values = points[:, :2] @ slope.T + [5, 0, 1, 2]
    field = LipField(points, values[:, 0], values[:, 1:])
    inside = np.column_stack([rng.uniform(-0.8, 0.8, (50, 2)), np.zeros(50)])
    pressure, traction = field.at(inside)
    exact = inside[:, :2] @ slope.T + [5, 0, 1, 2]
    found = np.column_stack([pressure, traction])
    near = np.linalg.norm(points[None] - inside[:, None], axis=2).argsort(axis=1)[:, :8]
    free = (exact > values[near].min(axis=1)) & (exact < values[near].max(axis=1))
    assert free.mean() > 0.9 and np.abs(found - exact)[free].max() < 1e-9
    assert field.at(points[:5])[0] == pytest.approx(values[:5, 0], abs=1e-9)
