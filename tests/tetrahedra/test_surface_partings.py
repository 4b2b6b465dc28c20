"""Edges of the surface are parted where tets then weigh less: shapes, grains and the front stay."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from craftmesh.mesh.kernels.shape_measures import shape_measures
from craftmesh.mesh.tet_connectivity import tet_volumes
from craftmesh.surface.front import front_edges
from craftmesh.surface.measure import area_vectors, side_volumes
from craftmesh.tetrahedra.kernels.tet_faults import FALL, fault_weight
from craftmesh.tetrahedra.kernels.tet_quality import WHOLE, quality_of
from craftmesh.tetrahedra.opening_model import is_at_fault
from craftmesh.tetrahedra.surface_partings import with_edges_parted, worthwhile
from craftmesh.tetrahedra.whole_mesh import Model
from craftmesh.types import CRACK, INTERFACE, GrainTets, Surface


def spindle(long, radius=0.6, count=6, shift=(0.0, 0.0), crack=False):
    """Return tets round one edge, from (0, 0, -long) to (0, 0, long), in two halves or on a crack's front.

    shift: of the ring of `count` nodes, along the edge and across it. Nodes 0 and 1 are the edge's ends.
    """
    turn = 2 * np.pi * np.arange(count) / count
    ring = np.stack(
        [radius * np.cos(turn) + shift[1], radius * np.sin(turn), np.full(count, shift[0])], axis=1
    )
    points = np.concatenate([[[0, 0, -long], [0, 0, long]], ring])
    this = 2 + np.arange(count)
    after = np.roll(this, -1)
    tets = np.column_stack([np.zeros(count, int), this, after, np.ones(count, int)])
    half = np.where(np.arange(count) < count // 2, 1, 1 if crack else 2)
    low = np.column_stack([np.zeros(count, int), after, this])
    high = np.column_stack([np.ones(count, int), this, after])
    inner = [[0, 1, 2]] if crack else [[0, 1, 2], [1, 0, 2 + count // 2]]
    sides = [[1, 1]] if crack else [[2, 1], [2, 1]]
    surface = Surface(
        points,
        np.concatenate([low, high, inner]).astype(np.int32),
        np.concatenate([np.stack([np.tile(half, 2), np.zeros(2 * count, int)], axis=1), sides]),
        np.array([INTERFACE] * 2 * count + [CRACK if crack else INTERFACE] * len(inner)),
    )
    blocks = []
    for grain in np.unique(half).tolist():
        nodes, local = np.unique(tets[half == grain], return_inverse=True)
        blocks.append(GrainTets(grain, nodes, np.zeros((0, 3)), local.reshape(-1, 4)))
    return Model(surface, blocks)


def at_fault(model):
    return is_at_fault(shape_measures(model.points, model.tets))


def weight(model):
    return sum(fault_weight(quality_of(model.points, *tet, WHOLE)) for tet in model.tets.tolist())


@settings(max_examples=100, deadline=None)
@given(st.floats(1.0, 4.0), st.integers(5, 8), st.floats(-0.5, 0.5), st.floats(-0.2, 0.2))
def test_what_is_parted_weighs_less_and_keeps_grains_facets_and_nodes(long, count, along, across):
    model = spindle(long, count=count, shift=(along * long, across))
    assert (tet_volumes(model.points, model.tets) > 0).all()
    parting = worthwhile(model, at_fault(model))
    if not len(parting.edges):
        return
    found, grains = with_edges_parted(model, parting)
    assert grains.tolist() == [1, 2] and weight(found) <= weight(model) - FALL
    assert (tet_volumes(found.points, found.tets) > 0).all()
    old, new = model.surface, found.surface
    assert np.array_equal(new.points[: len(old.points)], old.points)
    assert np.array_equal(new.points[len(old.points) :], parting.places(old.points))
    volumes = [side_volumes(one.points, one.facets, one.sides) for one in (old, new)]
    assert volumes[1] == pytest.approx(volumes[0], rel=1e-12)
    for side in ([2, 1], [1, 0], [2, 0]):  # each patch has the area it had, its normals together too
        areas = [area_vectors(s.points, s.facets[(s.sides == side).all(axis=1)]) for s in (old, new)]
        assert np.allclose(areas[0].sum(axis=0), areas[1].sum(axis=0), atol=1e-12)
        assert np.linalg.norm(areas[1], axis=1).sum() == pytest.approx(
            np.linalg.norm(areas[0], axis=1).sum(), rel=1e-12
        )
    faces = np.sort(found.tets[:, [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]]].reshape(-1, 3), axis=1)
    known, times = np.unique(faces, axis=0, return_counts=True)
    outer = np.unique(np.sort(new.facets[(new.sides <= 0).any(axis=1)], axis=1), axis=0)
    assert times.max() == 2 and np.array_equal(known[times == 1], outer)
    facets = np.sort(new.facets, axis=1)
    assert len(np.unique(np.concatenate([known, facets]), axis=0)) == len(known)


def test_a_long_edge_in_the_middle_of_its_tets_is_parted_in_its_middle():
    model = spindle(2.0)
    parting = worthwhile(model, at_fault(model))
    found, _ = with_edges_parted(model, parting)
    assert parting.edges.tolist() == [[0, 1]] and parting.shares.tolist() == [0.5]
    assert at_fault(model).all() and not at_fault(found).any()
    assert np.array_equal(found.points[8], [0, 0, 0])


def test_edges_of_the_front_stay():
    model = spindle(2.0, crack=True)
    assert [0, 1] in front_edges(model.surface).tolist() and at_fault(model).all()
    assert [0, 1] not in worthwhile(model, at_fault(model)).edges.tolist()


def test_sound_tets_have_nothing_parted():
    model = spindle(0.5)
    assert not at_fault(model).any()
    assert worthwhile(model, at_fault(model)).edges.shape == (0, 2)
