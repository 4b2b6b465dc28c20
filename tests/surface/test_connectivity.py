"""Points with the same coordinates are told by one of them, others with the same key by themselves."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from craftmesh.surface.connectivity import lowest_equal_point


# pi along x has the key of 1 along z
@given(st.lists(st.sampled_from([-1.0, 0.0, -0.0, 1.0, 1e-300, np.e, np.pi]), max_size=60))
def test_equal_points_have_the_lowest_of_them(numbers):
    points = np.array(numbers[: len(numbers) // 3 * 3], float).reshape(-1, 3)
    rows = [tuple(point) for point in points.tolist()]
    assert lowest_equal_point(points).tolist() == [rows.index(row) for row in rows]


def test_other_points_with_one_key_stay_apart():
    points = np.array([[np.pi, 0, 0], [0, 0, 1], [0, 0, 1], [np.pi, 0, 0]])
    assert lowest_equal_point(points).tolist() == [0, 1, 1, 0]
