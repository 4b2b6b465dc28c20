"""Whole cracks after growth: where the theory says, and still cracks."""

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from craftmesh.cracks.height_parts import kinks_of
from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.polyline import feet, polyline
from craftmesh.cracks.series import crack_area, prescribed_crack
from craftmesh.cracks.sheets import cracks_from_triangles, one_crack, sheets
from craftmesh.cracks.triangulated import boundary_loops
from craftmesh.errors import CraftmeshError
from craftmesh.growth import grow as growth
from craftmesh.growth.extension import kinks_and_extensions
from craftmesh.growth.front_points import FrontPoints
from craftmesh.growth.front_step import FrontStep
from craftmesh.growth.grow import FOLDED, SHORTENED, grow
from craftmesh.growth.options import GrowthOptions, SmoothingOptions
from craftmesh.growth.steps import crack_size
from craftmesh.surface.measure import area_vectors

BOX = np.array([[0.0, 0.0, 0.0], [40.0, 40.0, 40.0]])
PENNY = CrackOptions(shape="penny", centre=(20.0, 20.0, 20.0), radius=6.0)
HALF_PENNY = CrackOptions(shape="penny", centre=(20.0, 0.0, 20.0), radius=6.0)
EDGE = CrackOptions(shape="through_edge", centre=(0.0, 20.0, 20.0), radius=6.0)
ELLIPSE = CrackOptions(shape="ellipse", centre=(20.0, 20.0, 20.0), semi_axes=(8.0, 5.0))


def opened(points):
    return np.tile([1.0, 0.0, 0.0], (len(points), 1))


def along(crack, options, k=opened):
    """Return rows about 0.8 apart of a crack in the plane z = 20 that goes as k(points) and options say."""
    line = polyline(crack.points[crack.fronts[0]])
    s = np.linspace(0, line.length, int(line.length / 0.8) + 1)
    s = s[:-1] if line.closed else s
    tangent = line.at(np.minimum(s + 1e-3, line.length)) - line.at(np.maximum(s - 1e-3, 0))
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    faces = area_vectors(crack.points, crack.triangles).sum(axis=0)
    normal = np.tile(faces / np.linalg.norm(faces), (len(s), 1))
    points = line.at(s)
    growth, _ = kinks_and_extensions(FrontPoints.of(k(points), crack_size(crack, BOX)), options)
    return replace(growth, points=points, normal=normal, binormal=np.cross(tangent, normal))


def grown_by(crack, options, k=opened, smoothing="fit"):
    return grow(crack, along(crack, options, k), BOX, SmoothingOptions(smoothing=smoothing)).crack


def test_a_penny_in_tension_grows_to_a_larger_penny():
    crack = prescribed_crack(BOX, PENNY)
    grown = grown_by(crack, GrowthOptions(extension=1.5))
    away = grown.points[grown.fronts[0]] - [20, 20, 20]
    # 2e-3: rows 0.8 apart on a radius of 6; the moves between them are fitted
    assert np.abs(np.linalg.norm(away, axis=1) - 7.5).max() < 2e-3
    assert np.abs(away[:, 2]).max() < 1e-9
    assert crack_area(grown) == pytest.approx(np.pi * 7.5**2, rel=1e-3)


@pytest.mark.parametrize(
    "options, radius",
    [(PENNY, 6.0), (HALF_PENNY, 6.0), (EDGE, 6.0), (ELLIPSE, 5.0)],
    ids=["penny", "half", "edge", "ellipse"],
)
def test_the_radius_is_the_depth_behind_the_front(options, radius):
    assert crack_size(prescribed_crack(BOX, options), BOX) == pytest.approx(radius, rel=2e-3)


@pytest.mark.parametrize(
    "options", [PENNY, HALF_PENNY, EDGE, ELLIPSE], ids=["penny", "half", "edge", "ellipse"]
)
def test_a_grown_crack_keeps_the_old_surface_and_is_a_crack(options):
    crack = prescribed_crack(BOX, options)

    def sheared(points):
        return np.stack([np.ones(len(points)), 0.3 * np.cos(points[:, 0]), 0 * points[:, 0]], axis=1)

    grown = grown_by(crack, GrowthOptions(), sheared)
    assert (grown.points[: len(crack.points)] == crack.points).all()
    assert len(grown.fronts) == 1
    assert len(boundary_loops(grown.triangles)) == 1
    assert crack_area(grown) > crack_area(crack)
    if not polyline(grown.points[grown.fronts[0]]).closed:
        ends = grown.points[grown.fronts[0][[0, -1]]]
        assert ((ends == BOX[0]) | (ends == BOX[1])).any(axis=1).all()


@pytest.mark.parametrize("options", [PENNY, HALF_PENNY], ids=["penny", "half"])
def test_savitzky_golay_takes_noise_of_single_nodes_off_the_new_front(options):
    """The paper's filter (section 2): kink angles that alternate from node to node leave a flat crack."""
    crack = prescribed_crack(BOX, options)

    def noisy(points):
        return np.stack([np.ones(len(points)), 0.1 * (-1.0) ** np.arange(len(points)), 0 * points[:, 0]], 1)

    def height(smoothing):
        grown = grown_by(crack, GrowthOptions(extension=1.5), noisy, smoothing)
        front = grown.points[grown.fronts[0]]
        # a front's ends are three rows of one window and keep more
        return np.abs(front[len(front) // 4 : 3 * len(front) // 4, 2] - 20).max()

    # 11 degrees of kink; a parabola in a window of seven leaves 5 / 21 of noise from node to node
    assert height("none") == pytest.approx(1.5 * np.sin(np.radians(11.1)), rel=0.03)
    assert height("savitzky_golay") == pytest.approx(5 / 21 * height("none"), rel=0.1)


def test_sliding_turns_the_crack_out_of_its_plane():
    crack = prescribed_crack(BOX, EDGE)

    def sheared(points):
        return np.tile([1.0, 0.2, 0.0], (len(points), 1))

    rows = along(crack, GrowthOptions(extension=2.0), sheared)
    grown = grow(crack, rows, BOX, SmoothingOptions()).crack
    tip = grown.points[grown.fronts[0]]
    angle = -2 * np.arctan(0.4 / (1 + np.sqrt(1.32)))
    assert rows.kink_angle == pytest.approx(angle, abs=1e-12)
    assert tip[:, 0] == pytest.approx(6 + 2 * np.cos(angle), abs=1e-9)
    assert tip[:, 2] == pytest.approx(20 + 2 * np.sin(angle) * rows.normal[0, 2], abs=1e-9)


def swung(rows, amplitude, wave):
    """Return the rows with their directions turned about the front, to and fro along it."""
    angle = amplitude * np.sin(2 * np.pi * rows.points[:, 1:2] / wave)
    sine, cosine = np.sin(angle), np.cos(angle)
    normal = cosine * rows.normal - sine * rows.binormal
    return replace(rows, normal=normal, binormal=cosine * rows.binormal + sine * rows.normal)


@pytest.mark.parametrize("turning", ["kinks", "directions"])
def test_what_turns_to_and_fro_within_a_step_does_not_fold_the_crack(turning):
    """A straight front goes by 8; each step's end would stand at 83 degrees to the next one's."""
    crack = prescribed_crack(BOX, EDGE)
    rows = along(crack, GrowthOptions(extension=8.0))
    if turning == "kinks":
        kink = np.radians(50) * np.sin(2 * np.pi * rows.points[:, 1] / 4.8)
        rows = replace(rows, kink_angle=kink)
    else:
        rows = swung(rows, np.radians(80), 10.0)
    grown = grow(crack, rows, BOX, SmoothingOptions()).crack
    # straight on by 8 in the mean; a fifth of it for the last waves, whose other half is beyond the ends
    assert np.abs(grown.points[grown.fronts[0]].mean(axis=0) - [14, 20, 20])[[0, 2]].max() < 1.6


def test_five_increments_make_one_sheet():
    crack = prescribed_crack(BOX, HALF_PENNY)
    for _ in range(5):
        crack = grown_by(crack, GrowthOptions(share=0.1))
    away = crack.points[crack.fronts[0]] - [20, 0, 20]
    # 0.1 % of the radius at each increment, its tolerance, and rows 0.8 apart
    assert np.linalg.norm(away, axis=1) == pytest.approx(6 * 1.1**5, rel=0.01)


@pytest.mark.slow
@given(
    middle=st.tuples(*[st.floats(1.0, 39.0)] * 3),
    near=st.sets(st.integers(0, 2), min_size=1),
    normal=st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda way: 0.3 < np.linalg.norm(way)),
    sliding=st.floats(-0.3, 0.3),
)
@settings(max_examples=15)
def test_a_crack_that_leaves_by_several_faces_ends_in_the_body_at_its_fronts_alone(
    middle, near, normal, sliding
):
    """Discs of radius 6 at faces, edges and corners of the box, at any angle, over three increments."""
    centre = tuple(1.0 if k in near else x for k, x in enumerate(middle))
    crack = prescribed_crack(BOX, CrackOptions(shape="penny", centre=centre, normal=normal, radius=6.0))

    def mixed(points):
        return np.stack(
            [np.ones(len(points)), sliding * np.cos(points[:, 0] / 3), 0 * points[:, 0]], axis=1
        )

    for _ in range(3):
        if len(crack.fronts) != 1 or polyline(crack.points[crack.fronts[0]]).length < 3.0:
            return  # `along` takes one front, of several rows
        grown = grown_by(crack, GrowthOptions(extension=1.5), mixed)
        if grown is None:
            return
        crack = grown
        fronts = {edge for front in crack.fronts for edge in _edges(front)}
        for a, b in sorted(
            {edge for loop in boundary_loops(crack.triangles) for edge in _edges(loop)} - fronts
        ):
            between = crack.points[a] + np.linspace(0, 1, 9)[:, None] * (crack.points[b] - crack.points[a])
            inward = np.minimum(between - BOX[0], BOX[1] - between).min(axis=1)
            assert inward.max() <= 1e-6


def _edges(line):
    return {(min(pair), max(pair)) for pair in zip(line[:-1].tolist(), line[1:].tolist())}


def test_a_strip_that_folds_is_laid_again(monkeypatch):
    """Kinks that jump by 80 degrees between rows, without smoothing: a shorter strip does not fold."""
    crack = prescribed_crack(BOX, PENNY)
    rows = along(crack, GrowthOptions(extension=3.0))
    kink = np.radians(40) * (-1.0) ** np.arange(len(rows.points))
    rows, options = replace(rows, kink_angle=kink), SmoothingOptions(smoothing="none")
    grown, repairs, extension = grow(crack, rows, BOX, options)
    assert repairs == {SHORTENED: 1}
    assert np.unique(extension / rows.extension).tolist() in ([0.5], [0.25])
    assert kinks_of(grown.points, grown.triangles).sharpest <= FOLDED
    assert crack_area(grown) > crack_area(crack)
    monkeypatch.setattr(growth, "ATTEMPTS", growth.ATTEMPTS[:1])
    with pytest.raises(CraftmeshError, match="folded"):
        grow(crack, rows, BOX, options)


def test_rows_that_no_rule_shortens_keep_their_extension_and_rows_beside_others_at_rest_do_not():
    crack = prescribed_crack(BOX, PENNY)
    rows = along(crack, GrowthOptions(extension=1.5))
    assert (grow(crack, rows, BOX, SmoothingOptions()).extension == rows.extension).all()
    rows.extension[0] = 0.0
    laid = grow(crack, rows, BOX, SmoothingOptions()).extension
    assert laid[0] == 0 < laid[1] < 0.81  # no farther than the row at rest is away
    assert (laid[4:-4] == 1.5).all()


def test_a_twisted_strip_is_no_washboard(monkeypatch):
    """Kinks of up to 65 degrees, to either side along a penny's front, over half of its radius."""
    crack = prescribed_crack(BOX, PENNY)
    rows = along(crack, GrowthOptions(extension=3.0))
    turn = np.arctan2(rows.points[:, 1] - 20, rows.points[:, 0] - 20)
    rows = replace(rows, kink_angle=np.radians(65) * np.sin(2 * turn))
    old = polyline(crack.points[crack.fronts[0]])

    def kinks_ahead():
        grown = grow(crack, rows, BOX, SmoothingOptions()).crack
        edges = kinks_of(grown.points, grown.triangles).edges
        return (feet(old, grown.points[edges].mean(axis=1))[1] > 1e-6).sum()

    assert kinks_ahead() == 0
    monkeypatch.setattr(growth, "ROWS", (1,))
    assert kinks_ahead() > 0


def test_the_normal_of_an_end_does_not_turn_the_front():
    """The last row of a half penny has the normal of one facet turned by 80 degrees."""
    crack = prescribed_crack(BOX, HALF_PENNY)
    rows = along(crack, GrowthOptions(extension=1.5))
    normal, binormal = rows.normal.copy(), rows.binormal.copy()
    turn = np.radians(80)
    normal[0], binormal[0] = (
        np.cos(turn) * normal[0] + np.sin(turn) * binormal[0],
        np.cos(turn) * binormal[0] - np.sin(turn) * normal[0],
    )
    grown = grow(crack, replace(rows, normal=normal, binormal=binormal), BOX, SmoothingOptions()).crack
    away = grown.points[grown.fronts[0]] - [20, 0, 20]
    assert np.abs(away[:, 2]).max() < 1e-9
    assert np.abs(np.linalg.norm(away, axis=1) - 7.5).max() < 5e-3


def test_a_front_beyond_the_box_leaves_no_crack():
    assert grown_by(prescribed_crack(BOX, EDGE), GrowthOptions(extension=50.0)) is None


def discs(*middles):
    return one_crack([prescribed_crack(BOX, replace(PENNY, centre=(x, 20.0, 20.0))) for x in middles])


def rows_of(crack, kept):
    """Rows along all fronts of cracks in a plane, of which the mesh has those at points for which kept."""
    parts = [along(part, GrowthOptions(extension=1.5)) for part in sheets(crack)]
    rows = FrontStep(
        *(np.concatenate([getattr(part, item.name) for part in parts]) for item in fields(FrontStep))
    )
    return rows.rows(kept(rows.points))


def test_discs_that_have_grown_together_grow_on_where_their_fronts_are_left():
    """Each disc's front inside the other has no rows; the rest goes on as a disc of its own."""
    crack = discs(16.0, 24.0)

    def in_neither(p):  # chords of the fronts are 1e-4 inside their discs
        return np.all([np.linalg.norm(p - [x, 20, 20], axis=1) > 5.99 for x in (16.0, 24.0)], axis=0)

    rows = rows_of(crack, in_neither)
    corners = np.array([[20, 20 - 20**0.5, 20], [20, 20 + 20**0.5, 20]])
    turned = np.linalg.norm(rows.points[:, None] - corners, axis=2).min(axis=1) < 1.5
    assert turned.any()  # as a curve through the corner there would have them
    rows = replace(rows, binormal=np.where(turned[:, None], -rows.binormal, rows.binormal))
    grown = grow(crack, rows, BOX, SmoothingOptions()).crack
    for part, x in zip(sheets(grown), (16.0, 24.0)):
        away = np.linalg.norm(part.points[part.fronts[0]] - [x, 20, 20], axis=1)
        outside = np.sign(part.points[part.fronts[0], 0] - 20) == np.sign(x - 20)
        assert np.abs(away[outside] - 7.5).max() < 0.01
        assert np.abs(away - 7.5).max() < 0.1


def test_discs_that_grow_over_each_other_almost_in_one_plane_become_one_sheet():
    first = prescribed_crack(BOX, replace(PENNY, centre=(13.0, 20.0, 20.0)))
    tilted = replace(PENNY, centre=(26.0, 20.0, 20.3), normal=(-0.02, 0.0, 1.0), axis=(0.0, 1.0, 0.0))
    both = one_crack([first, prescribed_crack(BOX, tilted)])
    grown = grow(both, rows_of(both, lambda p: np.ones(len(p), bool)), BOX, SmoothingOptions()).crack
    assert len(sheets(both)) == 2 and len(sheets(grown)) == 1 and len(grown.fronts) == 1
    middles = np.array([tilted.centre, (13.0, 20.0, 20.0)])
    front = grown.points[grown.fronts[0]]
    away = np.linalg.norm(front[:, None] - middles, axis=2).min(axis=1)
    # chords of the fronts at 0.4 from corners, which the outline has where the discs meet
    assert np.abs(away - 7.5).max() < 0.05
    # the lens that both discs cover counts once
    half = np.arccos(6.5 / 7.5)
    lens = 2 * 7.5**2 * (half - np.sin(half) * np.cos(half))
    assert crack_area(grown) == pytest.approx(2 * np.pi * 7.5**2 - lens, rel=5e-3)


def test_a_front_that_has_vanished_in_another_crack_stays_and_is_read_again():
    crack = discs(20.0, 21.0)
    small = prescribed_crack(BOX, replace(PENNY, centre=(20.5, 20.0, 20.0), radius=2.0))
    both = one_crack([sheets(crack)[0], small])
    rows = rows_of(both, lambda p: np.linalg.norm(p - [20, 20, 20], axis=1) > 5.9)
    grown = grow(both, rows, BOX, SmoothingOptions()).crack
    first, second = sheets(grown)
    assert np.abs(np.linalg.norm(first.points[first.fronts[0]] - [20, 20, 20], axis=1) - 7.5).max() < 2e-3
    assert np.array_equal(second.points, small.points) and len(second.fronts) == 1
    again = cracks_from_triangles(
        grown.points, grown.triangles, [grown.points[front] for front in grown.fronts], BOX
    )
    assert len(again.fronts) == 2 and crack_area(again) == pytest.approx(crack_area(grown))


def test_a_sheet_that_has_left_the_box_ends_no_other():
    far = prescribed_crack(BOX, replace(EDGE, radius=39.5, centre=(0.0, 20.0, 5.0)))
    both = one_crack([far, prescribed_crack(BOX, PENNY)])
    grown = grow(both, rows_of(both, lambda p: np.ones(len(p), bool)), BOX, SmoothingOptions()).crack
    assert [len(sheet.fronts) for sheet in sheets(grown)] == [0, 1]
    again = cracks_from_triangles(
        grown.points, grown.triangles, [grown.points[front] for front in grown.fronts], BOX
    )
    assert [len(sheet.fronts) for sheet in sheets(again)] == [0, 1]


def test_nothing_goes_under_the_threshold():
    k = np.tile([1.0, 0.2, 0.1], (5, 1))
    found = [
        kinks_and_extensions(FrontPoints.of(k, 3.0), GrowthOptions(threshold=threshold, share=0.25))[
            0
        ].extension
        for threshold in (2.0, 0.9)
    ]
    assert (found[0] == 0).all() and (found[1] == 0.75).all()


def test_rows_of_another_crack_are_refused():
    crack = prescribed_crack(BOX, PENNY)
    other = along(prescribed_crack(BOX, ELLIPSE), GrowthOptions())
    with pytest.raises(CraftmeshError, match="away from the crack's fronts"):
        grow(crack, other, BOX, SmoothingOptions())


@given(st.lists(st.floats(1e-3, 10), min_size=3, max_size=30))
@settings(max_examples=50)
def test_extensions_stay_within_their_caps(driving):
    driving = np.array([1.0, 1.0, *driving])
    options = GrowthOptions(law="power", exponent=2.5, extension=3.0)
    k = np.outer(driving, [1.0, 0.0, 0.0])
    size = kinks_and_extensions(FrontPoints.of(k, 3.0), options)[0].extension
    assert size.min() >= 0.6 and size.max() <= 6.0
    assert (np.diff(size[np.argsort(driving)]) >= 0).all()
    with_threshold = kinks_and_extensions(FrontPoints.of(k, 3.0), replace(options, threshold=1e-4))[
        0
    ].extension
    assert with_threshold.min() == pytest.approx(3.0 * driving.min() ** 2.5 / np.median(driving**2.5))
