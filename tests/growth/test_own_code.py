"""The functions and the solver of docs/extending.md run as they stand."""

import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml
from edge_crack import write_edge_crack

from craftmesh.cli import main
from craftmesh.growth.extension import kinks_and_extensions
from craftmesh.growth.front_points import FrontPoints
from craftmesh.growth.options import GrowthOptions, check_own
from craftmesh.io.front_csv import read_front
from craftmesh.io.npz import write_labels
from craftmesh.io.stage_npz import read_solution
from craftmesh.types import Voxels

PAGE = Path(__file__).resolve().parents[2] / "docs" / "extending.md"
MODEL = (
    "--material",
    "1=cubic:168400,121400,75400",
    "--faces",
    "ZMIN.z=fixed",
    "ZMIN.x=fixed",
    "ZMIN.y=fixed",
)
MODEL += ("ZMAX.z=stress:100",)


@pytest.fixture
def shown(tmp_path, monkeypatch):
    """Return a function that writes the module of a section and returns the section's options."""
    monkeypatch.syspath_prepend(tmp_path)

    def write(section):
        text = PAGE.read_text().split(f"\n## {section}\n")[1].split("\n## ")[0]
        (code,) = re.findall(r"```python\n(.*?)```", text, flags=re.S)
        name = re.match(r"# (my_\w+)\.py\n", code)[1]
        (tmp_path / f"{name}.py").write_text(code)
        monkeypatch.delitem(sys.modules, name, raising=False)
        (shown,) = re.findall(r"```yaml\n(.*?)```", text, flags=re.S)
        return yaml.safe_load(shown)

    return write


@pytest.fixture
def body(tmp_path):
    """A box with an edge crack in one crystal that is turned by 20 degrees about the front, y."""
    write_edge_crack(tmp_path, (8, 3, 8))
    half = np.radians(10)
    turns = np.tile([np.cos(half), 0, np.sin(half), 0], (2, 1))
    phases = np.array([0, 1])
    voxels = Voxels(np.ones((1, 1, 1), int), (1,) * 3, (0,) * 3, orientations=turns, phases=phases)
    write_labels(tmp_path / "labels.npz", voxels)
    return tmp_path


def run(verb, folder, *words):
    known = ("--microstructure", str(folder / "labels.npz"))
    return main([verb, str(folder / "volume.vtu"), *words, *known, *MODEL])


def test_the_criterion_goes_along_a_cleavage_plane_of_the_grain(shown, body):
    keys = shown("Your own criterion")["grow"]
    check_own(GrowthOptions(**keys))
    assert run("solve", body, "-o", str(body / "u.npz")) == 0
    words = ("--crack", str(body / "crack.vtp"), "--criterion", keys["criterion"])
    assert run("fracture", body, str(body / "u.npz"), "-o", str(body / "sif.csv"), *words) == 0
    # the axes of the front differ from y by what its nodes do from a line
    assert np.abs(read_front(body / "sif.csv")["kink_angle"]) == pytest.approx(20, abs=0.1)


def test_the_driving_force_is_that_of_the_shears(shown):
    keys = shown("Your own criterion")["grow"]
    front = FrontPoints.of(np.array([[1.0, 3.0, -4.0]]), 1.0)
    options = GrowthOptions(driving=keys["driving"], criterion="straight")
    assert kinks_and_extensions(front, options)[0].driving == pytest.approx([5.0])


def test_the_law_holds_for_its_phase_and_lets_short_cracks_grow(shown):
    options = GrowthOptions(**shown("Your own law")["grow"])
    k = np.tile([30.0, 0, 0], (2, 1))
    for size, grows in ((1.0, True), (50.0, False)):
        front = FrontPoints.of(k, size, phase=np.array([1, 2]), grain=np.array([1, 2]))
        rate = kinks_and_extensions(front, options)[0].da_dn
        assert rate == pytest.approx([1e-12 * 30**3 * grows, 1e-12 * 30**3])


def test_the_solver_gets_the_deck_and_its_field_is_checked(shown, body, capsys):
    """Your program is a stand-in that knows the field of the built-in solver."""
    keys = shown("Your own solver")["solve"]
    assert run("solve", body, "-o", str(body / "known.npz")) == 0
    known = read_solution(body / "known.npz")
    (body / "field.json").write_text(json.dumps(known.displacement.tolist()))
    own = f"""
import json
def solve_deck(deck):
    assert open(deck).read().startswith("*HEADING")
    return list(enumerate(json.load(open({str(body / "field.json")!r})), 1))SHORT
"""
    (command,) = keys["command"]
    command = command.replace("python /path/of", f"{sys.executable} {body}")
    words = ("--solver", keys["solver"], "--command", command, "-o", str(body / "own.npz"))
    (body / "my_fem.py").write_text(own.replace("SHORT", ""))
    assert run("solve", body, *words) == 0
    assert (read_solution(body / "own.npz").displacement == known.displacement).all()
    (body / "my_fem.py").write_text(own.replace("SHORT", "[:-1]"))
    capsys.readouterr()
    assert run("solve", body, *words) == 1 and "is missing" in capsys.readouterr().err
