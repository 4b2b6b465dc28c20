"""Splines along a front follow what varies as fast as the front bends."""

import numpy as np

from craftmesh.fracture import fit
from craftmesh.fracture.fit import OF_BEND, FrontLine, segment_basis
from craftmesh.fracture.segments import Segments, segments_of
from craftmesh.mesh.front_curve import SHORTEST

KNOTS = 4.0


def test_pieces_are_shorter_where_the_front_bends_but_half_as_long_at_least():
    s = np.arange(120.0)
    bend = np.where((s > 40) & (s < 60), 3.5, np.where((s > 80) & (s < 100), 0.5, 1e6))
    line = FrontLine(s, np.ones(120), bend, 120.0, True)
    isotropic = np.diag([1, 1, 1, 0.5, 0.5, 0.5])
    whole, elastic = (np.zeros(1), np.full(1, 120.0)), (isotropic[None], np.zeros((1, 3, 3)))
    ring = Segments(*whole, *elastic, np.zeros(120, np.int64), True, 120.0)
    breaks = segment_basis(line, ring, 0, KNOTS).breaks
    middle, length = (breaks[1:] + breaks[:-1]) / 2, np.diff(breaks)
    # a whole number of pieces goes round: lengths are those wished within some percent
    for low, high, wished in ((5, 35, KNOTS), (44, 56, OF_BEND * 3.5), (84, 96, SHORTEST * KNOTS)):
        own = length[(middle > low) & (middle < high)]
        assert np.abs(own / wished - 1).max() < 0.05


def test_no_test_is_centred_where_the_material_changes():
    """Wherever on a closed front its first node lies, by whatever rounding arc lengths add up."""
    rng = np.random.default_rng(0)
    for _ in range(200):
        steps = rng.uniform(0.5, 1.5, 24)
        s, total = np.append(0.0, np.cumsum(steps[:-1])), steps.sum()
        own = 1.0 + np.roll(np.arange(24) // 8, rng.integers(24))
        stiffness = own[:, None, None] * np.diag([1, 1, 1, 0.5, 0.5, 0.5])
        segments = segments_of(s, total, True, stiffness, np.zeros((24, 3, 3)))
        line = FrontLine(s, np.ones(24), np.full(24, 1e6), total, True)
        for segment in range(3):
            found = fit.tests_on(line, segments, segment)
            assert len(found.centres) == 7
            assert min(found.before.min(), found.behind.min()) > 0.49


def test_j_is_fitted_where_it_is_valid_alone():
    """Whatever J is at nodes without a valid one, it stays at the others, and all other values stay."""
    s, at = np.arange(40.0), np.arange(0.05, 40, 0.1)
    line = FrontLine(s, np.ones(40), np.full(40, 1e6), 40.0, True)
    isotropic = np.diag([1, 1, 1, 0.5, 0.5, 0.5])
    whole, elastic = (np.zeros(1), np.full(1, 40.0)), (isotropic[None], np.zeros((1, 3, 3)))
    ring = Segments(*whole, *elastic, np.zeros(40, np.int64), True, 40.0)
    has_j = np.abs(s - 20) > 5
    even = np.full((len(at), 2), 0.1)
    spoiled = even + np.outer(100.0 * (np.abs(at - 20) < 3), [0, 1])

    def values(weights, known):
        return fit.fit_segment(line, ring, 0, at, weights, KNOTS, known).at(s)

    assert np.abs(values(even, has_j) - 1).max() < 0.01
    # hats of two edges on both sides keep off what is three edges away
    assert np.abs(values(spoiled, has_j)[has_j, 1] - 1).max() < 0.01
    assert np.abs(values(spoiled, has_j | True)[has_j, 1] - 1).max() > 1
    assert np.abs(values(spoiled, has_j)[:, 0] - values(even, has_j)[:, 0]).max() < 1e-12
    nowhere = np.zeros(40, bool)
    assert (values(spoiled, nowhere) == values(spoiled, ~nowhere)).all()
