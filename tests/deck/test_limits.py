"""Decks are held to what Abaqus and CalculiX take, and another unit of length is the same model."""

import shutil
from dataclasses import replace

import numpy as np
import pytest
from deck_reader import of_kind, points_of, read_deck
from hypothesis import given, settings
from hypothesis import strategies as st
from structured_box import structured_box

from craftmesh import cli
from craftmesh.assembly.assemble import assemble
from craftmesh.deck.check_deck import check_deck
from craftmesh.deck.limits import LEAST_JACOBIAN, deck_warning
from craftmesh.deck.write_deck import write_model
from craftmesh.errors import CraftmeshError
from craftmesh.io.stage_npz import read_solution
from craftmesh.io.vtk import write_tets
from craftmesh.mechanics.model import ElasticModel, elastic_model
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.mechanics.units import UnitsOptions
from craftmesh.solve.solve import solve
from craftmesh.types import TetMesh

NANOMETRES = 1e-7  # edge of a voxel of 100 nm in metres


def block(edge: float = 1.0, **sets) -> TetMesh:
    mesh = assemble(*structured_box((2, 2, 2), lambda c: np.where(c[:, 0] < 1, 1, 2), None, (edge,) * 3))[0]
    named = {name: dict(getattr(mesh, name)) | own for name, own in sets.items()}
    return replace(mesh, **named)


def model_of(mesh: TetMesh, **options) -> ElasticModel:
    return elastic_model(mesh, ModelOptions(**options))[0]


@settings(max_examples=20)
@given(
    scale=st.floats(1e-9, 1e9),
    load=st.sampled_from(("strain", "stress")),
    axis=st.sampled_from(tuple("xyz")),
)
def test_a_model_in_another_unit_of_length_has_the_same_strains(scale, load, axis):
    magnitude = {"strain": 1e-3, "stress": 140.0}[load]
    model = model_of(block(0.7), load=load, magnitude=magnitude, axis=axis, scale=scale)
    scaled = model.in_unit_of_deck()
    assert scaled.scale == 1 and (scaled.stiffness() == model.stiffness()).all()
    ours, theirs = solve(model)[0], solve(scaled)[0]
    moved = theirs.displacement / scale
    assert np.allclose(moved, ours.displacement, rtol=0, atol=1e-6 * np.abs(ours.displacement).max())
    forces = theirs.reactions / scale**2
    assert np.allclose(forces, ours.reactions, rtol=0, atol=1e-6 * np.abs(ours.reactions).max())


@pytest.mark.parametrize("scale", [1.0, 1e3, 1e6])
def test_the_deck_has_scaled_points_and_moves_and_says_so(tmp_path, scale):
    mesh = block(NANOMETRES)
    model = model_of(mesh, scale=scale)
    write_model(tmp_path / "model.inp", model)
    blocks = read_deck(tmp_path / "model.inp")
    assert np.allclose(points_of(blocks), scale * model.mesh.points, rtol=1e-14, atol=0)
    moved = float(of_kind(blocks, "BOUNDARY")[1][1][0][3])
    assert moved == pytest.approx(scale * 2 * NANOMETRES * 1e-3, rel=1e-12)
    ((_, elastic),) = of_kind(blocks, "ELASTIC")
    assert [float(value) for value in elastic[0]] == [70000, 0.33]
    text = (tmp_path / "model.inp").read_text()
    for what, factor in (("displacements", scale), ("forces", scale**2)):
        assert (f"{what} are {factor:g} times the model's" in text) == (scale != 1)
    breaches = check_deck(tmp_path / "model.inp")
    assert len(breaches) == (scale == 1) and all("CalculiX treats as 0" in one for one in breaches)


@pytest.mark.parametrize("element", ["C3D4", "C3D10"])
@settings(max_examples=20)
@given(power=st.floats(-12, -4))
def test_the_factor_that_a_warning_names_is_enough(element, power):
    mesh, least = block(10**power), 10 ** (3 * power)
    said = deck_warning(model_of(mesh, element=element))
    if abs(least / LEAST_JACOBIAN - 1) > 1e-6:
        assert bool(said) == (least < LEAST_JACOBIAN)
    if said:
        factor = int(said.split(" times smaller")[0].split()[-1])
        assert not deck_warning(model_of(mesh, element=element, scale=float(factor)))
        assert deck_warning(model_of(mesh, element=element, scale=factor / 1000))


@pytest.mark.parametrize(
    ("units", "said"),
    [
        ((), []),
        (("um", ""), ["** Units of the model: length um, area um^2"]),
        (("", "MPa"), ["** Units of the model: stress MPa"]),
        (
            ("\u00b5m", "MPa"),
            ["area um^2, force MPa um^2, K MPa sqrt(um), J MPa um, stress MPa"],
        ),
        (("a\n*NODE", "x" * 300), ["length a *NODE"]),
    ],
)
def test_units_are_named_in_the_heading_and_nowhere_else(tmp_path, units, said):
    write_model(tmp_path / "a.inp", model_of(block()))
    write_model(tmp_path / "b.inp", model_of(block()), units=UnitsOptions(*units))
    lines = (tmp_path / "b.inp").read_text("ascii").splitlines()
    added = [line for line in lines if line.startswith("** Units")]
    assert len(added) == len(said) and all(text in line for text, line in zip(said, added))
    assert [line for line in lines if line not in added] == (tmp_path / "a.inp").read_text().splitlines()
    assert check_deck(tmp_path / "b.inp") == []


NODES, FACES = np.array([0, 1]), np.array([[0, 0]])


@pytest.mark.parametrize(
    ("sets", "said"),
    [
        ({"node_sets": {"N" * 81: NODES}}, "over 80 characters"),
        ({"face_sets": {"F" * 79: FACES}}, "element set .* over 80 characters"),  # with its _S1
        *(
            ({"node_sets": {name: NODES}}, "is not a letter followed")
            for name in ("7", "1TOP", "my set", "a,b", "a=b", "*TOP", "t\u00fcr", "", "a\nb", "a.b", "_A")
        ),
        ({"node_sets": {"Top": NODES, "TOP": NODES}}, "is duplicate to the solvers"),
        ({"node_sets": {"nall": NODES}}, "is duplicate to the solvers"),
        ({"face_sets": {"eall": FACES, "EALL": FACES}}, "is duplicate to the solvers"),
    ],
)
def test_names_that_the_solvers_do_not_read_are_refused(tmp_path, sets, said):
    with pytest.raises(CraftmeshError, match=f"^deck: the .*{said}") as error:
        write_model(tmp_path / "model.inp", model_of(block(**sets)))
    assert "\n" not in str(error.value) and list(tmp_path.iterdir()) == []


def test_empty_sets_need_no_name_and_names_of_eighty_characters_are_written(tmp_path):
    mesh = block(node_sets={"N" * 80: NODES, "not written": NODES[:0]})
    write_model(tmp_path / "model.inp", model_of(mesh))
    assert check_deck(tmp_path / "model.inp") == []


def test_inp_and_solve_say_what_calculix_would_refuse(tmp_path, capsys):
    write_tets(tmp_path / "volume.vtu", block(NANOMETRES))
    volume, deck, field = (str(tmp_path / name) for name in ("volume.vtu", "model.inp", "u.npz"))
    assert cli.main(["inp", volume, "-o", deck]) == 0
    (line,) = capsys.readouterr().err.splitlines()
    assert "warning" in line and "1000 times smaller (inp.scale)" in line
    assert cli.main(["solve", volume, "--solver", "calculix", "-o", field]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("craftmesh: error: calculix: ") and "1000 times smaller" in line
    assert cli.main(["inp", volume, "--scale", "1000", "-o", deck]) == 0
    assert capsys.readouterr().err == "" and cli.main(["check", deck]) == 0


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX (ccx) is not installed")
def test_calculix_solves_voxels_of_100_nm_in_metres(tmp_path):
    write_tets(tmp_path / "volume.vtu", block(NANOMETRES))
    found = {}
    for solver in ("builtin", "calculix"):
        flags = ["--solver", solver, "--scale", "1000", "-o", str(tmp_path / f"{solver}.npz")]
        assert cli.main(["solve", str(tmp_path / "volume.vtu"), *flags]) == 0
        found[solver] = read_solution(tmp_path / f"{solver}.npz")
    moved, reactions = found["builtin"].displacement, found["builtin"].reactions
    assert np.abs(moved).max() == pytest.approx(2e-10, rel=1e-6)  # a strain of 1e-3 over 200 nm
    # .frd has six digits
    assert np.allclose(found["calculix"].displacement, moved, rtol=0, atol=1e-5 * np.abs(moved).max())
    assert np.allclose(found["calculix"].reactions, reactions, rtol=0, atol=1e-3 * np.abs(reactions).max())


def test_a_field_that_is_brought_is_in_the_decks_unit(tmp_path):
    mesh = block(NANOMETRES)
    write_tets(tmp_path / "volume.vtu", mesh)
    field = solve(model_of(mesh).in_unit_of_deck())[0].displacement
    rows = (f"{k},{x!r},{y!r},{z!r}" for k, (x, y, z) in enumerate((1e6 * field).tolist(), 1))
    (tmp_path / "field.csv").write_text("\n".join(["node,ux,uy,uz", *rows]))
    flags = ["--solver", "external", "--scale", "1000000", "-o", str(tmp_path / "u.npz")]
    assert cli.main(["solve", str(tmp_path / "volume.vtu"), *flags]) == 0
    assert np.allclose(read_solution(tmp_path / "u.npz").displacement, field, rtol=1e-12, atol=0)
