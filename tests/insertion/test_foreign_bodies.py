"""Cracks in surfaces of other makers: bodies that do not fill their box, with facets of any kind."""

import numpy as np
import pytest
import trimesh

from craftmesh import Surface, crack_from_triangles, insert_crack
from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.series import prescribed_crack
from craftmesh.surface.check_surface import check_surface
from craftmesh.surface.front import front_edges
from craftmesh.surface.measure import area_vectors
from craftmesh.types import CRACK

RADIUS = 10.0


def ball():
    """A ball of one grain, and within it a smaller one, from trimesh; points of no facet among them."""
    outer, inner = trimesh.creation.icosphere(3, RADIUS), trimesh.creation.icosphere(2, 4.0)
    points = np.concatenate([[[99.0, 0, 0]], outer.vertices, inner.vertices])
    facets = np.concatenate([outer.faces + 1, inner.faces + 1 + len(outer.vertices)])
    sides = np.repeat([[1, 0], [2, 1]], [len(outer.faces), len(inner.faces)], axis=0)
    return Surface.of_facets(points, facets, sides)


def penny(surface, **options):
    return prescribed_crack(surface.box, CrackOptions(**options))


def area_of(surface):
    crack = surface.facets[surface.kind == CRACK]
    return np.linalg.norm(area_vectors(surface.points, crack), axis=1).sum()


def test_a_crack_within_a_ball_crosses_its_inner_grain():
    surface = ball()
    result, report = insert_crack(surface, penny(surface, centre=(0.2, 0.1, 0.3), radius=6.0))
    assert check_surface(Surface(*compacted(result))) == [] and report["crack_grains"] == 2
    assert report["crack_area"] == pytest.approx(np.pi * 36, rel=0.02)  # chords of the front


def compacted(surface):
    """Return the arrays of a surface without points of no facet, of which the ball has one."""
    used = np.unique(surface.facets)
    return surface.points[used], np.searchsorted(used, surface.facets), surface.sides, surface.kind


@pytest.mark.parametrize(
    ("centre", "normal"), [((8.0, 0.2, 0.1), (0.1, 0.2, 1)), ((0.0, -9.0, 0.5), (0.3, 0, 1))]
)
def test_a_crack_that_leaves_a_ball_short_of_its_box_ends_on_the_ball(centre, normal):
    """The front's ends lie outside the ball, on its box, where there is nothing to end on."""
    surface = ball()
    result, report = insert_crack(surface, penny(surface, centre=centre, normal=normal, radius=5.0))
    assert check_surface(Surface(*compacted(result))) == []
    unit = np.array(normal) / np.linalg.norm(normal)
    crack = result.points[result.facets[result.kind == CRACK]]
    assert np.abs((crack - centre) @ unit).max() < 1e-9
    # points of the ball move onto the crack along it: 0.05 was measured, 0.04 of an edge
    assert np.linalg.norm(crack, axis=2).max() < 1.01 * RADIUS
    front = result.points[np.unique(front_edges(result))]
    off = np.linalg.norm(front - centre, axis=1) - 5.0
    assert np.abs(off).max() < 0.01  # TOUCHING, 1e-3 of edges of 1.4
    assert report["crack_area"] == pytest.approx(lens(np.array(centre), unit, 5.0), rel=0.02)


def lens(centre, normal, radius):
    """Return the area that a penny has in common with the ball, from a fine grid of its plane."""
    u = np.cross(normal, [0.0, 0.3, 0.7])
    u /= np.linalg.norm(u)
    s = np.stack(np.meshgrid(*2 * [np.linspace(-radius, radius, 801)]), axis=-1).reshape(-1, 2)
    places = centre + s[:, :1] * u + s[:, 1:] * np.cross(normal, u)
    hit = (np.linalg.norm(s, axis=1) <= radius) & (np.linalg.norm(places, axis=1) <= RADIUS)
    return hit.mean() * (2 * radius) ** 2


def test_a_given_surface_in_a_pipe_spans_its_wall():
    pipe = trimesh.creation.annulus(4, RADIUS, 20, sections=32).subdivide_to_size(2.5)
    surface = Surface.of_facets(pipe.vertices, pipe.faces, np.tile([5, 0], (len(pipe.faces), 1)))
    assert {5, 6} <= set(surface.kind) <= {0, 1, 2, 3, 4, 5, 6}  # its ends lie on planes of its box
    square = np.array([[0, -3, 0.4], [12, -3, 0.4], [12, 3, 0.2], [0, 3, 0.2]])
    crack = crack_from_triangles(square, np.array([[0, 1, 2], [0, 2, 3]]), None, surface.box)
    result, report = insert_crack(surface, crack)
    assert check_surface(result) == [] and report["crack_facets_outside_material"] > 0
    corners = result.points[result.facets[result.kind == CRACK]]
    distance = np.linalg.norm(corners[:, :, :2], axis=2)
    assert distance.min() > 4 * np.cos(np.pi / 32) - 0.1 and distance.max() < RADIUS + 0.1


def test_what_parts_the_ball_is_a_disc_without_a_front():
    surface = ball()
    result, report = insert_crack(surface, penny(surface, centre=(0, 0, 7.0), radius=30.0))
    assert check_surface(Surface(*compacted(result))) == [] and not len(front_edges(result))
    assert report["crack_area"] == pytest.approx(
        np.pi * (RADIUS**2 - 7.0**2), rel=0.02
    )  # facets are chords
