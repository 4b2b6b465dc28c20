"""Where two parts of a crack meet in edges beside each other, the triangle between these is closed."""

import numpy as np
import pytest

from craftmesh.insertion.fins import SLIT, Fronts, without_slits
from craftmesh.surface.front import front_edges
from craftmesh.types import CRACK, Surface


def halves(width: float) -> Surface:
    """Two parts of a crack: one has the edge from (0, 0, 0) to (0, 2, 0), one a node beside it."""
    points = np.array([[0, 0, 0], [0, 2, 0], [-2, 1, 0], [width, 1.8, 0], [2, 1, 0.5]], float)
    facets = np.array([[0, 1, 2], [0, 4, 3], [3, 4, 1]])
    sides = np.full((3, 2), 7, np.int32)
    return Surface(points, facets, sides, np.full(3, CRACK, np.uint8))


def outer(surface: Surface) -> Fronts:
    return Fronts(surface.points, np.array([[1, 2], [2, 0], [0, 4], [4, 1]]))


@pytest.mark.parametrize("width", [0.0, 1e-4, 0.019])
def test_a_narrow_slit_is_closed(width):
    surface = halves(width)
    closed = without_slits(surface, outer(surface), 1.0)
    assert len(closed.facets) == 4 and closed.kind[3] == CRACK and closed.sides[3].tolist() == [7, 7]
    assert front_edges(closed).tolist() == [[0, 2], [0, 4], [1, 2], [1, 4]]
    edges = closed.facets[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    assert len(np.unique(edges, axis=0)) == len(edges), "facets side by side turn alike"


def test_what_is_wider_or_ends_at_the_front_stays_open():
    wide = halves(2 * SLIT)
    assert without_slits(wide, outer(wide), 1.0) is wide
    narrow = halves(1e-4)
    ends = Fronts(narrow.points, np.concatenate([outer(narrow).edges, [[0, 1], [0, 3], [3, 1]]]))
    assert without_slits(narrow, ends, 1.0) is narrow
