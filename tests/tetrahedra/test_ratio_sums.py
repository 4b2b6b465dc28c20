"""What a table of faces gives of all its tets at once is what the tets give one by one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from craftmesh.tetrahedra.kernels.tet_quality import (
    FLAT,
    INVERTED,
    VOLUME_LENGTH,
    aspect_ratio_at,
    quality_of,
)
from craftmesh.tetrahedra.kernels.tet_ratio_sums import (
    TABLE_ROWS,
    RatioCone,
    fill_table,
    filled,
    ratio_sum,
)


def star(seed):
    """Points, and the faces (f, 3) of their hull, which turn right-handed towards its inside."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(int(rng.integers(4, 30)), 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    points = points * rng.uniform(0.8, 1.2, (len(points), 1)) * [1, rng.uniform(0.2, 1), 1]
    hull = ConvexHull(points)
    a, b, c = points[hull.simplices].transpose(1, 0, 2)
    outward = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) > 0
    faces = np.where(outward[:, None], hull.simplices[:, ::-1], hull.simplices).astype(np.int64)
    return points, faces


def ratios_of(points, faces, limit=FLAT):
    room = filled(len(faces)) + 3
    table = np.full((TABLE_ROWS, room), np.nan)
    fill_table(points, faces, len(faces), table)
    return RatioCone(table, np.full(room, np.nan), len(faces), limit)


@settings(max_examples=60)
@given(st.integers(0, 10**6))
def test_the_sum_of_ratios_is_that_of_the_tets_one_by_one(seed):
    points, faces = star(seed)
    apex = points.mean(axis=0) + np.random.default_rng(seed).normal(0, 0.2, 3) * np.ptp(points, axis=0)
    plain = sum(aspect_ratio_at(points, *face, *apex) for face in faces)
    cone = ratios_of(points, faces)
    assert ratio_sum(cone, *apex) == pytest.approx(plain, rel=1e-9)


def test_a_sum_with_a_flat_or_an_inverted_tet_is_inverted():
    points, faces = star(3)
    for apex in (points[faces[0]].mean(axis=0), [9.0, 0.0, 0.0], points[0]):
        assert ratio_sum(ratios_of(points, faces), *apex) >= INVERTED


def test_a_sum_is_inverted_where_a_tet_is_not_over_the_limit():
    points, faces = star(5)
    corners = np.vstack([points, points.mean(axis=0)])
    least = min(quality_of(corners, *face, len(points), VOLUME_LENGTH) for face in faces)
    assert least > 0.1
    assert ratio_sum(ratios_of(points, faces, least * (1 + 1e-9)), *corners[-1]) >= INVERTED
    assert ratio_sum(ratios_of(points, faces, least * (1 - 1e-9)), *corners[-1]) < INVERTED
