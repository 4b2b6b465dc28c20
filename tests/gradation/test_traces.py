"""A trace of the crack may go along the crack as far as junction lines go, but no farther off it."""

import numpy as np
import pytest
from few_facets import prepared
from unchanged import OPEN

from craftmesh.gradation.kernels.collapse import collapse
from craftmesh.gradation.kernels.result_codes import DISTANCE, DONE
from craftmesh.types import CRACK, INTERFACE, Surface

ROWS = 6


def crossed(bulge) -> tuple[Surface, int]:
    """Return a crack in the plane z = 0, crossed by a boundary at x = 0, and the middle of their trace.

    There the crack and the boundary go by `bulge` (3,) out of their ways.
    """
    columns = [(-2, 0), (-1, 0), (0, 0), (1, 0), (2, 0), (0, 2), (0, 1), (0, -1), (0, -2)]
    points = np.array([[x, y, z] for x, z in columns for y in range(ROWS)], float)
    trace = 2 * ROWS + 2
    points[trace] += bulge
    facets, sides, kind = [], [], []
    for p, q, both, of in (
        *((p, p + 1, (1 + p // 2,) * 2, CRACK) for p in range(4)),
        *((p, q, (1, 2), INTERFACE) for p, q in ((5, 6), (6, 2), (2, 7), (7, 8))),
    ):
        for row in range(ROWS - 1):
            a, b = ROWS * p + row, ROWS * q + row
            facets += [[a, b, b + 1], [a, b + 1, a + 1]]
            sides += [both, both]
            kind += [of, of]
    return Surface(points, facets, sides, kind), trace


@pytest.mark.parametrize(
    "bulge, reason",
    [
        ((0.12, 0, 0), DONE),
        ((0.18, 0, 0), DISTANCE),
        ((0, 0, 0.03), DONE),
        ((0, 0, 0.05), DISTANCE),
        ((0.12, 0, 0.05), DISTANCE),
    ],
)
def test_a_trace_is_kept_along_the_crack_as_lines_are_and_off_it_as_the_crack_is(bulge, reason):
    surface, trace = crossed(bulge)
    _, references = prepared(surface)
    limits = OPEN._replace(distance=0.15, crack_distance=0.04)
    assert collapse(*references, limits, trace + 1, trace, False, np.inf) == reason
