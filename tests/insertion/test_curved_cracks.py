"""Curved cracks: facets near the given surface, none in or through a boundary, contacts made."""

from dataclasses import replace

import numpy as np
import pytest
from given_cracks import over_grid, wavy_disc
from models import with_voids
from structured_box import structured_box

from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.polyline import polyline
from craftmesh.cracks.series import prescribed_crack
from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.growth.front_step import FrontStep
from craftmesh.growth.grow import grow
from craftmesh.growth.options import SmoothingOptions
from craftmesh.insertion.cut import uncut
from craftmesh.insertion.insert import insert_crack
from craftmesh.insertion.options import InsertOptions
from craftmesh.insertion.pierce import snap_to_front
from craftmesh.insertion.sheet import sheet_of
from craftmesh.sizing.sizing import Sizing, densify
from craftmesh.surface.check_surface import check_surface
from craftmesh.surface.front import front_edges
from craftmesh.surface.measure import area_vectors
from craftmesh.types import CRACK, Surface

SIZE = 24.0
BOX = np.array([[0.0, 0.0, 0.0], [SIZE, SIZE, SIZE]])
CORNERS = np.array([[i, j, 4 - i - j] for i in range(5) for j in range(5 - i)]) / 4


@pytest.fixture(scope="module")
def polycrystal() -> Surface:
    return with_voids(24, 9, 2, 3.0, (0.0, 0.0, 0.0))


def crack_corners(surface: Surface) -> np.ndarray:
    return surface.points[surface.facets[surface.kind == CRACK]]


def sizing_about(crack, l_min: float) -> Sizing:
    sources = np.concatenate([densify(crack.points[front], l_min / 2) for front in crack.fronts])
    return Sizing(l_min, max(1.0, l_min), 2.0, 4.0, 8.0, 1.0, sources)


@pytest.mark.sampled(3)
@pytest.mark.parametrize("tilt", [0, 40])
@pytest.mark.parametrize("l_min", [0.5, 1.0])
def test_facets_lie_near_the_given_surface_and_in_no_box_plane(polycrystal, l_min, tilt):
    points, triangles = wavy_disc(8.0, 2.5, rings=24)
    c, s = np.cos(np.radians(tilt)), np.sin(np.radians(tilt))
    points = points @ np.array([[1, 0, 0], [0, c, s], [0, -s, c]]) + [12.0, 12.0, 6.0 if tilt else 12.0]
    crack = crack_from_triangles(points, triangles, None, BOX)
    surface, _ = insert_crack(polycrystal, crack, sizing_about(crack, l_min))
    assert check_surface(surface) == []
    sheet, corners = sheet_of(crack, BOX), crack_corners(surface)
    samples = np.einsum("sk,mkx->msx", CORNERS, corners).reshape(-1, 3)
    off = np.abs(sheet.offset(samples)) / np.linalg.norm(sheet.gradient(samples), axis=1)
    # before facets followed the bends, up to 0.25 l_min; a few at the front's chords stay at up to 0.06
    assert np.quantile(off, 0.995) < 0.05 * l_min
    assert off.max() < 0.08 * l_min
    in_plane = (np.abs(corners[:, :, None] - BOX[None, None]) < 1e-9).all(axis=1).any(axis=(1, 2))
    assert not in_plane.any()


def test_the_area_is_that_of_the_given_crack(polycrystal):
    points, triangles = wavy_disc(7.0, 2.0, rings=24)
    crack = crack_from_triangles(points + 12.0, triangles, None, BOX)
    surface, report = insert_crack(polycrystal, crack, sizing_about(crack, 0.5))
    given = np.linalg.norm(area_vectors(crack.points, crack.triangles), axis=1).sum()
    if not report["crack_facets_outside_material"]:
        # chords of the front cut off 0.1 %
        assert report["crack_area"] == pytest.approx(given, rel=5e-3)


def test_facets_of_a_void_that_lie_on_the_crack_are_no_crack_facets():
    def label(c: np.ndarray) -> np.ndarray:
        middle = (np.abs(c[:, :2] - 3) < 1).all(axis=1)
        return np.where(middle & (c[:, 2] > 3) & (c[:, 2] < 5), -1, 1)

    model, _ = structured_box((6, 6, 6), label)
    box = np.array([[0.0, 0, 0], [6, 6, 6]])
    crack = prescribed_crack(box, CrackOptions(centre=(3, 3, 3), radius=2.2))
    surface, report = insert_crack(model, crack, None)
    assert check_surface(surface) == []
    middle = crack_corners(surface).mean(axis=1)
    assert not (np.abs(middle[:, :2] - 3) < 1).all(axis=1).any()
    assert report["crack_facets_outside_material"] >= 8
    # less the void's face of 2 x 2; chords within 0.02 of the circle cut off 1.2 %
    assert report["crack_area"] == pytest.approx(np.pi * 2.2**2 - 4, rel=0.02)


@pytest.mark.slow
def test_a_rough_crack_that_grazes_a_boundary_and_the_box_is_inserted():
    """Rough at the size of the facets and nearly along a boundary: sound with smaller facets there."""
    model, _ = structured_box((8, 8, 8), lambda c: 1 + (c[:, 2] > 4).astype(int))
    box = np.array([[0.0, 0, 0], [8, 8, 8]])
    points, triangles = wavy_disc(3.5, 0.0, rings=20)
    x, y = points[:, :2].T
    points[:, 2] = 0.1 * np.sin(5.3 * x + 1) * np.cos(4.1 * y) + 0.12 * np.sin(2.3 * y + x) + 0.02 * x
    crack = crack_from_triangles(points + [4, 6, 4], triangles, None, box)
    surface, _ = insert_crack(model, crack, sizing_about(crack, 0.4))
    assert check_surface(surface) == []


@pytest.mark.sampled(3)
@pytest.mark.parametrize("height", [-0.1, 0.0, 0.05])
def test_a_crack_that_bulges_through_a_boundary_between_its_points_is_inserted(height):
    """A wavy crack along a flat boundary that it crosses and touches again and again."""
    model, _ = structured_box((8, 8, 8), lambda c: 1 + (c[:, 2] > 4).astype(int))
    box = np.array([[0.0, 0, 0], [8, 8, 8]])
    points, triangles = wavy_disc(3.2, 0.0, rings=24)
    points[:, 2] = 0.3 * np.sin(2.1 * points[:, 0]) * np.cos(1.7 * points[:, 1]) + height
    crack = crack_from_triangles(points + [4, 4, 4], triangles, None, box)
    surface, _ = insert_crack(model, crack, sizing_about(crack, 0.4))
    assert check_surface(surface) == []
    given = np.linalg.norm(area_vectors(crack.points, crack.triangles), axis=1).sum()
    area = np.linalg.norm(area_vectors(surface.points, surface.facets[surface.kind == CRACK]), axis=1).sum()
    assert area == pytest.approx(given, rel=0.02)


def wavy_strip(height: float, waves: tuple[float, float, float], skew: float) -> tuple:
    """A strip across a box of 16 x 16: points, triangles; waves: amplitude, wave number, phase along x."""
    across, along = np.meshgrid(np.linspace(-3, 19, 60), np.linspace(-3, 9, 30), indexing="ij")
    along = along + skew * (across - 8) * (along + 3) / 12
    amplitude, number, phase = waves
    return over_grid(across, along, height + amplitude * np.sin(number * (across - 0.15 * along) + phase))


@pytest.mark.parametrize("slope", [0.2, 0.3])
def test_the_area_beside_a_curved_mouth_at_a_small_angle_is_kept(slope):
    """A cap whose mouth in z = 0 has a radius of 7 l_min, and its front at x = 9."""
    model, _ = structured_box((16, 16, 8), lambda c: np.ones(len(c), int))
    box = np.array([[0.0, 0, 0], [16, 16, 8]])
    x, y = np.meshgrid(np.arange(-2, 9, 0.25), np.arange(-2, 18, 0.25), indexing="ij")
    z = slope / 10 * (25 - (x - 8) ** 2 - (y - 8) ** 2)
    crack = crack_from_triangles(*over_grid(x, y, z), None, box)
    _, report = insert_crack(model, crack, sizing_about(crack, 0.7))
    # chords that were 0.03 l_min off the crack cut off 0.51 and 0.52 %
    assert report["crack_area"] == pytest.approx(area_within(crack, box), rel=0.0045)


def test_a_crack_that_also_touches_a_corner_of_the_box_is_inserted():
    """It is below the box within a circle through the corner, and above its floor outside of that."""
    model, _ = structured_box((16, 16, 8), lambda c: np.ones(len(c), int))
    box = np.array([[0.0, 0, 0], [16, 16, 8]])
    x, y = np.meshgrid(np.arange(-2.0, 12.5, 0.5), np.arange(-2.0, 12.5, 0.5), indexing="ij")
    crack = crack_from_triangles(*over_grid(x, y, 0.04 * (x**2 + y**2) - 0.3 * (x + y)), None, box)
    surface, report = insert_crack(model, crack, sizing_about(crack, 0.5))
    assert check_surface(surface) == []
    assert report["crack_area"] == pytest.approx(area_within(crack, box), rel=0.005)


@pytest.mark.parametrize(
    "height, waves, skew",
    [
        (0.51, (1.55, 0.569, 4.871), -0.275),
        (0.742, (1.737, 0.482, 4.458), -0.411),
        (0.815, (1.01, 0.669, 2.34), -0.132),
        (0.329, (1.399, 0.661, 0.18), -0.352),
    ],
)
def test_a_front_that_leaves_through_a_curved_mouth_ends_there(height, waves, skew):
    """The mouth's chord in the box plane passes beside the front's end, once missed there or met twice."""
    model, _ = structured_box((16, 16, 8), lambda c: np.ones(len(c), int))
    box = np.array([[0.0, 0, 0], [16, 16, 8]])
    crack = crack_from_triangles(*wavy_strip(height, waves, skew), None, box)
    surface, _ = insert_crack(model, crack, sizing_about(crack, 0.5))
    assert check_surface(surface) == []
    given = np.concatenate([crack.points[front[[0, -1]]] for front in crack.fronts])
    ends, count = np.unique(front_edges(surface), return_counts=True)
    ends = surface.points[ends[count == 1]]
    assert len(ends) == len(given)
    assert np.linalg.norm(ends[:, None] - given, axis=2).min(axis=1).max() < 0.02 * 0.5


def test_a_crack_that_stops_just_short_of_an_edge_of_the_box_reaches_it():
    """Its side is 1e-6 off y = 16 at z = 8, and on it 0.02 lower: neither front nor mouth was there."""
    model, _ = structured_box((16, 16, 8), lambda c: np.ones(len(c), int))
    box = np.array([[0.0, 0, 0], [16, 16, 8]])
    z, share = np.meshgrid(np.linspace(3, 9, 20), np.linspace(0, 1, 12), indexing="ij")
    y = 6 + share * (10 - 1e-6 * (z - 7.98) / 0.02)
    crack = crack_from_triangles(*over_grid(np.full(z.shape, 8.3), y, z), None, box)
    surface, report = insert_crack(model, crack, sizing_about(crack, 0.5))
    assert check_surface(surface) == []
    assert report["crack_area"] == pytest.approx(50.0, rel=1e-6)


def test_points_near_the_rim_of_a_crack_without_a_front_stay():
    """It severs the box: its rim is its mouth, pushed out of the box."""
    model, _ = structured_box((16, 16, 8), lambda c: np.ones(len(c), int))
    box = np.array([[0.0, 0, 0], [16, 16, 8]])
    x, y = np.meshgrid(np.linspace(-1, 17, 30), np.linspace(-1, 17, 30), indexing="ij")
    crack = crack_from_triangles(*over_grid(x, y, 4.1 + 0.02 * (x - 8) ** 2), None, box)
    sheet = sheet_of(crack, box)
    cut = replace(uncut(model), phi=np.zeros(len(model.points)), size=np.ones(len(model.points)))
    assert not sheet.rim.curves
    assert snap_to_front(cut, sheet, lambda places: np.ones(len(places)), InsertOptions()) is cut


@pytest.mark.parametrize("kink", [25.0, 45.0])
def test_a_strip_grown_in_a_box_plane_reaches_it_all_along(polycrystal, kink):
    """The mouth of a tilted half penny has grown in y = 0, and the old crack reaches out beside it."""
    tilt = np.radians(35)
    options = CrackOptions(centre=(12.0, 0.0, 12.0), radius=5.0, normal=(0.0, np.sin(tilt), np.cos(tilt)))
    crack = prescribed_crack(BOX, options)
    line = polyline(crack.points[crack.fronts[0]])
    s = np.linspace(0, line.length, 31)
    tangent = np.stack([np.interp(s, line.arc, column) for column in line.tangents().T], axis=1)
    normal = np.tile(options.normal, (31, 1))
    if area_vectors(crack.points, crack.triangles).sum(axis=0) @ normal[0] < 0:
        normal = -normal
    turned = np.full(31, np.radians(kink))
    along = FrontStep.of(line.at(s), normal, np.cross(tangent, normal), turned, np.full(31, 2.0))
    grown = grow(crack, along, BOX, SmoothingOptions()).crack
    surface, report = insert_crack(polycrystal, grown, sizing_about(grown, 0.6))
    assert check_surface(surface) == []
    assert report["crack_facets_outside_material"] == 0
    front = front_edges(surface)
    ends, count = np.unique(front, return_counts=True)
    given = grown.points[grown.fronts[0][[0, -1]]]
    off = np.linalg.norm(surface.points[ends[count == 1]][:, None] - given, axis=2).min(axis=1)
    assert len(off) == 2 and off.max() < 0.02 * 0.6
    # 0.9 % are chords of the front and at the kink; a corner that was left out took 1.5 and 2.2 %
    assert report["crack_area"] == pytest.approx(area_within(grown), rel=0.012)


def area_within(crack, box=BOX) -> float:
    """Return the area of a crack within the box, from triangles split in 64, by their centres."""
    corners = crack.points[crack.triangles]
    for _ in range(3):
        middles = (corners + np.roll(corners, -1, axis=1)) / 2
        at_corners = [np.stack([corners[:, k], middles[:, k], middles[:, k - 1]], axis=1) for k in range(3)]
        corners = np.concatenate([*at_corners, middles])
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    centre = corners.mean(axis=1)
    within = ((centre >= box[0]) & (centre <= box[1])).all(axis=1)
    return float(np.linalg.norm(np.cross(first, second), axis=1)[within].sum() / 2)
