"""Sheets whose fronts all but touch become one, with the strip between them; others stay apart."""

import numpy as np
import pytest
import shapely

from craftmesh.cracks.merged_sheets import OVERLAP, WIDTH, sheet_pair, with_neck
from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.prepare import prepare_crack
from craftmesh.cracks.series import prescribed_crack
from craftmesh.cracks.sheets import sheets
from craftmesh.surface.measure import total_area

BOX = np.array([[0.0, 0, 0], [36, 30, 28]])
L_MIN, RADIUS = 0.8, 5.7


def two_discs(gap: float, height: float = 0.0):
    """Two round cracks in one plane, `gap` (in l_min) apart, the second `height` (in l_min) over it."""
    reach = RADIUS + gap * L_MIN / 2
    centres = [(18 - reach, 15.2, 14.1), (18 + reach, 15.2, 14.1 + height * L_MIN)]
    return [
        prescribed_crack(BOX, CrackOptions(shape="penny", centre=c, radius=RADIUS, normal=(0, 0, 1)))
        for c in centres
    ]


@pytest.mark.parametrize(("gap", "height"), [(0.0, 0.0), (0.01, 0.015), (-0.01, 0.0), (-0.03, 0.015)])
def test_discs_that_all_but_touch_are_one_sheet_whose_front_is_hardly_moved(gap, height):
    given = two_discs(gap, height)
    merged = prepare_crack(given, BOX, L_MIN)
    assert len(sheets(merged)) == 1
    (front,) = merged.fronts
    fronts = [one.points[one.fronts[0]] for one in given]
    away = np.min(
        [shapely.distance(shapely.LineString(f), shapely.points(merged.points[front])) for f in fronts], 0
    )
    assert away.max() < 0.02 * L_MIN
    area = total_area(merged.points, merged.triangles)
    both = sum(total_area(one.points, one.triangles) for one in given)
    # a strip of WIDTH at most along some three l_min, or a lens as wide as OVERLAP, of 204 in all
    assert abs(area - both) < 3 * max(WIDTH, OVERLAP) * L_MIN**2
    turned = np.degrees(turns(merged.points[front]))
    assert (turned > 60).sum() == 2  # the two ends of the strip


def turns(line: np.ndarray) -> np.ndarray:
    """Return the turn at each point of a closed line (k, 3), in radians."""
    step = np.diff(line, axis=0)
    step /= np.linalg.norm(step, axis=1)[:, None]
    return np.arccos(np.clip((step * np.roll(step, 1, axis=0)).sum(axis=1), -1, 1))


@pytest.mark.parametrize("gap", [0.05, 0.3, -0.06, -1.0])
def test_discs_that_are_apart_or_overlap_stay_two(gap):
    merged = prepare_crack(two_discs(gap), BOX, L_MIN)
    assert len(sheets(merged)) == 2


def test_discs_side_by_side_at_another_height_stay_two():
    assert len(sheets(prepare_crack(two_discs(0.0, height=1.0), BOX, L_MIN))) == 2


def test_the_hole_of_a_ring_is_kept_where_its_outside_touches_another():
    first, second = two_discs(0.0)
    pair = sheet_pair(first, second, 0.02 * L_MIN)
    hole = shapely.Point(pair.outlines[0].centroid).buffer(1.0)
    holed = pair._replace(outlines=(pair.outlines[0].difference(hole), pair.outlines[1]))
    whole = with_neck(holed, L_MIN)
    assert len(whole.interiors) == 1
    assert shapely.Polygon(whole.interiors[0]).area == pytest.approx(hole.area, rel=1e-6)
