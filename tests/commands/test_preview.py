"""The preview of a crack: what it meets is what geometry says, and a refusal is told, not raised."""

import io
import json

import numpy as np
import pytest
from matplotlib.image import imread
from structured_box import structured_box

from craftmesh.cli import main
from craftmesh.cracks.crack_surface_intersections import oblique, traces
from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.series import prescribed_crack
from craftmesh.io.vtk import write_crack, write_surface


def layers(centres):
    """Grain 3 below x = 4, grain 7 above; the void 2 in a corner of the latter."""
    x, y, z = centres.T
    labels = np.where(x < 4, 3, 7)
    labels[(x > 6) & (x < 8) & (y > 2) & (y < 4) & (z > 2) & (z < 4)] = -2
    return labels


SURFACE = structured_box((10, 8, 8), layers)[0]


def penny(**options):
    return prescribed_crack(SURFACE.box, CrackOptions(**options))


def test_traces_have_the_lengths_and_angles_of_the_planes():
    """A penny of radius 3 round (4, 4, 4.1), tilted by 60 degrees to the boundary x = 4: a chord of 6."""
    normal = (np.cos(np.radians(60)), 0, np.sin(np.radians(60)))
    found = traces(penny(centre=(4, 4, 4.1), normal=normal, radius=3.0), SURFACE)
    flat = SURFACE.kind[found.facet] == 0
    inner = flat & (SURFACE.sides[found.facet] > 0).all(axis=1)
    assert found.angle[inner] == pytest.approx(60)
    assert found.length[inner].sum() == pytest.approx(6, rel=1e-3)
    assert found.ends[inner][..., 0] == pytest.approx(4)
    assert oblique(found, SURFACE, 59) == []
    assert {one.sides for one in oblique(found, SURFACE, 61)} == {(3, 7), (-2, 7)}


def test_oblique_boundaries_come_with_angle_length_and_place():
    tilt = np.radians(5)
    found = traces(penny(centre=(4, 4, 4.1), normal=(np.cos(tilt), 0, np.sin(tilt)), radius=3.0), SURFACE)
    (one,) = oblique(found, SURFACE, 10)
    assert one.sides == (3, 7) and one.kind == 0 and one.angle == pytest.approx(5)
    assert one.length == pytest.approx(6, rel=1e-3) and one.place[0] == pytest.approx(4)


def preview(folder, crack, *words):
    write_surface(folder / "surface.vtp", SURFACE)
    write_crack(folder / "crack.vtp", crack)
    files = [str(folder / name) for name in ("surface.vtp", "crack.vtp")]
    status = main(
        ["preview", *files, "-o", str(folder / "crack.png"), "--report", str(folder / "crack.json"), *words]
    )
    picture = (folder / "crack.png").read_bytes()
    assert np.ptp(imread(io.BytesIO(picture))[..., :3]) > 0.5
    return status, json.loads((folder / "crack.json").read_text()), picture


def test_the_verb_tells_grains_fronts_and_ends(tmp_path, capsys):
    crack = penny(centre=(4.2, 0, 4.6), normal=(0.05, 0.1, 1), radius=2.5)
    status, report, picture = preview(tmp_path, crack, "--l-min", "0.5")
    assert status == 0 and report["refused"] is None and report["oblique"] == []
    assert list(report["grains"]) == ["3", "7"]
    area = sum(grain["area"] for grain in report["grains"].values())
    assert area == pytest.approx(np.pi * 2.5**2 / 2, rel=0.02)
    (front,) = report["fronts"]
    assert front["ends"] == ["YMIN", "YMIN"] and front["length"] == pytest.approx(np.pi * 2.5, rel=0.02)
    told = capsys.readouterr().out
    assert "grain 7: area" in told and "front 1: from YMIN to YMIN" in told
    assert preview(tmp_path, crack, "--l-min", "0.5")[2] == picture


def test_a_front_that_ends_on_a_void_and_a_grain_that_is_cut_through(tmp_path, capsys):
    crack = penny(centre=(9.5, 3, 3.2), normal=(0, 0.05, 1), radius=2.6)
    status, report, _ = preview(tmp_path, crack, "--l-min", "0.5")
    assert status == 0
    assert sorted(end for front in report["fronts"] for end in front["ends"]) == [
        "VOID_2", "VOID_2", "XMAX", "XMAX",
    ]  # fmt: skip
    options = {"shape": "through_edge", "centre": (0, 4, 4.3), "axis": (1, 0, 0.02), "radius": 6.0}
    status, report, _ = preview(tmp_path, penny(**options), "--l-min", "0.5")
    assert report["grains"]["3"]["front_length"] == 0 < report["grains"]["7"]["front_length"]
    assert "grain 3: area" in capsys.readouterr().out


def test_what_would_be_refused_is_told_with_the_exit_status(tmp_path, capsys):
    crack = penny(centre=(4, 4, 7.99), normal=(0, 0, 1), radius=2.0)
    status, report, _ = preview(tmp_path, crack, "--l-min", "0.5")
    assert status == 1 and list(report["grains"]) == ["3", "7"]
    assert report["refused"].startswith("the crack lies 0.01 from the box face ZMAX")
    assert "refused: the crack lies 0.01" in capsys.readouterr().out
