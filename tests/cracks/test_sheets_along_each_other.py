"""Sheets that run along each other: made one where that moves nothing visibly, refused where it would."""

import numpy as np
import pytest

from craftmesh.cracks.merged_sheets import merged_sheets
from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.prepare import refuse_along_sheets
from craftmesh.cracks.series import crack_area, prescribed_crack
from craftmesh.cracks.sheets import one_crack, sheets
from craftmesh.errors import CraftmeshError
from craftmesh.surface.measure import nearest_facet

BOX = np.array([[0.0, 0.0, 0.0], [22.0, 20.0, 18.0]])
L_MIN = 0.7
MIDDLE = np.array([10.7, 10.0, 9.0])  # of the two discs' overlap, 3.4 wide


def discs(tilt=0.0, apart=0.0, back=2.5):
    """Two discs of radius 4.2 that overlap; the second turned round MIDDLE, and moved off it by `apart`."""
    angle = np.radians(tilt)
    along, normal = (
        np.array([np.cos(angle), 0, np.sin(angle)]),
        np.array([-np.sin(angle), 0, np.cos(angle)]),
    )
    first = CrackOptions(shape="penny", centre=(8.2, 10.0, 9.0), radius=4.2)
    centre = MIDDLE + back * along + apart * normal
    second = CrackOptions(
        shape="penny", centre=tuple(centre), normal=tuple(normal), axis=tuple(along), radius=4.2
    )
    return one_crack([prescribed_crack(BOX, options) for options in (first, second)])


@pytest.mark.parametrize(("tilt", "apart"), [(0.0, 0.01), (0.2, 0.0), (1.0, 0.1)])
def test_sheets_almost_in_one_surface_become_one(tilt, apart):
    crack = discs(tilt, apart)
    reach = apart + 2.2 * np.sin(np.radians(tilt)) + 1e-3
    merged = merged_sheets(crack, BOX, L_MIN, reach)
    assert len(sheets(merged)) == 1 and len(merged.fronts) == 1
    _, off, _ = nearest_facet(merged.points, crack.points, crack.triangles)
    assert 0 < off.max() <= reach
    half = np.arccos(2.5 / 4.2)
    lens = 2 * 4.2**2 * (half - np.sin(half) * np.cos(half))
    assert crack_area(merged) == pytest.approx(2 * np.pi * 4.2**2 - lens, rel=5e-3)
    refuse_along_sheets(merged, BOX, L_MIN)


@pytest.mark.parametrize(("tilt", "apart"), [(0.0, 0.0), (0.0, 0.3), (30.0, 0.0)])
def test_sheets_in_one_plane_or_apart_stay_as_they_are(tilt, apart):
    crack = discs(tilt, apart)
    assert merged_sheets(crack, BOX, L_MIN, 0.02 * L_MIN) is crack
    refuse_along_sheets(crack, BOX, L_MIN)


@pytest.mark.parametrize(
    ("tilt", "apart", "said"),
    [
        (0.0, 0.1, r"cracks 1 and 2 run 0.1 to 0.1 from each other near .*, at 0 degrees"),
        (
            1.7,
            0.03,
            r"at 1.7 degrees, over an area of .*; move .* cross at 6 degrees or more",
        ),
        (5.0, 0.0, r"at 5 degrees"),
    ],
)
def test_sheets_that_run_along_each_other_are_refused_with_angle_and_place(tilt, apart, said):
    crack = merged_sheets(discs(tilt, apart), BOX, L_MIN, 0.02 * L_MIN)
    with pytest.raises(CraftmeshError, match=said):
        refuse_along_sheets(crack, BOX, L_MIN)


def test_a_crossing_at_eight_degrees_is_taken():
    refuse_along_sheets(discs(8.0), BOX, L_MIN)


def test_a_third_crack_joins_two_that_have_become_one():
    third = CrackOptions(shape="penny", centre=(10.7, 15.5, 9.005), radius=4.0)
    crack = one_crack([discs(0.0, 0.01), prescribed_crack(BOX, third)])
    assert len(sheets(merged_sheets(crack, BOX, L_MIN, 0.02 * L_MIN))) == 1
