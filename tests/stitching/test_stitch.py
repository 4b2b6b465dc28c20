"""Surfaces of single grains become the one surface that they were taken from."""

import numpy as np
import pytest
from grain_folders import write_grain_folder
from models import real_grains, with_voids
from structured_box import structured_box

from craftmesh.errors import CraftmeshError
from craftmesh.io.surface_files import read_grain_folder
from craftmesh.stitching.stitch import StitchOptions, stitch_grains
from craftmesh.surface.check_surface import check_surface
from craftmesh.surface.connectivity import compact
from craftmesh.surface.measure import side_volumes
from craftmesh.types import INTERFACE, Surface


@pytest.fixture(scope="module")
def polycrystal():
    return with_voids(24, 10, 1, 3.0, (3.0, -1.0, 0.5))


def grains_of(surface: Surface) -> list:
    grains = []
    for grain in surface.grains.tolist():
        behind, ahead = (surface.sides == grain).T
        facets = np.concatenate([surface.facets[behind & ~ahead], surface.facets[ahead & ~behind][:, ::-1]])
        grains.append((grain, *compact(surface.points, facets)[:2]))
    return grains


def canonical(surface: Surface):
    """Points in order of their coordinates; facets as sorted corners with sides behind and ahead."""
    order = np.lexsort(surface.points.T[::-1])
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    facets = rank[surface.facets]
    low = np.argmin(facets, axis=1)[:, None]
    after, last = (np.take_along_axis(facets, (low + i) % 3, 1) for i in (1, 2))
    sides = np.where(after < last, surface.sides, surface.sides[:, ::-1])
    rows = np.column_stack([np.sort(facets, axis=1), sides, surface.kind])
    return surface.points[order], rows[np.lexsort(rows.T[::-1])]


def assert_same(first: Surface, second: Surface) -> None:
    a, b = canonical(first), canonical(second)
    assert np.array_equal(a[0], b[0])
    assert np.array_equal(a[1], b[1])


def voids_renamed(surface: Surface) -> Surface:
    sides = np.where(surface.sides < 0, -1, surface.sides)
    return Surface(surface.points, surface.facets, sides, surface.kind)


def test_taking_a_surface_apart_and_stitching_it_gives_it_back(polycrystal):
    stitched, report = stitch_grains(grains_of(polycrystal))
    assert_same(voids_renamed(stitched), voids_renamed(polycrystal))
    assert report["voids"] == 2
    assert check_surface(stitched) == []


def test_neither_order_nor_turned_normals_matter(polycrystal):
    grains = grains_of(polycrystal)
    expected, _ = stitch_grains(grains)
    other = [(g, p, t[:, ::-1] if g % 2 else t) for g, p, t in reversed(grains)]
    stitched, _ = stitch_grains(other)
    assert stitched.points.tobytes() == expected.points.tobytes()
    assert_same(stitched, expected)


def test_coordinates_of_stl_files_come_out_with_an_exact_box(polycrystal, tmp_path):
    write_grain_folder(tmp_path, polycrystal)
    stitched, _ = stitch_grains(read_grain_folder(tmp_path))
    assert check_surface(stitched) == []
    old = side_volumes(polycrystal.points, polycrystal.facets, polycrystal.sides)
    new = side_volumes(stitched.points, stitched.facets, stitched.sides)
    # float32: 1e-7 of the coordinates, over grains a quarter of the box wide
    assert max(abs(new[g] / old[g] - 1) for g in old) < 1e-5


def test_points_apart_by_rounding_are_joined_and_planes_made_exact(polycrystal):
    rng = np.random.default_rng(0)
    noise = 1e-7 * np.linalg.norm(np.ptp(polycrystal.points, axis=0))
    grains = [(g, p + noise * rng.uniform(-1, 1, p.shape), t) for g, p, t in grains_of(polycrystal)]
    stitched, _ = stitch_grains(grains)
    assert check_surface(stitched) == []
    assert len(stitched.points) == len(polycrystal.points)


def test_facets_that_collapse_are_dropped_on_both_sides():
    surface, _ = structured_box((3, 3, 3), lambda c: 1 + (c[:, 2] > 1).astype(int))
    inner = np.flatnonzero((surface.points == [1, 1, 1]).all(axis=1))[0]
    other = np.flatnonzero((surface.points == [2, 1, 1]).all(axis=1))[0]
    points = surface.points.copy()
    points[inner] = points[other] + [1e-9, 0, 0]
    moved = Surface(points, surface.facets, surface.sides, surface.kind)
    stitched, report = stitch_grains(grains_of(moved))
    assert report["degenerate_facets_dropped"] == 4
    assert check_surface(stitched) == []


def test_voids_are_numbered_by_their_lowest_point():
    def label_of(c):
        labels = np.ones(len(c), int)
        labels[((c > [1, 1, 3]) & (c < [2, 2, 4])).all(axis=1)] = 0
        labels[((c > [3, 1, 1]) & (c < [4, 2, 2])).all(axis=1)] = 0
        return labels

    surface, _ = structured_box((5, 3, 5), label_of)
    stitched, report = stitch_grains(grains_of(surface))
    assert report["voids"] == 2
    first = stitched.points[stitched.facets[(stitched.sides == -1).any(axis=1)]].reshape(-1, 3)
    second = stitched.points[stitched.facets[(stitched.sides == -2).any(axis=1)]].reshape(-1, 3)
    assert first[:, 0].max() == 2 and second[:, 0].min() == 3


def test_a_hole_open_to_the_box_is_outside():
    surface, _ = structured_box(
        (4, 4, 4), lambda c: 1 - ((c[:, :2] > 1) & (c[:, :2] < 3)).all(axis=1).astype(int)
    )
    stitched, report = stitch_grains(grains_of(surface))
    assert report["voids"] == 0 and report["exterior_facets"] == 64
    walls = (stitched.kind == INTERFACE) & (stitched.sides == 0).any(axis=1)
    assert walls.sum() == 64


def test_different_triangles_on_one_boundary_are_refused_with_the_grains(polycrystal):
    grains = grains_of(polycrystal)
    low, high = polycrystal.points.min(axis=0), polycrystal.points.max(axis=0)
    grain, points, triangles = grains[4]
    inner = ((points > low + 0.5) & (points < high - 0.5)).all(axis=1)
    points = points + 0.05 * inner[:, None] * np.sin(7 * points)
    grains[4] = grain, points, triangles
    with pytest.raises(CraftmeshError, match=rf"\b{grain}\b.*do not match"):
        stitch_grains(grains)


def test_a_swapped_diagonal_is_refused_with_the_place():
    surface, _ = structured_box((3, 3, 3), lambda c: 1 + (c[:, 2] > 1).astype(int))
    first, (grain, points, triangles) = grains_of(surface)
    centre = points[triangles].mean(axis=1)
    pair = np.flatnonzero((np.abs(centre - [1.5, 1.5, 1]) < [0.5, 0.5, 0.1]).all(axis=1))
    corners = np.unique(triangles[pair])
    a, b = np.setdiff1d(corners, np.intersect1d(*triangles[pair])).tolist()
    c, d = np.intersect1d(*triangles[pair]).tolist()
    fixed = np.array([[a, b, c], [b, a, d]])
    normal = np.cross(points[b] - points[a], points[c] - points[a])
    triangles = triangles.copy()
    triangles[pair] = fixed if normal[2] < 0 else fixed[:, ::-1]
    with pytest.raises(CraftmeshError, match=r"1, 2 do not match near \[1\.5, 1\.5, 1"):
        stitch_grains([first, (grain, points, triangles)])


def test_an_open_grain_is_refused_with_its_id(polycrystal):
    grains = grains_of(polycrystal)
    grain, points, triangles = grains[2]
    grains[2] = grain, points, triangles[3:]
    with pytest.raises(CraftmeshError, match=rf"grains {grain} are not closed"):
        stitch_grains(grains)


def test_overlapping_grains_are_refused():
    surface, _ = structured_box((2, 2, 2), lambda c: np.ones(len(c), int))
    ((_, points, triangles),) = grains_of(surface)
    with pytest.raises(CraftmeshError, match="overlap"):
        stitch_grains([(1, points, triangles), (2, points, triangles)])


@pytest.mark.parametrize(
    "grains", [[], [(0, np.eye(3), [[0, 1, 2]])], [(1, np.eye(3) * np.nan, [[0, 1, 2]])]]
)
def test_bad_input_is_refused_in_one_line(grains):
    with pytest.raises(CraftmeshError) as error:
        stitch_grains(grains)
    assert "\n" not in str(error.value)


def test_real_stl_sets_come_back_as_they_were(shared_data, tmp_path):
    surface, _ = real_grains(shared_data)
    write_grain_folder(tmp_path, surface)
    stitched, _ = stitch_grains(read_grain_folder(tmp_path), StitchOptions())
    assert_same(stitched, surface)
