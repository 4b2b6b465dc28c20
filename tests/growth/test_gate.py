"""Points that stay, and cracks that grow in part: closed, arrested, noise."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_grow import BOX, along

from craftmesh.cracks.polyline import feet, polyline
from craftmesh.cracks.series import crack_area
from craftmesh.cracks.triangulated import boundary_loops, crack_from_triangles
from craftmesh.growth.extension import (
    ARRESTED,
    CLOSED,
    NOISE,
    doubts,
    kinks_and_extensions,
)
from craftmesh.growth.front_points import FrontPoints
from craftmesh.growth.grow import grow
from craftmesh.growth.options import GrowthOptions, SmoothingOptions
from craftmesh.surface.measure import area_vectors

STEP = GrowthOptions(extension=2.0)
COUNT = 48
TURN = np.arange(COUNT) * 2 * np.pi / COUNT


def ring(count):
    turn = np.arange(count) * 2 * np.pi / count
    return 6 * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)


PLACES = ring(COUNT)


def front(k_1, k_2=0.0, k_3=0.0):
    """K round a front of COUNT points, each a number or one a point."""
    return np.stack([np.broadcast_to(each, COUNT) for each in (k_1, k_2, k_3)], axis=1).astype(float)


def found(k, options=STEP, error=0.0, contact=False, trusted=None):
    """The growth of a penny of radius 6 in a body under a stress of 1."""
    doubt = doubts(np.broadcast_to(error, COUNT), 1.0, 6.0)
    trusted = np.ones(COUNT, bool) if trusted is None else trusted
    known = {"points": PLACES, "doubt": doubt, "trusted": trusted, "contact": contact}
    return kinks_and_extensions(FrontPoints.of(k, 6.0, **known), options)[0]


def test_a_closed_crack_stays_whatever_its_sliding():
    """Lips that overlap: what K_II there is without contact is none."""
    for sliding in (0.02, 1.0):
        growth = found(front(-2.8, sliding * np.cos(TURN)))
        assert (growth.stays == CLOSED).all()
        assert not growth.extension.any() and not growth.kink_angle.any()


def test_where_contact_was_solved_real_sliding_goes_on_and_noise_does_not():
    growth = found(front(0.0, 1.5 * np.cos(TURN)), contact=True)
    slides = np.abs(np.cos(TURN)) > 0.1
    assert (growth.stays[slides] == "").all() and (growth.extension[slides] == 2.0).all()
    assert np.abs(np.degrees(growth.kink_angle[slides])) == pytest.approx(70.53, abs=0.01)
    assert (growth.stays[np.abs(np.cos(TURN)) < 1e-9] == NOISE).all()
    assert (found(front(0.0, 0.02)).stays == NOISE).all()


@pytest.mark.parametrize("criterion", ["tangential_stress", "energy_release"])
def test_a_crack_along_the_load_is_noise(criterion):
    """K 2e-4 of root(pi a), as coarse meshes have it, in all modes and signs."""
    k = 1e-3 * np.random.default_rng(3).normal(size=(COUNT, 3))
    growth = found(k, GrowthOptions(criterion=criterion))
    assert (growth.stays == NOISE).all() and not growth.extension.any()


def test_a_k_under_its_own_error_is_noise():
    error = np.where(TURN < 1, 3.0, 0.1)
    assert ((found(front(2.0), error=error).stays == NOISE) == (TURN < 1)).all()


def test_the_threshold_holds_point_by_point():
    k = front(2 + np.cos(TURN))
    for law in ("uniform", "power"):
        options = GrowthOptions(extension=2.0, law=law, threshold=1.0, stress_ratio=0.5, coefficient=1e-3)
        growth = found(k, options)
        under = 0.5 * growth.driving <= 1.0
        assert under.any() and not under.all()
        assert ((growth.stays == ARRESTED) == under).all() and ((growth.extension == 0) == under).all()
        assert np.median(growth.extension[~under]) == pytest.approx(2.0, rel=0.1)
    nothing = found(k, GrowthOptions(threshold=3.0))
    assert (nothing.stays == ARRESTED).all() and not nothing.da_dn.any()


def test_a_point_between_two_grains_stays_with_the_points_next_to_it():
    trusted = np.ones(COUNT, bool)
    trusted[[5, 30]] = False
    k = front(np.where(TURN < 2, 2.0, -2.0))
    k[5, 0], k[30, 0] = -2.0, 2.0
    stays = found(k, trusted=trusted).stays
    assert stays[5] == "" and stays[30] == CLOSED


def disc(y, count):
    """A disc of triangles round (20, y, 20), whose corners are 6 from there."""
    around = np.arange(count)
    triangles = np.stack([around, np.roll(around, -1), np.full(count, count)], axis=1)
    places = np.append(ring(count), [[0, 0, 0]], axis=0) + [20, y, 20]
    return crack_from_triangles(places, triangles, None, BOX)


def edge():
    """A strip from the face x = 0 to x = 6."""
    y = np.linspace(-2, 42, 23)
    points = np.concatenate([np.stack([x + 0 * y, y, 20 + 0 * y], axis=1) for x in (-4.0, 6.0)])
    k, count = np.arange(22), len(y)
    triangles = np.concatenate(
        [np.stack([k, count + k, k + 1], axis=1), np.stack([k + 1, count + k, count + k + 1], axis=1)]
    )
    return crack_from_triangles(points, triangles, None, BOX)


# rows are 0.8 apart; one disc has a front of shorter edges than the quarters of that
GIVEN = {"penny": disc(20, 48), "fine": disc(20, 400), "half": disc(0, 48), "edge": edge()}


@cache
def rows_of(name):
    return along(GIVEN[name], GrowthOptions())


def grown_where(name, goes, kink=0.0, smoothing="fit"):
    """Return a crack, its rows, which of them stay, and the crack grown by 1.5 where `goes` (share)."""
    crack, rows = GIVEN[name], rows_of(name)
    rest = ~goes(np.arange(len(rows.points)) / len(rows.points))
    # that of noise turns nothing
    rows = replace(rows, extension=np.where(rest, 0, 1.5), kink_angle=np.where(rest, 1.2, kink))
    return crack, rows, rest, grow(crack, rows, BOX, SmoothingOptions(smoothing=smoothing)).crack


def flattest(crack):
    """Return the least area of a triangle over the square of its longest side."""
    sides = crack.points[crack.triangles]
    longest = np.linalg.norm(sides - np.roll(sides, 1, axis=1), axis=2).max(axis=1)
    return (np.linalg.norm(area_vectors(crack.points, crack.triangles), axis=1) / longest**2).min()


def check_grown_in_part(crack, rows, rest, grown):
    """Rows that stay lie on the new front as on the old one; the strip has no holes, no flat triangles."""
    old, new = (polyline(each.points[each.fronts[0]]) for each in (crack, grown))
    off = feet(new, rows.points[rest])[1]
    assert off.max(initial=0.0) <= feet(old, rows.points[rest])[1].max(initial=0.0) + 1e-9
    # of a strip all along 0.008 to 0.016: the halves of the old front's facets
    assert flattest(grown) > 0.004
    assert len(boundary_loops(grown.triangles)) == 1 and len(grown.fronts) == 1
    assert new.closed == old.closed
    assert {tuple(place) for place in crack.points} <= {tuple(place) for place in grown.points}


@given(
    name=st.sampled_from(sorted(GIVEN)),
    arcs=st.lists(st.tuples(st.floats(0, 1), st.floats(0, 0.4)), min_size=1, max_size=3),
    kink=st.floats(-0.5, 0.5),
    smoothing=st.sampled_from(["fit", "none"]),
)
@settings(max_examples=15)
def test_arcs_of_a_front_stay_exactly_where_they_are(name, arcs, kink, smoothing):
    def goes(at):
        return ~np.any([np.mod(at - start, 1) <= length for start, length in arcs], axis=0)

    crack, rows, rest, grown = grown_where(name, goes, kink, smoothing)
    check_grown_in_part(crack, rows, rest, grown)
    assert (crack_area(grown) > crack_area(crack)) == (~rest).any()


def test_half_a_penny_goes_on_in_full_and_the_other_half_not_at_all():
    crack, rows, rest, grown = grown_where("penny", lambda at: at < 0.5)
    away = grown.points[grown.fronts[0]] - [20, 20, 20]
    radius = np.linalg.norm(away, axis=1)
    # the old front's chords, and a step on each side in which the new front leaves it at 45 degrees
    assert radius.min() > 6 - 0.013 and radius.max() == pytest.approx(7.5, abs=0.013)
    turn = np.diff(np.unwrap(np.arctan2(away[:, 1], away[:, 0])))
    gone = np.abs(turn[radius[1:] > 7.48]).sum()
    # rows speak for half the way to the next: 24 of 47 spacings, a point of the front more or less
    assert gone == pytest.approx(2 * np.pi * (~rest).mean() - 2 * 1.5 / 6, abs=2 * 0.2 / 6)
    assert np.abs(away[:, 2]).max() < 1e-9


def test_the_end_that_stays_is_not_carried_out_of_the_box():
    crack, _, _, grown = grown_where("half", lambda at: at > 0.3)
    ends = [each.points[each.fronts[0][[0, -1]]] for each in (crack, grown)]
    assert (ends[1][0] == ends[0][0]).all() and np.linalg.norm(ends[1][1] - ends[0][1]) > 1.4
