"""Divided facets cover the given ones, fit each other, and part along what crosses them."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from craftmesh.surface.facet_subdivision import AT_END, bisected, divided, divided_at
from craftmesh.surface.measure import area_vectors, total_area


def ball(seed=0, count=60):
    """Return points and outward facets of a closed surface, and its edges, the lower point first."""
    points = np.random.default_rng(seed).normal(size=(count, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    hull = ConvexHull(points)
    inwards = np.einsum("ij,ij->i", area_vectors(points, hull.simplices), hull.equations[:, :3]) < 0
    facets = np.where(inwards[:, None], hull.simplices[:, ::-1], hull.simplices)
    return points, facets, edges_of(facets)


def edges_of(facets):
    pairs = np.sort(np.concatenate([facets[:, [0, 1]], facets[:, [1, 2]], facets[:, [2, 0]]]), axis=1)
    return np.unique(pairs, axis=0)


def is_closed(facets):
    directed = np.concatenate([facets[:, [0, 1]], facets[:, [1, 2]], facets[:, [2, 0]]])
    rows = {tuple(pair) for pair in directed.tolist()}
    return len(rows) == len(directed) and all((b, a) in rows for a, b in rows)


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9, 1.0])
def test_facets_split_at_any_edges_fit_and_cover_theirs(share):
    points, facets, edges = ball()
    chosen = edges[np.random.default_rng(3).random(len(edges)) < share]
    every = np.concatenate([points, points[chosen].mean(axis=1)])
    found, parent = divided(every, facets, chosen, len(points))
    assert is_closed(found) and (np.diff(parent) >= 0).all()
    # each split edge makes two edges and cuts the facets on both of its sides
    assert len(found) == len(facets) + 2 * len(chosen)
    assert not {tuple(pair) for pair in edges_of(found)} & {tuple(pair) for pair in chosen}
    whole, parts = area_vectors(points, facets), np.zeros((len(facets), 3))
    np.add.at(parts, parent, area_vectors(every, found))
    assert parts == pytest.approx(whole, abs=1e-14)
    # no part is turned over, and a middle of edges makes parts of a quarter or a half
    along = np.einsum("ij,ij->i", area_vectors(every, found), whole[parent]) / (whole[parent] ** 2).sum(
        axis=1
    )
    assert along.min() >= 0.25 - 1e-9


def test_two_new_points_of_a_facet_part_it_along_the_shorter_diagonal():
    for corner in ([3.0, 1.0, 0], [-2.0, 1.0, 0], [0.5, 4.0, 0]):
        points = np.array([[0.0, 0, 0], [1, 0, 0], corner])
        for left_out in range(3):
            edges = np.array([pair for k, pair in enumerate(((0, 1), (1, 2), (0, 2))) if k != left_out])
            every = np.concatenate([points, points[edges].mean(axis=1)])
            found, _ = divided(every, np.array([[0, 1, 2]]), edges, 3)
            kept = [(0, 1), (1, 2), (0, 2)][left_out]
            lengths = {
                (end, new): np.linalg.norm(every[end] - every[new])
                for end in kept
                for new in (3, 4)
                if end not in edges[new - 3]
            }
            shorter = min(lengths, key=lengths.__getitem__)
            assert shorter in {tuple(pair) for pair in edges_of(found).tolist()}


@pytest.mark.parametrize("height", [-0.3, 0.0, 0.41])
def test_facets_part_where_a_plane_crosses_them(height):
    points, facets, edges = ball(1, 200)
    psi = points @ [0.6, 0.0, 0.8] - height
    off = psi[edges]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(off.prod(axis=1) < 0, off[:, 0] / (off[:, 0] - off[:, 1]), np.nan)
    found = divided_at(points, facets, np.sign(psi).astype(int), edges, share)
    assert is_closed(found.facets) and len(found.points) == len(points) + len(found.ends)
    sides = found.side[found.facets]
    assert not ((sides > 0).any(axis=1) & (sides < 0).any(axis=1)).any()
    new = found.points[len(points) :]
    assert (
        new @ [0.6, 0.0, 0.8] == pytest.approx(height, abs=1e-12) and (found.side[len(points) :] == 0).all()
    )
    # an end is on the crossing just where some edge is crossed within a tenth of it
    near = np.concatenate([edges[share < AT_END, 0], edges[share > 1 - AT_END, 1]])
    assert set(np.flatnonzero(found.side[: len(points)] == 0)) == set(near) | set(np.flatnonzero(psi == 0))
    assert {*near} and (
        found.side[: len(points)] == np.where(np.isin(np.arange(200), near), 0, np.sign(psi))
    ).all()


def test_bisected_triangles_fill_the_given_ones_that_meet_the_slab():
    corners = np.random.default_rng(5).random((6, 3, 3)) * (4.0, 2.0, 1.0)
    parts = bisected(corners, np.array([[-9.0] * 3, [9.0] * 3]), 0.4)
    lengths = np.linalg.norm(parts - np.roll(parts, 1, axis=1), axis=2)
    assert 0.2 < lengths.max() <= 0.4
    areas = [total_area(c.reshape(-1, 3), np.arange(3 * len(c)).reshape(-1, 3)) for c in (corners, parts)]
    assert areas[0] == pytest.approx(areas[1])
    slab = np.array([[0.0] * 3, [1.0, 2.0, 1.0]])
    near = bisected(corners, slab, 0.4)
    assert (near.min(axis=1)[:, 0] <= 1.0).all() and 0 < len(near) < len(parts)
    whole = parts[parts.min(axis=1)[:, 0] <= 1.0]
    assert sorted(near.reshape(-1, 9).tolist()) == sorted(whole.reshape(-1, 9).tolist())
