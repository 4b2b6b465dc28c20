"""Points slide within grain boundaries and faces of the box until the tets round them are better."""

from dataclasses import replace

import numpy as np
import pytest
from structured_box import plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.mesh.check_tets import check_tets
from craftmesh.mesh.shape_measures import is_flat, is_poor, shape_measures
from craftmesh.surface.classification import Classification
from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.kernels.ranks import AT_JUNCTION, IN_PATCH, ON_LINE
from craftmesh.surface.measure import mean_edges, side_volumes
from craftmesh.tetrahedra.kernels.tet_quality import COMBINED_QUALITY, all_qualities
from craftmesh.tetrahedra.kernels.tet_smoothing import FREE_FROM
from craftmesh.tetrahedra.options import TetrahedralizeOptions
from craftmesh.tetrahedra.record import record_of
from craftmesh.tetrahedra.surface_freedom import SLIDE
from craftmesh.tetrahedra.surface_moves import given_way, is_stretched, slid
from craftmesh.tetrahedra.volume import Volume, complete_volume
from craftmesh.tetrahedra.whole_mesh import Model
from craftmesh.types import CRACK

CELLS = 5


def shaken_box(seed, crack_at=None, out_of_plane=0.0):
    """Two grains with all points inside patches shaken within their plane, or off the boundary's too."""
    surface, tets = structured_box((CELLS,) * 3, lambda c: np.where(c[:, 0] < 2, 1, 2), crack_at)
    classes = Classification(surface)
    step = np.random.default_rng(seed).uniform(-0.25, 0.25, surface.points.shape)
    step[classes.held] = 0.0
    boundary = ~classes.held.any(axis=1)
    step[boundary, 0] *= out_of_plane / 0.25
    step[classes.rank != IN_PATCH] = 0.0
    return replace(surface, points=surface.points + step), tets


def is_at_fault(measures):
    return is_poor(measures) | is_stretched(measures)


def smoothed_surface(surface, tets):
    """Return the model with its points slid."""
    return slid(Model(surface, tets))[0]


def measures_of(surface, tets):
    model = Model(surface, tets)
    return shape_measures(model.points, model.tets)


def worst_round_points(surface, tets) -> np.ndarray:
    """Return the worst quality (n,) round each point of the surface, tet by tet."""
    model = Model(surface, tets)
    quality, worst = np.empty(len(model.tets)), np.full(len(model.points), np.inf)
    all_qualities(model.points, model.tets, len(model.tets), quality, COMBINED_QUALITY)
    for corners, value in zip(model.tets.tolist(), quality.tolist()):
        worst[corners] = np.minimum(worst[corners], value)
    return worst[: len(surface.points)]


@pytest.mark.parametrize("seed", range(4))
def test_the_mean_aspect_ratio_falls_and_no_tet_is_at_fault_more(seed):
    surface, tets = shaken_box(seed, out_of_plane=0.03)
    found = smoothed_surface(surface, tets)
    before, after = measures_of(surface, tets), measures_of(found.surface, found.grain_tets)
    assert after[:, 1].mean() < before[:, 1].mean() - 0.02
    for is_bad in (is_flat, is_poor, is_stretched):
        assert is_bad(after).sum() <= is_bad(before).sum()
    worst = [worst_round_points(*one).min() for one in ((surface, tets), (found.surface, found.grain_tets))]
    assert worst[1] >= min(worst[0], FREE_FROM) - 1e-8
    assert check_tets(assemble(found.surface, found.grain_tets)[0]) == []
    assert (found.surface.facets == surface.facets).all()


def test_points_stay_in_their_plane_and_lines_and_volumes_stay():
    surface, tets = shaken_box(0)
    found = smoothed_surface(surface, tets)
    before, after = surface.points, found.surface.points
    for plane in (0.0, float(CELLS)):
        assert (after[before == plane] == plane).all()
    assert (after[before[:, 0] == 2.0, 0] == 2.0).all()
    rank = Classification(surface).rank
    moved = (after != before).any(axis=1)
    assert moved[rank == IN_PATCH].mean() > 0.5 and moved[rank == ON_LINE].mean() > 0.5
    assert not moved[rank == AT_JUNCTION].any()
    moves = np.linalg.norm(after - before, axis=1)
    edges, _, _ = unique_edges(surface.facets)
    assert (moves <= SLIDE * mean_edges(surface.points, edges) * (1 + 1e-12)).all()
    volumes = [side_volumes(at, surface.facets, surface.sides) for at in (before, after)]
    assert volumes[0] == pytest.approx(volumes[1], rel=1e-12)


def test_points_where_a_line_is_bent_stay_and_interior_points_beside_the_surface_move():
    surface, tets = shaken_box(3)
    bent = int(np.flatnonzero((surface.points == [2.0, 2.0, 0.0]).all(axis=1))[0])
    assert Classification(surface).rank[bent] == ON_LINE
    points = surface.points.copy()
    points[bent, 0] += 0.4
    found = smoothed_surface(replace(surface, points=points), tets)
    assert (found.surface.points[bent] == points[bent]).all()
    inner = [np.concatenate([one.interior for one in each]) for each in (tets, found.grain_tets)]
    moved = (inner[0] != inner[1]).any(axis=1)
    beside = ((inner[0] < 1.5) | (inner[0] > CELLS - 1.5)).any(axis=1) | (abs(inner[0][:, 0] - 2.0) < 1.5)
    assert moved[beside].mean() > 0.3 and not moved[~beside].any()


def test_the_crack_and_bent_places_stay():
    crack_at = plane_crack(0, 2, lambda c: np.maximum(abs(c[:, 1] - 2.5), abs(c[:, 2] - 2.5)) < 1.5)
    surface, tets = structured_box((CELLS,) * 3, lambda c: np.where(c[:, 0] < 2, 1, 2))
    cracked, _ = structured_box((CELLS,) * 3, lambda c: np.where(c[:, 0] < 2, 1, 2), crack_at)
    shaken, _ = shaken_box(1)
    bent = (surface.points == [CELLS, 2.0, 2.0]).all(axis=1)
    points = shaken.points + np.where(bent[:, None], [-0.5, 0.0, 0.0], 0.0)
    # a dent in a face of the box is none of the box
    kind = np.where(bent[surface.facets].any(axis=1), 0, cracked.kind)
    given = replace(surface, points=points, kind=kind)
    found = smoothed_surface(given, tets)
    on_crack = np.unique(given.facets[given.kind == CRACK])
    assert len(on_crack) > 10
    assert (found.surface.points[on_crack] == points[on_crack]).all()
    assert (found.surface.points[bent] == points[bent]).all()
    assert (found.surface.points != points).any()


def test_points_with_equal_places_stay_together():
    surface, tets = shaken_box(2)
    twin = int(np.flatnonzero((surface.points[:, 0] == 2.0) & (Classification(surface).rank == 0))[0])
    alone = smoothed_surface(surface, tets).surface.points[twin]
    assert (alone != surface.points[twin]).any()
    doubled = replace(surface, points=np.vstack([surface.points, surface.points[twin]]))
    found = smoothed_surface(doubled, tets)
    assert (found.surface.points[[twin, -1]] == surface.points[twin]).all()


def test_the_record_names_the_poor_tets_that_are_left_and_without_optimise_nothing_moves():
    surface, tets = shaken_box(3)
    options = TetrahedralizeOptions()
    record = record_of(options.mesher, {"poor": {"1": [{"dihedrals": [1.0, 90.0]}]}}, [], None)
    filled = Volume(surface, tets, record)
    found = complete_volume(filled, lambda: None, options)
    mesh, _ = assemble(found.surface, found.grain_tets)
    assert found.record["smoothed"]["surface_points_moved"] > 0
    assert is_poor(shape_measures(mesh.points, mesh.tets)).sum() == 0
    assert found.record["poor"] == {}
    kept = complete_volume(filled, lambda: None, replace(options, optimise=False))
    assert kept.record["smoothed"] is None
    assert kept.surface.points.tobytes() == given_way(Model(surface, tets)).model.surface.points.tobytes()


def bytes_of(surface, grain_tets):
    parts = [surface.points.tobytes()]
    for one in grain_tets:
        parts += [one.nodes.tobytes(), one.interior.tobytes(), one.tets.tobytes()]
    return b"".join(parts)


def test_the_same_input_gives_the_same_bytes_in_whatever_order_the_grains_come():
    surface, tets = shaken_box(4)
    first, second = (
        complete_volume(Volume(surface, own, {}), lambda: None, TetrahedralizeOptions())
        for own in (tets, tets[::-1])
    )
    assert bytes_of(first.surface, first.grain_tets) == bytes_of(second.surface, second.grain_tets)


@pytest.mark.parametrize("seed", range(3))
def test_the_report_says_what_slid_and_no_tet_at_fault_is_left_once_the_surface_gives_way(seed):
    surface, tets = shaken_box(seed, out_of_plane=0.03)
    found, report = slid(Model(surface, tets))
    means = [measures_of(*one)[:, 1].mean() for one in ((surface, tets), (found.surface, found.grain_tets))]
    assert report["aspect_ratio_mean"] == pytest.approx(means)
    moves = np.linalg.norm(found.surface.points - surface.points, axis=1)
    assert report["surface_points_moved"] == (moves > 0).sum() > 0
    assert report["largest_move"] == moves.max()
    volumes = [side_volumes(s.points, s.facets, s.sides) for s in (surface, found.surface)]
    # the boundary is rough by .03, and its points slide on tangent planes
    assert volumes[0] == pytest.approx(volumes[1], rel=1e-3)
    last = given_way(found).model
    assert not is_at_fault(measures_of(last.surface, last.grain_tets)).any()
