"""A report begins with what was made and failed, how good it is, how long cracks live, and materials."""

import re
from dataclasses import replace

import numpy as np
import pytest
from shown_models import asked, write_front, write_increment

from craftmesh.cli import main
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.report.case_files import Failure, read_cases
from craftmesh.report.measures import life, materials, verdict, with_error
from craftmesh.report.page import _number, _span, page
from craftmesh.report.sweeps import ReportOptions
from craftmesh.types import Crystal

COPPER, NICKEL = "cubic:168400,121400,75400", "cubic:246500,147300,124700"


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    write_increment(folder / "one" / "000")
    write_front(folder / "one" / "000", [1.0, 2.0, 3.0])
    flags = ["--campaign", asked(folder, ["one"]), "-o", str(folder / "report.html")]
    assert main(["report", str(folder), *flags]) == 0
    return read_cases(folder)[0]


def of_config(case, **sections):
    return replace(case, record=case.record | {"config": case.record["config"] | sections})


def test_failures_stand_first_and_tiles_count_them(case):
    failed = [
        Failure("two", "two/000/tets.log", "grain 7: " + "no room " * 40),
        Failure("three", "", "waits"),
    ]
    text = page([case], ReportOptions(), failed)
    assert "1 of 3 made, 1 failed, 1 unfinished" in text and "✗</span> Not all is made: three, two." in text
    assert text.index('id="failures"') < text.index('class="tiles"') < text.index('id="case-one"')
    assert re.search(r'id="failures".*?<table class="text">', text, re.S)
    assert "✓</span> The case is made." in page([case], ReportOptions())


def test_a_case_that_failed_and_has_increments_counts_once(case):
    assert (
        verdict([case], [Failure("one", "one/001/tets.log", "no room")]).counts == "0 of 1 made, 1 failed"
    )


def test_the_first_screen_has_the_path_of_the_crack_its_life_and_its_material(case):
    text = page(
        [of_config(case, inp={"material": [COPPER]}, units={"length": "um", "stress": "MPa"})],
        ReportOptions(),
    )
    first = text[text.index('class="first"') : text.index('class="view"')]
    assert "cut open along the crack" in first and " um</text>" in first and ">z</text>" in first
    assert "<dt>Life</dt>" in first and "copper, which stands in for an unnamed material" in first
    assert "K_I [MPa sqrt(um)]" in first


def test_life_is_cycles_with_their_error_or_the_key_that_is_missing(case):
    grows = replace(case, record=case.record | {"growth": "grow"})
    assert "crack is prescribed" in life(case) and "grow.coefficient" in life(grows)
    counted = {"cycles": np.array([12345.6]), "cycles_doubt": np.array([432.1])}
    front = case.increments[0].front | counted
    grows = replace(grows, increments=[replace(case.increments[0], front=front)])
    assert life(grows) == "12\u202f350 ± 430 load cycles to the crack of increment 000"


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (1.23456, 0.0123, "1.235 ± 0.012"),
        (98765.0, 4321.0, "98\u202f800 ± 4\u202f300"),
        (0.1234, np.nan, "0.12"),
    ],
)
def test_no_digit_is_beyond_the_error(value, error, text):
    assert with_error(value, error) == text


@pytest.mark.parametrize(
    ("ends", "text"),
    [
        ((-8.88, 34.31), "-8.9 … 34.3"),
        ((557.2, 627.4), "557 … 627"),
        ((8.0, 8.0001), "8.00"),
        ((2e-5, 3.14159e-5), "2.00e-05 … 3.14e-05"),
        (None, "–"),
    ],
)
def test_both_ends_of_a_range_have_the_digits_of_the_larger(ends, text):
    assert _span(ends) == text


def test_a_measured_number_keeps_its_last_zeros_and_a_whole_one_has_none():
    assert [_number(value) for value in (98.04, 98.0, 999.7, 12)] == ["98.0", "98", "1\u202f000", "12"]


def test_a_material_is_named_and_told_where_it_only_stands_in(case):
    def told(material, crystals):
        return materials(of_config(replace(case, crystals=crystals), inp={"material": material}))

    assert told([COPPER], {0: Crystal("cubic", "Al-6XN")}).startswith(
        "copper, which stands in for cubic Al-6XN"
    )
    assert told([COPPER], {0: Crystal("cubic", "Copper")}) == "copper (cubic 168400, 121400, 75400)"
    assert told([NICKEL], {}) == "nickel (cubic 246500, 147300, 124700)"
    assert "the default, which stands in for yours" in told(list(ModelOptions().material), {})
    both = told(
        ["1=isotropic:71000,0.33", f"2={COPPER}"], {1: Crystal("cubic", ""), 2: Crystal("cubic", "Copper")}
    )
    assert both == "phase 1 is isotropic 71000, 0.33; phase 2 is copper (cubic 168400, 121400, 75400)"
