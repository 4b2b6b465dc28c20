"""CalculiX runs decks with its single crystal, and slips as the resolved shear stress says."""

import os
import re
import shutil
import subprocess

import numpy as np
import pytest
import scipy
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.cli import main
from craftmesh.deck.options import DeckOptions
from craftmesh.deck.write_deck import write_deck
from craftmesh.errors import CraftmeshError
from craftmesh.io.model_tables import read_displacements, read_frd, read_slip_table
from craftmesh.io.npz import write_labels
from craftmesh.io.stage_npz import read_solution, read_solution_vtu, read_solutions
from craftmesh.io.user_material import read_template
from craftmesh.io.vtk import write_tets
from craftmesh.mechanics.model import elastic_model
from craftmesh.mechanics.orientation import quaternion_to_matrix, random_orientations
from craftmesh.mechanics.user_materials import parse_templates
from craftmesh.mesh.second_order import raise_order
from craftmesh.mesh.tet_connectivity import tet_volumes
from craftmesh.report.charts import loops
from craftmesh.solve.foreign import check_solutions
from craftmesh.solve.options import SolveOptions
from craftmesh.solve.solve import solve
from craftmesh.types import Voxels

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


def planes_by_shear(matrix):
    """Return the planes {111} by the largest resolved shear stress on each under tension along z."""
    pull, planes = matrix[2], np.array([[1, 1, 1], [1, 1, -1], [1, -1, 1], [1, -1, -1]])
    ways = np.array([(0, 1, 1), (0, 1, -1), (1, 0, 1), (1, 0, -1), (1, 1, 0), (1, -1, 0)])
    shear = np.abs((planes @ pull)[:, None] * (ways @ pull)) * (planes @ ways.T == 0)
    return planes[np.argsort(-shear.max(axis=1))]


def slipped(folder, stress, steps):
    """Return the slip (18,) of a crystal under uniaxial stress, and the matrix of its orientation."""
    mesh, _ = assemble(*structured_box((1, 1, 1), lambda c: np.ones(len(c), int)))
    turn = random_orientations(2, np.random.default_rng(8))
    options = DeckOptions(
        load="stress", magnitude=stress, steps=steps, user_material="single_crystal", output_every=10_000
    )
    write_deck(folder / "model.inp", mesh, options, turn, None, linear_template())
    run(folder)
    slip = read_frd(folder / "model.frd", {"SDV": 60})["SDV"][1][:, SLIP]
    assert np.ptp(slip, axis=0).max() <= 1e-5 * slip.max() + 1e-12  # the stress is uniform
    return slip[0], quaternion_to_matrix(turn[1])


def test_a_crystal_slips_where_the_resolved_shear_stress_passes_its_strength(tmp_path):
    """Under sigma(t) = sigma t the slip of a system is (m sigma - r0)^2 / (2 K m sigma), and 0 below r0."""
    stress = 78.0
    slip, matrix = slipped(tmp_path, stress, ("ramp:1,increments=60",))
    found, factors = np.sort(slip)[::-1], schmid_factors(matrix)
    over = np.maximum(factors * stress - R0, 0)
    exact = over**2 / (2 * K * factors * stress)
    assert 0 < np.count_nonzero(exact) < 12
    assert np.allclose(found[:12], exact, rtol=0, atol=0.14 * exact.max()) and (found[12:] == 0).all()
    assert ((found[:12] > 0) == (exact > 0)).all()
    planes = np.array(
        [re.findall(r"-?\d", hkl) for hkl in read_template("single_crystal")["slip_planes"]], int
    )
    (most,) = np.unique(planes[slip == slip.max()], axis=0)
    assert most.tolist() == planes_by_shear(matrix)[0].tolist()


BY_HAND = """*NODE, NSET=ALL
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
5, 0, 0, 1
6, 1, 0, 1
7, 1, 1, 1
8, 0, 1, 1
*ELEMENT, TYPE=C3D8, ELSET=CUBE
1, 1, 2, 3, 4, 5, 6, 7, 8
*ORIENTATION, NAME=TURN, SYSTEM=RECTANGULAR
{axes}
*MATERIAL, NAME=SINGLE_CRYSTAL
*USER MATERIAL, CONSTANTS=21
106750, 60410, 28340, {K}, 1, 1e-6, 1e-6, 1
1, {R0}, 1e-6, 1e-6, 30, 10, 5000, 200
1, 1, 1e6, 10, 10
*DEPVAR
60
*SOLID SECTION, ELSET=CUBE, MATERIAL=SINGLE_CRYSTAL, ORIENTATION=TURN
*BOUNDARY
1, 1, 3
2, 2, 3
4, 3, 3
3, 3, 3
*STEP, INC=1000
*STATIC
{step}, 1, 1e-5, {step}
*DLOAD
1, P2, -78
*EL FILE, FREQUENCY=1000
SDV
*END STEP
"""


def test_a_cube_written_by_hand_slips_alike(tmp_path):
    """One brick, with the constants, the orientation and the load as CalculiX' manual has them."""
    (tmp_path / "ours").mkdir()
    ours, matrix = slipped(tmp_path / "ours", 78.0, ("ramp:1,increments=20",))
    axes = ", ".join(f"{x:.15g}" for x in matrix[:, :2].T.ravel())
    (tmp_path / "model.inp").write_text(BY_HAND.format(axes=axes, K=K, R0=R0, step=1 / 20))
    run(tmp_path)
    slip = read_frd(tmp_path / "model.frd", {"SDV": 60})["SDV"][1][0, SLIP]
    assert slip.max() > 1e-4 and slip == pytest.approx(ours, abs=1e-4 * slip.max())  # .frd has 6 digits


def test_two_cycles_give_the_slip_of_one_material_point(tmp_path):
    """A triangle between +-sigma is over r0 in four quarter periods a cycle, each as in the ramp."""
    slip, matrix = slipped(tmp_path, 78.0, ("triangle:1,R=-1,cycles=2,time=4,increments=80",))
    found, factors = np.sort(slip)[::-1], schmid_factors(matrix)
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
    # lips that do not press overlap by half of the largest displacement; the penalty leaves 1e-3 of it
    assert np.abs(moved - ours)[lips].max() <= 2e-3 * np.abs(ours).max()


def test_solve_gives_the_fields_at_the_end_and_the_loop_of_the_face(tmp_path):
    """Through `craftmesh solve`, with a deck in another unit of length."""
    mesh, _ = assemble(*structured_box((2, 2, 2), lambda c: np.where(c[:, 0] < 1, 1, 2)))
    write_tets(tmp_path / "volume.vtu", mesh)
    turns = random_orientations(3, np.random.default_rng(1))
    labels = np.ones((2, 2, 2), np.int32)
    labels[1] = 2
    write_labels(tmp_path / "labels.npz", Voxels(labels, (1.0,) * 3, (0.0,) * 3, orientations=turns))
    files = f"{tmp_path}/volume.vtu --microstructure {tmp_path}/labels.npz"
    options = "--user-material single_crystal --magnitude 5e-3 --steps triangle:1,R=-1 --scale 10"
    ends = f"-o {tmp_path}/solution.npz --vtu {tmp_path}/solution.vtu --slip-table {tmp_path}/slip.csv"
    assert main(f"solve {files} {options} --solver calculix {ends}".split()) == 0
    solution = read_solution(tmp_path / "solution.npz")
    strain, stress = (solution.history[f"ZMAX.z {name}"] for name in ("strain", "stress"))
    assert strain.max() == pytest.approx(5e-3) and strain.min() == pytest.approx(-5e-3)
    assert abs(strain[-1]) < 1e-12 and stress[-1] > 50  # flow in compression leaves tension
    # the first increments are elastic: slip begins over r0, at 2 r0 of uniaxial stress or more
    modulus = stress[1] / strain[1]
    assert 60e3 < modulus < 77e3 and stress[0] == strain[0] == 0
    assert stress.max() < 0.5 * modulus * 5e-3
    points, elements, of_nodes, slip = read_solution_vtu(tmp_path / "solution.vtu")
    volumes = tet_volumes(points, elements[:, :4])
    mean = np.average(of_nodes[elements[:, 4:]].mean(axis=1)[:, 2], weights=volumes)
    assert mean == pytest.approx(stress[-1], rel=0.02)  # means at nodes are not those of elements
    assert slip.max() == pytest.approx(solution.record["largest_slip"]) and slip.min() >= 0
    table = read_slip_table(tmp_path / "slip.csv")
    places, at_end = table.points, table.stress
    assert len(table.normals) == 7 and table.slip.sum(axis=1).max() <= slip.max() * (1 + 1e-6)
    solved = raise_order(mesh)
    near, at = scipy.spatial.cKDTree(solved.points).query(places)
    assert near.max() == 0 and 0 < len(places) < len(solved.points)
    assert at_end.shape == (len(places), 6) and at_end[:, 2].max() > 50  # tension is left along z
    for node, own in zip(at, table.grain):  # no node of the table is shared by grains
        assert (solved.grain[(solved.tets == node).any(axis=1)] == own).all()
    with pytest.raises(CraftmeshError, match="end of a load in steps, but K needs elastic fields"):
        model, _ = elastic_model(mesh, DeckOptions())
        check_solutions(model, read_solutions(tmp_path / "solution.npz"), "solution.npz")
    assert loops(solution.history, "MPa").axes[0].get_ylabel() == "nominal stress [MPa]"
    assert main(f"solve {files} {options} --solver external {ends}".split()) == 1
