"""The error that K is said to have: what raises it, where, and in which unit."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from craftmesh.fracture.error import WEIGHTS, errors
from craftmesh.fracture.fit import FrontLine
from craftmesh.fracture.segments import segments_of
from craftmesh.mechanics.materials import Material, mean_moduli, turned
from craftmesh.mechanics.orientation import quaternion_to_matrix, random_orientations

COUNT = 24
ISOTROPIC = Material("isotropic", (200.0, 0.3)).stiffness()
COPPER = Material("cubic", (168.4, 121.4, 75.4)).stiffness()


def found(scale=1.0, excess=0.0, spread=0.0, stiffness=ISOTROPIC, jump=0.0, closed=True, **other):
    """The errors along a front of edges of one, its radius four of them, with K_I = scale.

    The root of J is larger by `excess` at node 6; from node 12 on, of 24, another grain, stiffer by `jump`,
    with K_I larger by as much in one-sided limits, and by `apart` the lips' opening. mixed: the nodes
    without a J.
    """
    edges = COUNT if closed else COUNT - 1
    line = FrontLine(np.arange(COUNT) + 0.0, np.ones(COUNT), np.full(COUNT, 4.0), edges + 0.0, closed)
    of_edge = np.broadcast_to(stiffness, (edges, 6, 6)).copy()
    if jump:
        of_edge[12:] *= 1 + jump
    segments = segments_of(line.s, line.total, closed, of_edge, np.zeros((edges, 3, 3)))
    k = scale * np.eye(3)[np.zeros(COUNT, int)]
    g = scale**2 * np.ones(COUNT)
    j = g * np.where(np.arange(COUNT) == 6, 1 + excess, 1.0) ** 2
    sides = [
        (1 + jump * (n % 2), 1 + other.get("apart", jump) * (n % 2)) for n in range(len(segments.start))
    ]
    limits = [np.tile([scale * own, 0, 0, 0, opening, 0], (2, 1)) for own, opening in sides]
    changes = np.full(COUNT, spread * scale), np.full(COUNT, other.get("by_pieces", 0.0))
    mixed = np.isin(np.arange(COUNT), other.get("mixed", ()))
    return errors(k, j, g, *changes, line, segments, limits, mixed)


@given(scale=st.floats(1e-6, 1e6), excess=st.floats(0, 0.2), spread=st.floats(0, 0.1))
@settings(max_examples=20)
def test_it_has_the_unit_of_k_and_each_sign_raises_it(scale, excess, spread):
    least = found()
    error = found(scale, excess, spread)
    assert (least > 0).all() and (error >= scale * least * (1 - 1e-12)).all()
    assert error == pytest.approx(scale * found(1.0, excess, spread))
    assert (found(scale, excess + 0.01, spread)[6] > error[6]) and (
        found(scale, excess, spread + 0.01) > error
    ).all()
    assert error[6] >= scale * excess


def test_where_the_opening_jumps_it_is_half_the_jump_and_halves_along_the_front():
    error = found(jump=0.4)
    # K 1.4 times the jump of 0.4 over an opening of 1.4, and the weight
    assert error[12] == pytest.approx(WEIGHTS.change * 0.2, rel=0.01) and (np.diff(error[12:16]) < 0).all()
    assert error[14] == pytest.approx(WEIGHTS.change * 0.05, rel=0.01)


def test_k_that_jumps_as_the_stiffness_does_is_no_error():
    """The lips' opening goes on across the boundary of two materials, whatever K is in each."""
    assert found(jump=2.0, apart=0.0) == pytest.approx(found())


def test_j_tells_nothing_where_the_tube_holds_other_materials():
    """Node 6 has a J that is off; where it is mixed the others' median stands for it, none if all are."""
    assert found(excess=0.1)[6] > 0.1
    assert found(excess=0.1, mixed=[6]) == pytest.approx(found())
    assert found(excess=0.1, mixed=range(COUNT)) == pytest.approx(found())
    crystals = found(excess=0.1, mixed=[0, 1], stiffness=COPPER)
    assert np.ptp(crystals) == 0  # in crystals J varies as the axes turn: the median holds for all


def test_k_that_changes_with_the_splines_pieces_is_off_by_no_less():
    assert (found(by_pieces=0.1) >= 0.1).all()


def test_it_grows_towards_the_ends_of_an_open_front():
    error = found(closed=False)
    assert (np.diff(error[:6]) < 0).all() and error[0] > 5 * error[COUNT // 2]
    assert error == pytest.approx(error[::-1])


def test_no_k_has_no_error():
    assert (found(scale=0.0) == 0).all()


def test_the_ratios_of_moduli_are_those_of_the_material_however_it_lies():
    turns = quaternion_to_matrix(random_orientations(8, np.random.default_rng(1)))
    zener = 2 * 75.4 / (168.4 - 121.4)
    cubic = 6 / 5 * (np.sqrt(zener) - 1 / np.sqrt(zener)) ** 2  # Ranganathan & Ostoja-Starzewski
    copper, isotropic = mean_moduli(turned(COPPER, turns)), mean_moduli(ISOTROPIC[None])
    assert copper.anisotropy == pytest.approx(cubic)
    assert np.ptp(copper.voigt_bulk / copper.voigt_shear) == pytest.approx(0, abs=1e-9)
    assert isotropic.anisotropy == pytest.approx(0, abs=1e-12)
    assert isotropic.voigt_bulk / isotropic.voigt_shear == pytest.approx(2 * 1.3 / (3 * 0.4))
    assert found(stiffness=COPPER).min() > 1.5 * found().max()
