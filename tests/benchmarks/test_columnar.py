"""How the benchmark of columnar grains compares two meshes of one crack."""

import sys
from pathlib import Path

import numpy as np
import pytest

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"


@pytest.fixture
def columnar(monkeypatch):
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    yield __import__("columnar")
    sys.modules.pop("columnar")


def figures(count: int, tets: int, off: float, at_ends: float) -> dict:
    s = np.linspace(0, 1, count)
    angle = 10 * s + np.where((s < 0.05) | (s > 0.95), at_ends, off)
    return {"tets": tets, "end": 0.06, "s": s.tolist(), "kink_angle": angle.tolist()}


def test_kink_angles_are_compared_at_the_same_places_and_apart_at_the_ends(columnar):
    row = columnar.compared(2, figures(301, 250, 0.5, 7.0), figures(201, 1000, 0.0, 0.0))
    assert row["increment"] == 2 and row["tets"] == [1000, 250] and row["fewer"] == 75
    assert row["off"] == pytest.approx([0.5] * 4)
    assert row["off_ends"] == pytest.approx(7.0)
