"""Steps of a front by a power of K, against how it would go in many small ones."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipe

from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.polyline import polyline
from craftmesh.cracks.series import prescribed_crack
from craftmesh.growth.correct import corrected
from craftmesh.growth.front_step import FrontStep, Step
from craftmesh.growth.grow import grow
from craftmesh.growth.options import SmoothingOptions
from craftmesh.growth.relaxation import FrontRows, over_step, rows_along

POWER, SPACING = 3.0, 0.8
BOX = np.array([[0.0, 0.0, 0.0], [60.0, 60.0, 60.0]])
CENTRE = np.array([30.0, 30.0, 30.0])
FIT = SmoothingOptions()


def axes_of(points):
    """Return the semi-axes of the ellipse about CENTRE nearest to points (n, 3) in its plane."""
    squares = ((points - CENTRE)[:, :2]) ** 2
    return 1 / np.sqrt(np.linalg.lstsq(squares, np.ones(len(points)), rcond=None)[0])


def irwin(points):
    """Return K_I (n,) of that ellipse in unit tension at its points (n, 3)."""
    a, b = axes_of(points)
    flat, wide = min(a, b), max(a, b)
    x, y = ((points - CENTRE)[:, :2] / [a, b]).T
    angle = np.arctan2(y, x) + (np.pi / 2 if b > a else 0)
    shape = (np.sin(angle) ** 2 + (flat / wide) ** 2 * np.cos(angle) ** 2) ** 0.25
    return np.sqrt(np.pi * flat) / ellipe(1 - (flat / wide) ** 2) * shape


def rows_of(crack):
    """Return where the front of a crack in its plane goes, its points with their rates."""
    line = polyline(crack.points[crack.fronts[0]])
    s = np.arange(0, line.length - SPACING / 2, SPACING)
    points = line.at(s)
    tangent = line.at(s + 0.1) - line.at(s - 0.1)
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    binormal = np.cross(tangent, [0.0, 0.0, 1.0])
    binormal *= np.sign((binormal * (points - CENTRE)).sum(axis=1))[:, None]
    normal = np.cross(binormal, tangent)
    rate = irwin(points) ** POWER
    known = {"rate": rate / np.median(rate), "power": np.full(len(s), POWER)}
    return FrontStep.of(points, normal, binormal, 0 * s, 0 * s, **known)


def step_of(crack, share):
    along = rows_of(crack)
    lines = [polyline(crack.points[front]) for front in crack.fronts]
    extension = over_step(
        along.rate,
        POWER,
        share * axes_of(along.points).min(),
        rows_along(lines, along.points, along.binormal),
    )
    return Step(crack, replace(along, extension=extension))


def grown(crack, share, steps):
    """Yield the semi-axes after each step, corrected as the next one finds K."""
    last = step_of(crack, share)
    for _ in range(steps):
        reached = grow(last.crack, last.along, BOX, FIT).crack
        last = corrected(last, step_of(reached, share), BOX, FIT)
        yield axes_of(last.along.points)


def test_an_ellipse_grows_as_its_axes_do():
    ellipse = CrackOptions(shape="ellipse", centre=tuple(CENTRE), semi_axes=(8.0, 4.0))
    found = np.array(list(grown(prescribed_crack(BOX, ellipse), 0.25, 2)))
    path = solve_ivp(lambda b, a: (b / a) ** (POWER / 2), (4, 8), [8.0], dense_output=True, rtol=1e-9)
    for a, b in found:
        # found: 0.4 and 0.5 %; the front is no ellipse any more, as Irwin's K and the axes' path have it
        assert b / a == pytest.approx(b / path.sol(b)[0], rel=0.006)


@pytest.mark.parametrize("wave", [1, 2, 3])
@pytest.mark.parametrize("sense", [1, -1])
def test_a_wave_of_a_round_front_decays_as_its_k_does(wave, sense):
    """Wave m ahead by x lowers ln K of a penny of radius a by x (m - 1) / 2a: a shift changes nothing.

    Of a front round a ligament, which turns the other way, it is (m + 1) / 2a (Gao & Rice 1987).
    """
    radius, count, step = 6.0, 48, 0.5
    turn = np.arange(count) * 2 * np.pi / count
    front = FrontRows(np.arange(count), radius * turn, 2 * np.pi * radius, True, sense / radius)

    def kept(m):
        z = POWER * step * max(m - sense, 0) / (2 * radius)
        return -np.expm1(-z) / z if z else 1.0

    found = over_step(1 + 0.1 * np.cos(wave * turn), POWER, step, [front])
    expected = step * (kept(0) + 0.1 * kept(wave) * np.cos(wave * turn))
    # 0.2 %: values are straight between the rows; the other sign is 1 % off and more
    assert found == pytest.approx(expected, abs=2e-3 * step)
