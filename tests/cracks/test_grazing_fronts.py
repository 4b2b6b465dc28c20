"""A front that grazes a face of the box ends on it, within what a front node may be off; others stay."""

import numpy as np
import pytest
from given_cracks import over_grid
from hypothesis import given, settings
from hypothesis import strategies as st

from craftmesh.cracks.crack_tolerances import PREPARATION
from craftmesh.cracks.grazing_fronts import ending_on_faces
from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.prepare import prepare_crack
from craftmesh.cracks.series import prescribed_crack
from craftmesh.cracks.sheets import sheets
from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.surface.kernels.distances import nearest_on_edges
from craftmesh.surface.measure import area_vectors
from craftmesh.surface.rounding import ON_PLANE
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
    return prescribed_crack(BOX, CrackOptions(centre=tuple(centre), normal=tuple(normal), radius=RADIUS))


def off_the_front(sheet, places: np.ndarray) -> np.ndarray:
    edges = np.concatenate([np.column_stack([front[:-1], front[1:]]) for front in sheet.fronts])
    return np.linalg.norm(nearest_on_edges(places, sheet.points, edges.astype(np.int64)) - places, axis=1)


@settings(max_examples=12)
@given(
    gap=st.floats(0.0005, 0.95 * PREPARATION.front),
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
    # PREPARATION.front, and the chord of an edge that was parted: 1e-4 of the radius
    assert off_the_front(sheet, line).max() <= PREPARATION.front * L_MIN * 1.001
    # the crack stays in its plane, where no triangle turns over, and its front runs on without turning back
    normal = np.roll([np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0.0], axis)
    height = (ended.points - ended.points.mean(axis=0)) @ normal
    assert np.ptp(height) <= 1e-9
    assert_not_folded(ended, sheet)


def assert_not_folded(ended, sheet):
    """The triangles of an ended sheet look as those of the given one, and its fronts never turn back."""
    normal = area_vectors(sheet.points, sheet.triangles).sum(axis=0)
    # the corner of a front may go on along its other side, which leaves a triangle without area
    assert (area_vectors(ended.points, ended.triangles) @ normal > -1e-9).all()
    for front in ended.fronts:
        steps = np.diff(ended.points[front], axis=0)
        assert (np.einsum("ij,ij->i", steps[1:], steps[:-1]) > 0).all()


@pytest.mark.parametrize("edge", [0.5, 2.0, 7.0])
def test_a_straight_front_that_grazes_a_face_ends_on_it_however_long_its_edges_are(edge):
    """A front that rises from 0.005 of l_min over the face to one l_min: a stretch is within reach."""
    x = np.linspace(0.0, 10.0, round(10.0 / edge) + 1)
    z = np.stack([0 * x + 25.0, 0.005 * L_MIN + 0.05 * x])
    points, triangles = over_grid(np.stack([x, x]) + 8.0, 0 * z + 10.0, z)
    sheet = crack_from_triangles(points, triangles, None, BOX)
    ended = ending_on_faces(sheet, BOX, L_MIN)
    assert_not_folded(ended, sheet)
    lines = np.concatenate([ended.points[front] for front in ended.fronts])
    assert off_the_front(sheet, lines).max() <= PREPARATION.front * L_MIN * 1.001
    assert len(ended.points) > len(sheet.points)


def test_a_closed_front_ends_on_a_face_alike_wherever_its_seam_is():
    sheet = penny(0.006)
    (front,) = sheet.fronts
    ring, known = front[:-1], None
    # the seam beside and within the stretch that grazes the face
    for k in np.flatnonzero(sheet.points[ring, 2] < 0.1 * L_MIN):
        turned = np.roll(ring, -k)
        ended = ending_on_faces(
            Crack(sheet.points, sheet.triangles, (np.append(turned, turned[0]),)), BOX, L_MIN
        )
        line = np.concatenate([ended.points[one] for one in ended.fronts])
        known = line if known is None else known
        assert line.shape == known.shape and np.abs(line - known).max() < 1e-9


@pytest.mark.parametrize("gap", [0.04, 0.5, -0.5, -3.0])
def test_a_front_that_stays_away_or_crosses_the_face_is_as_it_was(gap):
    sheet = penny(gap)
    assert ending_on_faces(sheet, BOX, L_MIN) is sheet


def test_a_front_that_the_crack_itself_parts_from_the_face_stays():
    """The crack comes through the face and ends just inside: its front stays where it was given."""
    sheet = penny(-2 * RADIUS / L_MIN + 0.01)
    assert ending_on_faces(sheet, BOX, L_MIN) is sheet


def test_a_crack_of_facets_of_a_surface_stays_beside_one_that_ends_on_a_face():
    """Its front may run against its triangles, which are turned as those of the boundaries are."""
    near, far = penny(0.01), penny(0.01, axis=0)
    facets = Crack(far.points, far.triangles[:, ::-1], far.fronts)
    first, second = sheets(prepare_crack([near, facets], BOX, L_MIN, of_facets=[1]))
    assert len(first.points) > len(near.points)
    assert np.array_equal(second.points, facets.points)
    assert np.array_equal(second.triangles, facets.triangles)
