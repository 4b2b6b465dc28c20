"""Pictures are images, the same bytes each time, and show what they are given."""

import io

import numpy as np
import pytest
from matplotlib.image import imread

from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.series import prescribed_crack
from craftmesh.report.pictures import (
    _added,
    along_front,
    as_webp,
    crack_by_increment,
    deformed_body,
    value_on_plane,
)
from craftmesh.types import Crack

VIEW = np.array([1.0, -0.8, 0.6])
BOX = np.array([[0.0, 0.0, 0.0], [10.0, 10.0, 10.0]])
TET = np.array([[0.0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]]), np.array([[0, 1, 2, 3]])


def cracks(radii):
    options = CrackOptions(shape="penny", centre=(5.0, 5.0, 5.0), increments=tuple(radii))
    return {f"{k:03d}": prescribed_crack(BOX, options, k) for k in range(len(radii))}


def intensities(k2):
    s = np.linspace(0, 6, 20)
    columns = {"front": np.ones(20, int), "s": s, "K_I": np.sin(s), "K_II": k2 * np.cos(s)}
    return {"000": columns | {"K_III": 0 * s, "kink_angle": 0 * s}}


def stress(value):
    return value_on_plane(*TET, np.array([value]), np.array([1.0, 1.0, 1.0]), 2, "stress")


PICTURES = [
    (
        lambda: crack_by_increment(cracks([2.0, 3.0]), BOX, VIEW),
        lambda: crack_by_increment(cracks([2.0, 4.0]), BOX, VIEW),
    ),
    (lambda: along_front(intensities(1.0)), lambda: along_front(intensities(2.0))),
    (
        lambda: deformed_body(TET[0], TET[1][:, :3], TET[0] * [0.1, 0, 0], VIEW),
        lambda: deformed_body(TET[0], TET[1][:, :3], TET[0] * [0, 0.1, 0], VIEW),
    ),
    (lambda: stress(1.0), lambda: stress(2.0)),
]


@pytest.mark.parametrize(("picture", "other"), PICTURES, ids=["crack", "front", "body", "stress"])
def test_a_picture_is_the_same_for_the_same_and_another_for_another(picture, other):
    first = as_webp(picture())
    assert first == as_webp(picture()) != as_webp(other())
    pixels = imread(io.BytesIO(first), format="webp") / 255
    assert pixels.shape[0] > 300 and np.ptp(pixels[..., :3]) > 0.5


def test_a_strip_that_is_laid_again_is_not_what_the_next_increment_added():
    def strips(*heights):  # rows of points along y at x = 1, 3, 4, ..., each at its height
        rows = [[[x, y, z] for y in (0.0, 5.0, 10.0)] for x, z in zip((1.0, 3.0, 4.0, 5.0), heights)]
        quads = [[i, i + 1, i + 4, i + 3] for k in range(len(rows) - 1) for i in (3 * k, 3 * k + 1)]
        triangles = [[q[i] for i in half] for q in quads for half in ((0, 1, 2), (0, 2, 3))]
        count = 3 * len(rows)
        return Crack(np.concatenate(rows), triangles, (np.arange(count - 3, count),))

    grown = {"0": strips(5, 5), "1": strips(5, 5, 5.4), "2": strips(5, 5, 5.2, 5.3)}
    corners, whose = _added(grown, BOX)
    assert np.bincount(whose).tolist() == [4, 4, 4]
    assert (corners[whose == 2, :, 0] >= 4).all()
