"""Points of the surface move within box planes and along the crack, those of its front not at all."""

from dataclasses import replace

import numpy as np
import pytest
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.cracks.crack_tolerances import TETRAHEDRA
from craftmesh.surface.front import front_edges, median_front_edge
from craftmesh.surface.measure import unit_normals
from craftmesh.tetrahedra.surface_freedom import crack_length, off_surface
from craftmesh.types import CRACK

STEPS = np.random.default_rng(3).normal(size=(20, 3))


INSIDE = hexagon((2, 2), 1.4)


def cracked_box(inside=INSIDE):
    return structured_box((4, 4, 2), lambda c: np.where(c[:, 0] < 2, 1, 2), plane_crack(2, 1, inside))[0]


def steps_of(surface):
    """Return what becomes of the same steps at each point (n, s, 3)."""
    ways = off_surface(surface).ways
    return np.einsum("nki,nkj,sj->nsi", ways, ways, STEPS)


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


def test_a_point_of_a_bent_crack_goes_no_farther_off_its_facets_than_the_crack_may():
    surface = cracked_box()
    points = surface.points.copy()
    front = np.unique(front_edges(surface))
    inner = np.setdiff1d(surface.facets[surface.kind == CRACK], front)
    points[inner[0]] += [0.03, 0.02, 0.1]
    surface = replace(surface, points=points)
    way, reach = steps_of(surface)[inner[0]], off_surface(surface).reach[inner[0]]
    ends = reach * way / np.linalg.norm(way, axis=1, keepdims=True)
    around = (surface.kind == CRACK) & (surface.facets == inner[0]).any(axis=1)
    off = abs(ends @ unit_normals(points, surface.facets[around]).T)
    limit = TETRAHEDRA.facets * median_front_edge(surface)
    assert off.max() <= limit * (1 + 1e-9)
    # 20 ways at random: one goes nearly straight up a facet that is off the mean by most
    assert off.max() > 0.8 * limit


def test_a_flat_crack_sets_no_limit_to_its_points():
    surface = cracked_box()
    assert (off_surface(surface).reach > 1e6).all()


def test_points_of_a_crack_without_a_front_go_as_far_as_those_of_others():
    surface = cracked_box(lambda centres: centres[:, 0] > -1)
    crack = np.unique(surface.facets[surface.kind == CRACK])
    inner = crack[((surface.points[crack] > 0) & (surface.points[crack] < (4, 4, 2))).all(axis=1)]
    points = surface.points.copy()
    points[inner[0]] += [0.03, 0.02, 0.1]
    surface = replace(surface, points=points)
    assert median_front_edge(surface) == 0 and 0.9 < crack_length(surface) <= 1
    reach = off_surface(surface).reach[inner[0]]
    assert TETRAHEDRA.facets < reach < np.inf
