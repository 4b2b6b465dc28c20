"""Friction of lips that touch: Coulomb's law at every pair of nodes, whole bodies where all stick."""

import re
from dataclasses import replace

import numpy as np
import pytest
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.load import Fixed, Load
from craftmesh.mechanics.model import ElasticModel, elastic_model
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.mesh.lips import lip_pairs
from craftmesh.solve.options import SolveOptions
from craftmesh.solve.solve import solve

SHAPE, EDGE = (6, 6, 4), 0.5
EXACT = SolveOptions(tolerance=1e-9)
SEVERED = plane_crack(2, 2, lambda centres: np.ones(len(centres), bool))
HEXAGON = plane_crack(2, 2, hexagon((3, 3), 2))


def pressed(crack, shear: float, friction: float, **options) -> ElasticModel:
    """A block with a crack amid its height, its bottom held, its top pressed and moved along x."""
    mesh, _ = assemble(
        *structured_box(SHAPE, lambda centres: np.ones(len(centres), int), crack, (EDGE,) * 3)
    )
    model, _ = elastic_model(mesh, ModelOptions(lip_friction=friction, quarter_points=False, **options))
    top, bottom = (model.mesh.node_sets[name] for name in ("ZMAX", "ZMIN"))
    held = tuple(Fixed(bottom, axis) for axis in range(3))
    moved = tuple(
        Fixed(top, axis, np.full(len(top), value)) for axis, value in enumerate((shear, 0.0, -1e-3))
    )
    return replace(model, load=Load(held, moved))


def at_pairs(model: ElasticModel, solution):
    """Return normal forces (p,), forces along the lips and slips (p, 3) of the lips' pairs of nodes."""
    pairs = lip_pairs(model.mesh)
    first, second = pairs.nodes.T
    force, jump = solution.contact[first], solution.displacement[first] - solution.displacement[second]
    push = np.einsum("pi,pi->p", pairs.normal, force)
    along, slip = (
        part - np.einsum("pi,pi->p", pairs.normal, part)[:, None] * pairs.normal for part in (force, jump)
    )
    return push, along, slip


@pytest.mark.parametrize("element", ["C3D4", "C3D10"])
def test_a_block_cut_through_is_whole_where_its_lips_stick(element):
    cut = pressed(SEVERED, 3e-4, 2.0, element=element)
    whole = pressed(
        plane_crack(2, 2, lambda centres: np.zeros(len(centres), bool)), 3e-4, 2.0, element=element
    )
    (found, report), (wanted, _) = (solve(model, EXACT) for model in (cut, whole))
    assert report["contact_sticking"] == report["contact_closed"] == report["contact_pairs"]
    place = {tuple(point): row for row, point in enumerate(whole.mesh.points.tolist())}
    same = [place[tuple(point)] for point in cut.mesh.points.tolist()]
    largest = np.abs(wanted.displacement).max()
    assert np.abs(found.displacement - wanted.displacement[same]).max() <= 1e-7 * largest


@pytest.mark.parametrize("element", ["C3D4", "C3D10"])
@pytest.mark.parametrize("crack", [SEVERED, HEXAGON])
@pytest.mark.parametrize("friction", [0.1, 0.3])
def test_forces_of_pairs_that_slide_are_against_the_slip_and_mu_times_the_pressure(
    crack, element, friction
):
    model = pressed(crack, 2e-3, friction, element=element)
    solution, report = solve(model, EXACT)
    push, along, slip = at_pairs(model, solution)
    size = np.linalg.norm(slip, axis=1, keepdims=True)
    slides = size[:, 0] > 1e-9
    assert report["contact_closed"] - report["contact_sticking"] == slides.sum() > 0
    law = -friction * push[:, None] * slip / np.maximum(size, 1e-300)
    forces = np.linalg.norm(solution.reactions)
    assert np.linalg.norm((along - law)[slides]) <= 1.01e-9 * forces
    assert report["residual"] <= 1e-9
    # the law in sum: no more than mu times the pressing force
    assert np.linalg.norm(along.sum(axis=0)) <= friction * push.sum() * (1 + 1e-9)
    if element == "C3D4":
        assert (np.linalg.norm(along, axis=1) <= friction * push * (1 + 1e-6)).all()


def test_the_shear_force_of_a_block_that_slides_is_mu_times_its_pressing_force():
    model = pressed(SEVERED, 3e-3, 0.1, material=("isotropic:70000,0",))
    solution, report = solve(model, EXACT)
    assert report["contact_sticking"] == 0
    shear, _, press = solution.reactions[model.mesh.node_sets["ZMAX"]].sum(axis=0)
    # the faces bend a little across the slip: measured 2e-6
    assert shear / -press == pytest.approx(0.1, rel=1e-4)


def test_slip_grows_with_the_load_in_proportion():
    model = pressed(SEVERED, 3e-4, 0.1)
    twice = replace(model, load=model.load.with_lengths(2.0))
    (one, first), (two, second) = (solve(own, EXACT) for own in (model, twice))
    assert first["contact_sticking"] == second["contact_sticking"] > 0
    assert np.abs(two.displacement - 2 * one.displacement).max() <= 1e-8 * np.abs(two.displacement).max()


def test_an_open_crack_is_the_same_to_the_bit_with_friction_and_without():
    pulled = [pressed(HEXAGON, 0.0, friction) for friction in (0.0, 0.5)]
    lifted = [replace(own, load=own.load.with_lengths(-1.0)) for own in pulled]
    off, on = (solve(own, EXACT)[0] for own in lifted)
    assert on.contact is None and on.displacement.tobytes() == off.displacement.tobytes()


def test_friction_without_contact_is_refused():
    said = "lip_friction is 0.3, but contact is false, so that lips overlap; set contact to true"
    with pytest.raises(CraftmeshError, match=re.escape(said)):
        solve(pressed(HEXAGON, 1e-3, 0.3), replace(EXACT, contact=False))
