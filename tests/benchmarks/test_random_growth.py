"""Random cracks that grow: the loop's rows, and the lines and the summary made of them."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))

import random_growth  # noqa: E402
from trials import drawing, volumes  # noqa: E402
from trials.closed_loop import closed_loop  # noqa: E402

DECK = {
    "flat": 0,
    "front_node": 1e-3,
    "facet": 0.03,
    "ar_under_5_pct": 100.0,
    "poor_pct": 0.0,
    "faults": {},
}


@pytest.mark.slow
def test_a_crack_grows_and_every_deck_is_checked(monkeypatch, tmp_path):
    monkeypatch.setattr(volumes, "MEASURED", {name: Path("/nowhere") for name in volumes.MEASURED})
    monkeypatch.setattr(drawing, "MOST_TETS", 3_000)
    case = drawing.draw_one(59, (12, 14))
    found = closed_loop(case, tmp_path, 2, judged=False)
    assert found["ended"] == "" and found["faults"] == {}
    assert [row["flat"] for row in found["rows"]] == [0, 0]
    assert found["extension"] / case.sizes.l_min in [pytest.approx(step) for step in (1.5, 2.0, 3.0)]
    assert (tmp_path / "001" / "sif.csv").exists() and (tmp_path / "001" / "base.vtp").exists()


def test_a_loop_that_stops_says_where():
    sound = {"seed": 1, "seconds": 3.0, "words": "a case", "rows": [DECK, DECK], "ended": "", "faults": {}}
    flat = DECK | {"flat": 2, "facet": 0.1, "faults": {"facets": "0.1 off"}}
    stopped = sound | {"seed": 2, "rows": [DECK, flat], "faults": {"001 growth": "folded"}}
    assert random_growth.told(sound).endswith("2 decks  a case: sound")
    assert random_growth.told(stopped).endswith("001 GROWTH folded")
    said = random_growth.summary([sound, stopped])
    assert said.startswith("2 seeds, 4 decks; without a fault: 1 seeds, 3 decks")
    assert "flat tets in 1 decks" in said and "worst facet: 0.1" in said
