"""Where the surface leaves no room for sound tets, its nodes give way; the box stays."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from structured_box import plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.cracks.crack_tolerances import TETRAHEDRA
from craftmesh.mesh.check_tets import check_tets
from craftmesh.mesh.shape_measures import flat_tets, is_poor, shape_measures
from craftmesh.mesh.tet_connectivity import tet_volumes
from craftmesh.surface.front import front_edges, median_front_edge
from craftmesh.surface.measure import nearest_facet, side_volumes, volume_drift
from craftmesh.tetrahedra import surface_moves
from craftmesh.tetrahedra.surface_moves import (
    LAYERS,
    MOST_DRIFT,
    NARROW_REACH,
    REACHES,
    given_way,
    is_stretched,
)
from craftmesh.tetrahedra.whole_mesh import Model
from craftmesh.types import CRACK

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


def opened_model(surface, tets):
    """Return the surface and the tets after the surface gave way, with its report and warning."""
    found = given_way(Model(surface, tets))
    return SimpleNamespace(
        surface=found.model.surface,
        grain_tets=found.model.grain_tets,
        report=found.report,
        warning=found.warning,
    )


def measures_of(surface, tets):
    model = Model(surface, tets)
    return shape_measures(model.points, model.tets)


def volumes(surface, grain_tets):
    return {
        g.grain: tet_volumes(np.concatenate([surface.points[g.nodes], g.interior]), g.tets)
        for g in grain_tets
    }


def test_the_surface_gives_way_for_both_neighbours():
    surface, tets = pushed_box()
    assert flat_tets(assemble(surface, tets)[0])["count"] > 0
    opened = opened_model(surface, tets)
    mesh, _ = assemble(opened.surface, opened.grain_tets)
    assert flat_tets(mesh)["count"] == 0 == opened.report["flat_left"]
    assert check_tets(mesh) == []
    assert opened.report["surface_points_moved"] > 0 and "surface points were moved" in opened.warning
    moves = np.linalg.norm(opened.surface.points - surface.points, axis=1)
    # mean edges are those of a cube of side 1, at most its diagonal, and of the pushed node's
    assert 0 < moves.max() == opened.report["largest_move"] < REACHES[-1] * 2
    inside = volumes(opened.surface, opened.grain_tets)
    assert all((volume > 0).all() for volume in inside.values())
    assert sum(volume.sum() for volume in inside.values()) == pytest.approx(CELLS**3, rel=1e-12)


def test_without_poor_tets_everything_stays():
    surface, tets = pushed_box(push=np.zeros(3))
    opened = opened_model(surface, tets)
    assert opened.surface is surface and opened.grain_tets is tets
    assert opened.report is None and opened.warning is None


def test_points_of_box_planes_stay_on_them():
    surface, tets = pushed_box(at=np.array([2.0, 0.0, 2.0]))
    opened = opened_model(surface, tets)
    before, after = surface.points, opened.surface.points
    assert opened.report["flat_left"] == 0 and (before != after).any()
    for limit in (0, CELLS):
        assert (after[before == limit] == limit).all()


def test_points_of_the_crack_stay_on_it():
    crack_at = plane_crack(0, 2, lambda c: np.maximum(abs(c[:, 1] - 2), abs(c[:, 2] - 2)) < 1)
    surface, tets = pushed_box(crack_at=None)
    cracked, _ = structured_box((CELLS,) * 3, lambda c: np.where(c[:, 0] < 2, 1, 2), crack_at)
    surface = replace(surface, kind=cracked.kind)
    opened = opened_model(surface, tets)
    crack, points = surface.facets[surface.kind == CRACK], opened.surface.points
    on_crack, front = np.unique(crack), np.unique(front_edges(surface))
    assert (on_crack == np.flatnonzero((surface.points == PUSHED + PUSH).all(axis=1))).any()
    assert (points[front] == surface.points[front]).all()
    _, off, _ = nearest_facet(points[on_crack], surface.points, crack)
    assert off.max() <= TETRAHEDRA.facets * median_front_edge(surface)


def test_poor_tets_are_opened_by_less_than_flat_ones():
    surface, tets = pushed_box(push=np.array([0.8, 0.0, 0.0]))
    before = flat_tets(assemble(surface, tets)[0])
    opened = opened_model(surface, tets)
    assert before["count"] == 0 == opened.report["flat_before"] and opened.report["poor_before"] > 0
    assert opened.report["poor_left"] == 0
    moves = np.linalg.norm(opened.surface.points - surface.points, axis=1)
    assert 0 < moves.max() < REACHES[-1] * 2
    assert check_tets(assemble(opened.surface, opened.grain_tets)[0]) == []


def test_stretched_tets_are_opened_as_poor_ones_and_nobody_is_warned():
    surface, tets = pushed_box(push=np.array([0.65, 0.0, 0.0]))
    opened = opened_model(surface, tets)
    assert opened.report["poor_before"] == 0 < opened.report["stretched_before"]
    assert opened.report["stretched_left"] == 0 and opened.warning is None
    moves = np.linalg.norm(opened.surface.points - surface.points, axis=1)
    assert 0 < moves.max() < REACHES[-1] * 2
    assert check_tets(assemble(opened.surface, opened.grain_tets)[0]) == []


def test_small_moves_open_narrow_tets():
    """Two nodes of the boundary go towards each other: angles at the edges opposite theirs close."""
    surface, tets = structured_box((CELLS,) * 3, lambda c: np.where(c[:, 0] < 2, 1, 2))
    points = surface.points.copy()
    for at, step in ((PUSHED, 0.36), (PUSHED + [0, 1, 0], -0.36)):
        points[(points == at).all(axis=1), 1] += step
    surface = replace(surface, points=points)
    opened = opened_model(surface, tets)
    before, after = measures_of(surface, tets), measures_of(opened.surface, opened.grain_tets)
    assert not is_poor(before).any() and opened.warning is None
    assert (before[:, 2] < 15).sum() > 0 == (after[:, 2] < 15).sum()
    assert not (is_poor(after) | is_stretched(after)).any()
    moves = np.linalg.norm(opened.surface.points - points, axis=1)
    # the longest mean edge is less than a cube's diagonal
    assert 0 < moves.max() < NARROW_REACH * np.sqrt(3)
    assert check_tets(assemble(opened.surface, opened.grain_tets)[0]) == []


def test_no_volume_drifts_too_far_for_stretched_tets(monkeypatch):
    surface, tets = pushed_box(push=np.array([0.65, 0.0, 0.0]))
    drifts = []
    for most in (MOST_DRIFT, 1e-5):
        monkeypatch.setattr(surface_moves, "MOST_DRIFT", most)
        opened = opened_model(surface, tets)
        assert opened.report["poor_before"] == 0 < opened.report["stretched_before"]
        volumes = [side_volumes(s.points, s.facets, s.sides) for s in (surface, opened.surface)]
        drifts.append(max(map(abs, volume_drift(*volumes).values())))
        assert drifts[-1] == pytest.approx(opened.report["volume_drift_worst"])
    assert drifts[0] > 1e-5 >= drifts[1]


def test_nothing_changes_far_from_tets_at_fault():
    cells = 13
    surface, tets = structured_box((cells,) * 3, lambda c: np.where(c[:, 0] < 3, 1, 2))
    points = surface.points.copy()
    points[(points == [3, 3, 3]).all(axis=1)] += PUSH
    surface = replace(surface, points=points)
    opened = opened_model(surface, tets)
    assert opened.report["flat_before"] > 0 == opened.report["flat_left"]
    before, after = (Model(s, t) for s, t in ((surface, tets), (opened.surface, opened.grain_tets)))
    # a layer is a cell at most; the tets at fault reach a cell and a half from the node
    far = (abs(before.points[before.tets] - [3, 3, 3]) > LAYERS + 2.5).any(axis=(1, 2))
    assert 0 < far.sum() < len(before.tets)
    kept = {corners.tobytes() for corners in after.points[after.tets]}
    assert all(corners.tobytes() in kept for corners in before.points[before.tets[far]])
    for grain in (1, 2):
        volume = [shape_measures(one.points, one.tets[one.grain == grain])[:, 0] for one in (before, after)]
        assert (volume[1] > 0).all() and volume[1].sum() == pytest.approx(
            side_volumes(after.surface.points, surface.facets, surface.sides)[grain], rel=1e-12
        )


def test_the_same_input_gives_the_same_bytes():
    first, second = (opened_model(*pushed_box()) for _ in range(2))
    assert first.surface.points.tobytes() == second.surface.points.tobytes()
    for a, b in zip(first.grain_tets, second.grain_tets):
        assert a.tets.tobytes() == b.tets.tobytes() and a.interior.tobytes() == b.interior.tobytes()
