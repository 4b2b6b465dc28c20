"""Steps laid again as chords of the path that the crack takes."""

from dataclasses import replace

import numpy as np
import pytest

from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.polyline import polyline
from craftmesh.cracks.series import prescribed_crack
from craftmesh.errors import CraftmeshError
from craftmesh.growth.correct import corrected
from craftmesh.growth.front_step import FrontStep, Step
from craftmesh.growth.grow import SHORTENED, grow
from craftmesh.growth.options import SmoothingOptions

BOX = np.array([[0.0, 0.0, 0.0], [40.0, 40.0, 40.0]])
EDGE = CrackOptions(shape="through_edge", centre=(0.0, 20.0, 20.0), radius=6.0)
PENNY = CrackOptions(shape="penny", centre=(20.0, 20.0, 20.0), radius=6.0)
FIT = SmoothingOptions()
STEP, STEPS, KINK = 1.5, 5, np.radians(16.0)
TURN = KINK  # from one step to the next: half of a kink is corrected, and without T half is left


def rows_of(crack, kink, ahead, extension=STEP):
    """Return rows 0.8 apart of a crack whose front goes ahead (3,), or off its middle, turned by a kink."""
    line = polyline(crack.points[crack.fronts[0]])
    s = np.linspace(0, line.length, int(line.length / 0.8) + 1)[: -1 if line.closed else None]
    points = line.at(s)
    tangent = line.at(np.minimum(s + 1e-3, line.length)) - line.at(np.maximum(s - 1e-3, 0))
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    binormal = np.tile(ahead, (len(s), 1)) if len(ahead) else points - [20.0, 20.0, 20.0]
    binormal = binormal / np.linalg.norm(binormal, axis=1)[:, None]
    kinks = kink(points) if callable(kink) else np.full(len(s), kink)
    normal = np.cross(binormal, tangent)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    return FrontStep.of(points, normal, binormal, kinks, np.full(len(s), extension))


def straight_ahead(angle):
    return np.array([np.cos(angle), 0.0, np.sin(angle)])


def test_kinks_that_stay_the_same_make_chords_of_a_circle():
    crack = prescribed_crack(BOX, EDGE)
    up = np.sign(rows_of(crack, 0.0, straight_ahead(0.0)).normal[0, 2])
    last, tips = Step(crack, rows_of(crack, 0.0, straight_ahead(0.0))), []
    for k in range(STEPS):
        grown = grow(last.crack, last.along, BOX, FIT).crack
        reached = Step(grown, rows_of(grown, KINK, straight_ahead(up * k * TURN)))
        last = corrected(last, reached, BOX, FIT)
        tips.append(last.crack.points[last.crack.fronts[0]][:, [0, 2]])
    # the first chord is half a kink off the crack's plane; the next ones turn by what is corrected and left
    radius = STEP / (2 * np.sin(TURN / 2))
    aside = KINK / 2 - TURN / 2
    away = np.concatenate(tips) - [6 - radius * np.sin(aside), 20 + up * radius * np.cos(aside)]
    assert np.linalg.norm(away, axis=1) == pytest.approx(radius, abs=1e-6)
    turned = np.arctan2(away[:, 0], -up * away[:, 1]).reshape(STEPS, -1) - aside
    assert turned.T == pytest.approx(
        np.tile(TURN * np.arange(1, STEPS + 1), (turned.shape[1], 1)), abs=1e-6
    )


def test_a_front_goes_on_from_its_corrected_place_by_what_is_left_of_the_kink():
    def wave(points):
        return 0.3 * np.sin(2 * np.arctan2(points[:, 1] - 20, points[:, 0] - 20))

    crack = prescribed_crack(BOX, PENNY)
    last = Step(crack, rows_of(crack, 0.0, ()))
    reached = grow(last.crack, last.along, BOX, FIT).crack
    along = rows_of(reached, wave, ())
    step = corrected(last, Step(reached, along), BOX, FIT)
    ways = np.degrees(
        np.arctan2(*((_ways(step.along) * axis).sum(axis=1) for axis in (along.normal, along.binormal)))
    )
    assert ways == pytest.approx(np.degrees(along.kink_angle), abs=1e-9)
    # the strip lies in its new direction, at half of the kink; 0.01: the fit of the moves along the front
    moved = step.along.points - along.points
    assert np.abs(moved[:, 2] - STEP * np.sin(wave(along.points) / 2) * along.normal[:, 2]).max() < 0.01
    grown = grow(step.crack, step.along, BOX, FIT).crack
    assert len(grown.fronts) == 1


def _ways(along):
    angle = along.kink_angle[:, None]
    return np.cos(angle) * along.binormal + np.sin(angle) * along.normal


def test_rows_that_are_not_trusted_turn_no_strip():
    crack = prescribed_crack(BOX, EDGE)
    last = Step(crack, rows_of(crack, 0.0, straight_ahead(0.0)))
    reached = grow(last.crack, last.along, BOX, FIT).crack
    along = rows_of(reached, 0.1, straight_ahead(0.0))
    wild = np.arange(len(along.points)) % 7 == 3
    doubtful = replace(along, kink_angle=np.where(wild, 1.2, 0.1), trusted=~wild)
    steps = [corrected(last, Step(reached, rows), BOX, FIT) for rows in (along, doubtful)]
    assert steps[0].crack.points == pytest.approx(steps[1].crack.points, abs=1e-9)
    nothing = replace(along, trusted=np.zeros(len(wild), bool))
    assert corrected(last, Step(reached, nothing), BOX, FIT).crack.points == pytest.approx(
        steps[0].crack.points
    ), "where none is trusted all are used"


def test_a_correction_that_needs_a_shorter_strip_is_refused(monkeypatch):
    """Load cycles of the strip are counted already."""
    crack = prescribed_crack(BOX, EDGE)
    last = Step(crack, rows_of(crack, 0.0, straight_ahead(0.0)))
    reached = grow(last.crack, last.along, BOX, FIT).crack
    monkeypatch.setattr("craftmesh.growth.grow.ATTEMPTS", ((SHORTENED, 1, 0.5, False),))
    with pytest.raises(CraftmeshError, match="folds unless it is shorter"):
        corrected(last, Step(reached, rows_of(reached, KINK, straight_ahead(0.0))), BOX, FIT)


def test_a_front_of_another_crack_is_refused():
    crack = prescribed_crack(BOX, EDGE)
    last = Step(crack, rows_of(crack, 0.0, straight_ahead(0.0)))
    far = grow(crack, rows_of(crack, 0.0, straight_ahead(0.0), 9.0), BOX, FIT).crack
    with pytest.raises(CraftmeshError, match="would lie 7.5 from"):
        corrected(last, Step(far, rows_of(far, 0.0, straight_ahead(0.0))), BOX, FIT)
    penny = prescribed_crack(BOX, PENNY)
    both = grow(penny, rows_of(penny, 0.0, ()), BOX, FIT).crack
    two = replace(both, fronts=(*both.fronts, *both.fronts))
    with pytest.raises(CraftmeshError, match="number of surfaces or fronts"):
        corrected(Step(penny, rows_of(penny, 0.0, ())), Step(two, rows_of(both, 0.0, ())), BOX, FIT)
