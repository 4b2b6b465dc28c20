"""The crack in the surface: conformal, on its own surface, grains and volumes as they were."""

from dataclasses import replace

import numpy as np
import pytest
from given_cracks import wavy_disc
from models import with_voids
from scipy.spatial import cKDTree
from structured_box import structured_box

from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.series import prescribed_crack
from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.errors import CraftmeshError
from craftmesh.insertion.attempts import refuse_intersections
from craftmesh.insertion.insert import insert_crack
from craftmesh.insertion.options import InsertOptions
from craftmesh.insertion.sheet import sheet_of
from craftmesh.remeshing.remesh import remesh
from craftmesh.sizing.sizing import Sizing, SizingOptions, densify, sizing_for
from craftmesh.surface.check_surface import check_surface
from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.front import front_edges
from craftmesh.surface.measure import area_vectors, facet_angles, side_volumes
from craftmesh.types import CRACK, Surface, Voxels

SIZE = 32.0
ORIGIN = np.array([5.0, -3.0, 2.0])
BOX = np.stack([ORIGIN, ORIGIN + SIZE])


@pytest.fixture(scope="module")
def polycrystal():
    """A smoothed polycrystal with two voids and an embedded grain."""
    return with_voids(32, 14, 3, 4.0, tuple(ORIGIN))


def at(*fractions) -> tuple:
    return tuple(ORIGIN + SIZE * np.array(fractions))


CRACKS = {
    "semicircle": CrackOptions(centre=at(0.5, 0.0, 0.5), radius=0.4 * SIZE),
    "tilted_semi_ellipse": CrackOptions(
        shape="ellipse", centre=at(0.45, 1.0, 0.6), semi_axes=(10.0, 7.0), normal=(0.3, 0.2, 1.0)
    ),
    "quarter_circle": CrackOptions(centre=at(1.0, 0.0, 0.4), radius=11.0, normal=(0.1, -0.15, 1.0)),
    "corner": CrackOptions(centre=at(0.0, 0.0, 0.0), radius=12.0, normal=(1.0, -0.8, 0.1)),
    "penny": CrackOptions(centre=at(0.52, 0.48, 0.45), radius=9.3, normal=(1.0, 1.0, 1.0)),
    "small_penny": CrackOptions(centre=at(0.3, 0.6, 0.3), radius=2.0, normal=(0.2, 1.0, 0.4)),
    "wide_penny": CrackOptions(centre=at(0.5, 0.5, 0.5), radius=0.55 * SIZE, normal=(0.1, 0.2, 1.0)),
    "through_edge": CrackOptions(
        shape="through_edge",
        centre=at(0.0, 0.5, 0.47),
        axis=(1.0, 0.0, 0.0),
        radius=13.0,
        normal=(0.0, 0.1, 1.0),
    ),
    "through_box_edges": CrackOptions(
        centre=at(0.0, 0.0, 0.5), radius=12.0, normal=(1.0, -1.0, 0.0), axis=(0.0, 0.0, 1.0)
    ),
    "touching_the_box": CrackOptions(centre=at(0.5, 0.25, 0.4), radius=0.25 * SIZE),
    "tiny": CrackOptions(centre=at(0.41, 0.52, 0.33), radius=0.4),
    "on_voxel_plane": CrackOptions(centre=at(0.5, 0.5, 0.5), radius=10.0),
}


@pytest.fixture(scope="module", params=CRACKS, ids=str)
def cracked(request, polycrystal):
    crack = prescribed_crack(BOX, CRACKS[request.param])
    return polycrystal, crack, *insert_crack(polycrystal, crack, None)


def crack_area(surface: Surface) -> float:
    crack = surface.facets[surface.kind == CRACK]
    return np.linalg.norm(area_vectors(surface.points, crack), axis=1).sum()


def test_the_cracked_surface_is_sound(cracked):
    _, _, surface, _ = cracked
    assert check_surface(surface) == []


def test_grains_keep_their_volumes(cracked):
    before, _, after, _ = cracked
    old = side_volumes(before.points, before.facets, before.sides)
    new = side_volumes(after.points, after.facets, after.sides)
    assert old.keys() == new.keys()
    # snapping moves boundary points by up to 0.2 of an edge; 3e-4 was the largest change measured
    assert max(abs(new[g] / old[g] - 1) for g in old) < 2e-3


def test_without_snapping_volumes_are_kept_exactly(polycrystal):
    crack = prescribed_crack(BOX, CRACKS["tilted_semi_ellipse"])
    after, _ = insert_crack(polycrystal, crack, None, InsertOptions(snap=0.0, snap_front=0.0))
    old = side_volumes(polycrystal.points, polycrystal.facets, polycrystal.sides)
    new = side_volumes(after.points, after.facets, after.sides)
    assert max(abs(new[g] / old[g] - 1) for g in old) < 1e-9
    assert check_surface(after) == []


def test_crack_facets_lie_on_the_crack_and_face_its_normal(cracked):
    _, crack, surface, _ = cracked
    sheet = sheet_of(crack, BOX)
    facets = surface.facets[surface.kind == CRACK]
    assert np.abs(sheet.offset(surface.points[np.unique(facets)])).max() < 1e-9
    assert (area_vectors(surface.points, facets) @ sheet.frame[2] > 0).all()


def test_front_nodes_lie_on_the_front_at_the_size_asked_for(cracked):
    before, crack, surface, _ = cracked
    sheet = sheet_of(crack, BOX)
    edges = front_edges(surface)
    nodes = np.unique(edges)
    # front points that nearly touch a trace are taken as they are: 1e-3 of an edge
    assert np.abs(sheet.rim.inside(sheet.uv(surface.points[nodes]))).max() < 2e-3
    inside = (surface.points[nodes] >= BOX[0]).all() and (surface.points[nodes] <= BOX[1]).all()
    assert inside
    length = np.linalg.norm(surface.points[edges[:, 0]] - surface.points[edges[:, 1]], axis=1)
    size = np.median(length)
    # boundaries that meet the front close to each other leave short edges: 4 of 38 at most
    assert (length < 0.5 * size).mean() < 0.11
    assert length.max() < 1.6 * size


def test_there_are_no_ears_and_no_chords(cracked):
    _, _, surface, _ = cracked
    edges = front_edges(surface)
    on_front = np.zeros(len(surface.points), bool)
    on_front[edges] = True
    facets = surface.facets[surface.kind == CRACK]
    assert not on_front[facets].all(axis=1).any()
    inner, _, _ = unique_edges(facets)
    chords = set(map(tuple, inner[on_front[inner].all(axis=1)].tolist())) - set(map(tuple, edges.tolist()))
    assert not chords


@pytest.mark.parametrize("name", ["penny", "small_penny", "quarter_circle", "through_edge"])
def test_the_crack_has_the_area_of_its_part_in_the_material(polycrystal, name):
    crack = prescribed_crack(BOX, CRACKS[name])
    surface, report = insert_crack(polycrystal, crack, None)
    sheet = sheet_of(crack, BOX)
    low, high = sheet.nodes.min(axis=0), sheet.nodes.max(axis=0)
    step = (high - low).max() / 150
    u, v = np.meshgrid(*(np.arange(low[i], high[i], step) + step / 2 for i in range(2)), indexing="ij")
    uv = np.stack([u.ravel(), v.ravel()], axis=1)
    points = sheet.lift(uv)
    inside = (sheet.rim.inside(uv) > 0) & ((points > BOX[0]) & (points < BOX[1])).all(axis=1)
    outside = report["crack_facets_outside_material"]
    exact = inside.sum() * step**2
    # chords of one edge cut off (1 / 6) (edge / radius)^2 of a circle: 4% at radius 2; a void takes more
    assert crack_area(surface) == pytest.approx(report["crack_area"])
    assert crack_area(surface) == pytest.approx(exact, rel=0.05 if not outside else 0.3)


def test_a_penny_inside_one_grain_leaves_the_boundaries_alone(polycrystal):
    inner = (
        np.stack(np.meshgrid(*[np.arange(3.0, SIZE - 3)] * 3, indexing="ij"), -1).reshape(-1, 3) + ORIGIN
    )
    free = (polycrystal.sides < 0).any(axis=1)
    depth = cKDTree(polycrystal.points).query(inner)[0]
    depth -= 100 * (cKDTree(polycrystal.points[polycrystal.facets[free, 0]]).query(inner)[0] < 6)
    centre = inner[np.argmax(depth)]
    options = CrackOptions(centre=tuple(centre), radius=depth.max() - 1.5, normal=(0.2, 1.0, 0.4))
    surface, report = insert_crack(polycrystal, prescribed_crack(BOX, options), None)
    crack = surface.kind == CRACK
    assert report["crack_grains"] == 1
    assert np.array_equal(surface.facets[~crack], polycrystal.facets)
    assert np.array_equal(surface.points[: len(polycrystal.points)], polycrystal.points)
    assert (surface.sides[crack] == surface.sides[crack][0, 0]).all() and surface.sides[crack].min() > 0


def test_grains_of_crack_facets_hold_their_centres(cracked):
    """A ray from a facet's centre first meets a boundary of the facet's own grain."""
    _, _, surface, _ = cracked
    boundary = surface.kind != CRACK
    rng = np.random.default_rng(0)
    rows = np.flatnonzero((surface.kind == CRACK) & (surface.sides[:, 0] == surface.sides[:, 1]))
    for row in rng.choice(rows, 12).tolist():
        origin = surface.points[surface.facets[row]].mean(axis=0)
        label = first_label(
            surface.points, origin, rng.normal(size=3), surface.facets[boundary], surface.sides[boundary]
        )
        assert label == surface.sides[row, 0]


def first_label(points, origin, direction, facets, sides) -> int:
    """The label before the first facet on a ray: plane by plane, then three orientation tests."""
    a, b, c = (points[facets[:, i]] - origin for i in range(3))
    normal = np.cross(b - a, c - a)
    with np.errstate(all="ignore"):
        distance = np.einsum("ij,ij->i", a, normal) / (normal @ direction)
    signs = [np.sign(np.cross(p, q) @ direction) for p, q in ((a, b), (b, c), (c, a))]
    hit = np.flatnonzero((signs[0] == signs[1]) & (signs[1] == signs[2]) & (distance > 0))
    nearest = hit[np.argmin(distance[hit])]
    return int(sides[nearest, 0] if normal[nearest] @ direction > 0 else sides[nearest, 1])


def test_front_edges_follow_the_sizing(polycrystal):
    crack = prescribed_crack(BOX, CRACKS["penny"])
    sources = np.concatenate([crack.points[front] for front in crack.fronts])
    sizing = Sizing(l_min=0.5, l0=1.0, l_max=1.5, r0=3.0, r1=8.0, exponent=1.0, sources=sources)
    surface, _ = insert_crack(polycrystal, crack, sizing)
    edges = front_edges(surface)
    length = np.linalg.norm(surface.points[edges[:, 0]] - surface.points[edges[:, 1]], axis=1)
    assert np.median(length) == pytest.approx(0.5, rel=0.1)
    assert check_surface(surface) == []


def test_a_crack_along_a_flat_grain_boundary_takes_its_facets():
    model, _ = structured_box((6, 6, 6), lambda c: 1 + (c[:, 2] > 3).astype(int))
    box = np.array([[0.0, 0, 0], [6, 6, 6]])
    crack = prescribed_crack(box, CrackOptions(centre=(3, 0, 3), radius=2.2))
    surface, report = insert_crack(model, crack, None)
    facets = surface.facets[surface.kind == CRACK]
    assert report["crack_facets_on_grain_boundaries"] == len(facets) > 0
    assert {tuple(row) for row in surface.sides[surface.kind == CRACK].tolist()} == {(1, 2)}
    assert (area_vectors(surface.points, facets)[:, 2] > 0).all()
    assert check_surface(surface) == []


@pytest.mark.parametrize("amplitude", [0.5, 1.5])
def test_a_curved_crack_stays_on_its_surface(polycrystal, amplitude):
    points, triangles = wavy_disc(9.0, amplitude, rings=14)
    crack = crack_from_triangles(points + at(0.5, 0.9, 0.5), triangles, None, BOX)
    surface, report = insert_crack(polycrystal, crack, None)
    sheet = sheet_of(crack, BOX)
    facets = surface.facets[surface.kind == CRACK]
    assert np.abs(sheet.offset(surface.points[np.unique(facets)])).max() < 0.02
    assert np.abs(sheet.offset(surface.points[facets].mean(axis=1))).max() < 0.05
    nodes = np.unique(front_edges(surface))
    foot = sheet.lift(sheet.rim.nearest_front(sheet.uv(surface.points[nodes]))[0])
    assert np.linalg.norm(foot - surface.points[nodes], axis=1).max() < 0.02
    assert check_surface(surface) == []


def test_the_same_input_gives_the_same_bytes(polycrystal):
    crack = prescribed_crack(BOX, CRACKS["semicircle"])
    first, again = (insert_crack(polycrystal, crack, None)[0] for _ in range(2))
    assert first.points.tobytes() == again.points.tobytes()
    assert first.facets.tobytes() == again.facets.tobytes()
    assert first.sides.tobytes() == again.sides.tobytes()


def test_a_crack_wholly_in_a_void_is_refused(polycrystal):
    facets = polycrystal.facets[(polycrystal.sides == -1).any(axis=1)]
    centre = polycrystal.points[np.unique(facets)].mean(axis=0)
    crack = prescribed_crack(BOX, CrackOptions(centre=tuple(centre), radius=1.5))
    with pytest.raises(CraftmeshError, match="no grain"):
        insert_crack(polycrystal, crack, None)


def test_crack_facets_that_meet_the_box_are_refused():
    model, _ = structured_box((2, 2, 2), lambda c: np.ones(len(c), int))
    corners = np.array([[0.3, 0.4, 1.0], [1.6, 0.5, 1.0], [1.1, 1.2, 2.3]])
    n = len(model.points)
    poking = Surface(
        np.concatenate([model.points, corners]),
        np.concatenate([model.facets, [[n, n + 1, n + 2]]]),
        np.concatenate([model.sides, [[1, 1]]]),
        np.append(model.kind, CRACK),
    )
    with pytest.raises(CraftmeshError, match="intersect others near"):
        refuse_intersections(poking)
    corners[2, 2] = 1.7
    inside = Surface(np.concatenate([model.points, corners]), poking.facets, poking.sides, poking.kind)
    refuse_intersections(inside)


@pytest.mark.parametrize("slope", [0.01, 0.03, 0.05])
def test_a_triple_line_that_grazes_the_crack_leaves_no_slivers(slope):
    x, y, z = np.indices((24, 16, 16)) + 0.5
    labels = np.where(z < 8 + slope * (x - 12), 1, np.where(y < 8.2, 2, 3))
    voxels = Voxels(labels, (1, 1, 1), (0, 0, 0))
    surface, _ = remesh(voxels)
    options = CrackOptions(shape="penny", centre=(12, 8, 8.01), normal=(0, 0.6 * slope, 1), radius=6.0)
    crack = prescribed_crack(voxels.box, options)
    sources = np.concatenate([densify(crack.points[front], 0.1) for front in crack.fronts])
    sizing = sizing_for(surface, sources, SizingOptions(l_min=0.5, l0=1.0, l_max=2.0, r0=6.0, r1=12.0))
    cut, _ = insert_crack(surface, crack, sizing)
    # Measured: 8.8 degrees at facets split along the front; 0.5 where the line's points stay off the crack.
    assert facet_angles(cut.points, cut.facets).min() > 8
    assert check_surface(cut) == []


@pytest.mark.parametrize("seed", [32, 107, 293])
def test_long_facets_with_a_corner_on_the_crack_are_cut(seed):
    """The corner is just inside the front, and the trace from it leaves the facet far outside."""
    rng, stretch = np.random.default_rng(seed), np.array([4.0, 1.0, 1.0])
    model, _ = structured_box((8, 8, 4), lambda c: np.where(c[:, 0] < 4, 1, 2))
    model = replace(model, points=model.points * stretch)
    corner = rng.integers([2, 2, 1], [7, 7, 4]) * stretch
    normal, away = rng.normal(size=(2, 3))
    normal /= np.linalg.norm(normal)
    away -= away @ normal * normal
    radius = rng.uniform(0.8, 3)
    centre = corner + away / np.linalg.norm(away) * (radius - rng.uniform(0.05, 0.4))
    options = CrackOptions(centre=tuple(centre), normal=tuple(normal), radius=radius)
    crack = prescribed_crack(model.box, options)
    sources = np.concatenate([densify(crack.points[front], 0.3) for front in crack.fronts])
    surface, _ = insert_crack(model, crack, Sizing(0.6, 1.0, 2.0, 4.0, 8.0, 1.0, sources))
    assert check_surface(surface) == []
