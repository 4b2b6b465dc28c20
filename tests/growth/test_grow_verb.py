"""`craftmesh grow`: the next crack from files, and the ends of a growth."""

import json

import numpy as np
import pytest

from craftmesh.cli import main
from craftmesh.cracks.along_faces import area_within
from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.shapes import prescribed_crack
from craftmesh.io.front_csv import write_front
from craftmesh.io.npz import write_labels
from craftmesh.io.vtk import read_crack, write_crack
from craftmesh.types import Voxels

EDGE = CrackOptions(shape="through_edge", centre=(0.0, 5.0, 6.0), radius=6.0)


@pytest.fixture
def grow(tmp_path):
    """Return a function that grows an edge crack of depth 6 in a body of 12 x 10 x 12."""
    labels = np.ones((12, 10, 12), int)
    labels[9:, :, 4:8] = 0  # a notch in the face x = 12, ahead of the crack
    voxels = Voxels(labels, np.ones(3), np.zeros(3))
    write_labels(tmp_path / "labels.npz", voxels)
    crack = prescribed_crack(EDGE, 0, voxels.box)
    write_crack(tmp_path / "crack.vtp", crack)

    def run(extension, *flags, **columns):
        y = np.linspace(0, 10, 11)
        places = {"x": 6 + 0 * y, "y": y, "z": 6 + 0 * y, "node": np.arange(1, 12)}
        tail = crack.points[crack.fronts[0][0]]
        y[:] = y if tail[1] == 0 else y[::-1]
        sign = -1.0 if tail[1] == 0 else 1.0  # of the normal, for the crack is on the left of its front
        frames = {"normal_x": 0 * y, "normal_y": 0 * y, "normal_z": sign + 0 * y}
        frames |= {"binormal_x": 1 + 0 * y, "binormal_y": 0 * y, "binormal_z": 0 * y}
        write_front(tmp_path / "front.csv", places | frames)
        goes = {"kink_angle": 0 * y, "extension": extension + 0 * y} | columns
        write_front(tmp_path / "sif.csv", places | goes)
        files = [str(tmp_path / name) for name in ("crack.vtp", "sif.csv", "front.csv")]
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
    assert report["ended"] == "" and report["extension"] == [2.0, 2.0]
    before, after = report["area"]
    assert after - before == pytest.approx(2.0 * 10, rel=1e-6)
    assert area(tmp_path / "grown.vtp") == pytest.approx(after)


@pytest.mark.parametrize(("extension", "warned"), [(0.9, True), (1.1, False)])
def test_a_step_within_an_edge_of_the_front_is_warned_of(grow, capsys, extension, warned):
    grow(extension)
    said = capsys.readouterr().err
    assert ("edges are 1 long" in said) == warned and ("grow.extension" in said) == warned


@pytest.mark.parametrize("word", ["limit", "short", "pierce+closed", "pierce"])
def test_rows_of_doubtful_intensities_do_not_turn_the_front(grow, tmp_path, word):
    flags = np.full(11, "", object)
    flags[5] = word
    grow(2.0, kink_angle=np.where(np.arange(11) == 5, 70.0, 0.0), flags=flags)
    height = np.abs(read_crack(tmp_path / "grown.vtp").points[:, 2] - 6).max()
    assert height > 0.1 if word == "pierce" else height < 1e-9


@pytest.mark.parametrize(
    ("extension", "said"),
    [
        (0.0, "no point of the front extends"),
        (4.0, "the crack severs the body: a piece of volume 660 round"),
        (7.0, "every front has left the body"),
    ],
    ids=["threshold", "severed", "left"],
)
def test_a_crack_that_stops_is_an_end_or_an_error(grow, tmp_path, capsys, extension, said):
    assert said in grow(extension, "--until")["ended"]
    assert area(tmp_path / "grown.vtp") == area(tmp_path / "crack.vtp")
    (tmp_path / "grown.vtp").unlink()
    capsys.readouterr()
    assert grow(extension) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line and "set its growth to until" in line
    assert not (tmp_path / "grown.vtp").exists()
