"""The steps of examples/tutorial run one after another, and print what their pages promise."""

import re
import runpy
from pathlib import Path

import numpy as np
import pytest

import craftmesh as cm

FOLDER = Path(__file__).resolve().parents[1] / "examples" / "tutorial"
STEPS = sorted(FOLDER.glob("t*.py"), key=lambda path: int(path.stem[1:]))


@pytest.fixture(scope="module")
def names(tmp_path_factory):
    """Return the names of each step's script after its run, in one folder for all."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("steps"))
        yield {path.stem: runpy.run_path(str(path)) for path in STEPS}


def test_the_page_lists_the_steps_and_files(names):
    rows = re.findall(
        r"^\| (t\d+) \| ([^|]+) \|.*\|([^|]+)\|$", (FOLDER / "README.md").read_text(), flags=re.M
    )
    assert [row[:2] for row in rows] == [
        (path.stem, path.read_text().partition("\n")[0].strip('".')) for path in STEPS
    ]
    written = {name for row in rows for name in re.findall(r"`([^`]+)`", row[2])}
    assert written == {path.name for path in Path().iterdir()}


def test_each_mesh_is_sound(names):
    assert cm.check(names["t1"]["surface"]) == cm.check(names["t6"]["body"]) == []
    assert cm.check(names["t9"]["body"]) == cm.check(names["t10"]["body"]) == []


def test_cleaning_gives_nearly_the_true_labels(names):
    step = names["t2"]
    noise = np.count_nonzero(step["measured"] != step["true"])
    assert np.count_nonzero(step["voxels"].labels != step["true"]) < 0.1 * noise  # measured: 1 of 42


def test_lengths_grow_with_the_distance(names):
    step = names["t4"]
    lengths = step["sizing"].at(step["front"] + np.outer(range(8), [0, 0, 1]))
    assert lengths[0] == pytest.approx(0.7) and (np.diff(lengths) >= 0).all()


def test_K_is_near_the_closed_form(names):
    step = names["t8"]
    # measured: 2 % below, the sides of the box are free
    assert step["columns"]["K_I"] == pytest.approx(step["exact"], rel=0.05)


def test_the_crack_grows_and_cycles_are_counted(names):
    step = names["t9"]
    assert step["counts"]["crack_area"] > 1.2 * np.pi * 3**2
    assert step["report"]["cycles"] > 0


def test_two_cracks_have_four_faces(names):
    lips = {name for name in names["t10"]["body"].face_sets if "LIP" in name}
    assert lips == {f"CRACK_{k}_LIP_{side}" for k in (1, 2) for side in "AB"}
