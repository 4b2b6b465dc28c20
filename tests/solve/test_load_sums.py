"""Sums of load cases are what solving them by themselves gives."""

from dataclasses import replace

import numpy as np
import pytest
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.deck.write_deck import write_model
from craftmesh.io.stage_npz import read_solution, read_solutions, write_solutions
from craftmesh.mechanics.model import ElasticModel, elastic_model
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.mechanics.orientation import random_orientations
from craftmesh.solve.options import SolveOptions
from craftmesh.solve.solve import solve, solve_model

COPPER = ("cubic:168.4e3,121.4e3,75.4e3",)
SOLVE = SolveOptions(tolerance=1e-10)
FACES = (
    "ZMIN.x=fixed",
    "ZMIN.y=fixed",
    "ZMIN.z=fixed",
    "tension/ZMAX.z=stress:100",
    "shear/ZMAX.x=stress:60",
)


def model_of(faces=FACES, combine=(), **options) -> ElasticModel:
    crack = plane_crack(2, 1, hexagon((2, 2), 1))
    mesh, _ = assemble(*structured_box((4, 4, 2), lambda c: np.where(c[:, 0] < 2, 1, 2), crack))
    known = random_orientations(3, np.random.default_rng(1))
    options = ModelOptions(material=COPPER, faces=faces, combine=combine, **options)
    return elastic_model(mesh, options, known)[0]


def off(found: np.ndarray, exact: np.ndarray) -> float:
    return float(np.abs(found - exact).max() / np.abs(exact).max())


def test_a_sum_of_cases_is_the_field_of_the_sum_of_loads():
    combine = ("peak=tension:1,shear:0.3", "valley=tension:0.4,shear:-0.2")
    found, report = solve_model(model_of(combine=combine), SOLVE)
    assert list(found) == ["peak", "valley"]
    for name, pull, shear in (("peak", 100, 18), ("valley", 40, -12)):
        faces = (*FACES[:3], f"ZMAX.z=stress:{pull}", f"ZMAX.x=stress:{shear}")
        alone, _ = solve(model_of(faces), SOLVE)
        # both fields are as far from the exact one as residuals of 1e-10 let them
        assert off(found[name].displacement, alone.displacement) <= 1e-8
        assert off(found[name].reactions, alone.reactions) <= 1e-8
        assert report["load_cases"][name]["iterations"] == 0  # no new solution
        assert found[name].record["residual"] <= 1e-10


def test_pressed_lips_and_eigenstrains_are_added_as_load_cases():
    strain = 1e-3 * np.array([1.0, 0.4, -0.3])
    texts = [f"orthotropic:{','.join(map(str, values))}" for values in (strain, -2 * strain)]
    combine = ("sum=tension:1,lip_pressure:0.5,eigenstrain:-2",)
    found, _ = solve_model(model_of(combine=combine, lip_pressure=90.0, eigenstrain=texts[:1]), SOLVE)
    alone, _ = solve(
        model_of(FACES[:3] + ("ZMAX.z=stress:100",), lip_pressure=45.0, eigenstrain=texts[1:]), SOLVE
    )
    assert off(found["sum"].displacement, alone.displacement) <= 1e-8


def test_without_sums_each_load_case_is_solved_as_by_itself():
    model = model_of(FACES)
    found, _ = solve_model(model, SOLVE)
    for name, load in model.cases.items():
        alone, _ = solve(replace(model, load=load, cases={}), SOLVE)
        assert np.array_equal(found[name].displacement, alone.displacement)


def test_cases_that_hold_different_faces_are_solved_each_with_its_own():
    faces = (*FACES[:3], "moved/ZMAX.x=strain:0.001", "pulled/ZMAX.x=stress:60")
    model = model_of(faces)
    found, _ = solve_model(model, SOLVE)
    for name, load in model.cases.items():
        assert off(found[name].displacement, solve(replace(model, load=load), SOLVE)[0].displacement) == 0


def test_where_lips_would_overlap_in_a_sum_it_is_solved_with_contact():
    model = model_of(combine=("open=tension:1", "shut=tension:-1,shear:0.5"))
    found, report = solve_model(model, SOLVE)
    assert found["open"].contact is None and "contact_closed" not in report["load_cases"]["open"]
    faces = (*FACES[:3], "ZMAX.z=stress:-100", "ZMAX.x=stress:30")
    alone, figures = solve(model_of(faces), SOLVE)
    assert report["load_cases"]["shut"]["contact_closed"] == figures["contact_closed"] > 0
    assert off(found["shut"].displacement, alone.displacement) <= 1e-8


def test_solutions_of_several_loads_are_read_back_and_the_first_as_one(tmp_path):
    found, _ = solve_model(model_of(combine=("open=tension:1", "shut=tension:-1")), SOLVE)
    write_solutions(tmp_path / "s.npz", found)
    again = read_solutions(tmp_path / "s.npz")
    assert list(again) == ["open", "shut"] and again["open"].contact is None
    for name in found:
        assert np.array_equal(again[name].displacement, found[name].displacement)
        assert again[name].record == found[name].record
    assert np.array_equal(again["shut"].contact, found["shut"].contact)
    assert np.array_equal(read_solution(tmp_path / "s.npz").reactions, found["open"].reactions)


@pytest.mark.parametrize("scale", [1.0, 1000.0])
def test_the_deck_of_several_cases_has_a_step_each(scale, tmp_path):
    write_model(tmp_path / "a.inp", model_of(scale=scale))
    deck = (tmp_path / "a.inp").read_text()
    steps = deck.split("*STEP\n")[1:]
    assert ["tension" in steps[0], "shear" in steps[1], len(steps)] == [True, True, 2]
    assert all("*BOUNDARY, OP=NEW\nZMIN, 1, 1, 0.0\n" in step for step in steps)
