"""Edges of the surface are swapped at facets with a node almost on their long edge, none of the front."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.mesh.check_tets import check_tets
from craftmesh.mesh.poor import is_flat
from craftmesh.surface.front import front_edges
from craftmesh.surface.measure import side_volumes
from craftmesh.tetrahedra.opening_model import begun, with_swap
from craftmesh.tetrahedra.opening_stages import STAGES
from craftmesh.tetrahedra.opening_ways import swapped_singly
from craftmesh.tetrahedra.surface_swaps import swaps_at
from craftmesh.tetrahedra.whole_mesh import Model

CELLS = 4
MIDDLE = np.array([2.0, 2.0, 2.0])


def box_with_cap(height=0.01):
    """Two grains whose plane boundary x = 2 has a node pushed almost onto an edge."""
    surface, tets = structured_box((CELLS,) * 3, lambda c: np.where(c[:, 0] < 2, 1, 2))
    points = surface.points.copy()
    node = int(np.flatnonzero((points == MIDDLE).all(axis=1))[0])
    at = surface.facets[
        (surface.facets == node).any(axis=1) & (points[surface.facets][:, :, 0] == 2).all(axis=1)
    ]
    ends = [[other for other in facet if other != node] for facet in at.tolist()]
    across = max(ends, key=lambda pair: np.linalg.norm(points[pair[1]] - points[pair[0]]))
    points[node] += (1 - height) * (points[across].mean(axis=0) - points[node])
    return replace(surface, points=points), tets, across


def has_edge(surface, ends):
    return any(set(ends) <= set(facet) for facet in surface.facets.tolist())


def test_the_long_edge_of_a_cap_is_swapped():
    surface, tets, across = box_with_cap()
    now = begun(surface, tets)
    assert now.count(is_flat) >= 2
    found = swapped_singly(now, replace(STAGES[-1], reaches=()))
    assert found.count(is_flat) == 0 and found.faults < now.faults
    assert has_edge(surface, across) and not has_edge(found.model.surface, across)
    assert check_tets(assemble(found.model.surface, found.model.grain_tets)[0]) == []
    after = found.model.surface
    volumes = side_volumes(after.points, after.facets, after.sides)
    assert volumes == pytest.approx({1: CELLS**3 / 2, 2: CELLS**3 / 2}, rel=1e-12)


def test_a_swap_that_is_refused_changes_nothing():
    surface, tets, _ = box_with_cap(height=1.0)
    assert begun(surface, tets) is None
    pushed, tets, _ = box_with_cap()
    now = begun(pushed, tets)
    lone = [
        swap for swap in swaps_at(now.model, np.arange(len(now.model.tets))) if with_swap(now, swap) is None
    ]
    assert lone and (now.model.surface.points == pushed.points).all()


def test_edges_of_the_front_stay():
    crack_at = plane_crack(2, 2, hexagon((2, 2), 1.4))
    surface, tets = structured_box((CELLS,) * 3, lambda c: np.where(c[:, 0] < 2, 1, 2), crack_at)
    model = Model(surface, tets)
    front = set(map(tuple, front_edges(surface).tolist()))
    found = list(swaps_at(model, np.arange(len(model.tets))))
    edges = {tuple(edge) for corners in model.tets for edge in combinations(sorted(corners.tolist()), 2)}
    assert found and front & edges
    for swap in found:
        assert tuple(swap.parting.edges[0].tolist()) not in front and swap.node < len(surface.points)
