"""Points moved onto the crack: on it within their own constraints, or not at all."""

import numpy as np
import pytest
from given_cracks import wavy_disc
from structured_box import structured_box

from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.series import prescribed_crack
from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.insertion.insert import insert_crack
from craftmesh.insertion.sheet import Sheet, sheet_of
from craftmesh.insertion.snap import onto_crack
from craftmesh.sizing.sizing import SizingOptions
from craftmesh.sizing.sources import Defects, sizing_around
from craftmesh.surface.rounding import SAME_PLACE
from craftmesh.types import CRACK

BOX = np.array([[0.0, 0.0, 0.0], [20.0, 20.0, 20.0]])


def tilted_sheet(amplitude: float, degrees: float) -> Sheet:
    """A wavy disc about the middle of the box's lowest plane, tilted to that plane by `degrees`."""
    points, triangles = wavy_disc(7.0, amplitude, rings=20)
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turned = points @ np.array([[1, 0, 0], [0, c, s], [0, -s, c]])
    return sheet_of(crack_from_triangles(turned + [10, 10, 0], triangles, None, BOX), BOX)


@pytest.mark.parametrize("amplitude", [0.0, 1.0, 3.0])
@pytest.mark.parametrize("degrees", [10, 20, 30, 75])
def test_points_of_a_box_plane_end_on_the_crack_in_their_plane_or_stay(amplitude, degrees):
    sheet = tilted_sheet(amplitude, degrees)
    rng = np.random.default_rng(0)
    points = np.column_stack([rng.uniform(4, 16, (2000, 2)), np.zeros(2000)])
    near = np.abs(sheet.offset(points)) < 0.4 * np.linalg.norm(sheet.gradient(points), axis=1)
    planes = np.tile([False, False, True], (near.sum(), 1))
    reach = np.full(near.sum(), 0.5)
    moved = onto_crack(points[near], planes, sheet, reach)
    found = np.isfinite(moved).all(axis=1)
    # where the sheet is nearly along the plane the way is longer than the reach, and points stay
    assert found.mean() > {10: 0.1, 20: 0.15}.get(degrees, 0.5)
    assert (moved[found, 2] == 0).all()
    assert np.abs(sheet.offset(moved[found])).max() <= SAME_PLACE * reach[0]
    if not sheet.planar:
        assert np.linalg.norm(moved[found] - points[near][found], axis=1).max() <= reach[0]


def test_the_gradient_is_that_of_the_offset():
    sheet = tilted_sheet(2.0, 30)
    points = np.random.default_rng(1).uniform(5, 15, (500, 3)) * [1, 1, 0.2]
    steps = 1e-6 * np.eye(3)
    numeric = [(sheet.offset(points + step) - sheet.offset(points - step)) / 2e-6 for step in steps]
    off = np.linalg.norm(np.stack(numeric, axis=1) - sheet.gradient(points), axis=1)
    # a few points are within the step of an edge of the crack's triangles, where the gradient jumps
    assert (off < 1e-6).mean() > 0.98


def test_neighbours_on_a_line_that_the_crack_crosses_at_a_small_angle_both_go_onto_it():
    """Only one can go to the crossing between them; the other was left 0.02 edges off."""
    surface, _ = structured_box((8, 8, 8), lambda places: 1 + (places[:, 0] > 4))
    normal = np.array([1.0, 0.04, 1.0]) / np.linalg.norm([1.0, 0.04, 1.0])
    options = CrackOptions(centre=(4.0, 3.5, 0.0), normal=tuple(normal), radius=2.6)
    result, _ = insert_crack(surface, prescribed_crack(surface.box, options))
    off = np.abs((result.points - options.centre) @ normal)
    near = np.linalg.norm(result.points - options.centre, axis=1) < 2.0
    assert near.sum() > 10 and not ((off[near] > 1e-9) & (off[near] < 0.1)).any()


def test_a_crack_that_parts_the_body_is_on_its_plane_however_long_the_lengths_are_away_from_it():
    """Without a front in the box all lengths are l_max, of which a share was taken for on the crack."""
    surface, _ = structured_box((8, 8, 8), lambda places: 1 + (places[:, 0] > 4))
    normal = np.array([1.0, 1.0, 1.0]) / np.sqrt(3)
    crack = prescribed_crack(
        surface.box, CrackOptions(centre=(1.5, 2.0, 1.9), normal=tuple(normal), radius=90.0)
    )
    options = SizingOptions(l_min=0.7, l0=1.0, l_max=60.0, r0=4.0, r1=8.0)
    sizing = sizing_around(surface, Defects(crack), options)
    result, _ = insert_crack(surface, crack, sizing)
    nodes = result.points[np.unique(result.facets[result.kind == CRACK])]
    assert len(nodes) > 10
    assert np.abs((nodes - [1.5, 2.0, 1.9]) @ normal).max() < 0.05 * 0.7
