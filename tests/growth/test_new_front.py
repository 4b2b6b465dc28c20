"""Fronts after an extension: parallel curves, loops cut off, ends beyond their planes."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from craftmesh.cracks.polyline import feet, polyline
from craftmesh.growth.correct import SHARE
from craftmesh.growth.front_step import FrontStep
from craftmesh.growth.moves import beside_rest, moves_along, points_at_rest, smoothed
from craftmesh.growth.new_front import (
    BEYOND,
    broken_through,
    new_front,
    stopped_outside,
    strip_triangles,
)
from craftmesh.growth.options import SmoothingOptions
from craftmesh.surface.measure import area_vectors

BOX = np.array([[0.0, 0.0, 0.0], [20.0, 20.0, 20.0]])
FRAME = np.eye(3)
CENTRE = np.array([10.0, 10.0, 10.0])


def circle(radius, count=400, start=0.0, end=2 * np.pi):
    turn = np.linspace(start, end, count + 1)
    points = CENTRE + radius * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    if end - start == 2 * np.pi:
        points[-1] = points[0]
    return polyline(points)


def outward(line, size):
    away = line.points - CENTRE
    return size * away / np.linalg.norm(away, axis=1)[:, None]


@pytest.mark.parametrize("size", [0.5, 2.0, 4.0])
def test_a_circle_grows_to_a_circle(size):
    old = circle(4.0)
    moved = new_front(old, outward(old, size), BOX, FRAME, 0.25)[0]
    radius = np.linalg.norm(moved.points - CENTRE, axis=1)
    # 1e-4: the sagitta of the old polyline's chords
    assert np.abs(radius - 4 - size).max() < 1e-4
    assert (moved.points[0] == moved.points[-1]).all()
    assert (np.diff(moved.origin) > 0).all()
    steps = np.linalg.norm(np.diff(moved.points, axis=0), axis=1)
    assert steps.max() < 0.26 and steps.min() > 0.24


def concave() -> tuple:
    """A quarter of a hole of radius 2 between two straight pieces, and its moves inwards by 3."""
    turn = np.linspace(np.pi, 1.5 * np.pi, 80)
    bend = np.array([10.0, 10.0, 10.0]) + 2 * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    down = np.stack([np.full(40, 8.0), np.linspace(18, 10.1, 40), np.full(40, 10.0)], axis=1)
    right = np.stack([np.linspace(10.1, 18, 40), np.full(40, 8.0), np.full(40, 10.0)], axis=1)
    moves = np.concatenate(
        [np.tile([3.0, 0, 0], (40, 1)), 1.5 * (CENTRE - bend), np.tile([0, 3.0, 0], (40, 1))]
    )
    return polyline(np.concatenate([down, bend, right])), moves


def test_a_concave_front_forms_no_loop():
    old, moves = concave()
    moved = new_front(old, moves, BOX, FRAME, 0.25)[0]
    corner = np.array([11.0, 11.0, 10.0])
    assert np.linalg.norm(moved.points - corner, axis=1).min() < 0.25
    # no point has come past the corner: all are 3 away from the old front, those on the sides exactly
    _, distance = feet(old, moved.points)
    assert distance.max() < 3.05 and distance.min() > 2.9
    assert (np.diff(moved.origin) >= 0).all()


def test_sides_that_meet_at_two_heights_are_joined_without_a_jump():
    old, moves = concave()
    rise = np.repeat([0.2, -0.2], [80, 80])
    moved = new_front(old, moves + rise[:, None] * [0, 0, 1], BOX, FRAME, 0.25)[0]
    height = moved.points[:, 2] - 10
    # 0.2 on either side fade over more than 3 of the old front; a jump would be 0.4 over a spacing of 0.25
    assert np.abs(np.gradient(height, 0.25)).max() < 0.2
    assert height[[0, -1]] == pytest.approx([0.2, -0.2], abs=1e-6)


def test_a_front_whose_ends_leave_the_box_keeps_its_course_there():
    """Half a circle on the plane y = 0, whose moves near the ends point out of the box."""
    turn = np.linspace(0, np.pi, 200)
    points = np.stack([10 + 4 * np.cos(turn), 4 * np.sin(turn), np.full(200, 10.0)], axis=1)
    points[[0, -1], 1] = 0.0
    moves = points - [10, 0, 10]
    moves[:, 1] -= 3.0
    moves *= 1.5 / np.linalg.norm(moves, axis=1)[:, None]
    moved = new_front(polyline(points), moves, BOX, FRAME, 0.25)[0]
    assert (moved.points[[0, -1], 1] < 0).all()
    gone = (points + moves)[:100]
    crossing = np.interp(0, gone[:, 1], gone[:, 0])
    half = moved.points[: len(moved.points) // 2]
    # 0.01: chords of a quarter on a front of radius five
    assert np.interp(0, half[:, 1], half[:, 0]) == pytest.approx(crossing, abs=0.01)


def test_an_oblique_front_goes_on_parallel_to_itself():
    """A straight front at 50 degrees to the planes y = 0 and y = 20 goes by 1.5 square to itself."""
    slope = np.tan(np.radians(40))
    y = np.linspace(0, 20, 100)
    points = np.stack([2 + slope * y, y, np.full(100, 10.0)], axis=1)
    square = np.array([1.0, -slope, 0.0]) / np.hypot(1, slope)
    moved = new_front(polyline(points), np.tile(1.5 * square, (100, 1)), BOX, FRAME, 0.25)[0]
    assert moved.points[0, 1] == pytest.approx(points[0, 1] + 1.5 * square[1])  # this end leaves the box
    assert moved.points[-1, 1] > 20
    assert (moved.points - points[0]) @ square == pytest.approx(1.5, abs=1e-6)


def test_a_front_that_meets_a_plane_at_a_low_angle_leaves_it():
    """All of a circle of radius 8 but a cap 1 high below the plane y = 0 grows by 1.5, in its plane."""
    middle, cut = np.array([10.0, 7.0, 10.0]), np.arccos(7 / 8)
    turn = np.linspace(cut - np.pi / 2, 1.5 * np.pi - cut, 400)
    out = np.stack([np.cos(turn), np.sin(turn), np.zeros(400)], axis=1)
    points = middle + 8 * out
    points[[0, -1], 1] = 0.0
    moved = new_front(polyline(points), 1.5 * out, BOX, FRAME, 0.25)[0]
    assert np.linalg.norm(moved.points - middle, axis=1) == pytest.approx(9.5, abs=0.01)


def test_a_front_that_comes_back_into_the_body_at_its_end_leaves_it_once():
    """A straight front from x = 0 goes by 1.5 along y; noise takes points near its end out of the box."""
    x = np.linspace(0, 20, 200)
    moves = np.tile([0.0, 1.5, 0.0], (200, 1))
    moves[5:8, 0] = -x[5:8] - 0.2
    points = np.stack([x, np.full(200, 10.0), np.full(200, 10.0)], axis=1)
    moved, repairs = new_front(polyline(points), moves, BOX, FRAME, 0.25)
    assert repairs == Counter(ends=1)
    outside = moved.points[: len(moved.points) // 2, 0] < 0
    assert np.abs(np.diff(outside.astype(int))).sum() == 1
    assert moved.points[~(moved.points[:, 0] < 1), 1] == pytest.approx(11.5)


@pytest.mark.parametrize("step", [0.8, 1.5, 2.5])
@pytest.mark.parametrize("reverse", [False, True])
def test_a_front_that_turns_back_outside_the_body_is_cut_off_there(step, reverse):
    """A front slopes down to 0.45 above the face y = 0, and goes down to it at a corner of 65 degrees."""
    x = np.linspace(0, 9.85, 60)
    slope = np.stack([x, 0.45 + 0.35 * (9.85 - x), np.full(60, 10.0)], axis=1)
    down = np.array([9.85, 0.45, 10.0]) + np.linspace(0, 1, 5)[1:, None] * [0.15, -0.45, 0.0]
    points = np.concatenate([slope, down])
    way = np.where(np.arange(64)[:, None] < 60, [-0.33, -0.944, 0.0], [-0.949, -0.316, 0.0])
    moves = step * way
    if reverse:
        points, moves = points[::-1], moves[::-1]
    old = polyline(points)
    moved, repairs = new_front(old, moves, BOX, FRAME, 0.25)
    assert repairs["ends"] == 1
    places = np.concatenate([points, moved.points])
    ids = np.arange(len(points), len(places))
    strip = strip_triangles(np.arange(len(points)), old.arc, ids, moved.origin)
    turn = area_vectors(places, strip)[:, 2]
    assert (turn > 0).all() or (turn < 0).all()  # no triangle is folded over


def test_a_short_front_that_turns_back_and_leaves_the_body_whole_is_not_cut():
    points = np.linspace([0.0, 1.7, 10.0], [1.7, 0.0, 10.0], 9)
    moves = 2 * ([-0.5, -0.5, 10.0] - points)
    moved, repairs = new_front(polyline(points), moves, BOX, FRAME, 0.25)
    assert repairs["ends"] == 0 and len(moved.points) >= len(points)


@pytest.mark.parametrize("drift", [0.5, -0.5])
def test_a_front_that_leaves_by_another_face_is_beyond_the_face_of_its_end_too(drift):
    """A front from y = 20, 1.5 away from the edge x = y = 20 of the box, leaves by x = 20."""
    y = np.linspace(20, 2, 100)
    points = np.stack([18.5 - (20 - y) / 2, y, np.full(100, 10.0)], axis=1)
    moves = np.tile([2.4, drift, 0.0], (100, 1))
    moved = new_front(polyline(points), moves, BOX, FRAME, 0.25)[0]
    between = points[0] + np.linspace(0, 1, 20)[1:, None] * (moved.points[0] - points[0])
    assert (between[:, :2] > 20).any(axis=1).all()


def test_only_ligaments_thinner_than_the_width_are_broken_through():
    turn = np.linspace(0, np.pi, 41)
    points = np.stack([turn, 0.6 * np.sin(turn) - 0.2, np.full(41, 10.0)], axis=1) + [5.0, 0.0, 0.0]
    broken, ligaments = broken_through(points, BOX, FRAME[2], 0.39)
    assert (broken == points).all() and not ligaments
    broken, ligaments = broken_through(points, BOX, FRAME[2], 0.41)
    assert ligaments == 1 and (broken[:, 1] < 0).all()
    assert (broken[[0, -1]] == points[[0, -1]]).all()


@pytest.mark.parametrize("slope, breaks", [(5, True), (30, False), (90, False)])
def test_a_front_along_a_face_leaves_the_body_where_it_gets_deeper(slope, breaks):
    way = np.array([np.cos(np.radians(slope)), np.sin(np.radians(slope)), 0.0])
    points = np.array([2.0, 0.0, 10.0]) + np.arange(-1, 60)[:, None] * 0.25 * way
    for line in (points, points[::-1]):
        broken, ligaments = broken_through(line, BOX, FRAME[2], 1.0)
        assert ligaments == breaks
        deep = (line[:, 1] >= 0.5) | (line[:, 1] < 0) | (not breaks)
        assert (broken[deep] == line[deep]).all() and (broken[~deep, 1] < 0).all()
        assert np.abs(broken - line).max() < 0.5 + BEYOND


def test_stopped_points_lie_just_outside_and_others_go_all_the_way():
    rng = np.random.default_rng(0)
    points, moves = rng.uniform(0, 20, (500, 3)), rng.normal(0, 8, (500, 3))
    stopped = stopped_outside(points, moves, BOX)
    size = np.linalg.norm(moves, axis=1)
    far = np.maximum(BOX[0] - points - stopped, points + stopped - BOX[1]).max(axis=1)
    whole = np.maximum(BOX[0] - points - moves, points + moves - BOX[1]).max(axis=1)
    goes = whole <= BEYOND * size
    assert 100 < goes.sum() < 400
    assert stopped[goes] == pytest.approx(moves[goes])
    assert far[~goes] == pytest.approx(BEYOND * size[~goes])


@pytest.mark.parametrize("smoothing", ["fit", "savitzky_golay", "none"])
@pytest.mark.parametrize("closed", [True, False])
def test_smoothing_keeps_what_is_smooth(smoothing, closed):
    length, count = 40.0, 40
    s = np.arange(count) * length / count if closed else np.linspace(0, length, count)
    at = np.linspace(0, length, 333)

    def moves(place):
        turn = 2 * np.pi * place / length
        return np.stack([np.cos(turn), np.sin(turn), np.ones_like(turn)], axis=1)

    smooth = smoothed(s, moves(s), length, closed, at, SmoothingOptions(smoothing=smoothing))
    # 0.01: a window of seven of forty rows round a circle, and chords of the interpolation (0.003)
    within = slice(None) if closed else slice(40, -40)
    assert np.abs(smooth - moves(at))[within].max() < 0.01
    # at open ends the fit goes on straight, and a whole wave on forty rows turns away from it by 0.08
    assert np.abs(smooth - moves(at)).max() < 0.1


def test_the_fit_takes_most_of_the_noise_away():
    noise = np.random.default_rng(1).normal(0, 0.1, (80, 3))
    s = np.arange(80.0)
    smooth = smoothed(s, 1 + noise, 80.0, True, s, SmoothingOptions())
    # rows over coefficients is 4: half of the noise stays
    assert np.std(smooth - 1) < 0.65 * np.std(noise)


@pytest.mark.parametrize("rows", [6, 11, 41])
def test_noise_is_not_blown_up_at_the_ends(rows):
    s = np.arange(float(rows))
    gain = smoothed(s, np.eye(rows), rows - 1.0, False, s, SmoothingOptions())
    # a line through the four rows next to the two that are left out goes on with 1.8
    assert np.linalg.norm(gain, axis=1).max() < 2.2
    assert gain.sum(axis=1) == pytest.approx(1)


def one_step(rows, step):
    """Return the matrix that takes a nearly straight front's places and moves, out of plane, a step on.

    Where its front moved by m in the last step and is h off its plane, it goes on by -|k| h per length,
    for waves of number k (Movchan, Gao & Willis 1998; Poisson's ratio 0). Free faces mirror the waves.
    """
    s = np.linspace(0, rows - 1.0, rows)
    fit = smoothed(s, np.eye(rows), rows - 1.0, False, s, SmoothingOptions(), step=step)
    waves = np.cos(np.pi * np.outer(s / s[-1], np.arange(rows)))
    back = waves @ np.diag(np.pi * step / s[-1] * np.arange(rows)) @ np.linalg.inv(waves)
    one = np.eye(rows)
    kink = np.hstack([-back, -one - back])
    place, move = np.hstack([one, 0 * one]), np.hstack([0 * one, one])
    return np.vstack([place + fit @ (move + SHARE * kink), fit @ (move + kink)])


@pytest.mark.parametrize("rows", [4, 6, 11, 31])
@pytest.mark.parametrize("step", [1.0, 2.0, 4.0, 10.0])
def test_no_wave_of_a_straight_front_grows_from_step_to_step(rows, step):
    """Waves shorter than a step turn back farther than due, unless the fit takes them away."""
    sizes = np.abs(np.linalg.eigvals(one_step(rows, step)))
    # 1: the front as a whole, and waves that the fit takes away, stay where they are
    assert sizes.max() == pytest.approx(1, abs=1e-6)


@pytest.mark.parametrize("wrong", [[0], [1], [-1], [29, 30]], ids=["first", "second", "last", "at a gap"])
def test_rows_beside_an_end_do_not_turn_the_front(wrong):
    """The intensities there have no bound; the fit goes on straight from the rows farther in."""
    s = np.concatenate([np.arange(30.0), np.arange(40.0, 70.0)])
    moves = np.ones((60, 3))
    moves[wrong, 1] = -5.0
    smooth = smoothed(s, moves, 69.0, False, np.linspace(0, 69, 70), SmoothingOptions())
    assert np.abs(smooth - 1).max() < 1e-6


@pytest.mark.parametrize("rows", range(2, 11))
def test_rows_two_spacings_from_the_ends_count_and_of_few_those_in_the_middle(rows):
    s = 0.25 * np.arange(rows)
    off = np.minimum(s, s[::-1])
    known = smoothed(s, np.ones((rows, 3)), s[-1], False, s, SmoothingOptions())
    for row in range(rows):
        changed = np.ones((rows, 3)) + 3.0 * (s == s[row])[:, None]
        counts = np.abs(smoothed(s, changed, s[-1], False, s, SmoothingOptions()) - known).max() > 1e-6
        assert counts == (off[row] >= min(0.5, off.max()))


@pytest.mark.parametrize("missing", [2, 3, 10])
@pytest.mark.parametrize("seam", ["in the gap", "in the rows", "past the gap", "before it"])
def test_rows_beside_a_gap_of_a_closed_front_do_not_count_wherever_its_seam_is(missing, seam):
    """Rows at a spacing of 1; those that are farther than three from the next have an end between them."""
    length = 50.0 + missing
    start = {"in the gap": 0, "in the rows": 30, "past the gap": length - 1, "before it": length - 49}[seam]
    s = np.sort((np.arange(50.0) + start + 0.5) % length)
    moves, place = np.random.default_rng(missing).normal(size=(50, 3)), (s - start) % length
    at = np.arange(length + 1)
    known = smoothed(s, moves, length, True, at, SmoothingOptions())
    for row in np.flatnonzero((place < 4) | (place > 46)):
        changed = moves + 7.0 * (s == s[row])[:, None]
        counts = not np.array_equal(smoothed(s, changed, length, True, at, SmoothingOptions()), known)
        assert counts == (missing < 3 or 2 < place[row] < 48)


def test_the_fit_bridges_a_gap_between_rows():
    s = np.concatenate([np.arange(0, 15.0), np.arange(30, 60.0)])
    smooth = smoothed(s, np.ones((len(s), 3)), 60.0, False, np.linspace(0, 60, 61), SmoothingOptions())
    assert np.abs(smooth - 1).max() < 1e-6


@pytest.mark.parametrize("smoothing", ["fit", "savitzky_golay", "none"])
@pytest.mark.parametrize("closed", [True, False])
def test_rows_that_are_not_trusted_go_as_their_neighbours(smoothing, closed):
    options, line = SmoothingOptions(smoothing=smoothing), circle(6.0, end=2 * np.pi if closed else 5.0)
    s = np.arange(40) * line.length / (40 if closed else 39)
    trusted = np.ones(40, bool)
    trusted[[10, 21, 22, 23, 24]] = False
    points, normal = line.at(s), np.tile([0.0, 0.0, 1.0], (40, 1))
    out = (points - CENTRE) / np.linalg.norm(points - CENTRE, axis=1)[:, None]
    kink, extension = np.where(trusted, 0.3, -1.0), np.where(trusted, 2.0, 5.0)
    rows = FrontStep.of(points, normal, out, kink, extension, trusted=trusted)
    moves = moves_along(line, s, rows, options, 1.0)
    assert np.linalg.norm(moves, axis=1) == pytest.approx(2.0)
    assert moves[:, 2] == pytest.approx(2 * np.sin(0.3))
    nothing = moves_along(line, s, replace(rows, trusted=0 * trusted), options, 1.0)
    every = moves_along(line, s, replace(rows, trusted=trusted | True), options, 1.0)
    assert (nothing == every).all(), "where none is trusted, all count"


@pytest.mark.parametrize("count", [3, 4, 6, 8])
def test_fronts_of_few_points_grow_to_curves_too(count):
    old = circle(4.0, count, 0.0, 1.2)
    moved = new_front(old, outward(old, 1.0), BOX, FRAME, 0.05)[0]
    off = np.abs(np.linalg.norm(moved.points - CENTRE, axis=1) - 5)
    # measured: 6e-4, 3e-4, 2e-4 and 2e-4 times that; straight between the points it is 0.025 (6 / count)^2
    assert off.max() < 1e-3 * (6 / count) ** 3


@pytest.mark.parametrize("row", [1, 47])
def test_the_seam_of_a_closed_front_rests_on_both_its_ends(row):
    """With four rows to a point, the point beside a row at rest stays, and no other."""
    line = circle(6.0, count=12)
    goes = np.ones(48, bool)
    goes[row] = False
    rest = points_at_rest(line, np.arange(48) / 48 * line.length, goes)
    assert np.flatnonzero(rest).tolist() == [0, 12]
    factors = beside_rest(line, rest, outward(line, 5.0))
    way = np.minimum(np.arange(13), 12 - np.arange(13)) * line.length / 12
    assert 5 * factors == pytest.approx(np.minimum(way, 5.0))


@pytest.mark.parametrize("degrees", [-70.0, 0.0, 35.0])
def test_moves_turn_from_the_binormal_towards_the_normal(degrees):
    rng = np.random.default_rng(3)
    normal, binormal, _ = np.linalg.qr(rng.normal(size=(20, 3, 3)))[0].transpose(1, 0, 2)
    extension, angle = rng.uniform(1, 2, 20), np.full(20, np.radians(degrees))
    moves = FrontStep.of(0 * normal, normal, binormal, angle, extension).moves
    about = np.cross(binormal, normal)  # a right-handed turn about it goes from the binormal to the normal
    turned = Rotation.from_rotvec(angle[:, None] * about).apply(binormal)
    assert moves == pytest.approx(extension[:, None] * turned, abs=1e-12)
