"""Splines along a front follow what varies as fast as the front bends."""

import numpy as np

from craftmesh.fracture.fit import OF_BEND, FrontLine, segment_basis
from craftmesh.fracture.segments import Segments
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
