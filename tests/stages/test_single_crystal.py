"""CalculiX runs decks with its single crystal, and slips as the resolved shear stress says."""

import os
import shutil
import subprocess

import numpy as np
import pytest
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.deck.options import DeckOptions
from craftmesh.deck.write_deck import write_deck
from craftmesh.io.model_tables import read_displacements, read_frd
from craftmesh.io.user_material import read_template
from craftmesh.mechanics.model import elastic_model
from craftmesh.mechanics.orientation import quaternion_to_matrix, random_orientations
from craftmesh.mechanics.user_materials import parse_templates
from craftmesh.mesh.second_order import raise_order
from craftmesh.solve.options import SolveOptions
from craftmesh.solve.solve import solve

pytestmark = pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX (ccx) is not installed")

K, R0 = 4000.0, 30.0
SLIP = slice(42, 60)  # state variables 43 to 60: slip accumulated on 12 octahedral and 6 cubic systems


def run(folder):
    done = subprocess.run(
        ["ccx", "-i", "model"],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=120,
        env=os.environ | {"OMP_NUM_THREADS": "1"},
    )
    assert "*ERROR" not in done.stdout + done.stderr and done.returncode == 0, done.stdout[-2000:]
    assert [row for row in done.stdout.splitlines() if "*WARNING" in row and "NSET" not in row] == []


def cracked():
    """Return a box of two grains with a crack inside."""
    crack = plane_crack(2, 2, hexagon((2, 2), 1))
    return assemble(*structured_box((4, 4, 4), lambda c: np.where(c[:, 0] < 2, 1, 2), crack))[0]


def linear_template():
    """Return the single crystal with slip rates linear in the overstress, and next to no hardening."""
    content = read_template("single_crystal")
    content["values"][3:12] = [K, 1, 1e-6, 1e-6, 1, 1, R0, 1e-6, 1e-6]
    return parse_templates(content, "linear")


def schmid_factors(matrix, axis=2):
    """Return |m| of the 12 systems {111}<110> under tension along a sample axis, largest first."""
    pull = matrix.T[:, axis]
    planes = [np.array([1, i, j]) / np.sqrt(3) for i in (1, -1) for j in (1, -1)]
    ways = [
        np.array(d) / np.sqrt(2)
        for d in ((0, 1, 1), (0, 1, -1), (1, 0, 1), (1, 0, -1), (1, 1, 0), (1, -1, 0))
    ]
    found = [abs((n @ pull) * (d @ pull)) for n in planes for d in ways if abs(n @ d) < 1e-9]
    return np.sort(found)[::-1]


def slipped(folder, stress, steps):
    """Return the slip (18,) of a crystal under uniaxial stress, and its Schmid factors."""
    mesh, _ = assemble(*structured_box((1, 1, 1), lambda c: np.ones(len(c), int)))
    turn = random_orientations(2, np.random.default_rng(8))
    options = DeckOptions(
        load="stress", magnitude=stress, steps=steps, user_material="single_crystal", output_every=10_000
    )
    write_deck(folder / "model.inp", mesh, options, turn, None, linear_template())
    run(folder)
    slip = read_frd(folder / "model.frd", {"SDV": 60})["SDV"][1][:, SLIP]
    assert np.ptp(slip, axis=0).max() <= 1e-5 * slip.max() + 1e-12  # the stress is uniform
    return np.sort(slip[0])[::-1], schmid_factors(quaternion_to_matrix(turn[1]))


def test_a_crystal_slips_where_the_resolved_shear_stress_passes_its_strength(tmp_path):
    """Under sigma(t) = sigma t the slip of a system is (m sigma - r0)^2 / (2 K m sigma), and 0 below r0."""
    stress = 78.0
    found, factors = slipped(tmp_path, stress, ("ramp:1,increments=60",))
    over = np.maximum(factors * stress - R0, 0)
    exact = over**2 / (2 * K * factors * stress)
    assert 0 < np.count_nonzero(exact) < 12
    assert np.allclose(found[:12], exact, rtol=0, atol=0.14 * exact.max()) and (found[12:] == 0).all()
    assert ((found[:12] > 0) == (exact > 0)).all()


def test_two_cycles_give_the_slip_of_one_material_point(tmp_path):
    """A triangle between +-sigma is over r0 in four quarter periods a cycle, each as in the ramp."""
    found, factors = slipped(tmp_path, 78.0, ("triangle:1,R=-1,cycles=2,time=4,increments=80",))
    over = np.maximum(factors * 78.0 - R0, 0)
    exact = 2 * 4 * over**2 / (2 * K * factors * 78.0)
    # differences too large on the way up are too small on the way down: 0.03
    assert np.allclose(found[:12], exact, rtol=0, atol=0.05 * exact.max())


def test_cracked_crystals_slip_while_their_lips_press(tmp_path):
    options = DeckOptions(
        magnitude=2e-3,
        steps=("ramp:-1,increments=4",),
        user_material="single_crystal",
        output_every=100,
        restart_every=1,
        lip_contact=True,
    )
    template = parse_templates(read_template("single_crystal"), "preset")
    turns = random_orientations(3, np.random.default_rng(1))
    write_deck(tmp_path / "model.inp", cracked(), options, turns, None, template)
    run(tmp_path)
    assert read_frd(tmp_path / "model.frd", {"SDV": 60})["SDV"][1][:, SLIP].max() > 1e-4
    assert (tmp_path / "model.rout").stat().st_size > 0


def test_lips_under_compression_meet_as_in_the_built_in_solver(tmp_path):
    mesh = cracked()
    options = DeckOptions(lip_contact=True, load="stress", magnitude=-100.0, steps=("ramp:1,increments=1",))
    write_deck(tmp_path / "model.inp", mesh, options)
    run(tmp_path)
    moved = read_displacements(tmp_path / "model.frd")[1]
    ours = solve(elastic_model(mesh, options)[0], SolveOptions())[0].displacement
    sets = raise_order(mesh).node_sets
    lips = np.unique(np.concatenate([sets["CRACK_LIP_A"], sets["CRACK_LIP_B"]]))
    # lips that do not press overlap by half of the largest displacement; the penalty leaves 1e-4 of it
    assert np.abs(moved - ours)[lips].max() <= 2e-4 * np.abs(ours).max()
