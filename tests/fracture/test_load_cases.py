"""`craftmesh fracture` of several loads: rows of each, and growth by a pair of them."""

import json

import numpy as np
import pytest
from edge_crack import write_edge_crack

from craftmesh.cli import main
from craftmesh.io.front_csv import read_front
from craftmesh.io.text_table import read_table

MODEL = ("--material", "isotropic:70000,0.3", "--quarter-points", "--faces", "ZMIN.z=fixed", "ZMIN.x=fixed")
MODEL += ("ZMIN.y=fixed", "pull/ZMAX.z=stress:100", "shear/ZMAX.x=stress:60", "back/ZMAX.z=stress:-100")
PAIR = ("--combine", "valley=pull:0.4,shear:0.12", "peak=pull:1,shear:0.3", "shut=back:1")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A box with an edge crack, its front from face to face, its load cases solved, and its surface."""
    path = tmp_path_factory.mktemp("cases")
    write_edge_crack(path, (8, 3, 8))
    for name, flags in (("cases", ()), ("sums", PAIR)):
        assert (
            verb("solve", path, "-o", str(path / f"{name}.npz"), "--tolerance", "1e-9", *MODEL, *flags) == 0
        )
    return path


def verb(name, folder, *flags):
    return main([name, str(folder / "volume.vtu"), *flags])


def fracture(folder, solution, *flags):
    """Run the verb; return the columns of all rows by load, and the report."""
    target = ("-o", str(folder / "sif.csv"), "--json", str(folder / "fracture.json"))
    assert verb("fracture", folder, str(folder / solution), *target, *MODEL, *flags) == 0
    table = read_table(folder / "sif.csv", ["x"])
    of_load = np.array(table.words("load_case"))
    columns = {name: table.column(name) for name in table.names}
    rows = {load: {n: c[of_load == load] for n, c in columns.items() if c is not None} for load in of_load}
    return rows, json.loads((folder / "fracture.json").read_text())


def test_k_and_t_of_a_sum_are_the_sums_of_those_of_its_load_cases(folder):
    cases, report = fracture(folder, "cases.npz")
    assert list(cases) == ["pull", "shear", "back"]
    assert [front["load_case"] for front in report["fronts"]] == list(cases)
    sums, _ = fracture(folder, "sums.npz", *PAIR)
    for name in ("K_I", "K_II", "K_III", "T"):
        exact = cases["pull"][name] + 0.3 * cases["shear"][name]
        # both fields are as far from the exact one as residuals of 1e-9 let them
        assert sums["peak"][name] == pytest.approx(exact, abs=1e-6 * np.abs(cases["pull"][name]).max())
    assert sums["peak"]["J"] == pytest.approx(sums["valley"]["J"] / 0.16, rel=1e-6)
    # the lips are shut in the sum, solved with contact, and would overlap: the gate takes 1 % for nothing
    assert np.abs(sums["shut"]["K_I"]).max() < 0.01 * cases["pull"]["K_I"].min()


def test_a_pair_in_proportion_grows_as_the_largest_load_with_its_ratio(folder):
    grow = ("--crack", str(folder / "crack.vtp"), "--law", "power", "--coefficient", "1e-9")
    pair, report = fracture(folder, "sums.npz", *PAIR, *grow, "--cycle", "peak", "valley")
    assert list(pair) == ["peak", "valley", "shut"]
    found = pair["peak"]
    assert found["R"] == pytest.approx(0.4, abs=1e-6)
    assert found["delta_K"] == pytest.approx(0.6 * found["driving"], rel=1e-6)
    assert np.isnan(pair["valley"]["extension"]).all()
    alone, ratio = fracture(folder, "sums.npz", *PAIR, *grow, "--cycle", "peak", "--stress-ratio", "0.4")
    for name in ("kink_angle", "extension", "rate", "driving"):
        assert found[name] == pytest.approx(alone["peak"][name], rel=1e-5)
    assert report["growth"]["ahead"] == pytest.approx(ratio["growth"]["ahead"], rel=1e-5)
    # who reads a front has the first load's rows alone
    assert len(read_front(folder / "sif.csv")["x"]) == len(found["x"])


def test_the_order_of_the_pair_does_not_count_and_shut_lips_have_no_range(folder):
    grow = ("--crack", str(folder / "crack.vtp"))
    pair, _ = fracture(folder, "sums.npz", *PAIR, *grow, "--cycle", "peak", "shut")
    turned, _ = fracture(folder, "sums.npz", *PAIR, *grow, "--cycle", "shut", "peak")
    for name in ("kink_angle", "extension", "delta_K", "R"):
        assert turned["shut"][name] == pytest.approx(pair["peak"][name], abs=1e-9)
    assert np.abs(pair["peak"]["R"]).max() < 0.02
    assert pair["peak"]["delta_K"] == pytest.approx(pair["peak"]["driving"], rel=0.02)


def test_loads_that_were_not_solved_are_named(folder, capsys):
    target = ("-o", str(folder / "none.csv"))
    for flags, said in (
        ((), "has the fields of valley, peak, shut, but the options are for pull, shear, back"),
        ((*PAIR, "--cycle", "top"), "cycle: unknown load case 'top'; known: valley, peak, shut"),
    ):
        assert verb("fracture", folder, str(folder / "sums.npz"), *target, *MODEL, *flags) == 1
        assert said in capsys.readouterr().err
    assert not (folder / "none.csv").exists()
