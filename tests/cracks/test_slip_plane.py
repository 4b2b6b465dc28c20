"""Cracks on a crystal plane within one grain: planar, inside the grain, through faces of the box."""

import json

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from models import voronoi

from craftmesh.cli import main
from craftmesh.cracks.check_crack import check_crack
from craftmesh.cracks.in_slip_plane import crack_in_slip_plane
from craftmesh.cracks.options import CrackOptions
from craftmesh.errors import CraftmeshError
from craftmesh.io.npz import write_labels
from craftmesh.io.vtk import read_crack, write_surface
from craftmesh.remeshing.remesh import remesh
from craftmesh.surface.labels import labels_at
from craftmesh.types import Voxels

GRAINS = remesh(voronoi(3, 6, (16, 16, 16)))[0]
L_MIN = 0.5
UP = np.array([0.0, 0.0, 1.0])


def body(is_second) -> Voxels:
    """A cube of edge 16: grain 2 where `is_second` of the voxels' middles, grain 1 elsewhere."""
    middles = np.moveaxis(np.indices((16, 16, 16)) + 0.5, 0, -1)
    return Voxels(np.where(is_second(middles), 2, 1), np.ones(3), np.zeros(3))


HALF = remesh(body(lambda at: at[..., 0] > 8))[0]
ISLAND = remesh(body(lambda at: np.linalg.norm(at - 8, axis=-1) < 5))[0]


def area_in_box(crack) -> float:
    """The area of a crack of constant z within the cube of edge 16."""
    part = shapely.union_all(shapely.polygons(crack.points[crack.triangles][:, :, :2]))
    return part.intersection(shapely.box(0, 0, 16, 16)).area


def crack_of(surface, normal=UP, **options):
    keys = CrackOptions(shape="slip_plane", plane=(1, 1, 1), **options)
    return crack_in_slip_plane(surface, keys, 0, np.asarray(normal, float), L_MIN)


def test_it_ends_before_other_grains_and_goes_through_faces_of_the_box():
    crack = crack_of(HALF, grain=1)
    assert check_crack(crack) == [] and len(crack.fronts) == 1
    # 1e-3: arcs of the outline are polygons
    assert area_in_box(crack) == pytest.approx((8 - L_MIN) * 16, rel=1e-3)
    front = crack.points[crack.fronts[0]]
    assert front[:, 0] == pytest.approx(8 - L_MIN, abs=1e-3) and set(front[[0, -1], 1]) == {0.0, 16.0}


def test_it_has_a_hole_around_an_enclosed_grain():
    crack = crack_of(ISLAND, grain=1, centre=(2.0, 8.0, 8.0))
    assert check_crack(crack) == [] and len(crack.fronts) == 1
    # 2 %: the sphere of voxels is smoothed
    assert area_in_box(crack) == pytest.approx(16**2 - np.pi * (5 + L_MIN) ** 2, rel=0.02)
    with pytest.raises(CraftmeshError, match="^crack.centre .8.0, 8.0, 8.0. is not within grain 1"):
        crack_of(ISLAND, grain=1, centre=(8.0, 8.0, 8.0))


def test_a_radius_cuts_it_off():
    crack = crack_of(HALF, grain=1, centre=(4.0, 8.0, 8.0), radius=2.0)
    assert area_in_box(crack) == pytest.approx(4 * np.pi, rel=1e-3)
    wide = crack_of(HALF, grain=1, centre=(4.0, 8.0, 8.0), radius=99.0)
    assert area_in_box(wide) == pytest.approx(area_in_box(crack_of(HALF, grain=1)))


@settings(max_examples=25)
@given(st.integers(1, 6), st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda n: np.linalg.norm(n) > 0.1))
def test_in_any_grain_and_direction_it_is_planar_and_inside_the_grain(grain, normal):
    normal = np.array(normal) / np.linalg.norm(normal)
    try:
        crack = crack_of(GRAINS, normal, grain=grain)
    except CraftmeshError as error:
        assert "is not within grain" in str(error)
        return
    assert check_crack(crack) == []
    assert np.ptp(crack.points @ normal) < 1e-9
    inside = ((crack.points > GRAINS.box[0]) & (crack.points < GRAINS.box[1])).all(axis=1)
    surface = GRAINS.points, GRAINS.facets.astype(np.int64), GRAINS.sides
    assert (labels_at(crack.points[inside], *surface) == grain).all()


def test_the_command_takes_the_orientation_of_the_grain(tmp_path, capsys):
    turns = np.tile([np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0], (3, 1))  # 90 degrees about x: crystal z is -y
    voxels = body(lambda at: at[..., 0] > 8)
    known = Voxels(voxels.labels, voxels.spacing, voxels.origin, turns)
    write_labels(tmp_path / "labels.npz", known)
    write_labels(tmp_path / "bare.npz", voxels)
    write_surface(tmp_path / "remeshed.vtp", HALF)
    flags = ["--surface", str(tmp_path / "remeshed.vtp"), "-o", str(tmp_path / "crack.vtp"), "--grain", "2"]
    flags += ["--shape", "slip_plane", "--l-min", "0.5", "--plane", "0", "0"]
    report = ["--report", str(tmp_path / "crack.json")]
    assert main(["crack", str(tmp_path / "labels.npz"), *flags, "1", *report]) == 0
    assert json.loads((tmp_path / "crack.json").read_text())["normal"] == pytest.approx(
        [0, -1, 0], abs=1e-6
    )
    assert np.ptp(read_crack(tmp_path / "crack.vtp").points[:, 1]) < 1e-6
    for volume, last, said in (
        ("bare.npz", "1", "crack.grain is 2, whose orientation is not known"),
        ("labels.npz", "0", "crack.grain is 2 and crack.plane (0, 0, 0); shape slip_plane needs"),
    ):
        capsys.readouterr()
        assert main(["crack", str(tmp_path / volume), *flags, last]) == 1
        assert said in capsys.readouterr().err
