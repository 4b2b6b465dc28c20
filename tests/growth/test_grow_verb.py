"""`craftmesh grow`: the next crack from files, and the ends of a growth."""

import json

import numpy as np
import pytest

from craftmesh.cli import main
from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.series import prescribed_crack
from craftmesh.cracks.within_box import area_within
from craftmesh.errors import CraftmeshError
from craftmesh.growth.grow import SHORTENED
from craftmesh.io.front_csv import read_front, write_front
from craftmesh.io.npz import write_labels
from craftmesh.io.vtk import read_crack, write_crack
from craftmesh.types import Voxels

EDGE = CrackOptions(shape="through_edge", centre=(0.0, 5.0, 6.0), radius=6.0)


@pytest.fixture
def grow(tmp_path):
    """Return a function that grows an edge crack of depth 6, or a file's, in a body of 12 x 10 x 12."""
    labels = np.ones((12, 10, 12), int)
    labels[9:, :, 4:8] = 0  # a notch in the face x = 12, ahead of the crack
    voxels = Voxels(labels, np.ones(3), np.zeros(3))
    write_labels(tmp_path / "labels.npz", voxels)
    crack = prescribed_crack(voxels.box, EDGE)
    write_crack(tmp_path / "crack.vtp", crack)

    def run(extension, *flags, grown="", tip=6.0, rows=11, **columns):
        y = np.linspace(0, 10, 11)
        places = {"x": tip + 0 * y, "y": y, "z": 6 + 0 * y, "node": np.arange(1, 12)}
        tail = crack.points[crack.fronts[0][0]]
        y[:] = y if tail[1] == 0 else y[::-1]
        sign = -1.0 if tail[1] == 0 else 1.0  # of the normal, for the crack is on the left of its front
        frames = {"normal_x": 0 * y, "normal_y": 0 * y, "normal_z": sign + 0 * y}
        frames |= {"binormal_x": 1 + 0 * y, "binormal_y": 0 * y, "binormal_z": 0 * y}
        goes = {"kink_angle": 0 * y, "extension": extension + 0 * y} | columns
        for name, values in (("front.csv", frames), ("sif.csv", goes)):
            kept = {key: value[:rows] for key, value in (places | values).items()}
            write_front(tmp_path / name, kept)
        files = [str(tmp_path / name) for name in (grown or "crack.vtp", "sif.csv", "front.csv")]
        outputs = ["-o", str(tmp_path / "grown.vtp"), "--report", str(tmp_path / "growth.json")]
        status = main(["grow", *files, "--volume", str(tmp_path / "labels.npz"), *outputs, *flags])
        if status:
            return status
        return json.loads((tmp_path / "growth.json").read_text())

    return run


def area(path):
    return area_within(read_crack(path), np.array([[0.0, 0.0, 0.0], [12.0, 10.0, 12.0]]))


def test_a_crack_goes_on(grow, tmp_path):
    report = grow(2.0)
    assert report["ended"] == "" and report["extension"] == [2.0, 2.0] and report["laid"] == 1.0
    before, after = report["area"]
    assert after - before == pytest.approx(2.0 * 10, rel=1e-6)
    assert area(tmp_path / "grown.vtp") == pytest.approx(after)


def test_a_strip_laid_at_half_the_step_says_so(grow, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("craftmesh.growth.grow.ATTEMPTS", ((SHORTENED, 1, 0.5, False),))
    step = tmp_path / "step.csv"
    report = grow(2.0, "--step", str(step))
    assert report["laid"] == 0.5 and report["repairs"] == {SHORTENED: 1}
    assert np.diff(report["area"]) == pytest.approx(10.0) and read_front(step)[
        "extension"
    ] == pytest.approx(1)
    assert "0.5 of the step long; the load cycles" in capsys.readouterr().err


@pytest.fixture
def second(grow, tmp_path):
    """Return a function that takes a step of 1 straight on and another with the kinks found there."""

    def run(kink, *words, extension=1.0, **columns):
        ends = ["--base", str(tmp_path / "base.vtp"), "--step", str(tmp_path / "step.csv")]
        grow(1.0, *ends)
        (tmp_path / "grown.vtp").rename(tmp_path / "first.vtp")
        last = [f"--last-{ends[0][2:]}", ends[1], f"--last-{ends[2][2:]}", ends[3]]
        again = [ends[0], str(tmp_path / "base2.vtp"), ends[2], str(tmp_path / "step2.csv")]
        kinks = np.full(11, kink)
        columns |= {"kink_angle": kinks}
        return grow(extension, *last, *again, *words, grown="first.vtp", tip=7.0, **columns)

    return run


def heights(path):
    """Return how far the crack of a file stands out of its first plane at x of 6, 7, 8."""
    places = read_crack(path).points
    return [float(np.abs(places[np.abs(places[:, 0] - x) < 0.1, 2] - 6).max()) for x in (6, 7, 8)]


def test_the_strip_of_the_step_before_is_turned_by_half_of_the_kinks_at_its_end(second, tmp_path):
    report = second(20.0)
    assert report["corrected"] == pytest.approx([10.0, 10.0])
    first, then = np.sin(np.radians(10)), np.sin(np.radians(20))
    assert heights(tmp_path / "grown.vtp") == pytest.approx([0, first, first + then], abs=1e-6)
    base = read_crack(tmp_path / "base2.vtp")
    assert np.abs(base.points[base.fronts[0]][:, 2] - 6) == pytest.approx(first, abs=1e-6)
    # what is written is what the next one reads: the frames lie in the strip as it is now
    columns = read_front(tmp_path / "step2.csv")
    assert columns["kink_angle"] == pytest.approx(10.0) and columns["trusted"].all()
    assert np.abs(columns["binormal_z"]) == pytest.approx(np.sin(np.radians(10)))
    kept = (tmp_path / "grown.vtp").read_bytes()
    second(20.0)
    assert (tmp_path / "grown.vtp").read_bytes() == kept


# of a step of 1: 1 - 2 sqrt(8 / pi) T / K_I times the angle off the path is the kink
@pytest.mark.parametrize(
    ("t", "turned", "left"), [(-0.1, 10.0, 6.8085), (-0.9, 5.165, 0.0), (np.nan, 10.0, 10.0)]
)
def test_the_stress_along_the_crack_says_how_far_a_step_was_off(second, tmp_path, t, turned, left):
    report = second(20.0, K_I=np.ones(11), T=np.full(11, t))
    assert report["corrected"] == pytest.approx([turned, turned], abs=0.01)
    assert read_front(tmp_path / "step2.csv")["kink_angle"] == pytest.approx(left, abs=0.01)


def test_the_strip_behind_rows_that_stay_is_turned_too(second, tmp_path):
    """Their K is known, their Delta K is under the threshold."""
    report = second(20.0, extension=np.where(np.arange(11) > 6, 0.0, 1.0))
    assert report["corrected"] == pytest.approx([10.0, 10.0])
    base = read_crack(tmp_path / "base2.vtp")
    assert np.abs(base.points[base.fronts[0]][:, 2] - 6) == pytest.approx(np.sin(np.radians(10)), abs=1e-6)


def test_without_correction_the_strip_of_the_step_before_stays(second, tmp_path):
    assert second(20.0, "--no-correct")["corrected"] == [0.0, 0.0]
    assert heights(tmp_path / "grown.vtp") == pytest.approx([0, 0, np.sin(np.radians(20))], abs=1e-6)
    assert (tmp_path / "base2.vtp").read_bytes() == (tmp_path / "first.vtp").read_bytes()


def test_a_strip_that_cannot_be_laid_again_stays_and_a_warning_says_so(
    second, tmp_path, capsys, monkeypatch
):
    def folds(*_):
        raise CraftmeshError("the crack surface folds")

    monkeypatch.setattr("craftmesh.growth.grow_crack.corrected", folds)
    assert second(20.0)["corrected"] == [0.0, 0.0]
    said = [line for line in capsys.readouterr().err.splitlines() if "last strip stays" in line]
    assert len(said) == 1 and "first.vtp" in said[0] and "surface folds" in said[0]
    assert heights(tmp_path / "grown.vtp") == pytest.approx([0, 0, np.sin(np.radians(20))], abs=1e-6)


def test_half_a_step_before_is_refused(grow, capsys):
    assert grow(2.0, "--last-step", "step.csv") == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert "--last-base and --last-step" in line


@pytest.mark.parametrize(("extension", "warned"), [(0.9, True), (1.1, False)])
def test_a_step_within_an_edge_of_the_front_is_warned_of(grow, capsys, extension, warned):
    grow(extension)
    said = capsys.readouterr().err
    assert ("edge length 1;" in said) == warned and ("grow.extension" in said) == warned


@pytest.mark.parametrize("word", ["limit", "pierce+short", "pierce", "closed"])
def test_rows_of_doubtful_intensities_do_not_turn_the_front(grow, tmp_path, word):
    flags = np.full(11, "", object)
    flags[5] = word
    grow(2.0, kink_angle=np.where(np.arange(11) == 5, 70.0, 0.0), flags=flags)
    height = np.abs(read_crack(tmp_path / "grown.vtp").points[:, 2] - 6).max()
    assert height > 0.1 if word in ("pierce", "closed") else height < 1e-9


def test_rows_that_are_all_doubtful_turn_the_front_and_the_strip_behind(second, tmp_path, grow):
    words = np.full(11, "error", object)
    kinks = np.full(11, 20.0)
    words[4], kinks[4] = "error+pierce+limit", -70.0  # a pierce point steers neither
    grow(2.0, kink_angle=kinks, flags=words)
    grown = read_crack(tmp_path / "grown.vtp")
    ahead = np.abs(grown.points[grown.fronts[0]][:, 2] - 6)
    assert ahead == pytest.approx(2 * np.sin(np.radians(20)), abs=1e-6)
    assert second(20.0, flags=np.full(11, "error", object))["corrected"] == pytest.approx([10.0, 10.0])


def test_the_end_says_why_points_stay(grow, capsys):
    words = np.array([*["closed"] * 7, "arrested", *["noise"] * 3], object)
    capsys.readouterr()
    report = grow(0.0, stays=words)
    assert report["stays"] == {"closed": 7, "arrested": 1, "noise": 3}
    said = "no point of the front extends: 7 closed (K_I is not above its estimated error), 1 arrested ("
    assert report["ended"].startswith(said)
    assert said in capsys.readouterr().err


def test_rows_that_stay_say_no_way_and_the_rest_goes_on(grow, tmp_path):
    rest = np.arange(11) > 6
    kink, words = np.where(rest, 70.0, 0.0), np.where(rest, "closed", "")
    report = grow(np.where(rest, 0.0, 2.0), stays=words, kink_angle=kink)
    assert report["ended"] == "" and report["stays"] == {"closed": 4} and report["kink_angle"] == [0.0, 0.0]
    grown = read_crack(tmp_path / "grown.vtp")
    front = grown.points[grown.fronts[0]]
    # the spline through the corner where the new front turns towards the old one goes .005 past it
    assert np.abs(front[:, 2] - 6).max() < 1e-9 and front[:, 0].max() == pytest.approx(8.0, abs=0.01)
    assert (front[:, 0] == 6.0).any()


@pytest.mark.parametrize(
    ("extension", "said"),
    [
        (0.0, "no point of the front extends"),
        (4.0, "the crack severs the body: a piece of volume 660 around"),
        (7.0, "every front has left the body"),
    ],
    ids=["threshold", "severed", "left"],
)
def test_a_crack_that_stops_is_written_as_it_is_with_the_reason(grow, tmp_path, capsys, extension, said):
    capsys.readouterr()
    report = grow(extension)
    assert said in report["ended"] and report["laid"] == 0
    assert area(tmp_path / "grown.vtp") == area(tmp_path / "crack.vtp")
    (line,) = capsys.readouterr().err.splitlines()
    assert "the crack stops here" in line and said in line


def test_a_crack_whose_mesh_has_no_front_is_at_its_end(grow, tmp_path):
    """As where it has reached a hole: sif.csv and front.csv have a header alone."""
    report = grow(2.0, rows=0)
    assert report["ended"] == "every front has left the body"
    assert (tmp_path / "grown.vtp").read_bytes() == (tmp_path / "crack.vtp").read_bytes()
