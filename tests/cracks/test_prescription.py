"""What numbers prescribe of a crack: its sizes increment by increment, its plane, its pairs of grains."""

import numpy as np
import pytest

from craftmesh.cracks.height_parts import best_fit_frame
from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.prescription import boundary_pairs, changing, frame_along, frame_of, semi_axes
from craftmesh.errors import CraftmeshError

CENTRE = (5.0, 5.0, 5.0)


@pytest.mark.parametrize("increment", [0, 1, 4])
def test_each_increment_adds_the_growth_to_both_semi_axes(increment):
    ellipse = CrackOptions(shape="ellipse", centre=CENTRE, semi_axes=(2.0, 1.0), growth=0.25)
    assert semi_axes(ellipse, increment) == (2.0 + increment / 4, 1.0 + increment / 4)
    penny = CrackOptions(centre=CENTRE, radius=3.0, growth=0.25)
    assert semi_axes(penny, increment) == (3.0 + increment / 4,) * 2 == changing(penny, increment)


def test_listed_sizes_do_not_grow_besides():
    listed = CrackOptions(centre=CENTRE, growth=0.25, increments=(2.0, (3.0, 1.0), 4.0))
    assert [semi_axes(listed, k) for k in range(3)] == [(2.0, 2.0), (3.0, 1.0), (4.0, 4.0)]
    with pytest.raises(CraftmeshError, match=r"crack.increments\[1\] is 'a.csv'; expected a radius"):
        semi_axes(CrackOptions(centre=CENTRE, increments=(2.0, "a.csv")), 1)
    with pytest.raises(CraftmeshError, match="crack.semi_axes is not given; expected semi_axes a, b > 0"):
        semi_axes(CrackOptions(shape="ellipse", centre=CENTRE), 0)


@pytest.mark.parametrize("lengths", [(1.0, 1.0), (1e-5, 1e5), (1e6, 1e-4)])
@pytest.mark.parametrize("shape, sizes", [("penny", (2.0, 2.0)), ("ellipse", (2.0, 1.0))])
def test_a_plane_is_right_handed_and_its_axis_goes_the_way_of_the_given_one(lengths, shape, sizes):
    normal, axis = np.array([1.0, 2.0, -1.0]), np.array([3.0, 0.5, 0.2])
    options = CrackOptions(
        shape=shape, centre=CENTRE, normal=tuple(lengths[0] * normal), axis=tuple(lengths[1] * axis)
    )
    frame = frame_of(options, sizes)
    assert frame @ frame.T == pytest.approx(np.eye(3), abs=1e-12) and np.linalg.det(frame) > 0
    assert frame[2] @ normal == pytest.approx(np.linalg.norm(normal))
    assert frame[0] @ axis > 0 and frame[1] @ axis == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("off, refused", [(0.0, True), (5e-7, True), (2e-6, False)])
def test_an_axis_along_the_normal_is_refused_by_the_angle_whatever_their_lengths(off, refused):
    for size in (1e-4, 1.0, 1e5):
        options = CrackOptions(
            shape="ellipse", centre=CENTRE, axis=(size * off, 0.0, -size), normal=(0, 0, 2)
        )
        if refused:
            with pytest.raises(CraftmeshError, match="not parallel to the normal"):
                frame_of(options, (2.0, 1.0))
        else:
            assert frame_of(options, (2.0, 1.0))[0] == pytest.approx([1, 0, 0], abs=1e-9)
        assert np.linalg.det(frame_of(options, (2.0, 2.0))) == pytest.approx(1.0)  # a circle has any


def test_pairs_of_grains_are_told_lower_first_and_others_are_refused():
    pairs = CrackOptions(shape="boundaries", boundaries=("7-3", "2 - 10"))
    assert boundary_pairs(pairs).tolist() == [[3, 7], [2, 10]]
    for text in ("3", "3-", "1-2-3", "a-b", "3-4.5"):
        with pytest.raises(CraftmeshError, match=f"boundaries has '{text}'; expected two grains"):
            boundary_pairs(CrackOptions(shape="boundaries", boundaries=("1-2", text)))
    with pytest.raises(CraftmeshError, match="boundaries is not given"):
        boundary_pairs(CrackOptions(shape="boundaries"))


def test_the_plane_of_best_fit_is_that_of_a_flat_sheet_and_its_first_row_is_the_long_way():
    rng = np.random.default_rng(7)
    for _ in range(5):
        turn = frame_along(*rng.normal(size=(2, 3)))
        corners = np.array([[-4.0, -1, 0], [4, -1, 0], [4, 1, 0], [-4, 1, 0]]) @ turn + rng.uniform(
            -9, 9, 3
        )
        frame = best_fit_frame(corners, np.array([[0, 1, 2], [0, 2, 3]]))
        assert frame[2] == pytest.approx(turn[2], abs=1e-9) and np.linalg.det(frame) == pytest.approx(1)
        # two corners count twice, by which the long way goes a little along the diagonal
        assert abs(frame[0] @ turn[0]) > 0.99


def test_a_gentle_sheet_has_the_mean_normal_by_area_and_a_steep_one_the_way_between_its_sides():
    """Two sides along a line, one three times as wide."""
    for degrees in (30.0, 80.0, 100.0):
        turn = np.radians(degrees)
        side = np.array([np.cos(turn), 0.0, np.sin(turn)])
        across = np.array([[0, 0, 0], [0, 1, 0]])
        points = np.concatenate([across - [3, 0, 0], across, across + side])
        triangles = np.array([[0, 2, 3], [0, 3, 1], [2, 4, 5], [2, 5, 3]])
        sides = np.array([[0, 0, 1.0], [-side[2], 0, side[0]]])
        share = np.array([3.0, 1.0]) if degrees < 45 else np.ones(2)
        known = share @ sides / np.linalg.norm(share @ sides)
        assert best_fit_frame(points, triangles)[2] == pytest.approx(known, abs=1e-9)


def test_the_long_way_is_taken_in_the_plane_and_not_over_the_height():
    """A roof whose sides stand at 50 degrees, one shorter than the other, and whose ridge is 1 long.

    It is 1.2 across, where half of its corners lie at the ends; along the ridge all do.
    """
    x, z = np.cos(np.radians(50.0)), np.sin(np.radians(50.0))
    profile = ((-x, 0.0), (0.0, z), (0.8 * x, 0.2 * z))
    points = np.array([[across, y, height] for across, height in profile for y in (0.0, 1.0)])
    triangles, rng = np.array([[0, 2, 3], [0, 3, 1], [2, 4, 3], [3, 4, 5]]), np.random.default_rng(8)
    for _ in range(5):
        turn = frame_along(*rng.normal(size=(2, 3)))
        frame = best_fit_frame(points @ turn, triangles)
        assert frame[2] == pytest.approx(turn[2], abs=1e-9) and abs(frame[0] @ turn[1]) > 0.99
