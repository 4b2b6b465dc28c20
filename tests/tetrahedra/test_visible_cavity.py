"""The cavity that an apex fills best, against all cavities there are; flat tets that a join mends."""

from itertools import product

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from craftmesh.mesh.tet_connectivity import tet_volumes
from craftmesh.tetrahedra.kernels.tet_cavity import FACES, new_scratch
from craftmesh.tetrahedra.kernels.tet_cavity_filling import join_in_cavity
from craftmesh.tetrahedra.kernels.tet_quality import VOLUME_LENGTH, Aim, all_qualities, quality_of
from craftmesh.tetrahedra.kernels.tet_visible_cavity import best_cavity
from craftmesh.tetrahedra.optimise_tets import _result, new_state


def delaunay_state(points):
    """Delaunay tets of points that all count as surface nodes, and their state."""
    tets = Delaunay(points).simplices.astype(np.int64)
    volume = tet_volumes(points, tets)
    tets[volume < 0] = tets[volume < 0][:, [0, 2, 1, 3]]
    state = new_state(points, tets, len(points), np.zeros((0, 3)), np.ones(len(points)))
    all_qualities(state.points, state.tets, len(tets), state.quality, VOLUME_LENGTH)
    return tets, state


def inward_faces(tets):
    """Plain reference: the outer faces of some tets, turned right-handed towards their inside."""
    faces = {}
    for tet in tets:
        for face in tet[FACES].tolist():
            faces.setdefault(frozenset(face), []).append(face)
    return [both[0] for both in faces.values() if len(both) == 1]


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), st.booleans())
def test_no_cavity_round_a_tet_is_better(seed, is_new):
    rng = np.random.default_rng(seed)
    points = rng.random((9, 3))
    tets, state = delaunay_state(points)
    assume(len(tets) <= 13 and tet_volumes(points, tets).min() > 1e-6)
    apex = -1 if is_new else int(rng.integers(len(points)))
    place = rng.dirichlet(np.ones(4)) @ points[tets[0]] if is_new else points[apex]
    found, size = best_cavity(state, 0, apex, tuple(place), VOLUME_LENGTH, new_scratch())
    nodes, best = np.vstack([points, place]), 0.0
    for others in product([False, True], repeat=len(tets) - 1):
        faces = [face for face in inward_faces(tets[np.array([True, *others])]) if apex not in face]
        best = max(best, min(quality_of(nodes, *face, len(points), VOLUME_LENGTH) for face in faces))
    assert found == pytest.approx(best, abs=1e-12)
    assert (size > 0) == (best > 0)


def test_flat_tets_of_surface_nodes_alone_are_mended():
    mended = 0
    for seed in range(20):
        points = np.random.default_rng(seed).normal(size=(14, 3))
        points /= np.linalg.norm(points, axis=1, keepdims=True)
        tets, state = delaunay_state(points)
        flattest = int(state.quality[: len(tets)].argmin())
        before = state.quality[flattest]
        aim = Aim(VOLUME_LENGTH, before + 0.05)
        if before > 0 and join_in_cavity(state, flattest, aim, new_scratch()):
            mended += 1
            _, result = _result(state, len(points))
            after = np.empty(len(result))
            all_qualities(points, result, len(result), after, VOLUME_LENGTH)
            assert not any(set(tet) == set(tets[flattest]) for tet in result.tolist())
            assert after.min() > before
            volume = tet_volumes(points, tets).sum()
            assert tet_volumes(points, result).sum() == pytest.approx(volume, rel=1e-12)
    assert mended > 3


def ring_with_crack_facet():
    """Five tets round the front edge (0, 1) of a crack facet that ends at node 2 of their ring."""
    angle = 2 * np.pi * np.arange(5) / 5
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(5)])
    points = np.vstack([[0, 0, -0.2], [0, 0, 0.2], ring])
    tets = np.array([[0, 1, 2 + i, 2 + (i + 1) % 5] for i in range(5)], np.int64)
    return points, tets, np.array([[0, 1, 2]], np.int64)


@pytest.mark.parametrize("apex", range(2, 7))
@pytest.mark.parametrize("first", range(5))
def test_a_crack_facet_stays_within_its_front(apex, first):
    points, tets, crack = ring_with_crack_facet()
    state = new_state(points, tets, len(points), crack, np.ones(len(points)))
    all_qualities(state.points, state.tets, len(tets), state.quality, VOLUME_LENGTH)
    place, work = tuple(points[apex]), new_scratch()
    _, size = best_cavity(state, first, apex, place, VOLUME_LENGTH, work)
    sides = [t for t in work.star[:size] if set(crack[0]) <= set(tets[t])]
    assert len(sides) < 2 or apex not in crack[0]
    join_in_cavity(state, first, Aim(VOLUME_LENGTH, 0.0), work)
    _, result = _result(state, len(points))
    assert sum(set(crack[0]) <= set(tet) for tet in result.tolist()) == 2
