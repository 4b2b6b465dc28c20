"""Between vertices, facets of the crack keep near the given crack, edges of its front near the front."""

import numpy as np
import pytest
from few_facets import fan, prepared, sheet
from numba import typeof
from plain_distances import from_facets, samples
from random_cases import disc
from structured_box import structured_box
from unchanged import OPEN

from craftmesh import Sizing, gradate
from craftmesh.cracks.crack_tolerances import GRADATED
from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.gradation.kernels.collapse import collapse
from craftmesh.gradation.kernels.crack_guard import leaves_crack, leaves_front
from craftmesh.gradation.kernels.result_codes import DISTANCE, DONE
from craftmesh.gradation.kernels.star import star_at
from craftmesh.insertion.insert import insert_crack
from craftmesh.sizing.sizing import densify
from craftmesh.surface.front import front_edges
from craftmesh.types import CRACK, Crack, Surface


def hollow(height: float) -> Surface:
    """Return a crack of two rings of six points round point 0, which is so high."""
    points, triangles = disc(rings=2, spokes=6)
    points = np.column_stack([2 * points, np.where(np.arange(13) == 0, height, 0.0)])
    return sheet(triangles, (1, 1), CRACK, points)


def given_as(surface: Surface) -> Crack:
    """Return the crack that `surface` is made of."""
    return Crack(surface.points, surface.facets, (np.append(np.arange(7, 13), 7),))


@pytest.mark.parametrize("bound, reason", [(np.inf, DONE), (0.29, DONE), (0.28, DISTANCE)])
def test_a_collapse_leaves_the_crack_no_farther_than_its_bound(bound, reason):
    """Without its hub the hexagon is flat; its places are up to 0.283 off the given one."""
    _, references = prepared(hollow(0.3), given_as(hollow(0.3)))
    assert collapse(*references, OPEN._replace(crack_facets=bound), 1, 0, False, np.inf) == reason


def test_flat_and_curved_given_or_not_compile_one_set_of_kernels():
    """All kernels take the state; read-only points of a given crack compiled them once more, 80 CPU s."""
    cracks = [
        (hollow(height), given) for height in (0.0, 0.3) for given in (None, given_as(hollow(height)))
    ]
    assert len({typeof(prepared(*crack)[0].guards) for crack in cracks}) == 1


@pytest.mark.parametrize("given, leaves", [(0.3, True), (0.0, False), (-0.3, False)])
def test_facets_that_are_off_the_crack_may_stay_or_come_nearer(given, leaves):
    """The hub goes from 0.1 to -0.1, which is farther from the crack, as far off, or nearer to it."""
    state, references = prepared(hollow(0.1), given_as(hollow(given)))
    star = star_at(references[0], 0)
    limit = 0.04  # FAR times this is more than what the eighths next to the hub are off
    assert not leaves_crack(references[0], star, limit)
    state.mesh.points[star.tip, 2] = -0.1
    assert leaves_crack(references[0], star, limit) == leaves


@pytest.mark.parametrize("bound, leaves", [(0.07, True), (0.09, True), (0.11, False)])
def test_vertices_are_kept_to_the_crack_as_the_middles_of_facets_are(bound, leaves):
    """A hub that goes 0.1 off leaves the middles of its edges 0.05 off."""
    state, references = prepared(hollow(0.3), given_as(hollow(0.3)))
    star = star_at(references[0], 0)
    state.mesh.points[star.tip, 2] = 0.4
    assert leaves_crack(references[0], star, bound) == leaves


@pytest.mark.parametrize("bound, leaves", [(0.03, True), (0.07, True), (0.08, False)])
def test_a_front_vertex_slides_as_far_as_the_edge_behind_it_stays_near_the_front(bound, leaves):
    """Half way to the next vertex its edge spans 45 degrees instead of 30; its middle is 0.076 off."""
    turn = np.radians(np.arange(0, 361))
    circle = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    front = np.append(np.arange(360), 0)
    state, references = prepared(
        fan(12, sides=(1, 1), kind=CRACK), Crack(circle, [[0, 120, 240]], (front,))
    )
    star = star_at(references[0], 1)
    assert not leaves_front(references[0], star, bound)
    state.mesh.points[star.tip] = circle[15]
    assert leaves_front(references[0], star, bound) == leaves


def test_gradation_keeps_to_the_given_crack_where_the_inserted_one_is_off_it():
    """Without the given crack, vertices were up to 0.02 l_min off it and facets 0.06."""
    surface, _ = structured_box((9, 9, 9), lambda centres: 1 + (centres[:, 0] > 4.5))
    box, l_min = np.array([[0.0] * 3, [9.0] * 3]), 1.0
    x, y = np.meshgrid(np.arange(-2, 11, 0.25), np.arange(-2, 6.3, 0.25), indexing="ij")
    points = np.stack([x, y, 4.4 + 0.4 * np.sin(0.9 * x + 0.3 * y)], axis=-1).reshape(-1, 3)
    a = (np.arange(x.shape[0] - 1)[:, None] * x.shape[1] + np.arange(x.shape[1] - 1)).ravel()
    b = a + x.shape[1]
    triangles = np.concatenate([np.stack([a, b, b + 1], axis=1), np.stack([a, b + 1, a + 1], axis=1)])
    crack = crack_from_triangles(points, triangles, None, box)
    sources = np.concatenate([densify(crack.points[f], 0.1) for f in crack.fronts])
    sizing = Sizing(l_min, 1.0, 2.0, 2.0, 4.0, 1.0, sources)
    before, _ = insert_crack(surface, crack, sizing)
    after, _ = gradate(before, sizing, crack=crack)
    off = []
    for found in (before, after):
        facets = found.facets[found.kind == CRACK]
        places = samples(found.points, facets)
        off.append(from_facets(places, crack.points, crack.triangles)[0].max())
        nodes = found.points[np.unique(facets)]
        # Where the crack meets the box, vertices go to and fro between the two.
        assert from_facets(nodes, crack.points, crack.triangles)[0].max() < 0.005 * l_min
    # The guard measures seven places a facet, these are more.
    assert off[1] <= 1.1 * max(off[0], GRADATED * l_min)
    assert len(front_edges(after))
