"""How the benchmark of the paper's models makes them coarser, and compares two meshes of one crack."""

import csv
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"


@pytest.fixture
def paper(monkeypatch):
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    yield __import__("paper")
    for name in ("paper", "paper_fields", "paper_pictures"):
        sys.modules.pop(name)


def along(count: int, off: float, at_ends: float) -> dict:
    s = np.linspace(0, 40, count)
    more = np.where((s < 2) | (s > 38), at_ends, off)
    ones = np.ones(count)
    return {"s": s, "kink_angle": s / 4 + more, "K_I": 2 * ones, "K_II": 0.01 * more, "K_III": 0 * ones}


def test_fronts_are_compared_at_the_same_places_without_their_ends(paper):
    row = paper.along_fronts(along(31, 0.0, 0.0), along(41, 0.5, 7.0))
    assert row["kink"] == pytest.approx([0.5] * 3)
    assert row["K"] == pytest.approx([100 * 0.005 / 2] * 2)
    assert "probe" not in row


def test_a_coarser_model_keeps_its_box_and_all_other_keys(paper, tmp_path):
    full, coarse = (yaml.safe_load(paper.campaign("paper_1", f, tmp_path).read_text()) for f in (1, 2))
    boxes = [np.multiply(one["generate"]["shape"], one["generate"]["spacing"]) for one in (full, coarse)]
    assert boxes[0] == pytest.approx(boxes[1])
    assert coarse["sizing"]["l_min"] == 2 * full["sizing"]["l_min"]
    assert coarse["sizing"]["r1"] == full["sizing"]["r1"]
    with open(coarse["cases"], encoding="utf-8") as stream:
        cases = {row["case"]: row for row in csv.DictReader(stream, delimiter="\t")}
    assert float(cases["uniform"]["sizing.l_max"]) == 2 * full["sizing"]["l_min"]


def test_stresses_are_compared_square_to_the_front_at_its_middle(paper):
    front = {"s": np.array([0.0, 1, 2]), "x": np.array([0.0, 5, 9]), "y": np.zeros(3), "z": np.zeros(3)}
    for name, axis in (("binormal", (0, 1, 0)), ("normal", (0, 0, 1))):
        front |= {f"{name}_{key}": np.full(3, float(value)) for key, value in zip("xyz", axis)}
    places = paper.square(front, edge=0.5)
    assert (places[:, 0] == 5).all()
    assert np.abs(places[:, 1:]).max() == pytest.approx(0.5 * sys.modules["paper_fields"].WIDTH / 2)
