"""Cracks as they are measured: clouds with fronts, fronts alone, voxels; and how far the surface is off."""

import json

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from craftmesh.cli import main
from craftmesh.commands.crack import given_surface
from craftmesh.cracks.check_crack import check_crack
from craftmesh.cracks.fitted_surface import crack_through_fronts, crack_through_points
from craftmesh.cracks.in_plane import filled
from craftmesh.cracks.options import CrackOptions, crack_files
from craftmesh.cracks.polyline import feet, polyline
from craftmesh.cracks.series import crack_area, crack_of_increment
from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.cracks.voxel_crack import crack_through_voxels
from craftmesh.errors import CraftmeshError
from craftmesh.io.npz import write_labels
from craftmesh.types import Voxels

BOX = np.array([[0.0, 0, 0], [40, 40, 40]])
CENTRE = np.array([20.0, 20, 20])


def wave(x, y):
    return 20 + 1.2 * np.sin(x / 5) * np.cos(y / 6) + 0.15 * x


def ring(radius, height=wave, count=80):
    """A closed front: a circle seen from above, its first point again at the end."""
    angle = np.append(np.arange(count) * 2 * np.pi / count, 0.0)
    x, y = 20 + radius * np.cos(angle), 20 + radius * np.sin(angle)
    return np.column_stack([x, y, height(x, y) + 0 * x])


def arc(radius, sag=0.0):
    """An open front: half a circle from the face y = 0, its ends `sag` inside the box."""
    angle = np.linspace(0, np.pi, 61)
    x, y = 20 + radius * np.cos(angle), sag + radius * np.sin(angle)
    return np.column_stack([x, y, 20 + 0.02 * (x - 20) ** 2])


def crack_of(surface):
    crack = crack_from_triangles(surface.points, surface.triangles, None, BOX)
    assert check_crack(crack) == []
    return crack


def off_front(crack, points):
    """Return how far points (k, 3) are from the crack's nearest front."""
    lines = [polyline(crack.points[front]) for front in crack.fronts]
    return np.min([feet(line, points)[1] for line in lines], axis=0)


def cloud_of(count, noise, seed=0):
    random = np.random.default_rng(seed)
    x, y = random.random((2, count)) * 30 + 5
    return np.column_stack([x, y, wave(x, y) + random.normal(0, noise, count)])


@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_a_measured_cloud_becomes_the_surface_that_it_was_taken_from(noise):
    front = ring(11.0)
    surface, report = crack_through_points(cloud_of(6000, noise), [front], BOX)
    crack = crack_of(surface)
    off = np.abs(crack.points[:, 2] - wave(*crack.points[:, :2].T))
    # facets of 0.8 cut the waves by 0.01; two points a facet take the noise to half
    assert np.sqrt((off**2).mean()) < 0.01 + 0.6 * noise
    assert report["deviation_rms"] == pytest.approx(0.9 * noise, abs=0.01 + 0.1 * noise)
    assert report["points_used"] + report["points_beside"] == 6000
    assert off_front(crack, front).max() < 1e-9


def test_far_off_points_show_in_the_deviation():
    cloud = cloud_of(3000, 0.0)
    nearest = np.argmin(np.linalg.norm(cloud - CENTRE, axis=1))
    cloud[nearest, 2] += 3.0
    _, report = crack_through_points(cloud, [ring(11.0)], BOX)
    assert 1.0 < report["deviation_most"] < 3.0 and report["deviation_rms"] < 0.1


@pytest.mark.parametrize("sag", [0.0, 1.5, -2.0])
def test_an_open_front_is_carried_on_to_the_box_and_bounds_the_smaller_side(sag):
    front = arc(12.0, sag)
    surface, _ = crack_through_fronts([front], BOX)
    crack = crack_of(surface)
    (found,) = crack.fronts
    ends = crack.points[found[[0, -1]]]
    assert (ends[:, 1] == 0.0).all()
    within = front[front[:, 1] > 0]
    assert off_front(crack, within).max() < 1e-9
    other, _ = crack_through_fronts([front], BOX, inside=(20, 35, 20))
    assert crack_of(other).points[:, 1].max() > 40  # behind the front lies the rest of the box


def test_a_front_that_ends_inside_is_refused_with_its_place():
    with pytest.raises(CraftmeshError, match=r"ends at \[32.0, 9.0, 22.88\], 8 inside the box face XMAX"):
        crack_through_fronts([arc(12.0, 9.0)], BOX)


def test_the_surface_of_successive_fronts_goes_through_all_of_them():
    fronts = [ring(radius) for radius in (5.0, 7.5, 11.0)]
    areas = []
    for count in (1, 2, 3):
        surface, report = crack_through_fronts(fronts[:count], BOX, spacing=0.8)
        crack = crack_of(surface)
        areas.append(crack_area(crack))
        assert off_front(crack, fronts[count - 1]).max() < 1e-9
        for front in fronts[:count]:  # earlier fronts lie in the surface: their points are its points
            assert np.abs(crack.points[:, None] - front).sum(axis=2).min(axis=0).max() < 1e-8
    off = crack.points[:, 2] - wave(*crack.points[:, :2].T)
    assert np.abs(off).max() < 0.3 and areas == sorted(areas)
    assert report["triangles"] == len(surface.triangles)


def test_a_ring_has_an_inner_front():
    surface, _ = crack_through_points(cloud_of(4000, 0.0), [ring(11.0), ring(4.0)], BOX)
    crack = crack_of(surface)
    assert len(crack.fronts) == 2
    plane = np.pi * (11**2 - 4**2)
    assert plane < crack_area(crack) < 1.1 * plane


def disc_voxels(radius, x):
    at = np.moveaxis(np.indices((40, 40, 40)), 0, -1) + 0.5
    near = np.abs(at[..., 2] - (20 + np.sin(at[..., 0] / 8))) <= 1.0
    return near & (np.hypot(at[..., 0] - x, at[..., 1] - 20) < radius)


@pytest.mark.parametrize("x", [20.3, 0.0])
def test_a_crack_as_voxels_gets_its_sheet_and_its_front(x):
    """The middle of two layers of voxels lies within half a voxel of the sheet they are drawn from."""
    surface, report = crack_through_voxels(disc_voxels(12.0, x), np.ones(3), np.zeros(3), BOX)
    crack = crack_of(surface)
    (front,) = crack.fronts
    radius = np.hypot(crack.points[front, 0] - x, crack.points[front, 1] - 20)
    assert abs(radius.mean() - 12.0) < 0.1 and np.abs(radius - 12.0).max() < 0.5
    within = (crack.points[:, 0] > 0) & (crack.points[:, 0] < 40)
    off = crack.points[within, 2] - (20 + np.sin(crack.points[within, 0] / 8))
    assert np.abs(off).mean() < 0.25 and np.abs(off).max() < 0.7
    assert report["deviation_most"] < 1.0 and report["voxels"] == disc_voxels(12.0, x).sum()
    assert (front[0] == front[-1]) == (x > 0)
    if x == 0:
        assert (crack.points[front[[0, -1]], 0] == 0).all()


def test_voxels_of_another_grid_and_of_two_pieces():
    coarse = disc_voxels(12.0, 20.0)[::2, ::2, :]
    surface, _ = crack_through_voxels(coarse, np.array([2.0, 2, 1]), np.zeros(3), BOX)
    assert len(crack_of(surface).fronts) == 1
    two = disc_voxels(5.0, 8.0) | disc_voxels(5.0, 30.0)
    with pytest.raises(CraftmeshError, match="2 regions"):
        crack_through_voxels(two, np.ones(3), np.zeros(3), BOX)


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1))
def test_a_polygon_is_filled_without_gaps_and_through_the_given_points(seed):
    random = np.random.default_rng(seed)
    angle = np.sort(random.random(random.integers(5, 40))) * 2 * np.pi
    radius = 3 + 2 * random.random(len(angle))
    polygon = shapely.Polygon(np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1))
    if not polygon.is_valid or polygon.area < 1:
        return
    inner = random.normal(0, 1.0, (random.integers(0, 30), 2))
    points, triangles = filled(polygon, inner, 0.5)
    corners = points[triangles]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    doubled = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    assert (doubled > 0).all() and doubled.sum() / 2 == pytest.approx(polygon.area, rel=1e-6)
    given_inside = inner[shapely.contains_xy(polygon, inner[:, 0], inner[:, 1])]
    every = np.concatenate([given_inside, np.asarray(polygon.exterior.coords)])
    assert np.abs(points[:, None] - every).sum(axis=2).min(axis=0).max() < 1e-7


def written(path, points):
    path.write_text("\n".join(["x,y,z", *(",".join(map(repr, row)) for row in points.tolist())]))
    return str(path)


def test_files_of_fronts_are_named_and_read_increment_by_increment(tmp_path):
    names = tuple(written(tmp_path / f"{k}.csv", ring(5.0 + 2 * k)) for k in range(3))
    options = CrackOptions(shape="fronts", increments=names)
    assert crack_files(options, 1) == {"increments[0]": names[0], "increments[1]": names[1]}
    cracks = [crack_of_increment(options, k, BOX, given_surface(options, k, BOX)[0]) for k in range(3)]
    assert crack_area(cracks[0]) < crack_area(cracks[1]) < crack_area(cracks[2])
    alone = CrackOptions(shape="fronts", file=names[2])
    assert crack_files(alone, 0) == {"file": names[2]}
    assert off_front(crack_of(given_surface(alone, 0, BOX)[0]), ring(9.0)).max() < 1e-9


def test_a_front_of_craftmesher_is_a_crack(shared_data):
    """Its AdvCrack file: an open front in a box from 0, whose ends are short of the face y = 0."""
    file = shared_data / "defects" / "craftmesher_AdvCrack.csv"
    box = np.array([[0.0, 0, 0], [100, 100, 100]])
    surface, _ = given_surface(CrackOptions(shape="fronts", file=str(file)), 0, box)
    crack = crack_from_triangles(surface.points, surface.triangles, None, box)
    (front,) = crack.fronts
    assert (crack.points[front[[0, -1]], 1] == 0).all()
    given_points = np.loadtxt(file, delimiter=",")[:, 7:]
    assert feet(polyline(crack.points[front]), given_points)[1].max() < 1e-9


@pytest.mark.parametrize("suffix", [".csv", ".xyz"])
def test_the_verb_reports_how_far_the_cloud_is(tmp_path, suffix, capsys):
    labels = np.ones((40, 40, 40), int)
    labels[20:] = 2
    write_labels(tmp_path / "labels.npz", Voxels(labels, (1, 1, 1), (0, 0, 0)))
    cloud = tmp_path / f"cloud{suffix}"
    if suffix == ".csv":
        written(cloud, cloud_of(3000, 0.05))
    else:
        np.savetxt(cloud, cloud_of(3000, 0.05))
    front = written(tmp_path / "front.csv", ring(11.0))
    words = ["crack", str(tmp_path / "labels.npz"), "--shape", "points", "--file", str(cloud)]
    words += ["-o", str(tmp_path / "crack.vtp"), "--report", str(tmp_path / "report.json")]
    assert main([*words, "--front", front]) == 0
    report = json.loads((tmp_path / "report.json").read_text())
    assert 0 < report["deviation_rms"] < 0.06
    assert "deviation most" in capsys.readouterr().out
    assert main(words) == 1
    assert "crack.front is not given; give the CSV file" in capsys.readouterr().err


def test_labels_say_which_voxels_are_the_crack(tmp_path, capsys):
    labels = np.where(np.arange(40)[:, None, None] < 20, 1, 2) + np.zeros((40, 40, 40), int)
    write_labels(tmp_path / "labels.npz", Voxels(labels, (0.5, 0.5, 0.5), (3, 0, 0)))
    marked = np.where(disc_voxels(12.0, 20.0), 7, labels)
    np.save(tmp_path / "marked.npy", marked)
    words = ["crack", str(tmp_path / "labels.npz"), "-o", str(tmp_path / "crack.vtp"), "--shape", "voxels"]
    words += ["--file", str(tmp_path / "marked.npy"), "--label"]
    assert main([*words, "7"]) == 0
    assert f"voxels: {disc_voxels(12.0, 20.0).sum()}" in capsys.readouterr().out
    for absent in ("8", "0"):
        assert main([*words, absent]) == 1
        assert f"no voxel has a label {absent}" in capsys.readouterr().err
    np.save(tmp_path / "marked.npy", marked[1:])
    assert main([*words, "7"]) == 1
    assert "has (39, 40, 40) voxels and no spacing" in capsys.readouterr().err
    assert main([*words[:-3], "--shape", "voxels"]) == 1
    assert "crack.file is None; expected labels in .npz" in capsys.readouterr().err


def test_what_bounds_no_sheet_is_refused():
    eight = ring(8.0)
    eight[20:60, 1] = 40 - eight[20:60, 1]
    with pytest.raises(CraftmeshError, match="crosses itself"):
        crack_through_fronts([eight], BOX)
    with pytest.raises(CraftmeshError, match="2 fronts, 1 of them open"):
        crack_through_points(cloud_of(500, 0.0), [ring(8.0), arc(5.0)], BOX)
    with pytest.raises(CraftmeshError, match="lie on a line"):
        crack_through_fronts([np.outer(np.arange(5.0), [1, 1, 1])], BOX)
    with pytest.raises(CraftmeshError, match=r"front 1 is an array \(2, 3\)"):
        crack_through_fronts([ring(8.0)[:2]], BOX)
    with pytest.raises(CraftmeshError, match="no point of the cloud is within the front"):
        crack_through_points(cloud_of(500, 0.0) + [60, 0, 9], [ring(8.0)], BOX, 1.0)
    with pytest.raises(CraftmeshError, match="spacing 1e-05 is too short"):
        crack_through_fronts([ring(8.0)], BOX, 1e-5)
