"""Nodes of the surface become one where flat tets need it: grains, crack and front stay what they are."""

from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.mesh.check_tets import check_tets
from craftmesh.mesh.shape_measures import flat_tets, is_flat, shape_measures
from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.front import ears, front_edges
from craftmesh.surface.measure import side_volumes
from craftmesh.tetrahedra.contraction_reach import keeps_surface
from craftmesh.tetrahedra.contraction_rules import keeps_topology, may_merge
from craftmesh.tetrahedra.stars import classes_of, stars_of
from craftmesh.tetrahedra.surface_contractions import contracted, rebuilt
from craftmesh.tetrahedra.whole_mesh import Model
from craftmesh.types import CRACK

CELLS = 4


def halves(centres):
    return np.where(centres[:, 0] < 2, 1, 2)


def pillar(centres):
    """Return three grains: halves, and a column one cell thick between them."""
    inside = (np.abs(centres[:, 0] - 2.5) < 0.6) & (np.abs(centres[:, 1] - 1.5) < 0.6)
    return np.where(inside, 3, halves(centres))


def short_edge(at, push):
    """Return a model in which a node of the boundary between two grains is pushed along it."""
    surface, tets = structured_box((CELLS,) * 3, halves)
    points = surface.points.copy()
    points[(points == at).all(axis=1)] += push
    return Model(replace(surface, points=points), tets)


def flat_of(model):
    return is_flat(shape_measures(model.points, model.tets))


@pytest.mark.parametrize("at", [(2.0, 2.0, 2.0), (2.0, 0.0, 2.0)])
def test_a_short_edge_of_a_boundary_goes(at):
    model = short_edge(np.array(at), np.array([0.0, 0.0, 0.995]))
    flat = flat_of(model)
    assert flat.any()
    found, grains, count = contracted(model, flat, 0.0)
    assert count == 1 and grains.tolist() == [1, 2] and not flat_of(found).any()
    mesh, _ = assemble(found.surface, found.grain_tets)
    assert check_tets(mesh) == [] and flat_tets(mesh)["count"] == 0
    volumes = side_volumes(found.surface.points, found.surface.facets, found.surface.sides)
    # the boundary is the plane x = 2, in which the node goes
    assert volumes == pytest.approx({1: CELLS**3 / 2, 2: CELLS**3 / 2}, rel=1e-12)


def test_a_corner_of_the_box_never_goes():
    surface, tets = structured_box((CELLS,) * 3, halves)
    points = surface.points.copy()
    points[(points == [0, 0, 1]).all(axis=1)] = [0, 0, 0.005]
    model = Model(replace(surface, points=points), tets)
    found, _, count = contracted(model, flat_of(model), 0.0)
    corners = found.surface.points[np.unique(found.surface.facets)]
    assert count and (corners == 0).all(axis=1).any()


def euler_numbers(surface):
    """Return V - E + F of each grain's boundary."""
    result = {}
    for grain in surface.grains.tolist():
        on = (surface.sides == grain).sum(axis=1) == 1
        edges, _, _ = unique_edges(surface.facets[on])
        result[grain] = len(np.unique(surface.facets[on])) - len(edges) + int(on.sum())
    return result


def is_closed(surface):
    """Tell whether each edge of each grain's boundary has two of its facets."""
    for grain in surface.grains.tolist():
        on = (surface.sides == grain).sum(axis=1) == 1
        if (unique_edges(surface.facets[on])[2] != 2).any():
            return False
    return True


def merges(model):
    """Return for each pair of nodes that may become one whether topology holds, and the model after it."""
    classes = classes_of(model.surface)
    nodes = np.arange(len(model.points))
    edges = {tuple(sorted(pair)) for tet in model.tets.tolist() for pair in permutations(tet, 2)}
    for a, b in sorted(edges):
        for kept, gone in ((a, b), (b, a)):
            stars = stars_of(model, classes, nodes)
            if not (stars.on_surface(kept) and stars.on_surface(gone) and may_merge(stars, kept, gone)):
                continue
            holds = keeps_topology(stars, kept, gone)
            stars.merge(kept, gone)
            yield holds, rebuilt(model, stars)[0]


def test_what_holds_leaves_bodies_of_the_same_kind():
    surface, tets = structured_box((3, 3, 1), pillar)
    before = euler_numbers(surface)
    answers = []
    for holds, model in merges(Model(surface, tets)):
        answers.append(holds)
        if holds:
            assert euler_numbers(model.surface) == before and is_closed(model.surface)
    assert any(answers) and not all(answers)


def test_what_holds_keeps_the_front():
    surface, tets = structured_box((4, 4, 2), halves, plane_crack(2, 1, hexagon((2, 2), 1.4)))
    count, edges, before = 0, len(front_edges(surface)), len(crack_ears(surface))
    for holds, model in merges(Model(surface, tets)):
        if holds:
            count += 1
            assert len(front_edges(model.surface)) == edges and len(crack_ears(model.surface)) <= before
    assert edges and count


def crack_ears(surface):
    on_front = np.zeros(len(surface.points), bool)
    on_front[front_edges(surface)] = True
    return ears(surface.facets[surface.kind == CRACK], on_front)


def test_the_surface_stays_near():
    surface, tets = structured_box((CELLS,) * 3, halves)
    points = surface.points.copy()
    points[(points == [2, 2, 2]).all(axis=1)] += [0.45, 0, 0]
    model = Model(replace(surface, points=points), tets)
    stars = stars_of(model, classes_of(surface), np.arange(len(model.points)))
    bump = int(np.flatnonzero((points == [2.45, 2, 2]).all(axis=1))[0])
    flat = [int(np.flatnonzero((points == place).all(axis=1))[0]) for place in ([2, 1, 2], [2, 1, 1])]
    assert not keeps_surface(stars, flat[0], bump)  # the bump, 0.45 high, would go
    assert keeps_surface(stars, flat[1], flat[0])


def beside_front(surface, near):
    """Yield the surface with a node off the crack, of no lower rank, moved `near` a node of its front."""
    classes = classes_of(surface)
    front = np.unique(front_edges(surface))
    edges, _, _ = unique_edges(surface.facets)
    for one, other in [*edges.tolist(), *edges[:, ::-1].tolist()]:
        if one in front and not classes.held[other].any() and classes.rank[other] >= classes.rank[one]:
            points = surface.points.copy()
            points[other] = points[one] + near * (points[other] - points[one])
            yield one, other, replace(surface, points=points)


@pytest.mark.parametrize(("near", "joins"), [(0.012, True), (0.03, False)])
def test_points_that_touch_the_front_become_it(near, joins):
    surface, tets = structured_box((4, 4, 2), pillar, plane_crack(2, 1, hexagon((1, 3), 1.1)))
    count = 0
    for gone, kept, moved in beside_front(surface, near):
        model = Model(moved, tets)
        stars = stars_of(model, classes_of(moved), np.arange(len(model.points)))
        assert may_merge(stars, kept, gone) == joins
        if joins and keeps_surface(stars, kept, gone) and keeps_topology(stars, kept, gone):
            stars.merge(kept, gone)
            assert stars.classes.held[kept, -1]
            after = front_edges(rebuilt(model, stars)[0].surface)
            assert len(after) == len(front_edges(surface)) and kept in after and gone not in after
            count += 1
    assert bool(count) == joins
