"""Random faults are one change of code each, the same for a seed, and are told apart by what tests see."""

import ast
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))

import mutate  # noqa: E402

SOURCE = '''"""A room with 1 + 1 modules."""

from math import pi


def steps(end: "int | None", *, width: float = 1) -> float:
    """Return 2 * the steps < end."""
    count = 0
    while count < end:
        count += 1
    return count * width if pi and not end > 100 else print(f"{end + 1} steps < 5")
'''
TEST = """from craftmesh.room.walk import steps

def test_steps():
    assert steps(3) == 3
"""


@pytest.fixture
def project(tmp_path, monkeypatch):
    for folder in ("craftmesh/room", "tests/room", "tests/other"):
        (tmp_path / "project" / folder).mkdir(parents=True)
    root = tmp_path / "project"
    (root / "craftmesh" / "__init__.py").touch()
    (root / "craftmesh" / "room" / "walk.py").write_text(SOURCE)
    (root / "tests" / "room" / "test_walk.py").write_text(TEST)
    monkeypatch.setattr(mutate, "ROOT", root)
    return root


def test_faults_are_one_change_of_the_code_each_and_the_same_for_a_seed(project):
    faults = list(mutate.drawn_faults(project, "room", 3))
    assert faults == list(mutate.drawn_faults(project, "room", 3))
    assert [fault.line for fault in faults] != [
        fault.line for fault in mutate.drawn_faults(project, "room", 4)
    ]
    # what may change: 1 of the width, 0, <, += and 1, then *, and, > and a digit of 100
    assert sorted(fault.line for fault in faults) == [6, 8, 9, 10, 10, 11, 11, 11, 11]
    for fault in faults:
        ast.parse(fault.source)
        before, after = SOURCE.splitlines(), fault.source.splitlines()
        assert [k for k in range(len(before)) if before[k] != after[k]] == [fault.line - 1]
        assert str(fault).startswith(f"craftmesh/room/walk.py:{fault.line}\n")


def test_a_fault_is_killed_or_hangs_or_lives_until_the_tests_elsewhere_see_it(project, monkeypatch):
    # tests without a fault take 0.3 s and so may take 1.9 s with one
    monkeypatch.setattr(mutate, "SPARE", 1.0)
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    module = Path("craftmesh/room/walk.py")

    def fault(line, old, new):
        return mutate.Fault(module, SOURCE, line, SOURCE.splitlines()[line - 1].replace(old, new) + "\n")

    faults = [fault(9, "<", ">"), fault(10, "+=", "-="), fault(11, "> 100", "> 900")]
    assert list(mutate.tried("room", faults, False)) == ["killed", "hung", "lives"]
    (project / "tests" / "other" / "test_far.py").write_text(
        TEST.replace("steps(3) == 3", "steps(500) is None")
    )
    assert list(mutate.tried("room", faults[2:], True)) == ["killed elsewhere"]
    assert (project / module).read_text() == SOURCE
