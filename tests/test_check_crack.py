"""The crack's check finds each breach in a square of two triangles."""

import numpy as np
import pytest

from craftmesh.check_crack import check_crack
from craftmesh.types import Crack

SQUARE = {
    "points": np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float),
    "triangles": np.array([[0, 1, 2], [0, 2, 3]]),
    "uv": np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float),
    "fronts": (np.array([1, 2, 3]),),
}


def test_sound_crack_has_no_breach():
    assert check_crack(Crack(**SQUARE)) == []


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"fronts": ()}, "no front"),
        ({"fronts": (np.array([0, 2]),)}, "front 1: 1 of 1 edges are not on the crack's boundary"),
        ({"triangles": np.zeros((0, 3)), "fronts": ()}, "no triangles"),
        (
            {"triangles": np.array([[0, 1, 2], [0, 2, 3], [0, 2, 1]])},
            "1 edges with more than two triangles",
        ),
        ({"triangles": np.array([[0, 1, 2], [0, 2, 3], [3, 3, 0]])}, "1 triangles without area"),
        ({"uv": np.array([[0, 0], [1, 0], [1, 1], [1, 0.2]], float)}, "1 triangles are folded"),
    ],
)
def test_each_breach_is_said(change, said):
    assert any(said in breach for breach in check_crack(Crack(**(SQUARE | change))))
