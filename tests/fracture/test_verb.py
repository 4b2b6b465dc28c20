"""`craftmesh fracture`: from a solved volume to sif.csv and fracture.json."""

import csv
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from edge_crack import write_edge_crack
from structured_box import structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.cli import main
from craftmesh.growth.steps import CycleCount
from craftmesh.io.front_csv import read_front
from craftmesh.io.npz import write_labels
from craftmesh.io.vtk import read_tets, write_tets
from craftmesh.types import Voxels

MATERIAL = ("--material", "isotropic:70,0.3")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A box with an edge crack, its front from face to face, its solution, and the crack's surface."""
    path = tmp_path_factory.mktemp("fracture")
    write_edge_crack(path, (10, 4, 10))
    solved = ("--quarter-points", "--tolerance", "1e-6")
    assert main(["solve", str(path / "volume.vtu"), "-o", str(path / "u.npz"), *MATERIAL, *solved]) == 0
    return path


def run(folder, *flags):
    target = ("-o", str(folder / "sif.csv"), "--json", str(folder / "fracture.json"))
    return main(["fracture", str(folder / "volume.vtu"), str(folder / "u.npz"), *target, *MATERIAL, *flags])


def test_an_edge_crack_in_tension(folder):
    assert run(folder, "--quarter-points", "--probe", "2", "--units", "um", "MPa") == 0
    columns = read_front(folder / "sif.csv")
    # as in a long strip of height 10: its energy ahead of the crack goes into the front
    exact = 70 * 1e-3 * np.sqrt(10 / 2 / (1 - 0.3**2))
    assert columns["K_I"][1:-1] == pytest.approx(exact, rel=0.1)
    assert np.abs(columns["K_II"][1:-1]).max() < 0.05 * columns["K_I"].max()
    assert np.abs(columns["probe_angle"][1:-1]).max() < 15
    with open(folder / "sif.csv", newline="", encoding="ascii") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 5 and rows[0]["flags"].startswith("end") and rows[-1]["flags"].startswith("end")
    report = json.loads((folder / "fracture.json").read_text())
    assert report["fronts"][0]["nodes"] == 5
    assert report["units"].keys() < columns.keys()
    assert report["units"]["K_I"] == "MPa sqrt(um)" and report["units"]["probe_angle"] == "degrees"


def test_kink_angles_by_the_near_field_are_those_of_erdogan_and_sih_in_isotropic_grains(folder):
    columns = {}
    for criterion in ("tangential_stress", "near_field"):
        flags = ("--crack", str(folder / "crack.vtp"), "--criterion", criterion)
        assert run(folder, "--quarter-points", *flags) == 0
        columns[criterion] = read_front(folder / "sif.csv")
    known, found = (columns[name] for name in ("tangential_stress", "near_field"))
    assert found["kink_angle"] == pytest.approx(known["kink_angle"], abs=5e-3)
    assert found["driving"] == pytest.approx(known["driving"], rel=1e-4)


def test_by_slip_the_front_goes_along_the_most_active_plane(folder, capsys):
    """The crystal's axes are the sample's: (111) meets the plane across a front along y at 45 degrees."""
    grid = np.moveaxis(np.mgrid[0:10:21j, 0:4:9j, 0:10:21j], 0, -1).reshape(-1, 3)
    table = np.column_stack([grid, np.ones(len(grid)), np.full(len(grid), 2.0)])
    np.savetxt(folder / "slip.csv", table, "%g", ",", header="x,y,z,slip_001,slip_111", comments="")
    flags = ("--quarter-points", "--crack", str(folder / "crack.vtp"), "--criterion", "slip")
    flags += ("--slip-table", str(folder / "slip.csv"))
    assert run(folder, *flags) == 1
    assert "has no orientation; give orientations" in capsys.readouterr().err
    known = Voxels(
        np.ones((1, 1, 1), int), (1,) * 3, (0,) * 3, orientations=np.tile([1.0, 0, 0, 0], (2, 1))
    )
    write_labels(folder / "labels.npz", known)
    assert run(folder, *flags, "--microstructure", str(folder / "labels.npz")) == 0
    assert np.abs(read_front(folder / "sif.csv")["kink_angle"]) == pytest.approx(45, abs=1)


# Shear sxz stresses (001) along [100], and tension along x and y pulls on (111). (001) slips a little more.
@pytest.mark.parametrize(
    ("parameter", "shear", "angle"),
    [("slip", 200, 0), ("fatemi_socie", 200, 45), ("energy", 200, 0), ("energy", 0, 45)],
)
def test_the_slip_parameter_decides_along_which_plane_the_front_goes(folder, parameter, shear, angle):
    grid = np.moveaxis(np.mgrid[0:10:21j, 0:4:9j, 0:10:21j], 0, -1).reshape(-1, 3)
    rows = np.tile([1.0, 0.9, 300, 300, 0, 0, shear, 0], (len(grid), 1))
    header = "x,y,z,slip_001_100,slip_111_-101,sxx,syy,szz,sxy,sxz,syz"
    np.savetxt(folder / "slip.csv", np.column_stack([grid, rows]), "%g", ",", header=header, comments="")
    turns = np.tile([1.0, 0, 0, 0], (3, 1))
    write_labels(
        folder / "labels.npz", Voxels(np.ones((1, 1, 1), int), (1,) * 3, (0,) * 3, orientations=turns)
    )
    flags = ["--quarter-points", "--crack", str(folder / "crack.vtp"), "--criterion", "slip"]
    flags += ["--slip-table", str(folder / "slip.csv"), "--microstructure", str(folder / "labels.npz")]
    flags += ["--slip-parameter", parameter]
    if parameter == "fatemi_socie":
        flags += ["--fatemi-socie-k", "1", "--cyclic-yield-stress", "400"]
    assert run(folder, *flags) == 0
    assert np.abs(read_front(folder / "sif.csv")["kink_angle"]) == pytest.approx(angle, abs=1)


def test_a_slip_table_without_grains_is_rejected_in_a_body_with_boundaries(folder, capsys):
    mesh = read_tets(folder / "volume.vtu")
    far = mesh.points[mesh.tets[:, :4], 0].mean(axis=1) > 9
    write_tets(folder / "two.vtu", replace(mesh, grain=np.where(far, 2, mesh.grain)))
    (folder / "slip.csv").write_text("x,y,z,slip\n5,2,5,1\n")
    turns = np.tile([1.0, 0, 0, 0], (3, 1))
    two = Voxels(np.array([1, 2]).reshape(2, 1, 1), (1,) * 3, (0,) * 3, orientations=turns)
    write_labels(folder / "two.npz", two)
    flags = ["--quarter-points", "--crack", str(folder / "crack.vtp"), "--criterion", "slip", *MATERIAL]
    flags += ["--slip-table", str(folder / "slip.csv"), "--microstructure", str(folder / "two.npz")]
    files = [str(folder / name) for name in ("two.vtu", "u.npz", "sif.csv")]
    assert main(["fracture", *files[:2], "-o", files[2], *flags]) == 1
    assert "slip.csv: has no column grain, but the body has several grains" in capsys.readouterr().err


def test_cycles_are_counted_on_from_the_front_before(folder, capsys):
    law = (
        "--quarter-points",
        "--crack",
        str(folder / "crack.vtp"),
        "--share",
        "0.2",
        "--coefficient",
        "1e-6",
    )
    assert run(folder, *law) == 0
    first = json.loads((folder / "fracture.json").read_text())["growth"]
    assert first["cycles"] == 0 and first["size"] == pytest.approx(5, rel=2e-3)
    (folder / "fracture.json").rename(folder / "first.json")
    assert run(folder, *law, "--last", str(folder / "first.json")) == 0
    second = json.loads((folder / "fracture.json").read_text())["growth"]
    # the field is the same: K stays as it is from front to front
    assert second["cycles"] == pytest.approx(first["step"] / first["rate"])
    assert read_front(folder / "sif.csv")["cycles"] == pytest.approx(second["cycles"])
    columns = read_front(folder / "sif.csv")
    assert columns["da_dN"] == pytest.approx(
        1e-6 * columns["delta_K" if "delta_K" in columns else "driving"] ** 3
    )
    assert columns["cycles_ahead"] == pytest.approx(columns["extension"] / columns["da_dN"])
    (folder / "growth.json").write_text('{"laid": 0.5}')
    laid = ("--last-growth", str(folder / "growth.json"))
    assert run(folder, *law, "--last", str(folder / "first.json"), *laid) == 0
    half = json.loads((folder / "fracture.json").read_text())["growth"]
    assert half["cycles"] == pytest.approx(second["cycles"] / 2)
    (folder / "first.json").write_text('{"fronts": []}')
    capsys.readouterr()
    assert run(folder, *law, "--last", str(folder / "first.json")) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert "first.json" in line and "--crack" in line


def test_a_mesh_without_a_front_has_no_rows(folder, tmp_path):
    """As where a crack has reached a hole; the cycles to there are those that were foreseen."""
    write_tets(
        tmp_path / "volume.vtu", assemble(*structured_box((2, 2, 2), lambda c: np.ones(len(c), int)))[0]
    )
    files = [str(tmp_path / name) for name in ("volume.vtu", "u.npz")]
    assert main(["solve", files[0], "-o", files[1], *MATERIAL]) == 0
    last = dict.fromkeys(CycleCount._fields, 0.0) | {"rate": 1.0, "cycles": 5.0, "ahead": 2.0}
    (tmp_path / "last.json").write_text(json.dumps({"growth": last}))
    target = ["-o", str(tmp_path / "sif.csv"), "--json", str(tmp_path / "fracture.json")]
    growth = ["--crack", str(folder / "crack.vtp"), "--last", str(tmp_path / "last.json")]
    assert main(["fracture", *files, *target, *MATERIAL, *growth, "--coefficient", "1e-6"]) == 0
    report = json.loads((tmp_path / "fracture.json").read_text())
    assert report["fronts"] == [] and report["growth"]["cycles"] == 7.0
    header, *rows = (tmp_path / "sif.csv").read_text().splitlines()
    assert "kink_angle" in header.split(",") and not rows


def test_a_crack_under_pressure_on_its_lips_alone_goes_on(folder, tmp_path):
    model = (*MATERIAL, "--quarter-points", "--load", "none", "--lip-pressure", "0.07")
    files = [str(path) for path in (folder / "volume.vtu", tmp_path / "u.npz")]
    assert main(["solve", files[0], "-o", files[1], "--tolerance", "1e-6", *model]) == 0
    target = ("-o", str(tmp_path / "sif.csv"), "--crack", str(folder / "crack.vtp"))
    assert main(["fracture", *files, *target, *model]) == 0
    columns = read_front(tmp_path / "sif.csv")
    assert (columns["extension"] > 0).all() and (columns["K_I"] > 0).all()


def test_the_same_input_gives_the_same_bytes(folder):
    assert run(folder, "--quarter-points") == 0
    assert json.loads((folder / "fracture.json").read_text())["units"]["J"] == "stress length"
    first = (folder / "sif.csv").read_bytes()
    assert run(folder, "--quarter-points") == 0
    assert (folder / "sif.csv").read_bytes() == first


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        ((), "out of balance"),  # solved with quarter points
        (("--quarter-points", "--magnitude", "2e-3"), "the load prescribes"),
        (("--element", "C3D4"), "has .* nodes, but the mesh"),
    ],
)
def test_a_field_of_other_options_is_refused(folder, capsys, flags, said):
    assert run(folder, *flags) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("craftmesh: error:")
    assert re.search(said, line)
