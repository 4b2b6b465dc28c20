"""`craftmesh run` and `demo`: what Snakemake is given, and the kernels that are compiled beside it."""

import os
import sys
import time
from contextlib import nullcontext
from pathlib import Path

import pytest
import yaml

from craftmesh.cli import main
from craftmesh.commands import compile as compiling
from craftmesh.commands import demo, run

SLEEPER = "#!/bin/sh\necho $$ $4 >> begun\nsleep 60\n"


@pytest.fixture
def given(monkeypatch):
    """The words that Snakemake would be given."""
    words: list[str] = []
    for module in (run, demo):
        monkeypatch.setattr(module, "run_snakemake", lambda own: words.extend(own))
        monkeypatch.setattr(module, "compiling_ahead", nullcontext)
    return words


def test_words_after_the_flag_are_for_snakemake(given, tmp_path):
    config = tmp_path / "mine.yaml"
    config.write_text("cases: cases.tsv\n")
    assert main(["run", str(config), "--snakemake", "-R", "inp", "--cores", "3"]) == 0
    # a flag that takes several values would take targets too
    assert given == ["--configfile", str(config), "--cores", "all", "-R", "inp", "--cores", "3"]


def test_a_profile_of_slurm_is_refused_where_nothing_submits(given, monkeypatch, capsys):
    monkeypatch.setenv("PATH", "")
    assert main(["run", "--profile", "profiles/slurm"]) == 1
    assert "sbatch, which is not on the PATH" in capsys.readouterr().err and given == []


def test_a_profile_takes_the_place_of_cores(given, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", str(tmp_path))
    (tmp_path / "sbatch").touch(0o755)
    assert main(["run", "--profile", "profiles/slurm"]) == 0
    assert given[0] == "--profile" and Path(given[1], "config.yaml").is_file()  # that comes along
    (tmp_path / "profiles/slurm").mkdir(parents=True)
    for own in ("profiles/slurm", "anothers"):  # one in ~/.config/snakemake is for Snakemake to find
        assert main(["run", "--profile", own]) == 0
        assert given[-2:] == ["--profile", own]


def test_the_demo_is_that_of_the_package_in_any_folder(given, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["demo", "--cores", "2"]) == 0
    config, cases = Path(given[3]), Path(given[5].removeprefix("cases="))
    assert given[:2] == ["--cores", "2"] and cases.is_file() and cases.is_absolute()
    assert {"cases", "cracks"} <= yaml.safe_load(config.read_text()).keys()


def begun(folder: Path) -> list[list[str]]:
    path = folder / "begun"
    return [line.split() for line in path.read_text().splitlines()] if path.is_file() else []


@pytest.mark.parametrize(("kept", "cores", "parts"), [(False, 2, 2), (True, 2, 0), (False, 1, 0)])
def test_kernels_compile_beside_a_first_run_and_no_longer(kept, cores, parts, tmp_path, monkeypatch):
    sleeper = tmp_path / "python"
    sleeper.write_text(SLEEPER)
    sleeper.chmod(0o755)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "executable", str(sleeper))
    monkeypatch.setattr(compiling, "is_kept", lambda _: kept)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(cores)))
    with compiling.compiling_ahead():
        until = time.monotonic() + 20 * bool(parts)
        while len(begun(tmp_path)) < parts and time.monotonic() < until:
            time.sleep(0.02)
    assert sorted(part for _, part in begun(tmp_path)) == ["gradate", "volume"][:parts]
    for number, _ in begun(tmp_path):
        assert not Path("/proc", number).exists()
