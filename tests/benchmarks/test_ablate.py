"""The rows of the corpus: written, read again, and what two runs of them are told to differ in."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))

import ablate  # noqa: E402


def row(seed: int, **others) -> dict[str, str]:
    deck = {"outcome": "deck", "faults": {}, "flat": 0, "ar_under_5_pct": 100.0, "tets": 900, "cpu_s": 2.0}
    return ablate.short_row({"seed": seed, **deck, "deck": "ab", **others})


def test_rows_are_read_as_they_were_written(tmp_path):
    rows = {seed: row(seed) for seed in (3, 1)} | {
        2: ablate.short_row({"seed": 2, "outcome": "refusal", "faults": {}})
    }
    ablate.write_rows(tmp_path / "rows.csv", rows)
    assert ablate.read_rows(tmp_path / "rows.csv") == rows
    assert list(ablate.read_rows(tmp_path / "rows.csv")) == [1, 2, 3]
    assert ablate.read_rows(tmp_path / "none.csv") == {}


def test_only_seeds_of_both_are_compared_and_each_new_fault_is_named():
    known = {1: row(1), 2: row(2), 3: row(3), 4: dict.fromkeys(ablate.COLUMNS, "")}
    rows = {
        1: row(1),
        2: row(2, faults={"flat": "2 unforced", "area": "off"}, flat=2, deck="cd"),
        4: row(4),
    }
    told = {line["what"]: (line["before"], line["now"]) for line in ablate.compared(known, rows)}
    assert told["decks"] == (2, 2) and told["CPU s"] == (4.0, 4.0)
    assert told["with a fault"] == told["with flat tets"] == (0, 1) and told["flat tets"] == (0.0, 2.0)
    assert told["2: faults"] == ("", "flat + area") and told["decks that are others"] == ("", 1)
