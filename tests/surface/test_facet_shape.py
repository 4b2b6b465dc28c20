"""Shapes of single facets against plain vectors and angles."""

import numpy as np
import pytest
from plain_distances import segment_distances, triangle_distances

from craftmesh.surface.kernels.facet_shape import (
    angle_score,
    area_vector,
    cosine_range,
    facet_distance2,
    keeps_normal,
    score_of_angle,
    segment_distance2,
)

RNG = np.random.default_rng(12)
POINTS = RNG.normal(size=(300, 3)) * [3.0, 1.0, 0.3]
TRIANGLES = [tuple(map(int, RNG.choice(300, 3, replace=False))) for _ in range(200)]


def angles(a, b, c):
    corner = POINTS[[a, b, c]]
    sides = [np.roll(corner, -1, axis=0) - corner, np.roll(corner, 1, axis=0) - corner]
    u, v = (side / np.linalg.norm(side, axis=1)[:, None] for side in sides)
    return np.degrees(np.arccos((u * v).sum(axis=1)))


def test_angles_and_their_score():
    for triangle in TRIANGLES:
        found = np.degrees(np.arccos(cosine_range(POINTS, *triangle)))
        known = angles(*triangle)
        assert found == pytest.approx([known.min(), known.max()], abs=1e-5)
        # 1 at 15 degrees and at 135, by the cosines' distance from those of a flat facet
        small = (1 - np.cos(np.radians(known.min()))) / (1 - np.cos(np.radians(15)))
        large = (1 + np.cos(np.radians(known.max()))) / (1 + np.cos(np.radians(135)))
        assert angle_score(POINTS, *triangle) == pytest.approx(min(small, large), abs=1e-8)
    assert score_of_angle(15.0) == pytest.approx(1) and score_of_angle(60.0) == pytest.approx(
        14.674, abs=1e-3
    )


def test_a_normal_is_kept_within_its_angle_alone():
    reference = np.zeros((1, 3))
    for a, b, c in TRIANGLES:
        normal = np.cross(POINTS[b] - POINTS[a], POINTS[c] - POINTS[a])
        assert area_vector(POINTS, a, b, c) == pytest.approx(normal)
        aside = POINTS[b] - POINTS[a]
        for degrees in (10.0, 30.0, 60.0, 120.0):
            turn = np.radians(degrees)
            reference[0] = np.cos(turn) * normal / np.linalg.norm(normal)
            reference[0] += np.sin(turn) * aside / np.linalg.norm(aside)
            kept = [
                keeps_normal(POINTS, reference, 0, a, b, c, np.cos(turn + off)) for off in (-1e-6, 1e-6)
            ]
            assert kept == [False, True]
    assert not keeps_normal(POINTS, reference, 0, 5, 5, 6, -1.0)


def test_distances_are_those_of_the_nearest_place():
    bound, rows = 4.0, range(0, 300, 60)
    for a, b, c in TRIANGLES:
        at, corners = POINTS[list(rows)], np.repeat(POINTS[[[a, b, c]]], len(rows), axis=0)
        known = triangle_distances(at, corners) ** 2
        found = [facet_distance2(POINTS, a, b, c, POINTS, row, bound) for row in rows]
        assert found == pytest.approx(np.minimum(known, bound), abs=1e-9)
        found = [segment_distance2(POINTS, a, b, POINTS, row) for row in rows]
        assert found == pytest.approx(segment_distances(at, corners[:, 0], corners[:, 1]) ** 2, abs=1e-9)
