"""The forge's workflows run what .ci/run and .ci/release run, on each Python that the package names."""

import re
import tomllib
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[2]
FILES = {path.stem: yaml.safe_load(path.read_text()) for path in ROOT.glob(".github/workflows/*.yml")}


def commands(name: str) -> list[str]:
    """Return the commands of a workflow."""
    jobs = FILES[name]["jobs"].values()
    return [step["run"] for job in jobs for step in job["steps"] if "run" in step]


def test_tests_are_those_of_continuous_integration():
    own = [line for line in (ROOT / ".ci/run").read_text().splitlines() if line.startswith("make ")]
    assert own and set(own) <= set(commands("tests"))


def test_targets_and_scripts_are_there():
    targets = re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(), flags=re.M)
    for command in [line for name in FILES for line in commands(name)]:
        word, _, target = command.partition(" ")
        assert word != "make" or target in targets
        assert not word.startswith(".") or (ROOT / word).stat().st_mode & 0o100


def test_the_matrix_is_the_pythons_of_the_package():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    named = {text.rpartition(" ")[2] for text in project["classifiers"] if re.search(r"3\.\d+$", text)}
    assert set(FILES["tests"]["jobs"]["tests"]["strategy"]["matrix"]["python"]) == named
