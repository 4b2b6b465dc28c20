"""Kernels of the gradation against slow, plain references on small meshes."""

import weakref
from collections import namedtuple

import numpy as np
import pytest
from few_facets import fan, prepared, sheet, tried
from hypothesis import given, settings
from hypothesis import strategies as st
from structured_box import structured_box
from unchanged import OPEN

from craftmesh.gradation.crack_reference import crack_triangles
from craftmesh.gradation.kernels.collapse_rules import closes_thin_end, link_refusal
from craftmesh.gradation.kernels.facet_grid import gather_candidates
from craftmesh.gradation.kernels.guards import attempt
from craftmesh.gradation.kernels.intersections import star_intersects
from craftmesh.gradation.kernels.one_pass import COLLAPSE, RELAX, one_pass
from craftmesh.gradation.kernels.projection import nearest_triangle, put_on_crack, put_on_front
from craftmesh.gradation.kernels.result_codes import DONE, JUNCTION_TRIANGLE, REFUSALS
from craftmesh.gradation.kernels.sheets import no_sheet
from craftmesh.gradation.kernels.star import star_at
from craftmesh.gradation.locality import BLOCK, block_order
from craftmesh.gradation.passes import (
    Gradation,
    Limits,
    collapse_short,
    edges_to_swap,
    filled_grid,
    swap_all,
    swap_poor,
)
from craftmesh.gradation.state import make_state, surface_of
from craftmesh.kernel_structs import by_reference
from craftmesh.surface.kernels.facet_shape import (
    angle_score,
    facet_distance2,
    score_of_angle,
    segment_distance2,
)
from craftmesh.surface.kernels.triangles import triangles_intersect
from craftmesh.surface.measure import facet_angles
from craftmesh.types import CRACK, Surface

seeds = st.integers(0, 2**32 - 1)


def dense_points(corners: np.ndarray, n: int = 60) -> np.ndarray:
    i, j = np.meshgrid(np.arange(n + 1), np.arange(n + 1))
    weights = np.stack([i, j, n - i - j], -1).reshape(-1, 3) / n
    return weights[(weights >= 0).all(1)] @ corners


@settings(max_examples=40)
@given(seeds)
def test_facet_distance_is_that_of_its_nearest_point(seed):
    points = np.random.default_rng(seed).uniform(-1, 1, (4, 3))
    found = np.sqrt(facet_distance2(points, 0, 1, 2, points, 3, np.inf))
    slow = np.linalg.norm(dense_points(points[:3]) - points[3], axis=1).min()
    # Samples are at most 1/60 of an edge (under 3.5) from any point of the facet.
    assert slow - 0.06 <= found <= slow + 1e-12


def test_distances_from_degenerate_facets():
    points = np.array([[0.0, 0, 0], [1.0, 0, 0], [2.0, 0, 0], [1.5, 1.0, 0]])
    assert facet_distance2(points, 0, 1, 2, points, 3, np.inf) == pytest.approx(1.0)
    assert segment_distance2(points, 0, 0, points, 3) == pytest.approx(1.5**2 + 1)


@settings(max_examples=40)
@given(seeds)
def test_angle_score_marks_15_and_135_degrees(seed):
    points = np.random.default_rng(seed).uniform(-1, 1, (3, 3))
    angles = facet_angles(points, np.array([[0, 1, 2]]))[0]
    good = angles.min() >= 15 and angles.max() <= 135
    assert (angle_score(points, 0, 1, 2) >= 1) == good


def test_angle_score_of_degenerate_facets_is_zero():
    line = np.array([[0.0, 0, 0], [1.0, 0, 0], [3.0, 0, 0]])
    assert angle_score(line, 0, 1, 2) == pytest.approx(0.0, abs=1e-12)
    assert angle_score(line, 0, 0, 2) == 0.0


def on_crack(corners: np.ndarray):
    """Return the reference to the arrays of a crack of triangles (t, 3, 3)."""
    facets = np.arange(3 * len(corners)).reshape(-1, 3)
    surface = sheet(facets, (1, 1), CRACK, corners.reshape(-1, 3))
    arrays = crack_triangles(surface, None)
    return by_reference(namedtuple("CrackArrays", arrays)(**arrays))


@settings(max_examples=30)
@given(seeds)
def test_projections_find_the_nearest_place(seed):
    rng = np.random.default_rng(seed)
    corners, place = rng.uniform(-1, 1, (5, 3, 3)), rng.uniform(-1, 1, 3)
    state = on_crack(corners)
    moved = place.copy()
    put_on_crack(state, 9.0, moved)
    slow = min(np.linalg.norm(dense_points(c) - place, axis=1).min() for c in corners)
    assert slow - 0.06 <= np.linalg.norm(moved - place) <= slow + 1e-12
    moved = place.copy()
    put_on_front(corners[:, :2].copy(), moved)
    samples = np.linspace(0, 1, 200)[:, None, None]
    along = corners[:, 0] + samples * (corners[:, 1] - corners[:, 0])
    slow = np.linalg.norm(along - place, axis=2).min()
    assert slow - 0.02 <= np.linalg.norm(moved - place) <= slow + 1e-12


@settings(max_examples=30)
@given(seeds, st.floats(0.01, 3))
def test_the_nearest_triangle_is_found_within_reach_alone(seed, reach):
    rng = np.random.default_rng(seed)
    corners = rng.uniform(0, 9, (200, 1, 3)) + rng.uniform(-1, 1, (200, 3, 3)) * rng.uniform(
        0, 1, (200, 1, 1)
    )
    places, state = rng.uniform(-2, 11, (20, 3)), on_crack(corners)
    points, ids = corners.reshape(-1, 3), np.arange(600).reshape(-1, 3)
    for row in range(20):
        all_of_them = [facet_distance2(points, *f, places, row, np.inf) for f in ids]
        found, distance2 = nearest_triangle(state, places, row, 0.0, reach)
        if min(all_of_them) < reach**2:
            assert all_of_them[found] == distance2 == min(all_of_them)
            some, near = nearest_triangle(state, places, row, reach, reach)
            assert all_of_them[some] == near <= reach**2
        else:
            assert (found, distance2) == (-1, np.inf)


def two_cubes() -> Surface:
    """Two unit cubes side by side, grains 1 and 2, with the shared face once."""
    points = np.array([[x, y, z] for x in (0.0, 1, 2) for y in (0.0, 1) for z in (0.0, 1)])
    quads = [
        ((0, 1, 3, 2), (1, 0), 1),
        ((4, 6, 7, 5), (1, 2), 0),
        ((8, 10, 11, 9), (2, 0), 2),
        ((0, 4, 5, 1), (1, 0), 3),
        ((4, 8, 9, 5), (2, 0), 3),
        ((2, 3, 7, 6), (1, 0), 4),
        ((6, 7, 11, 10), (2, 0), 4),
        ((0, 2, 6, 4), (1, 0), 5),
        ((4, 6, 10, 8), (2, 0), 5),
        ((1, 5, 7, 3), (1, 0), 6),
        ((5, 9, 11, 7), (2, 0), 6),
    ]
    facets = [t for q, _, _ in quads for t in ((q[0], q[1], q[2]), (q[0], q[2], q[3]))]
    sides = [s for _, s, _ in quads for _ in range(2)]
    return Surface(points, facets, sides, [k for _, _, k in quads for _ in range(2)])


def test_classes_of_two_cubes():
    mesh, guards, _ = make_state(two_cubes(), np.ones(12))
    # Box corners and the ends of the grain boundary's border are points; nothing else is there.
    assert (mesh.rank[:12] == 2).all()
    assert sorted(set(mesh.flags[:12].tolist())) == sorted(
        {x + y + z for x in (0, 1, 2) for y in (4, 8) for z in (16, 32)}
    )
    assert np.allclose(guards.volume, [1.0, 1.0])


def test_a_reference_keeps_its_arrays_and_no_longer_than_itself():
    state = make_state(two_cubes(), np.ones(12))
    points = weakref.ref(state.mesh.points)
    reference = by_reference(*state)
    del state
    assert points() is not None
    del reference
    assert points() is None


def test_work_goes_block_by_block_and_by_key_in_each():
    rng = np.random.default_rng(4)
    edges, key = rng.integers(0, 5 * BLOCK, (3000, 2)), rng.integers(0, 40, 3000) / 7
    assert (block_order(edges[:, 0], key) == np.lexsort((key, edges[:, 0] // BLOCK))).all()
    assert len(block_order(edges[:0, 0], key[:0])) == 0


def test_every_refusal_has_a_name_of_its_own():
    assert sorted(REFUSALS) == list(range(len(REFUSALS)))
    assert len(set(REFUSALS.values())) == len(REFUSALS)


def test_state_and_back_keeps_the_surface():
    surface = two_cubes()
    back = surface_of(make_state(surface, np.ones(12)), surface)
    assert np.array_equal(back.points, surface.points)
    assert np.array_equal(np.sort(back.facets, 1), np.sort(surface.facets, 1))
    assert np.array_equal(back.kind, surface.kind)
    assert (back.sides[:, 0] >= back.sides[:, 1]).all()


def lists_of(first, after, heads) -> dict:
    """Return per head its list, heads with an empty one left out."""
    found = {}
    for head in heads:
        item = first[head]
        while item >= 0:
            found.setdefault(head, []).append(int(item))
            item = after[item]
    return found


def test_facets_that_are_gone_leave_and_the_rest_keeps_lists_and_witnesses():
    surface, _ = structured_box((6, 6, 6), lambda centres: 1 + (centres[:, 0] > 3))
    state = make_state(surface, np.full(len(surface.points), 2.0))
    gradation = Gradation(state, filled_grid(state.mesh), {})
    collapse_short(gradation, Limits(0.75, 1.4, 1.6, 0.5, 0.0, 0.3, 0.5, 0.04, 0.5, False))
    (old, guards, _), edges = gradation.state, gradation.edges()
    living = np.flatnonzero(old.alive)
    gradation.make_room()
    (new, new_guards, _), count = gradation.state, int(gradation.mesh.used[1])
    assert count == len(living) < 0.7 * len(old.alive) and not new.alive[count:].any()
    for name in ("facets", "patch", "facet_stamp"):
        assert np.array_equal(getattr(new, name)[:count], getattr(old, name)[living])
    assert np.array_equal(new_guards.reference[:count], guards.reference[living])
    vertices = range(int(new.used[0]))
    corners = lists_of(new.first, new.after, vertices)
    before = lists_of(old.first, old.after, vertices)
    assert corners.keys() == before.keys() and all(
        v in new.facets[c // 3] for v in corners for c in corners[v]
    )
    assert all([living[c // 3] * 3 + c % 3 for c in corners[v]] == before[v] for v in corners)
    witnesses = lists_of(new_guards.witness_first, new_guards.witness_after, range(count))
    assert {living[f]: w for f, w in witnesses.items()} == lists_of(
        guards.witness_first, guards.witness_after, living
    )
    assert len(witnesses) > 0 and all(np.array_equal(a, b) for a, b in zip(edges, gradation.edges()))


@settings(max_examples=30)
@given(seeds)
def test_grid_query_agrees_with_all_pairs(seed):
    surface = two_cubes()
    extra = np.random.default_rng(seed).uniform(-0.5, 2.5, (3, 3))
    mesh = make_state(surface, np.ones(12)).mesh
    grid = filled_grid(mesh)
    points = np.concatenate([surface.points, extra])
    star = np.array([[12, 13, 14]])
    box = tuple(extra.min(axis=0)), tuple(extra.max(axis=0))
    near = gather_candidates(grid, points, mesh.facets, mesh.alive, mesh.facet_stamp, 1, no_sheet(), *box)
    hit = star_intersects(grid, points, mesh.facets, near, star, 1, False)
    assert hit == any(triangles_intersect(points, 12, 13, 14, *f) for f in mesh.facets)


def thin_end(upper_wedge: int, tip: bool = True) -> Surface:
    """The contact of grains 1 and 2 in z = 0 ends in point 0 between wedges of grain 3 and of another.

    Points 1 and 2 are on its border lines, next to its end; without a tip the lines do not meet.
    """
    points = [[0, 0, 0], [1, -0.05, 0], [1, 0.05, 0], [2, 0, 0], [2, -0.3, 0], [2, 0.3, 0]]
    points += [[0.5, -1, -0.5], [0.5, -1, 0.5], [0.5, 1, -0.5], [0.5, 1, 0.5], [0, 0.3, 0]]
    contact = [[0, 1, 2], [1, 3, 2], [1, 4, 3], [2, 3, 5]] + ([] if tip else [[0, 2, 10]])
    above = 0 if tip else 10
    wedges = [[1, 0, 6], [0, 1, 7], [above, 2, 8], [2, above, 9]]
    sides = [[1, 2]] * len(contact) + [[1, 3], [3, 2], [1, upper_wedge], [upper_wedge, 2]]
    facets = np.array(contact + wedges, np.int32)
    kind = np.zeros(len(facets), np.uint8)
    return Surface(np.array(points, float), facets, np.array(sides, np.int32), kind)


@pytest.mark.parametrize(
    "surface, closes", [(thin_end(4), True), (thin_end(3), False), (thin_end(4, tip=False), False)]
)
def test_thin_ends_of_contacts_close_where_no_side_is_tied(surface, closes):
    state = by_reference(*make_state(surface, np.ones(len(surface.points))))
    assert closes_thin_end(state, 1, 2) == closes_thin_end(state, 2, 1) == closes
    assert not closes_thin_end(state, 0, 1)


def test_the_vertex_where_a_thin_end_closed_is_a_junction_point():
    surface = thin_end(4)
    state = make_state(surface, np.ones(len(surface.points)))
    references = by_reference(*state), by_reference(filled_grid(state.mesh))
    # As where the lines go on beyond the surface's edge.
    state.mesh.rank[[1, 2]] = 1
    assert tried(references, OPEN._replace(merge_points=True), COLLAPSE, (1, 2)) == DONE
    (kept,) = (v for v in (1, 2) if state.mesh.first[v] >= 0)
    assert state.mesh.rank[kept] == 2


def remnant(beyond: str) -> Surface:
    """Grains 1 and 2 touch in facet 0 1 2, whose line 0 2 borders on grain 4 and whose line 1 2 on grain 5.

    Beyond line 0 1 there is the contact again, with the crack across ("crack") or grain 3 in between
    ("both"), or grain 3 alone ("grain").
    """
    points = [[0, 0, 0], [1, -0.05, 0], [1, 0.05, 0]]
    points += [[1.5, 0, 0.6], [1.5, -0.6, 0.5], [1.5, 0.6, 0.5]]
    points += [[0.5, -1, -0.5], [0.5, -1, 0.5], [0.5, 1, -0.5], [0.5, 1, 0.5]]
    points += [[1.5, 0, -0.6], [1.5, -0.6, -0.5], [1.5, 0.6, -0.5], [0.5, -1, 0]]
    facets = [[0, 1, 2], [0, 2, 8], [2, 0, 9], [1, 2, 3], [1, 3, 4], [2, 5, 3], [2, 1, 10], [1, 11, 10]]
    facets += [[2, 10, 12], [1, 0, 6], [0, 1, 7]] + [[1, 0, 13]] * (beyond != "grain")
    sides = [[1, 2], [1, 4], [4, 2]] + [[1, 5]] * 3 + [[5, 2]] * 3
    sides += [[1, 1], [2, 2]] if beyond == "crack" else [[1, 3], [3, 2]]
    sides += [[1, 2]] * (beyond != "grain")
    kind = np.where([a == b for a, b in sides], CRACK, 0).astype(np.uint8)
    return Surface(np.array(points, float), np.array(facets, np.int32), np.array(sides, np.int32), kind)


@pytest.mark.parametrize(
    "beyond, merge_points, refusal",
    [
        ("crack", True, DONE),
        ("crack", False, JUNCTION_TRIANGLE),
        ("both", True, JUNCTION_TRIANGLE),
        ("grain", True, JUNCTION_TRIANGLE),
    ],
)
def test_remnants_of_contacts_close_where_the_contact_goes_on_and_no_side_is_tied(
    beyond, merge_points, refusal
):
    surface = remnant(beyond)
    state = by_reference(*make_state(surface, np.ones(len(surface.points))))
    for a, b in ((1, 2), (2, 1)):
        assert link_refusal(state, a, b, False, merge_points) == refusal


def test_relaxation_evens_facets_out_inside_a_patch_only():
    surface, _ = structured_box((6, 6, 6), lambda centres: 1 + (centres[:, 0] > 3))
    state = make_state(surface, np.ones(len(surface.points)))
    mesh, count = state.mesh, len(surface.points)
    inside = np.flatnonzero(mesh.rank[:count] == 0)
    held = (mesh.flags[inside, None] >> np.array([0, 2, 4])) & 3 > 0
    mesh.points[inside] += np.where(held, 0.0, np.random.default_rng(3).uniform(-0.3, 0.3, held.shape))
    before = mesh.points[:count].copy()
    limits = Limits(0.75, 1.4, 1.6, 1.0, 0.0, 0.3, 0.5, 0.04, 0.5, False)
    references = by_reference(*state), by_reference(filled_grid(mesh))
    stopped, done = one_pass(*references, limits, RELAX, np.arange(len(before))[:, None], 0.0, 0)
    moved = np.flatnonzero((mesh.points[:count] != before).any(axis=1))
    assert stopped == len(before) and done == len(moved) > 0.7 * len(inside)
    assert np.isin(moved, inside).all() and (mesh.points[inside] == before[inside])[held].all()
    even, uneven = (facet_angles(p, surface.facets).min(axis=1).mean() for p in (mesh.points, before))
    assert even > uneven + 2


@pytest.mark.parametrize("edge", [(0, 1), (1, 0)])
def test_an_inner_vertex_gives_way_to_a_line_whichever_end_it_is(edge):
    state, references = prepared(fan(6))
    assert state.mesh.rank[[0, 1]].tolist() == [0, 1]
    assert tried(references, OPEN, COLLAPSE, edge) == DONE
    assert state.mesh.first[0] < 0 <= state.mesh.first[1]
    assert state.mesh.alive.sum() == 4


def test_later_swaps_look_at_facets_that_have_changed_alone():
    surface = fan(7, hub=(0.1, 0.05, 0.0))
    gradation = Gradation(prepared(surface)[0], filled_grid(prepared(surface)[0].mesh), {})
    limits = OPEN._replace(cosine=0.5)
    swap_all(gradation, limits)
    assert not len(edges_to_swap(gradation, gradation.swapped))
    assert len(edges_to_swap(gradation, limits._replace(cosine=0.4))) == 7
    references = gradation.reference()
    star = star_at(references[0], 3)
    gradation.mesh.points[star.tip] *= 1.1
    assert attempt(*references, limits, star, 0.0, 0.0) == DONE
    around = {tuple(edge) for edge in edges_to_swap(gradation, gradation.swapped).tolist()}
    assert around == {(0, 2), (0, 3), (0, 4), (2, 3), (3, 4)}


@pytest.mark.parametrize("half, swapped", [(0.2, 1), (0.9, 0)])
def test_edges_of_poor_facets_are_swapped_and_no_others(half, swapped):
    """Swaps gain in both rhombi; facets of the flat one have angles of 11 degrees, the others of 42."""
    points = [[-1, 0, 0], [0, -half, 0], [1, 0, 0], [0, half, 0]]
    state = prepared(sheet([[0, 1, 2], [0, 2, 3]], points=points))[0]
    gradation = Gradation(state, filled_grid(state.mesh), {})
    assert swap_poor(gradation, OPEN._replace(floor=score_of_angle(20.0))) == swapped
    assert swap_all(gradation, OPEN) == 1 - swapped
