"""Sectors between the facets round an edge: found as by plain arithmetic."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from structured_box import structured_box

from craftmesh.surface.wedges import wedges


def fan(angles, labels, turned):
    """Facets round the edge from 0 to (0, 0, 1) at `angles`; labels[i] lies between i and i + 1."""
    points = [[0, 0, 0], [0, 0, 1]] + [[np.cos(a), np.sin(a), 0.5] for a in np.radians(angles)]
    facets, sides = [], []
    for i in range(len(angles)):
        ahead, behind = labels[i], labels[i - 1]
        facets.append([1, 0, 2 + i] if turned[i] else [0, 1, 2 + i])
        sides.append([ahead, behind] if turned[i] else [behind, ahead])
    return np.array(points, float), np.array(facets), np.array(sides)


@settings(max_examples=50)
@given(st.integers(0, 2**32 - 1))
def test_sectors_of_a_fan_have_their_angles_and_labels(seed):
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 6))
    angles = np.sort(rng.uniform(0, 360, count))
    labels = rng.permutation(count) + 1
    order = rng.permutation(count)
    points, facets, sides = fan(angles, labels, rng.random(count) < 0.5)
    found = wedges(points, facets[order], sides[order], np.array([[0, 1]]))
    gaps = dict(zip(labels.tolist(), (np.roll(angles, -1) - angles) % 360))
    assert dict(zip(found.label.tolist(), found.angle)) == pytest.approx(gaps)


def test_wedges_of_a_cube_are_right_angles_and_only_the_chosen_edges_count():
    surface, _ = structured_box((1, 1, 1), lambda centres: np.ones(len(centres), int))
    edges = np.array([[0, 1]])
    found = wedges(surface.points, surface.facets, surface.sides, edges)
    assert len(found.edge) == 2 and (found.edge == edges).all()
    assert found.angle[found.label == 1] == pytest.approx([90]) or found.angle.tolist() == pytest.approx(
        [180, 180]
    )
