"""Cases with keys of their own: columns of the sheet and sweeps, checked as the keys themselves."""

import pytest

from craftmesh.campaign.campaign import Campaign, read_campaign
from craftmesh.errors import CraftmeshError

COLUMNS = ["case", "microstructure", "crack", "increments"]
PENNY = {"centre": [0.0, 0.0, 0.0], "radius": 5.0}
ROW = ["one", "synthetic", "penny", "1"]


@pytest.fixture
def sheet(tmp_path):
    """Return a function that reads a sheet with one more column, `cells` down the rows a, b, ..."""

    def read(column: str, *cells: str, **keys) -> Campaign:
        lines = ["\t".join([*COLUMNS, column])]
        lines += ["\t".join([name, *ROW[1:], cell]) for name, cell in zip("abc", cells)]
        path = tmp_path / "cases.tsv"
        path.write_text("\n".join(lines))
        config = {"cases": str(path), "sizing": {"l0": 1.0}, "cracks": {"penny": PENNY}}
        return read_campaign(config | keys)

    return read


def test_a_cell_overrides_its_key_for_its_case_alone(sheet):
    found = sheet("sizing.l_min", "0.4", "")
    assert "--l-min 0.4" in found.flags("sizing", "a") and "--l-min" not in found.flags("sizing", "b")
    assert "--l-min 0.4" in found.crack_flags("a", "000") and "--l-min" not in found.crack_flags("b", "000")
    plain = sheet("growth", "prescribed", "prescribed")
    assert found.flags("sizing", "b") == plain.flags("sizing", "b")


@pytest.mark.parametrize(
    ("column", "cell", "ask", "flags"),
    [
        ("remesh.laplace_laps", "7", lambda c: c.flags("remesh", "a"), "--laplace-laps 7"),
        ("import.smoothing_rounds", "2", lambda c: c.import_flags("a"), "--smoothing-rounds 2"),
        (
            "inp.material",
            '["isotropic:210000,0.3"]',
            lambda c: c.deck_flags("a"),
            "--material isotropic:210000",
        ),
        ("inp.load", "stress", lambda c: c.model_flags("a"), "--load stress"),
        ("inp.element", "C3D4", lambda c: c.export_flags("a"), "--element C3D4"),
        ("cracks.penny.radius", "3.5", lambda c: c.crack_flags("a", "000"), "--radius 3.5"),
        ("cracks.penny.centre", "[1, 2, 3]", lambda c: c.crack_flags("a", "000"), "--centre 1 2 3"),
        ("grow.extension", "1E-03", lambda c: c.growth_flags("a"), "--extension 0.001"),
        ("grow.smoothing", "none", lambda c: c.grow_flags("a"), "--smoothing none"),
        ("sizing.around_voids", "TRUE", lambda c: c.flags("sizing", "a"), "--around-voids"),
        ("stitch.snap", "0.1", lambda c: c.flags("stitch", "a"), "--snap 0.1"),
        ("gradate.passes", "5", lambda c: c.flags("gradate", "a"), "--passes 5"),
    ],
)
def test_any_key_of_a_section_may_be_a_column(sheet, column, cell, ask, flags):
    assert flags in ask(sheet(column, cell))
    assert flags not in ask(sheet(column, ""))


def test_null_in_a_cell_takes_the_configurations_value_away(sheet):
    found = sheet("sizing.l_min", "null", sizing={"l0": 1.0, "l_min": 0.5})
    assert "--l-min" not in found.flags("sizing", "a")


def test_a_list_in_a_cell_makes_a_case_of_each_value(sheet):
    found = sheet("sizing.l_min", "[0.4, 5e-1]", "0.6")
    assert list(found.cases) == ["a-l_min-0.4", "a-l_min-0.5", "b"]
    assert "--l-min 0.5" in found.flags("sizing", "a-l_min-0.5")
    case = found.cases["a-l_min-0.4"]
    assert (case.row, case.swept) == ("a", {"sizing.l_min": 0.4})
    assert found.cases["b"].swept == {}


def test_a_longer_list_keeps_the_names_of_those_before(sheet):
    assert list(sheet("sizing.l_min", "[0.4]").cases) == ["a-l_min-0.4"]
    assert list(sheet("sizing.l_min", "[0.4, 0.5]").cases)[0] == "a-l_min-0.4"


def test_the_configurations_sweep_goes_through_every_row_and_a_cell_takes_its_place(sheet):
    found = sheet("sizing.l_min", "0.3", "", sweep={"sizing.l_min": [0.4, 0.5], "sizing.l_max": [2, 4]})
    assert list(found.cases) == [
        *("a-l_max-2", "a-l_max-4"),
        *("b-l_min-0.4-l_max-2", "b-l_min-0.4-l_max-4", "b-l_min-0.5-l_max-2", "b-l_min-0.5-l_max-4"),
    ]
    assert "--l-min 0.3" in found.flags("sizing", "a-l_max-4")


def test_names_tell_keys_and_values_apart(sheet):
    both = {"sizing.exponent": [1.0, 2.0], "grow.exponent": [3.0]}
    (first, _) = sheet("growth", "prescribed", sweep=both).cases
    assert first == "a-sizing.exponent-1.0-grow.exponent-3.0"
    long = ["cubic:168400.0,121400.0,75400.0"]
    names = list(sheet("inp.material", "", sweep={"inp.material": [long, ["isotropic:2,0.3"]]}).cases)
    assert names == ["a-material-1", "a-material-isotropic_2_0.3"]


def test_a_list_that_is_a_value_of_the_key_is_no_sweep(sheet):
    found = sheet("cracks.penny.increments", "[4.0]", "[[4.0, 3.0]]")
    assert list(found.cases) == ["a", "b"]
    assert "--increments 4.0,3.0" in found.crack_flags("b", "000")
    swept = sheet("cracks.penny.centre", "[[1, 2, 3], [4, 5, 6]]")
    assert list(swept.cases) == ["a-centre-1_2_3", "a-centre-4_5_6"]


def test_cracks_and_growth_may_be_swept_too(sheet):
    cracks = {"penny": PENNY, "small": PENNY | {"radius": 2.0}}
    found = sheet("growth", "[prescribed, until]", cracks=cracks)
    assert {name: case.growth for name, case in found.cases.items()} == {
        "a-growth-prescribed": "prescribed",
        "a-growth-until": "until",
    }


@pytest.mark.parametrize(
    ("column", "cells", "said"),
    [
        (
            "sizing.l_mim",
            [""],
            "column sizing.l_mim: unknown key 'sizing.l_mim'; did you mean 'sizing.l_min'",
        ),
        ("chunks", ["3"], "column chunks: unknown key 'chunks'; expected section.key"),
        (
            "cracks.gone.radius",
            ["3"],
            "unknown key 'cracks.gone.radius'; did you mean 'cracks.penny.radius'",
        ),
        ("inp.includes", ["true"], "column inp.includes: inp.includes applies to all cases"),
        ("sizing.l_min", ["", "x"], "line 3, case 'b': sizing.l_min is 'x'; expected a number > 0"),
        ("sizing.l_min", ["[0.4, x]"], "case 'a-l_min-x': sizing.l_min is 'x'; expected a number > 0"),
        ("sizing.l_min", ["[]"], "line 2, case 'a', column sizing.l_min is an empty list"),
        ("sizing.l_min", ["[0.4"], "line 2, case 'a', column sizing.l_min is '.0.4'; write a valid"),
        ("sizing.l_min", ["[0.4, 0.4]"], "line 2: duplicate case name 'a-l_min-0.4'"),
        ("sizing.l_min", ["4"], "line 2, case 'a': sizing.l_min is 4.* l_max"),
        ("sizing.points", ["gone.csv"], "line 2, case 'a': sizing.points: gone.csv does not exist"),
        ("inp.load", ["", "pull"], "line 3, case 'b': inp.load is 'pull'; expected one of strain"),
        ("cracks.penny.file", ["a.stl"], "case 'a': cracks.penny.file is 'a.stl', but shape penny has no"),
        (
            "cracks.penny.centre",
            ["[1, 2]"],
            "case 'a': cracks.penny.centre is .1, 2.; expected a list of 3",
        ),
    ],
)
def test_mistakes_in_columns_name_sheet_row_and_key(sheet, column, cells, said):
    with pytest.raises(CraftmeshError, match=said) as caught:
        sheet(column, *cells)
    assert "cases.tsv" in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("sweep", "said"),
    [
        ({"sizing.l_mim": [1]}, "sweep: unknown key 'sizing.l_mim'; did you mean 'sizing.l_min'"),
        ({"sizing.l_min": [0.5, "x"]}, "sweep: sizing.l_min is 'x'; expected a number > 0"),
        ({"sizing.l_min": 0.5}, "sweep.sizing.l_min is 0.5; expected a list of at least 1 values"),
        ({"sizing.l_min": []}, "sweep.sizing.l_min is ..; expected a list of at least 1 values"),
    ],
)
def test_mistakes_in_a_sweep(sheet, sweep, said):
    with pytest.raises(CraftmeshError, match=said):
        sheet("growth", "prescribed", sweep=sweep)


def test_a_growing_case_needs_displacements_of_second_order(sheet):
    with pytest.raises(CraftmeshError, match="case 'a': inp.element is C3D4, but the crack grows"):
        sheet("growth", "grow", inp={"element": "C3D4"})
