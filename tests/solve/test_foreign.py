"""Fields of other programs are held against the model, and CalculiX finds the built-in solver's."""

import shutil
import stat
import sys
from pathlib import Path

import numpy as np
import pytest
from structured_box import hexagon, plane_crack, structured_box

from craftmesh import cli
from craftmesh.assembly.assemble import assemble
from craftmesh.errors import CraftmeshError
from craftmesh.io.npz import write_labels
from craftmesh.io.stage_npz import read_solution
from craftmesh.io.vtk import write_tets
from craftmesh.mechanics.model import ElasticModel, elastic_model
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.mechanics.orientation import random_orientations
from craftmesh.solve.foreign import foreign_solution
from craftmesh.solve.options import SolveOptions
from craftmesh.solve.solve import solve
from craftmesh.types import Voxels

COPPER = "cubic:168.4e3,121.4e3,75.4e3"


def cracked():
    crack = plane_crack(2, 2, hexagon((3, 3), 2))
    return assemble(*structured_box((6, 6, 4), lambda c: np.where(c[:, 0] < 3, 1, 2), crack))[0]


def orientations() -> np.ndarray:
    return random_orientations(3, np.random.default_rng(1))


def model_of(**options) -> ElasticModel:
    return elastic_model(cracked(), ModelOptions(material=(COPPER,), **options), orientations())[0]


@pytest.fixture(scope="module")
def solved() -> tuple[ElasticModel, np.ndarray]:
    model = model_of()
    return model, solve(model)[0].displacement


@pytest.fixture
def folder(tmp_path) -> Path:
    """A folder with the mesh and the orientations of its grains."""
    write_tets(tmp_path / "volume.vtu", cracked())
    write_labels(
        tmp_path / "labels.npz", Voxels(np.ones((1, 1, 1)), np.ones(3), np.zeros(3), orientations())
    )
    return tmp_path


def run(folder: Path, *flags: str) -> int:
    return cli.main(
        ["solve", str(folder / "volume.vtu"), "--microstructure", str(folder / "labels.npz")]
        + ["--material", COPPER, "-o", str(folder / "solution.npz"), *flags]
    )


def write_csv(path: Path, field: np.ndarray) -> None:
    order = np.random.default_rng(0).permutation(len(field))
    rows = [f"{field[i, 2]!r},{i + 1},{field[i, 0]!r},{field[i, 1]!r}\n" for i in order.tolist()]
    path.write_text("uz, node, ux, uy\n" + "".join(rows).replace("np.float64(", "").replace(")", ""))


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX (ccx) is not installed")
@pytest.mark.parametrize(
    "flags",
    [
        ("--quarter-points",),
        ("--load", "stress", "--magnitude", "50", "--axis", "y", "--sides", "rollers"),
        ("--element", "C3D4"),
        ("--load", "stress", "--magnitude", "50", "--element", "C3D4", "--axis", "x"),
    ],
)
def test_calculix_finds_the_same_field(folder, flags):
    assert run(folder, "--no-contact", *flags) == 0  # the deck has none
    own = read_solution(folder / "solution.npz")
    assert run(folder, "--solver", "calculix", *flags) == 0
    other = read_solution(folder / "solution.npz")
    assert other.record["solver"] == "calculix" and own.record["solver"] == "builtin"
    # .frd has six digits
    off = np.abs(own.displacement - other.displacement).max()
    assert off <= 1e-5 * np.abs(own.displacement).max()
    assert np.abs(own.reactions - other.reactions).max() <= 1e-3 * np.abs(own.reactions).max()
    assert sorted(path.name for path in folder.iterdir()) == ["labels.npz", "solution.npz", "volume.vtu"]


def test_a_field_is_waited_for_and_taken(folder, solved, capsys):
    assert run(folder, "--solver", "external") == 1
    said = capsys.readouterr().err
    model, field = solved
    assert f"waits for {folder / 'field.csv'}" in said and "columns node,ux,uy,uz" in said
    assert f"each node 1 to {len(field)}" in said and not (folder / "solution.npz").exists()
    write_csv(folder / "field.csv", field)
    assert run(folder, "--solver", "external", "--vtu", str(folder / "solution.vtu")) == 0
    first = read_solution(folder / "solution.npz")
    assert (first.displacement == field).all() and first.record["residual"] <= 1e-8
    given = ("--field", str(folder / "given.npz"))
    shutil.copy(folder / "solution.npz", folder / "given.npz")
    assert run(folder, "--solver", "external", *given) == 0
    assert (read_solution(folder / "solution.npz").reactions == first.reactions).all()


def test_a_field_of_something_else_is_refused(solved):
    model, field = solved
    numbers = np.arange(1, len(field) + 1)
    other_load = solve(model_of(axis="x"))[0].displacement
    stiff = replace_material(model)
    inside = np.setdiff1d(numbers - 1, np.concatenate(list(model.mesh.node_sets.values())))
    moved = field.copy()
    moved[inside] *= 1.5
    lost = field.copy()
    lost[4, 1] = np.nan
    for case, numbers_given, values, said in (
        (model, numbers, other_load, "moves along . by .* the load prescribes"),
        (model, numbers, moved, "of the forces out of balance"),
        (model, numbers, 1e3 * field, r"its values are those of the deck, about 1000 times as large \(um"),
        (model, numbers, 1e-6 * field, r"of the deck, about 1000000 times as small \(m beside um\?\)"),
        (stiff, numbers, field, "of the forces out of balance"),
        (model, numbers[:-1], field[:-1], f"node {len(field)} is missing"),
        (model, np.append(numbers, 3), field[[*range(len(field)), 2]], "node 3 is duplicate"),
        (model, numbers + 1, field, f"node {len(field) + 1} is no node of the deck"),
        (model, numbers, lost, "node 5 has a value that is not finite"),
    ):
        with pytest.raises(CraftmeshError, match=f"field.csv: .*{said}"):
            foreign_solution(case, numbers_given, values, "external", "field.csv")


def replace_material(model: ElasticModel) -> ElasticModel:
    """The same body of a softer material under a load of the same moves: another crystal's orientation."""
    turned = orientations()[[0, 2, 1]]
    return elastic_model(cracked(), ModelOptions(material=("cubic:168.4e3,20e3,120e3",)), turned)[0]


def program(folder: Path, text: str) -> str:
    path = folder / "program"
    path.write_text(f"#!{sys.executable}\n{text}")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return str(path)


def test_abaqus_is_called_by_the_template_and_its_csv_read(folder, solved):
    """A program in the place of Abaqus: it finds the deck and is told where the values go."""
    write_csv(folder / "values", solved[1])
    text = f"""
import pathlib, shutil, sys
job, script, field = sys.argv[1:]
assert pathlib.Path(job + ".inp").read_text().startswith("*HEADING")
assert "openOdb" in pathlib.Path(script).read_text()
shutil.copy({str(folder / "values")!r}, field)
"""
    call = program(folder, text) + " {job} {script} {field}"
    work = folder / "work"
    assert run(folder, "--solver", "abaqus", "--command", call, "--work", str(work)) == 0
    found = read_solution(folder / "solution.npz")
    assert found.record["solver"] == "abaqus" and (found.displacement == solved[1]).all()
    assert {path.name for path in work.iterdir()} == {"model.inp", "field.csv", "abaqus_1.log"}


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        (("--command", "{model}"), "command '{model}' is invalid ('model')"),
        (("--command", "not-there-at-all"), "not-there-at-all: cannot be run"),
        (("--command", "sleep 60", "--time-limit", "0.3"), "sleep: gave no answer within 0.3 s"),
        (("--command", "cat {job}.nothing"), "cat: ended with status 1 (cat: model.nothing: No such file"),
        (("--command", "true"), "abaqus: wrote no field.csv"),
    ],
)
def test_calls_that_fail_are_said_in_one_line(folder, flags, said, capsys):
    assert run(folder, "--solver", "abaqus", *flags) == 1
    assert said in capsys.readouterr().err
    assert not (folder / "solution.npz").exists()


def test_a_program_is_held_to_its_memory(folder, capsys):
    call = program(folder, "x = bytearray(2 ** 30)")
    flags = ("--solver", "calculix", "--command", call, "--memory-limit", "0.5")
    assert run(folder, *flags) == 1 and "MemoryError" in capsys.readouterr().err


def test_the_solution_says_how_it_was_found(folder):
    assert run(folder, "--tolerance", "1e-6", "--report", str(folder / "r.json")) == 0
    record = read_solution(folder / "solution.npz").record
    assert record["solver"] == "builtin" and 0 < record["residual"] <= 1e-6 and record["iterations"] > 1
    assert "seconds" in (folder / "r.json").read_text()
    first = (folder / "solution.npz").read_bytes()
    assert run(folder, "--tolerance", "1e-6") == 0
    assert (folder / "solution.npz").read_bytes() == first


def test_options_default_to_the_built_in_solver():
    assert SolveOptions().solver == "builtin"
