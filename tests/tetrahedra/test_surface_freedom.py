"""Points of the surface move within box planes and within a flat crack, those of its front not at all."""

from dataclasses import replace

import numpy as np
import pytest
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.surface.front import front_edges
from craftmesh.tetrahedra.surface_freedom import freedom
from craftmesh.types import CRACK

STEPS = np.random.default_rng(3).normal(size=(20, 3))


INSIDE = hexagon((2, 2), 1.4)


def cracked_box(inside=INSIDE):
    return structured_box((4, 4, 2), lambda c: np.where(c[:, 0] < 2, 1, 2), plane_crack(2, 1, inside))[0]


def steps_of(surface):
    """Return what becomes of the same steps at each point (n, s, 3)."""
    return np.einsum("nij,sj->nsi", freedom(surface), STEPS)


def test_points_stay_in_the_planes_that_hold_them():
    surface = cracked_box(lambda centres: centres[:, 1] < 3)
    steps, points = steps_of(surface), surface.points
    for axis, top in enumerate((4, 4, 2)):
        held = (points[:, axis] == 0) | (points[:, axis] == top)
        assert (steps[held][:, :, axis] == 0).all()
    crack = np.unique(surface.facets[surface.kind == CRACK])
    assert steps[crack][:, :, 2] == pytest.approx(0, abs=1e-12)
    loose = np.setdiff1d(np.flatnonzero(((points > 0) & (points < (4, 4, 2))).all(axis=1)), crack)
    assert (steps[loose] == STEPS).all()


def test_the_front_stays_and_the_rest_of_a_flat_crack_slides():
    surface = cracked_box()
    steps = steps_of(surface)
    front = np.unique(front_edges(surface))
    inner = np.setdiff1d(surface.facets[surface.kind == CRACK], front)
    assert (steps[front] == 0).all() and len(inner)
    assert steps[inner][:, :, :2] == pytest.approx(np.broadcast_to(STEPS[:, :2], (len(inner), 20, 2)))


def test_a_bent_crack_stays():
    surface = cracked_box()
    points = surface.points.copy()
    front = np.unique(front_edges(surface))
    inner = np.setdiff1d(surface.facets[surface.kind == CRACK], front)
    points[inner[0], 2] += 0.1
    assert (steps_of(replace(surface, points=points))[inner] == 0).any(axis=(1, 2)).any()
    assert (steps_of(replace(surface, points=points))[inner[0]] == 0).all()
