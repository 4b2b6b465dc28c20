"""Eigenstrains strain bodies that are free, stress those that are held, and are read by phase."""

import numpy as np
import pytest
from structured_box import structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.errors import CraftmeshError
from craftmesh.io.model_tables import read_grain_strains
from craftmesh.mechanics.eigenstrains import as_strain, parse_eigenstrains
from craftmesh.mechanics.model import elastic_model
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.mechanics.orientation import quaternion_to_matrix, random_orientations
from craftmesh.mechanics.stress import grain_stress
from craftmesh.solve.options import SolveOptions
from craftmesh.solve.solve import solve

EXACT = SolveOptions(tolerance=1e-12)
COPPER = ("cubic:168400,121400,75400",)
SHEARED = "anisotropic:1e-3,-5e-4,2e-3,1e-3,3e-4,-7e-4"


def block(label_of=lambda centres: np.where(centres[:, 0] < 1, 1, 2)):
    return assemble(*structured_box((2, 2, 3), label_of, None, (0.5, 1.0, 0.25)))[0]


def model_of(*eigenstrain, orientations=None, phases=None, **options):
    options = ModelOptions(**{"load": "none"} | options, eigenstrain=eigenstrain)
    return elastic_model(block(), options, orientations, phases)[0]


def strained(model):
    """The displacements of a solved model less those of its first node, and its stress."""
    solution, _ = solve(model, EXACT)
    moved = solution.displacement - solution.displacement[0]
    return moved, grain_stress(model, solution.displacement).stress


@pytest.mark.parametrize("element", ["C3D4", "C3D10"])
def test_a_free_body_takes_a_uniform_eigenstrain_without_stress(element):
    same = np.tile(random_orientations(1, np.random.default_rng(3)), (3, 1))
    turn = quaternion_to_matrix(same[0])
    strain = turn @ parse_eigenstrains([SHEARED])[None] @ turn.T
    model = model_of(SHEARED, orientations=same, material=COPPER, element=element)
    moved, stress = strained(model)
    points = model.mesh.points - model.mesh.points[0]
    gradient = np.linalg.lstsq(points, moved, rcond=None)[0]
    assert np.abs(moved - points @ gradient).max() < 1e-12
    assert np.abs((gradient + gradient.T) / 2 - strain).max() < 1e-12
    assert np.abs(stress).max() < 1e-7 * 168400 * 1e-3  # the solver leaves 1e-12 of the forces


def test_a_held_body_has_the_stress_of_the_opposite_strain():
    model = model_of("isotropic:2e-3", load="strain", magnitude=0.0, material=("isotropic:70000,0.3",))
    _, stress = strained(model)
    assert stress[:, 2] == pytest.approx(-70000 * 2e-3, rel=1e-9)
    assert np.abs(np.delete(stress, 2, axis=1)).max() < 1e-7


def test_a_heated_layer_is_in_balance_with_a_cold_one():
    phases = np.array([0, 1, 2])
    model = model_of("2=isotropic:1e-3", phases=phases)
    _, stress = strained(model)
    solution, report = solve(model, EXACT)
    assert report["residual"] <= 1e-12 and np.abs(stress).max() > 0.1 * 70000 * 1e-3
    # of forces of 7e1 on each element
    assert np.abs(solution.reactions).max() < 1e-9


def test_a_table_by_grain_says_what_texts_by_phase_do(tmp_path):
    turns = random_orientations(3, np.random.default_rng(3))
    given = parse_eigenstrains([SHEARED])[None]
    sample = [turn @ given @ turn.T for turn in quaternion_to_matrix(turns[1:])]
    lines = ["grain,e11,e22,e33,e12,e13,e23"]
    lines += [
        ",".join(map(repr, [grain, *strain[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]].tolist()]))
        for grain, strain in zip((1, 2), sample)
    ]
    (tmp_path / "strains.csv").write_text("\n".join(lines))
    grains, rows = read_grain_strains(tmp_path / "strains.csv")
    table = {grain: as_strain(row) for grain, row in zip(grains, rows)}
    options = ModelOptions(load="none", eigenstrain_file="strains.csv")
    by_table, _ = elastic_model(block(), options, turns, grain_strains=table)
    by_phase = model_of(SHEARED, orientations=turns)
    assert np.abs(by_table.eigenstrain() - by_phase.eigenstrain()).max() < 1e-15
    assert by_table.load.heat == 1 and by_table.eigenstrain().any()
    with pytest.raises(CraftmeshError, match="no row for 1 of 2 grains: 2"):
        elastic_model(block(), options, grain_strains={1: table[1]})
    (tmp_path / "strains.csv").write_text("grain,e\n1,1e-3\n1,2e-3")
    with pytest.raises(CraftmeshError, match="line 3: grain is 1; .*each grain only once"):
        read_grain_strains(tmp_path / "strains.csv")


@pytest.mark.parametrize(
    ("texts", "said"),
    [
        (["1e-3"], "expected KIND:VALUES"),
        (["isotropic:a"], "expected KIND:VALUES"),
        (["isotropic:nan"], "not within -1 to 1"),
        (["orthotropic:1e-3"], "expected KIND:VALUES"),
        (["isotropic:12"], "not within -1 to 1"),
        (["-1=isotropic:1e-3"], "expected KIND:VALUES"),
        (["1=isotropic:1e-3", "1=isotropic:2e-3"], "second entry for its phase"),
        (["1=isotropic:1e-3", "isotropic:2e-3"], "or one per phase"),
    ],
)
def test_other_texts_are_refused(texts, said):
    with pytest.raises(CraftmeshError, match=f"^eigenstrain: .*{said}"):
        parse_eigenstrains(texts)


def test_strains_that_do_not_fit_the_grains_are_refused():
    with pytest.raises(CraftmeshError, match="no grain has phase 3; expected one of 1, 2"):
        model_of("3=isotropic:1e-3", phases=np.array([0, 1, 2]))
    with pytest.raises(CraftmeshError, match="grains have no phase"):
        model_of("3=isotropic:1e-3")
    with pytest.raises(CraftmeshError, match="grain 1 has no orientation"):
        model_of("orthotropic:1e-3,0,0")
