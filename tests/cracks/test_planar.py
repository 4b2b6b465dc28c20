"""The kernels of plane triangulations against scipy, shapely and plain loops over all triangles."""

import numpy as np
import pytest
import shapely
from scipy.spatial import Delaunay

from craftmesh.cracks.in_plane import triangulate, with_room
from craftmesh.errors import CraftmeshError
from craftmesh.surface.kernels import planar
from craftmesh.surface.kernels.planar import Candidates, Planar

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def square_with_room(points: np.ndarray) -> Planar:
    """The unit square as two triangles; `points` (n, 2) have rows after its corners but are not in it."""
    rows = 2 * len(points) + 2
    corners, across = np.full((rows, 3), -1), np.full((rows, 3), -1)
    corners[:2] = [[0, 1, 2], [0, 2, 3]]
    across[:2] = [[-1, -1, 1], [0, -1, -1]]
    uv = np.concatenate([SQUARE, points])
    return Planar(uv, corners, across, np.zeros((rows, 3), bool), np.array([len(uv), 2]))


def with_diagonal_fixed(points: np.ndarray) -> Planar:
    mesh = square_with_room(points)
    mesh.fixed[0, 2] = mesh.fixed[1, 0] = True
    return mesh


def filled(points: np.ndarray) -> Planar:
    mesh = square_with_room(points)
    for point in range(4, len(mesh.uv)):
        assert planar.insert_point(mesh, planar.locate(mesh, 0, point, False), point) == planar.DONE
    return mesh


def random_points(seed: int, count: int = 60) -> np.ndarray:
    return np.random.default_rng(seed).uniform(0.01, 0.99, (count, 2))


def as_set(triangles) -> set:
    return {tuple(sorted(row)) for row in np.asarray(triangles).tolist()}


def edges_of(mesh: Planar) -> dict:
    """Directed edge -> (triangle, side), by a plain loop."""
    rows = mesh.triangles.tolist()
    return {(row[i], row[(i + 1) % 3]): (t, i) for t, row in enumerate(rows) for i in range(3)}


def assert_sound(mesh: Planar, area: float = 1.0) -> None:
    """Triangles are positive and cover the area once, links are mutual, both sides agree on fixed."""
    assert min(planar.turn(mesh.uv, *row) for row in mesh.triangles) > 0
    assert sum(shapely.Polygon(mesh.uv[row]).area for row in mesh.triangles) == pytest.approx(area)
    sides = edges_of(mesh)
    assert len(sides) == 3 * len(mesh.triangles)
    for (a, b), (t, i) in sides.items():
        u, j = sides.get((b, a), (-1, -1))
        assert mesh.across[t, i] == u
        assert u < 0 or mesh.fixed[t, i] == mesh.fixed[u, j]


def unsettled(mesh: Planar) -> int:
    """The free edges whose opposite point lies in the circle of their triangle, by determinants."""
    sides, count = edges_of(mesh), 0
    for (a, b), (t, i) in sides.items():
        if (b, a) in sides and not mesh.fixed[t, i]:
            u, j = sides[b, a]
            step = mesh.uv[mesh.corners[t]] - mesh.uv[mesh.corners[u, (j + 2) % 3]]
            count += np.linalg.det(np.column_stack([step, (step**2).sum(axis=1)])) > 1e-9
    return count


@pytest.mark.parametrize("seed", range(5))
def test_inserted_points_give_the_delaunay_triangulation(seed):
    mesh = filled(random_points(seed))
    assert_sound(mesh)
    assert as_set(mesh.triangles) == as_set(Delaunay(mesh.uv).simplices)


def test_points_of_a_lattice_are_inserted_on_edges_and_settle():
    lattice = np.stack(np.meshgrid(*[np.arange(1, 8) / 8] * 2), axis=-1).reshape(-1, 2)
    mesh = filled(lattice[np.random.default_rng(0).permutation(len(lattice))])
    assert_sound(mesh)
    assert unsettled(mesh) == 0


def test_thousands_of_flips_that_follow_one_another_are_all_made():
    """A fan of needles about a point far from a rough rim."""
    angle = np.linspace(0.0, np.pi / 2, 3000)
    uv = np.concatenate([[[0.0, 0.0]], np.stack([np.cos(angle), np.sin(angle)], axis=1)])
    uv[1:] *= 1 - 1e-3 * np.random.default_rng(0).random((3000, 1))
    row = np.arange(2999)
    corners = np.stack([0 * row, row + 1, row + 2], axis=1)
    across = np.stack([row - 1, 0 * row - 1, np.where(row < 2998, row + 1, -1)], axis=1)
    mesh = Planar(uv, corners, across, np.zeros((2999, 3), bool), np.array([3001, 2999]))
    area = sum(shapely.Polygon(uv[t]).area for t in corners)
    planar.legalise_all(mesh)
    assert_sound(mesh, area)
    assert unsettled(mesh) == 0


@pytest.mark.parametrize("seed", range(3))
def test_a_walk_ends_in_the_triangle_that_holds_the_point(seed):
    points = random_points(seed)
    mesh = filled(points[:40])
    mesh = mesh._replace(uv=np.concatenate([mesh.uv, points[40:]]))
    polygons = [shapely.Polygon(mesh.uv[row]) for row in mesh.triangles]
    for point in range(44, 64):
        holding = [t for t, p in enumerate(polygons) if p.covers(shapely.Point(mesh.uv[point]))]
        assert [planar.locate(mesh, start, point, False) for start in (0, 17)] == holding * 2


@pytest.mark.parametrize("exponent", [-30, 0, 30])
@pytest.mark.parametrize(
    ("behind", "triangle"), [(1e-13, 0), (1e-10, -1)]
)  # of the edge; rounding is 1e-12
def test_what_is_rounding_behind_an_edge_goes_by_its_length(behind, triangle, exponent):
    mesh = square_with_room(np.array([[0.5, -behind]]))
    mesh = mesh._replace(uv=np.ldexp(mesh.uv, exponent))
    assert planar.locate(mesh, 0, 4, False) == triangle


def test_a_walk_stops_at_a_fixed_edge_unless_it_may_pass():
    mesh = with_diagonal_fixed(np.array([[0.2, 0.7]]))
    assert planar.locate(mesh, 0, 4, False) == -1
    assert planar.locate(mesh, 0, 4, True) == 1


def test_a_point_on_a_fixed_edge_is_blocked_and_nothing_changes():
    mesh = with_diagonal_fixed(np.array([[0.5, 0.5]]))
    before = mesh.corners.copy()
    assert planar.insert_point(mesh, 0, 4) == planar.BLOCKED
    assert np.array_equal(mesh.corners, before) and mesh.used.tolist() == [5, 2]


@pytest.mark.parametrize("seed", range(6))
def test_recovered_edges_are_there_and_the_rest_is_constrained_delaunay(seed):
    mesh = filled(random_points(seed, 30))
    drawn: list[tuple[int, int]] = []
    for a, b in np.random.default_rng(seed).integers(0, len(mesh.uv), (40, 2)).tolist():
        line = shapely.LineString(mesh.uv[[a, b]])
        if a == b or any(line.crosses(shapely.LineString(mesh.uv[list(pair)])) for pair in drawn):
            continue
        assert planar.recover_edge(mesh, a, b)
        drawn.append((a, b))
        for key in ((a, b), (b, a)):
            if key in edges_of(mesh):
                mesh.fixed[edges_of(mesh)[key]] = True
    planar.legalise_all(mesh)
    assert len(drawn) > 5
    assert_sound(mesh)
    assert unsettled(mesh) == 0
    assert all((a, b) in edges_of(mesh) or (b, a) in edges_of(mesh) for a, b in drawn)


def test_an_edge_across_a_fixed_one_is_not_recovered():
    mesh = with_diagonal_fixed(np.zeros((0, 2)))
    assert not planar.recover_edge(mesh, 1, 3)
    mesh.fixed[:] = False
    assert planar.recover_edge(mesh, 1, 3)
    assert_sound(mesh)


def test_splitting_an_edge_keeps_what_is_fixed():
    mesh = with_diagonal_fixed(np.array([[0.5, 0.5]]))
    assert planar.split_inner_edge(mesh, 0, 2, 4) == (2, 3)
    assert_sound(mesh)
    fixed = {tuple(sorted(edge)) for edge, side in edges_of(mesh).items() if mesh.fixed[side]}
    assert fixed == {(0, 4), (2, 4)}


def test_spaced_candidates_keep_their_distances():
    k = 500
    mesh = square_with_room(np.zeros((k, 2)))
    mesh.used[0] = 4
    uv = np.random.default_rng(2).uniform(0, 1, (k, 2))
    wanted = Candidates(uv, np.zeros(k, int), np.full(k, 0.12), np.full(k, 0.05))
    inserted = planar.insert_spaced(mesh, wanted, np.zeros(len(mesh.corners), bool))
    assert 20 < inserted == mesh.used[0] - 4 <= 100
    used = mesh._replace(uv=mesh.uv[: mesh.used[0]])
    assert_sound(used)
    assert as_set(used.triangles) == as_set(Delaunay(used.uv).simplices)
    # distances are kept from the corners of the triangle and of its neighbours: here these are the nearest
    assert (np.linalg.norm(used.uv[:, None] - used.uv[None], axis=2) + np.eye(len(used.uv))).min() >= 0.12
    # clearance from the fixed edges of the triangle alone: 0.0486 where a neighbour has the rim
    assert shapely.MultiPoint(used.uv[4:]).distance(shapely.LinearRing(SQUARE)) >= 0.045
    assert planar.insert_spaced(mesh, wanted, np.ones(len(mesh.corners), bool)) == 0


def ring(count: int, radius: float) -> np.ndarray:
    angle = 2 * np.pi * np.arange(count) / count
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def closed(first: int, count: int) -> np.ndarray:
    row = np.arange(count)
    return first + np.stack([row, (row + 1) % count], axis=1)


def everywhere(uv: np.ndarray) -> np.ndarray:
    return np.ones(len(uv))


def annulus() -> tuple[Planar, np.ndarray, shapely.Polygon]:
    """The patch between two rings, with a trace and a loose point inside; its segments; its polygon."""
    uv = np.concatenate([ring(60, 3.0), ring(20, 1.0), [[2.0, 0.1], [2.4, 0.3], [0.0, -2.0]]])
    segments = np.concatenate([closed(0, 60), closed(60, 20), [[80, 81]]])
    patch = triangulate(uv, segments, np.array([82]), lambda at: np.linalg.norm(at, axis=1) - 1)
    return patch, segments, shapely.Polygon(uv[:60], [uv[60:80]])


def in_use(patch: Planar) -> Planar:
    return patch._replace(uv=patch.uv[: patch.used[0]])


def test_a_patch_has_every_segment_and_point_and_covers_the_polygon():
    patch, segments, polygon = annulus()
    assert_sound(patch, polygon.area)
    assert np.array_equal(np.unique(patch.triangles), np.arange(83))
    sides = edges_of(patch)
    for a, b in segments.tolist():
        found = [sides[key] for key in ((a, b), (b, a)) if key in sides]
        assert found and all(patch.fixed[side] for side in found)


def test_edges_within_a_wall_are_split():
    patch = triangulate(ring(12, 1.0), closed(0, 12), np.zeros(0, int), everywhere)
    area = shapely.Polygon(ring(12, 1.0)).area
    patch = with_room(patch, 40)
    wall = np.ones((12, 1), bool)
    assert planar.split_within_walls(patch, wall, 2) == 9  # all inner edges of a dodecagon
    assert_sound(in_use(patch), area)
    assert all(max(row) >= 12 for row in patch.triangles.tolist())
    assert planar.split_within_walls(patch, wall, 2) == 0


@pytest.mark.parametrize("walls", [[range(6), range(5, 13)], [range(13)]])
def test_triangles_within_a_wall_are_split(walls):
    patch = triangulate(ring(12, 1.0), closed(0, 12), np.zeros(0, int), everywhere)
    on = np.zeros((12, len(walls)), bool)
    for w, points in enumerate(walls):
        on[[point % 12 for point in points], w] = True
    patch = with_room(patch, 40)
    planar.split_within_walls(patch, on, 3)
    assert_sound(in_use(patch), shapely.Polygon(ring(12, 1.0)).area)
    rows = [row for row in patch.triangles.tolist() if max(row) < 12]
    assert not any(on[row].all(axis=0).any() for row in rows)


def test_crossing_traces_are_refused():
    uv = np.concatenate([ring(12, 3.0), [[-1.0, 0.0], [1.0, 0.1], [0.0, -1.0], [0.1, 1.0]]])
    segments = np.concatenate([closed(0, 12), [[12, 13], [14, 15]]])
    with pytest.raises(CraftmeshError, match="the crack meets boundaries cross"):
        triangulate(uv, segments, np.zeros(0, int), everywhere)
