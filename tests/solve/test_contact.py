"""Lips that would overlap press on each other instead, without friction; others feel nothing of it."""

from dataclasses import replace

import numpy as np
import pytest
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.mechanics.load import Fixed, Load
from craftmesh.mechanics.model import ElasticModel, elastic_model
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.mesh.lips import lip_pairs
from craftmesh.mesh.mesh_sets import LIPS
from craftmesh.solve.options import SolveOptions
from craftmesh.solve.problem import problem_of
from craftmesh.solve.solve import solve
from craftmesh.types import Solution

SHAPE, EDGE = (6, 6, 4), 0.5
EXACT = SolveOptions(tolerance=1e-12)
OFF = replace(EXACT, contact=False)


def cracked(crack=None, **options) -> ElasticModel:
    """A block with a hexagonal crack in the middle of its height, or another one."""
    crack = crack or plane_crack(2, SHAPE[2] / 2, hexagon((3, 3), 2))
    mesh, _ = assemble(
        *structured_box(SHAPE, lambda centres: np.ones(len(centres), int), crack, (EDGE,) * 3)
    )
    return elastic_model(mesh, ModelOptions(**{"quarter_points": False} | options))[0]


def bent(model: ElasticModel) -> ElasticModel:
    """The model with its bottom held and its top turned about y."""
    mesh = model.mesh
    top, bottom = mesh.node_sets["ZMAX"], mesh.node_sets["ZMIN"]
    middle = mesh.points[:, 0].mean()
    turn = Fixed(top, 2, 1e-3 * (mesh.points[top, 0] - middle))
    return replace(model, load=Load(tuple(Fixed(bottom, axis) for axis in range(3)), moved=(turn,)))


def overlap(model: ElasticModel, solution: Solution) -> float:
    return max(-lip_pairs(model.mesh).gaps(solution.displacement).min(), 0.0)


@pytest.mark.parametrize("element", ["C3D4", "C3D10"])
@pytest.mark.parametrize("sides", ["free", "rollers"])
def test_a_flat_crack_square_to_the_pressure_might_as_well_not_be_there(element, sides):
    model = cracked(element=element, sides=sides, load="stress", magnitude=-50.0)
    solution, report = solve(model, EXACT)
    points = model.mesh.points - model.mesh.points.min(axis=0)
    exact = points * np.array([0.33, 0.33, -1.0]) * 50 / 70e3
    assert np.abs(solution.displacement - exact).max() <= 1e-10 * np.abs(exact).max()
    assert overlap(model, solution) <= 1e-12 * np.abs(exact).max()
    assert report["contact_closed"] == report["contact_pairs"] > 0
    assert report["overlap_without_contact"] > 1e-6
    # of the hexagon's 24 halves of squares; the nodes of the front bear the rest
    a, b = (model.mesh.node_sets[lip] for lip in LIPS)
    own, other = np.setdiff1d(a, b), np.setdiff1d(b, a)
    push = solution.contact[own].sum(axis=0)
    assert np.abs(solution.contact.sum(axis=0)).max() <= 1e-12 * push[2]
    assert 0 < push[2] <= 50 * 24 * EDGE**2 / 2 and np.abs(push[:2]).max() <= 1e-12 * push[2]
    assert solution.contact[other].sum(axis=0) == pytest.approx(-push, abs=1e-12 * push[2])


@pytest.mark.parametrize("quarter_points", [False, True])
def test_a_bent_block_closes_one_half_of_its_crack(quarter_points):
    model = bent(cracked(quarter_points=quarter_points))
    solution, report = solve(model, EXACT)
    assert 0 < report["contact_closed"] < report["contact_pairs"]
    largest = np.abs(solution.displacement).max()
    assert overlap(model, solution) <= 1e-9 * largest < 1e-3 * report["overlap_without_contact"]
    pairs = lip_pairs(model.mesh)
    push = np.einsum("pi,pi->p", solution.contact[pairs.nodes[:, 0]], pairs.normal)
    gaps = pairs.gaps(solution.displacement)
    assert (np.abs(gaps[push != 0]) <= 1e-12 * largest).all()  # no force across a gap
    mids = np.unique(pairs.facets[:, 3:])[1:]
    assert (push[mids] >= -1e-9 * push.max()).all()  # even pressure has no force on corners
    # a corner may pull by itself, but not with what is around it: half of its edges' mid nodes
    edges = np.concatenate([pairs.facets[:, [k, 3 + k, (k + 1) % 3]] for k in range(3)])
    edges = np.unique(edges[edges[:, 1] >= 0], axis=0)
    work = push.copy()
    for corner in (0, 2):
        known = np.unique(edges[edges[:, corner] >= 0][:, [corner, 1]], axis=0)
        np.add.at(work, known[:, 0], push[known[:, 1]] / 2)
    corners = np.setdiff1d(pairs.facets[:, :3], [-1])
    assert (work[corners] >= -1e-9 * push.max()).all() and push[corners].min() < -0.1 * push.max()
    turned = push[:, None] * pairs.normal - solution.contact[pairs.nodes[:, 0]]
    assert np.abs(turned).max() <= 1e-12 * push.max()  # no friction
    problem = problem_of(model)
    left, reactions, residual = problem.balance(solution.displacement, solution.contact)
    assert residual == report["residual"] <= 1e-12 and (reactions == solution.reactions).all()
    forces = reactions + problem.forces
    assert np.abs(forces.sum(axis=0)).max() <= 1e-10 * np.abs(forces).sum()


def test_contact_makes_the_body_stiffer_than_overlapping_lips_and_softer_than_none():
    cracked_model = bent(cracked())
    whole = bent(cracked(plane_crack(2, SHAPE[2] / 2, lambda centres: np.zeros(len(centres), bool))))
    energy = [
        (solution.reactions * solution.displacement)[model.mesh.node_sets["ZMAX"], 2].sum()
        for model, options in ((cracked_model, OFF), (cracked_model, EXACT), (whole, EXACT))
        for solution in [solve(model, options)[0]]
    ]
    assert energy[0] < energy[1] * (1 - 1e-4) and energy[1] < energy[2] * (1 - 1e-4)


def test_an_open_crack_is_the_same_to_the_bit_with_contact_and_without():
    model = cracked(magnitude=1e-3)
    on, off = (solve(model, options)[0] for options in (EXACT, OFF))
    assert on.displacement.tobytes() == off.displacement.tobytes()
    assert on.record == off.record and on.contact is None and "contact_pairs" not in on.record


def test_lips_overlap_where_contact_is_switched_off():
    model = cracked(magnitude=-1e-3)
    solution, report = solve(model, OFF)
    assert solution.contact is None and overlap(model, solution) > 1e-4 and "overlap" not in report


def test_contact_gives_the_same_bits_again():
    first, second = (solve(bent(cracked()))[0] for _ in range(2))
    assert first.displacement.tobytes() == second.displacement.tobytes()
    assert first.contact.tobytes() == second.contact.tobytes() and first.record == second.record


def test_parts_of_a_severed_body_press_on_each_other():
    severed = plane_crack(2, 2, lambda centres: np.ones(len(centres), bool))
    model = cracked(severed, magnitude=-1e-3)
    solution, report = solve(model, EXACT)
    assert report["contact_closed"] == report["contact_pairs"]
    z = model.mesh.points[:, 2]
    assert np.abs(solution.displacement[:, 2] + 1e-3 * (z - z.min())).max() <= 1e-9 * np.ptp(z)
