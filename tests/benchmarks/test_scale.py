"""Growth with size: slopes of known powers, memory of a known line, and stages that are kept."""

import subprocess
import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"
sys.path.insert(0, str(BENCHMARKS))

import scale  # noqa: E402


def test_slopes_are_exponents_and_memory_is_a_line():
    assert scale.slope((125, 1000), (3 * 125**1.25, 3 * 1000**1.25)) == pytest.approx(1.25)
    assert scale.grains_that_fit((100, 200), (300, 500), 1500) == 700
    assert scale.grains_that_fit((100, 200), (500, 500), 1500) == float("inf")


def test_a_stage_that_is_done_is_kept_and_one_that_failed_is_run_again(tmp_path):
    with pytest.raises(SystemExit, match="crack fails, see"):
        scale.run_stage(tmp_path, "crack", "crack nothing.npz -o crack.vtp")
    made = scale.run_stage(tmp_path, "generate", "generate --shape 6 5 4 --grains 2 -o generated.npz")
    assert made.cpu_s > 0 and made.peak_mb > 20
    (tmp_path / "generated.npz").unlink()
    assert scale.run_stage(tmp_path, "generate", "--nonsense") == made
    with pytest.raises(SystemExit):
        scale.run_stage(tmp_path, "crack", "crack nothing.npz -o crack.vtp")


@pytest.mark.slow
def test_the_whole_way_is_run_at_two_sizes(tmp_path):
    command = [sys.executable, str(BENCHMARKS / "scale.py"), "1", "2", "--folder", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert [line.split(" | ")[0].strip("| ") for line in lines[2:]] == [*scale.STAGES, "sum"]
    assert (tmp_path / "2" / "model.inp").stat().st_size > 1000
