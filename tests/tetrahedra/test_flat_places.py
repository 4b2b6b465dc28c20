"""Where the surface leaves no room for sound tets, its nodes give way; the box stays."""

from dataclasses import replace

import numpy as np
import pytest
from structured_box import plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.cracks.promises import TETRAHEDRA
from craftmesh.mesh.check_tets import check_tets
from craftmesh.mesh.shape_measures import flat_tets
from craftmesh.mesh.tet_connectivity import tet_volumes
from craftmesh.surface.front import front_edges, median_front_edge
from craftmesh.surface.measure import nearest_facet
from craftmesh.tetrahedra import flat_places, opening_model
from craftmesh.tetrahedra.flat_places import given_way
from craftmesh.tetrahedra.opening_model import STAGES, Opening, begun, is_at_fault, is_narrow
from craftmesh.tetrahedra.surface_freedom import freedom
from craftmesh.tetrahedra.whole_mesh import Model
from craftmesh.types import CRACK, INTERFACE, GrainTets, Surface

CELLS = 4
# A node on the boundary between two halves of the box, and how far it is pushed towards the next one.
PUSHED = np.array([2.0, 2.0, 2.0])
PUSH = np.array([0.97, 0.0, 0.0])


def pushed_box(at=PUSHED, push=PUSH, crack_at=None):
    """Two grains whose boundary has a node that almost touches the opposite face of its tets."""
    surface, tets = structured_box((CELLS,) * 3, lambda c: np.where(c[:, 0] < 2, 1, 2), crack_at)
    points = surface.points.copy()
    points[(points == at).all(axis=1)] += push
    return replace(surface, points=points), tets


def volumes(surface, grain_tets):
    return {
        g.grain: tet_volumes(np.concatenate([surface.points[g.nodes], g.interior]), g.tets)
        for g in grain_tets
    }


def test_the_surface_gives_way_for_both_neighbours():
    surface, tets = pushed_box()
    assert flat_tets(assemble(surface, tets)[0])["count"] > 0
    opened = given_way(surface, tets)
    mesh, _ = assemble(opened.surface, opened.grain_tets)
    assert flat_tets(mesh)["count"] == 0 == opened.report["flat_left"]
    assert check_tets(mesh) == []
    assert opened.report["surface_points_moved"] > 0 and "were moved by up to" in opened.warning
    moves = np.linalg.norm(opened.surface.points - surface.points, axis=1)
    # mean edges are those of a cube of side 1, at most its diagonal, and of the pushed node's
    assert 0 < moves.max() == opened.report["largest_move"] < STAGES[0].reaches[-1] * 2
    inside = volumes(opened.surface, opened.grain_tets)
    assert all((volume > 0).all() for volume in inside.values())
    assert sum(volume.sum() for volume in inside.values()) == pytest.approx(CELLS**3, rel=1e-12)


@pytest.mark.parametrize(
    "better, worse", [((30, 93, 386), (26, 197, 926)), ((0, 5, 60), (1, 5, 20)), ((0, 2, 9), (0, 3, 5))]
)
def test_a_flat_tet_less_is_no_gain_at_any_price(better, worse):
    """Models with so many flat, poor and stretched tets, each sort with those of the sort before."""
    sound, stretched = [0.0, 2.0, 50.0, 80.0, 0.9], [0.0, 6.0, 15.0, 90.0, 0.3]
    poor, flat = [0.0, 8.0, 8.0, 90.0, 0.2], [0.0, 30.0, 2.0, 90.0, 0.1]
    surface, tets = pushed_box()

    def faults(counts):
        rows = np.repeat([flat, poor, stretched, sound], [counts[0], *np.diff(counts), 50], axis=0)
        model = Model(surface, tets[:1])
        return Opening(model, {tets[0].grain: rows}, surface.points, freedom(surface)).faults

    assert faults(better) < faults(worse)


def test_without_poor_tets_everything_stays():
    surface, tets = pushed_box(push=np.zeros(3))
    opened = given_way(surface, tets)
    assert opened.surface is surface and opened.grain_tets is tets
    assert opened.report is None and opened.warning is None and opened.poor == {}


def test_points_of_box_planes_stay_on_them():
    surface, tets = pushed_box(at=np.array([2.0, 0.0, 2.0]))
    opened = given_way(surface, tets)
    before, after = surface.points, opened.surface.points
    assert opened.report["flat_left"] == 0 and (before != after).any()
    for limit in (0, CELLS):
        assert (after[before == limit] == limit).all()


def test_points_of_the_crack_stay_on_it():
    crack_at = plane_crack(0, 2, lambda c: np.maximum(abs(c[:, 1] - 2), abs(c[:, 2] - 2)) < 1)
    surface, tets = pushed_box(crack_at=None)
    cracked, _ = structured_box((CELLS,) * 3, lambda c: np.where(c[:, 0] < 2, 1, 2), crack_at)
    surface = replace(surface, kind=cracked.kind)
    opened = given_way(surface, tets)
    crack, points = surface.facets[surface.kind == CRACK], opened.surface.points
    on_crack, front = np.unique(crack), np.unique(front_edges(surface))
    assert (on_crack == np.flatnonzero((surface.points == PUSHED + PUSH).all(axis=1))).any()
    assert (points[front] == surface.points[front]).all()
    _, off, _ = nearest_facet(points[on_crack], surface.points, crack)
    assert off.max() <= TETRAHEDRA.facets * median_front_edge(surface)


def test_poor_tets_are_opened_by_less_than_flat_ones():
    surface, tets = pushed_box(push=np.array([0.8, 0.0, 0.0]))
    before = flat_tets(assemble(surface, tets)[0])
    opened = given_way(surface, tets)
    assert before["count"] == 0 == opened.report["flat_before"] and opened.report["poor_before"] > 0
    assert opened.report["poor_left"] == 0
    moves = np.linalg.norm(opened.surface.points - surface.points, axis=1)
    assert 0 < moves.max() < STAGES[1].reaches[-1] * 2
    assert check_tets(assemble(opened.surface, opened.grain_tets)[0]) == []


def test_stretched_tets_are_opened_as_poor_ones_and_nobody_is_warned():
    surface, tets = pushed_box(push=np.array([0.65, 0.0, 0.0]))
    opened = given_way(surface, tets)
    assert opened.report["poor_before"] == 0 < opened.report["stretched_before"]
    assert opened.report["stretched_left"] == 0 and opened.warning is None
    moves = np.linalg.norm(opened.surface.points - surface.points, axis=1)
    assert 0 < moves.max() < STAGES[2].reaches[-1] * 2
    assert check_tets(assemble(opened.surface, opened.grain_tets)[0]) == []


def test_small_moves_open_narrow_tets():
    """Two nodes of the boundary go towards each other: angles at the edges opposite theirs close."""
    surface, tets = structured_box((CELLS,) * 3, lambda c: np.where(c[:, 0] < 2, 1, 2))
    points = surface.points.copy()
    for at, step in ((PUSHED, 0.36), (PUSHED + [0, 1, 0], -0.36)):
        points[(points == at).all(axis=1), 1] += step
    before = begun(replace(surface, points=points), tets)
    after = flat_places.with_moves(before, STAGES[-1])
    assert before.count(is_narrow) > 0 == after.count(is_narrow)
    assert after.count(is_at_fault) <= before.count(is_at_fault)
    moves = np.linalg.norm(after.model.points[: len(points)] - points, axis=1)
    # the longest mean edge is less than a cube's diagonal
    assert 0 < moves.max() < STAGES[-1].reaches[-1] * np.sqrt(3)
    assert check_tets(assemble(after.model.surface, after.model.grain_tets)[0]) == []


def test_a_narrow_tet_alone_is_given_way_to_and_nobody_is_warned():
    long, short = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], [[0.5, 0.87, -0.11], [0.5, 0.87, 0.11]]
    surface, tets = one_tet(np.array(long + short))
    before = begun(surface, tets)
    assert before.count(is_narrow) == 1 and before.count(is_at_fault) == 0
    opened = given_way(surface, tets)
    assert begun(opened.surface, opened.grain_tets) is None
    assert opened.report["surface_points_moved"] > 0 and opened.warning is None


def test_nodes_of_a_volume_that_is_held_stay():
    surface, tets = pushed_box(push=np.zeros(3))
    moved, _ = pushed_box()
    now = Opening(Model(moved, tets), {}, surface.points, freedom(moved))
    drift = max(map(abs, now.drifts.values()))
    # a pyramid over the six or eight facets at the node, of 0.5 each, in a half of 4 x 4 x 2
    assert 0.03 < drift < 0.05
    assert not now.changed_by(1.01 * drift) and now.changed_by(0.99 * drift) == {1, 2}
    assert now.mobile(set()).any() and not now.mobile({1, 2}).any()


def test_no_move_changes_a_volume_by_more_than_its_stage_allows():
    now = begun(*pushed_box(push=np.array([0.65, 0.0, 0.0])))
    free, bound = (flat_places.with_moves(now, replace(STAGES[2], drift=drift)) for drift in (np.inf, 1e-3))
    drifts = [max(map(abs, after.drifts.values())) for after in (free, bound)]
    assert drifts[0] > 1e-3 >= drifts[1]


def one_tet(points):
    """A grain of one tet."""
    tets = np.array([[0, 1, 2, 3]])
    facets = tets[0][[[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]]].astype(np.int32)
    surface = Surface(points, facets, np.array([[1, 0]] * 4, np.int32), np.full(4, INTERFACE))
    return surface, [GrainTets(1, np.arange(4), np.zeros((0, 3)), tets)]


def test_what_makes_it_worse_is_not_done(monkeypatch):
    def spoilt(now, reach, bad, stage, held):
        points = now.model.points.copy()
        points[(points == [2.0, 1.0, 1.0]).all(axis=1)] += PUSH
        return points, np.array([1, 2])

    monkeypatch.setattr(opening_model, "_moved_points", spoilt)
    monkeypatch.setattr(opening_model, "repaired", lambda model, grains, measure: model)
    surface, tets = pushed_box()
    opened = given_way(surface, tets)
    assert (opened.surface.points == surface.points).all() and opened.warning is None
    assert opened.report["flat_left"] == opened.report["flat_before"] > 0


def test_the_same_input_gives_the_same_bytes():
    first, second = (given_way(*pushed_box()) for _ in range(2))
    assert first.surface.points.tobytes() == second.surface.points.tobytes()
    for a, b in zip(first.grain_tets, second.grain_tets):
        assert a.tets.tobytes() == b.tets.tobytes() and a.interior.tobytes() == b.interior.tobytes()
