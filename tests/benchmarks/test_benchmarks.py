"""The benchmarks run as users run them, on a tiny case, and measure what they say."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"


def figures(name: str, folder: Path, *flags: str) -> list[dict]:
    target = folder / "figures.json"
    command = [sys.executable, str(BENCHMARKS / name), "--case", "tiny", "--runs", "1", "--no-peers"]
    done = subprocess.run(
        [*command, "--json", str(target), *flags], capture_output=True, text=True, timeout=1200
    )
    assert done.returncode == 0, done.stderr
    rows = json.loads(target.read_text())["rows"]
    for row in rows:
        assert "failed" not in row
        assert row["method"] in done.stdout
    return rows


@pytest.mark.slow
def test_gradation_measures_a_gradated_surface(tmp_path):
    (row,) = figures("gradation.py", tmp_path)
    assert row["facets_out"] < row["facets_in"]
    assert row["cpu_s"] > 0 and row["operations_per_s"] > 0
    # Measured: 216 MB, most of it numpy, scipy and numba.
    assert 30 < row["peak_mb"] < 2000
    assert row["intersections"] == 0
    # Front edges follow l_min; their measured median on this case is 0.99 of it.
    assert 0.8 < row["front"][1] < 1.25


@pytest.mark.slow
def test_volume_compares_ours_with_plain_tetgen(tmp_path):
    plain, ours = figures("volume.py", tmp_path)
    assert (plain["method"], ours["method"]) == ("TetGen", "craftmesh")
    # Interior points bring lengths inside to the target: measured medians are 1.41 and 0.95.
    assert abs(ours["inside"][1] - 1) < abs(plain["inside"][1] - 1)
    assert ours["poor_pct"] < plain["poor_pct"]
    assert ours["ar_mean"] < plain["ar_mean"]
    assert ours["peak_mb"] > 30


@pytest.mark.slow
def test_noise_takes_a_volume_through_the_chain_as_it_is_and_smoothed(tmp_path):
    noisy, smoothed = figures("noise.py", tmp_path)
    assert (noisy["method"], smoothed["method"]) == ("noisy", "smoothed")
    assert noisy["roughness"] == smoothed["roughness"] > 0.06
    assert noisy["changed"] == 0 < smoothed["changed"]
    assert smoothed["tets"] > 0 and smoothed["drift"] < 1


@pytest.mark.slow
def test_deck_measures_the_model_in_every_form(tmp_path):
    target = tmp_path / "figures.json"
    command = [sys.executable, str(BENCHMARKS / "deck.py"), "--elements", "5000", "--runs", "1"]
    methods = ["write_deck, includes", "craftmesh export .e"]
    flags = [word for method in methods for word in ("--method", method)]
    done = subprocess.run(
        [*command, *flags, "--json", str(target)], capture_output=True, text=True, timeout=1200
    )
    assert done.returncode == 0, done.stderr
    rows = json.loads(target.read_text())["rows"]
    assert [row["method"] for row in rows] == methods
    for row in rows:
        assert row["method"] in done.stdout and 5000 <= row["elements"] < 7000
        assert row["cpu_s"] > 0 and row["peak_mb"] > 30
        # Ten node numbers of four bytes are the least that an element takes.
        assert row["file_mb"] > 40e-6 * row["elements"]


def test_unknown_case_is_refused():
    command = [sys.executable, str(BENCHMARKS / "gradation.py"), "--case", "huge"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 2
    assert "huge" in done.stderr
