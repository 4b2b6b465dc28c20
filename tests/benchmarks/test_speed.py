"""The record of speed: who counts as slower, what is compared with what, and how it is drawn."""

import csv
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "benchmarks"), str(ROOT / "docs")]

import speed  # noqa: E402
from speed_page import picture, speed_page  # noqa: E402

LIMITS = {"gradate": 1.5, "tetrahedralize": 15.0}
QUICK, SLOW = {"gradate": 1.5, "tetrahedralize": 15.0}, {"gradate": 1.5, "tetrahedralize": 15.1}


@pytest.mark.parametrize(
    ("tried", "count", "stages"),
    [
        ([QUICK, QUICK, SLOW], 2, []),
        ([SLOW, SLOW, QUICK], 2, ["tetrahedralize"]),
        ([SLOW, QUICK, SLOW], 3, ["tetrahedralize"]),
        ([QUICK, SLOW, QUICK], 3, []),
    ],
)
def test_a_stage_is_slower_that_is_over_its_limit_twice(tried, count, stages):
    taken = iter(tried)
    assert speed.slower(taken, LIMITS) == stages
    assert len(list(taken)) == len(tried) - count


def test_the_last_row_of_this_machine_and_case_is_the_accepted_one():
    rows = [
        {"machine": machine, "case": case, "stage": "gradate", "ratio": ratio}
        for machine, case, ratio in (("a", "small", "1.5"), ("a", "small", "1.25"), ("b", "small", "9"))
    ]
    assert speed.accepted(rows, "a", "small") == {"gradate": 1.25}
    assert speed.accepted(rows, "a", "g26") == speed.accepted(rows, "c", "small") == {}


def test_every_row_of_the_record_is_on_the_page():
    with open(speed.RECORD, newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert rows and all(set(row) == set(speed.FIELDS) for row in rows)
    page = speed_page(speed.RECORD)
    for row in rows:
        assert f"## {row['case']}, {row['stage']}" in page
        assert f"| {row['ratio']} |" in page


def test_a_larger_ratio_is_drawn_higher():
    drawn = ElementTree.fromstring(picture([2.0, 1.0, 3.0]))
    first, second, third = (float(dot.get("cy")) for dot in drawn.iter("circle"))
    assert third < first < second


@pytest.mark.slow
def test_a_run_appends_rows_and_the_next_is_checked_against_them(tmp_path, capfd):
    record = tmp_path / "speed.csv"
    speed.record(record, ["small"])
    with open(record, newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["stage"] for row in rows] == ["gradate", "tetrahedralize"]
    record.write_text(record.read_text().replace(rows[1]["ratio"], "0.001"))
    assert "tetrahedralize: twice over" in speed.check(record)
    assert "success" not in capfd.readouterr().out, "TetGen prints"
