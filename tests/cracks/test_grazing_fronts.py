"""A front that grazes a face of the box ends on it, within what a front node may be off; others stay."""

import numpy as np
import pytest
from given_cracks import over_grid
from hypothesis import given, settings
from hypothesis import strategies as st

from craftmesh.cracks.grazing_fronts import TAKEN, ending_on_faces
from craftmesh.cracks.meshable import meshable
from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.series import prescribed_crack
from craftmesh.cracks.sheets import sheets
from craftmesh.cracks.triangulated import ON_PLANE, crack_from_triangles
from craftmesh.cracks.within_box import area_within
from craftmesh.surface.kernels.distances import nearest_on_edges
from craftmesh.types import Crack

BOX = np.array([[0.0, 0, 0], [20, 20, 20]])
L_MIN = 0.5
RADIUS = 4.0


def penny(gap: float, degrees: float = 90.0, axis: int = 2, top: bool = False):
    """A penny, at an angle to a face of the box, whose front comes as near to it as gap, along it."""
    sine, cosine = np.sin(np.radians(degrees)), np.cos(np.radians(degrees))
    centre = np.full(3, 10.0)
    height = (RADIUS + gap * L_MIN) * sine
    centre[axis] = 20.0 - height if top else height
    normal = np.roll([cosine, sine, 0.0], axis)
    return prescribed_crack(CrackOptions(centre=tuple(centre), normal=tuple(normal), radius=RADIUS), 0, BOX)


def off_the_front(sheet, places: np.ndarray) -> np.ndarray:
    edges = np.concatenate([np.column_stack([front[:-1], front[1:]]) for front in sheet.fronts])
    return np.linalg.norm(nearest_on_edges(places, sheet.points, edges.astype(np.int64)) - places, axis=1)


@settings(max_examples=12, deadline=None)
@given(
    gap=st.floats(0.0005, 0.95 * TAKEN),
    degrees=st.floats(20.0, 160.0),
    axis=st.integers(0, 2),
    top=st.booleans(),
)
def test_a_front_that_grazes_a_face_ends_on_it(gap, degrees, axis, top):
    sheet = penny(gap, degrees, axis, top)
    ended = ending_on_faces(sheet, BOX, L_MIN)
    (front,) = ended.fronts
    line = ended.points[front]
    on_plane = ON_PLANE * np.linalg.norm(BOX[1] - BOX[0])
    assert np.abs(line[[0, -1], axis] - (20.0 if top else 0.0)).max() <= on_plane
    assert ((line >= BOX[0] - on_plane) & (line <= BOX[1] + on_plane)).all()
    # TAKEN, and the chord of an edge that was parted: 1e-4 of the radius
    assert off_the_front(sheet, line).max() <= TAKEN * L_MIN * 1.001
    # the crack stays in its plane
    normal = np.roll([np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0.0], axis)
    height = (ended.points - ended.points.mean(axis=0)) @ normal
    assert np.ptp(height) <= 1e-9


@pytest.mark.parametrize("gap", [0.04, 0.5, -0.5, -3.0])
def test_a_front_that_stays_away_or_crosses_the_face_is_as_it_was(gap):
    sheet = penny(gap)
    assert ending_on_faces(sheet, BOX, L_MIN) is sheet


@settings(max_examples=20, deadline=None)
@given(
    low=st.floats(0.1, 0.9),
    degrees=st.floats(8.0, 90.0),
    width=st.floats(2.0, 6.0),
    axis=st.integers(0, 2),
)
def test_a_front_that_dips_to_just_above_the_face_between_two_ends_goes_past_it_whole(
    low, degrees, width, axis
):
    """At small angles it is farther from the face along the crack than a node may be off."""
    x = np.linspace(-2, 22, 97)
    gap = low * TAKEN * L_MIN * np.clip(1 - (2 * (x - 10) / width) ** 2, -4, None)
    along = np.stack([gap / np.sin(np.radians(degrees)), np.full(len(x), 6.0)])
    y, z = 3 + np.cos(np.radians(degrees)) * along, np.sin(np.radians(degrees)) * along
    points, triangles = over_grid(np.broadcast_to(x, y.shape), y, z)
    sheet = crack_from_triangles(np.roll(points, axis, axis=1), triangles, None, BOX)
    assert len(sheet.fronts) == 2
    ended = ending_on_faces(sheet, BOX, L_MIN)
    (front,) = ended.fronts
    assert np.allclose(ended.points[front][:, (axis + 2) % 3], 6.0 * np.sin(np.radians(degrees)))
    assert area_within(ended, BOX) - area_within(sheet, BOX) == pytest.approx(
        2 / 3 * width * gap.max() / np.sin(np.radians(degrees)), rel=0.05
    )


@settings(max_examples=20, deadline=None)
@given(
    low=st.floats(0.05, 0.9),
    slope=st.floats(-1e-4, 1e-4),
    degrees=st.floats(8.0, 172.0),
    turn=st.floats(-30.0, 30.0),
    axis=st.integers(0, 2),
)
def test_a_front_along_the_whole_of_a_face_goes_past_it_and_the_crack_parts_the_body(
    low, slope, degrees, turn, axis
):
    """It ends on two other faces, along which the crack's end has to go, however they meet it."""
    x = np.linspace(-5, 25, 61)
    gap = low * TAKEN * L_MIN * np.clip(1 + slope * (x - 10) * 20, 0.5, 1.1)
    deep = np.full(len(x), 5.0)
    along = np.stack([gap, deep]) / np.sin(np.radians(degrees))
    lean = x + np.tan(np.radians(turn)) * np.stack([0 * x, deep])
    y, z = 10 + np.cos(np.radians(degrees)) * along, np.stack([gap, deep])
    points, triangles = over_grid(lean, y, z)
    sheet = crack_from_triangles(np.roll(points, axis, axis=1), triangles, None, BOX)
    plane = (axis + 2) % 3
    (line,) = [one for one in sheet.fronts if sheet.points[one][:, plane].max() < 1]
    ended = meshable([sheet], BOX, L_MIN)
    assert all(ended.points[front][:, plane].min() > 1 for front in ended.fronts)
    widened = area_within(ended, BOX) - area_within(sheet, BOX)
    x, gaps = sheet.points[line][:, axis], sheet.points[line][:, plane]
    narrow = abs(np.trapezoid(gaps, x)) / np.sin(np.radians(degrees))
    assert widened == pytest.approx(narrow, rel=1e-3)
    again = ending_on_faces(ended, BOX, L_MIN, only_whole=True)
    assert again is ended


def test_a_front_that_the_crack_itself_parts_from_the_face_stays():
    """The crack comes through the face and ends just inside: its front stays where it was given."""
    sheet = penny(-2 * RADIUS / L_MIN + 0.01)
    assert ending_on_faces(sheet, BOX, L_MIN) is sheet


def test_a_crack_of_facets_of_a_surface_stays_beside_one_that_ends_on_a_face():
    """Its front may run against its triangles, which are turned as those of the boundaries are."""
    near, far = penny(0.01), penny(0.01, axis=0)
    facets = Crack(far.points, far.triangles[:, ::-1], far.fronts)
    first, second = sheets(meshable([near, facets], BOX, L_MIN, of_facets=[1]))
    assert len(first.points) > len(near.points)
    assert np.array_equal(second.points, facets.points)
    assert np.array_equal(second.triangles, facets.triangles)
