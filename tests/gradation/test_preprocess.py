"""Preprocessing of surfaces (paper, section 2.2): each test builds the artefact and sees it go, or stay."""

import numpy as np
import pytest
from few_facets import fan

from craftmesh import GradateOptions, Sizing, Surface, gradate
from craftmesh.gradation.nonmanifold_vertices import release_tied_nodes
from craftmesh.gradation.preprocess import remove_unnecessary_nodes, smooth_junctions
from craftmesh.remeshing.remesh import RemeshOptions, remesh
from craftmesh.surface.check_surface import check_surface
from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.measure import side_volumes
from craftmesh.surface.wedges import sharp_wedges
from craftmesh.types import CRACK, INTERFACE, Voxels


def box_of_grains(labels) -> Surface:
    return remesh(Voxels(labels, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)), RemeshOptions())[0]


def cone(tip: int, ring: list[int], end: int) -> list[list[int]]:
    """Return a closed double cone over `ring`, from `tip` to `end`, its normals outwards."""
    around = list(zip(ring, ring[1:] + ring[:1]))
    return [[tip, b, a] for a, b in around] + [[end, a, b] for a, b in around]


def hourglass(cones: int = 2, sides: int = 6, host=None) -> tuple[Surface, int]:
    """Return bodies of grain 2 that meet in one point inside the box of grain 1, and that point."""
    box = box_of_grains(np.ones((8, 8, 8), int)) if host is None else host
    centre = np.array([4.0, 4.0, 4.0])
    directions = np.array([[0, 0, 1.0], [0, 0, -1.0], [0, 1.0, 0], [0, -1.0, 0]])[:cones]
    points, facets = [centre], []
    tip = len(box.points)
    for axis in directions:
        u = np.roll(axis, 1)
        v = np.cross(axis, u)
        start = tip + len(points)
        turn = 2 * np.pi * np.arange(sides) / sides
        points += list(centre + 1.2 * axis + 0.6 * (np.cos(turn)[:, None] * u + np.sin(turn)[:, None] * v))
        points.append(centre + 1.8 * axis)
        facets += cone(tip, list(range(start, start + sides)), start + sides)
    facets = np.array(facets)
    surface = Surface(
        np.concatenate([box.points, points]),
        np.concatenate([box.facets, facets]),
        np.concatenate([box.sides, np.tile([2, 1], (len(facets), 1))]),
        np.concatenate([box.kind, np.zeros(len(facets), np.uint8)]),
    )
    return surface, tip


@pytest.mark.parametrize("cones", [2, 3, 4])
def test_tied_node_gets_a_copy_per_fan_at_the_centroid_of_its_polygon(cones):
    surface, tip = hourglass(cones)
    result, released, refused = release_tied_nodes(surface)
    assert (released, refused) == (1, 0)
    assert len(result.points) == len(surface.points) + cones - 1
    assert check_surface(result) == []
    moved = result.points[[tip, *range(len(surface.points), len(result.points))]]
    expected = np.array([[4, 4, 5.2], [4, 4, 2.8], [4, 5.2, 4], [4, 2.8, 4]])[:cones]
    assert np.allclose(moved, expected, atol=1e-12)
    assert release_tied_nodes(result)[1:] == (0, 0)


def test_release_keeps_everything_else():
    surface, tip = hourglass()
    result, *_ = release_tied_nodes(surface)
    others = np.delete(np.arange(len(surface.points)), tip)
    assert np.array_equal(result.points[others], surface.points[others])
    assert np.array_equal(result.sides, surface.sides) and np.array_equal(result.kind, surface.kind)
    before, after = (side_volumes(x.points, x.facets, x.sides) for x in (surface, result))
    assert after[2] < before[2] and sum(after.values()) == pytest.approx(sum(before.values()), rel=1e-12)


@pytest.mark.parametrize("lift", [0.0, 0.25])
def test_release_is_refused_where_it_would_pass_over_or_cut_a_body(lift):
    # A small body of grain 3 inside the upper cone: the copy's facets would pass it, or end in it.
    surface, tip = hourglass()
    corners = np.array([[3.95, 3.95, 4.9], [4.05, 3.95, 4.9], [4, 4.05, 4.9], [4, 4, 5.0]]) + (0, 0, lift)
    n = len(surface.points)
    body = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]) + n
    inside = Surface(
        np.concatenate([surface.points, corners]),
        np.concatenate([surface.facets, body]),
        np.concatenate([surface.sides, np.tile([3, 2], (4, 1))]),
        np.concatenate([surface.kind, np.zeros(4, np.uint8)]),
    )
    result, released, refused = release_tied_nodes(inside)
    assert (released, refused) == (0, 1)
    assert result is inside


def test_body_that_touches_a_box_plane_lets_go_and_the_plane_stays():
    box = box_of_grains(np.ones((8, 8, 8), int))
    top = box.points[:, 2].max()
    tip = int(np.linalg.norm(box.points - (4, 4, top), axis=1).argmin())
    centre = box.points[tip]
    ring = centre + np.array([[0.5, 0, -0.8], [0, 0.5, -0.8], [-0.5, 0, -0.8], [0, -0.5, -0.8]])
    n = len(box.points)
    facets = np.array(cone(tip, [n + 3, n + 2, n + 1, n], n + 4))
    surface = Surface(
        np.concatenate([box.points, ring, centre[None] - (0, 0, 1.4)]),
        np.concatenate([box.facets, facets]),
        np.concatenate([box.sides, np.tile([2, 1], (8, 1))]),
        np.concatenate([box.kind, np.zeros(8, np.uint8)]),
    )
    result, released, refused = release_tied_nodes(surface)
    assert (released, refused) == (1, 0) and check_surface(result) == []
    assert (result.points[result.facets[result.kind == 6]][:, :, 2] == top).all()


def test_gradation_releases_on_demand():
    surface, _ = hourglass()
    plain = Sizing(1.0, 1.0, 1.0, 1.0, 2.0, 1.0, np.zeros((0, 3)))
    _, kept = gradate(surface, plain, GradateOptions(passes=1, cleaning_passes=0))
    options = GradateOptions(passes=1, cleaning_passes=0, release_tied_nodes=True)
    after, report = gradate(surface, plain, options)
    assert report["operations"]["released_nodes"] == 1 and kept["operations"]["released_nodes"] == 0
    assert check_surface(after) == [] and release_tied_nodes(after)[1:] == (0, 0)


def with_corner_raised(surface: Surface, row: int, lift: float) -> Surface:
    """Return the surface with facet `row` split into three at its centroid, that raised by `lift`."""
    a, b, c = surface.facets[row].astype(int)
    corners = surface.points[[a, b, c]]
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    n = len(surface.points)
    keep = np.arange(len(surface.facets)) != row
    return Surface(
        np.concatenate([surface.points, [corners.mean(0) + lift * normal / np.linalg.norm(normal)]]),
        np.concatenate([surface.facets[keep], [[a, b, n], [b, c, n], [c, a, n]]]),
        np.concatenate([surface.sides[keep], surface.sides[[row] * 3]]),
        np.concatenate([surface.kind[keep], surface.kind[[row] * 3]]),
    )


def test_unnecessary_node_of_a_box_corner_stays():
    # A tetrahedron: every vertex has three facets, but each is a corner where planes or patches meet.
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    facets = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    surface = Surface(points, facets, [[1, 0]] * 4, [5, 3, 1, 0])
    assert remove_unnecessary_nodes(surface)[1] == 0


@pytest.mark.parametrize("column", [0, 1])
def test_unnecessary_node_of_two_patches_stays(column):
    surface = with_corner_raised(box_of_grains(np.ones((4, 4, 4), int)), 0, 0.0)
    assert remove_unnecessary_nodes(surface)[1] == 1
    sides = surface.sides.copy()
    sides[-1, column] = 7
    mixed = Surface(surface.points, surface.facets, sides, surface.kind)
    assert remove_unnecessary_nodes(mixed)[1] == 0


def test_unnecessary_node_on_a_bend_over_the_normal_tolerance_stays():
    plain = box_of_grains(np.ones((4, 4, 4), int))
    row = int(np.flatnonzero(plain.kind == 6)[0])
    corners = plain.points[plain.facets[row]]
    edge = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1).max()
    flat, bent = (with_corner_raised(plain, row, lift * edge) for lift in (0.02, 0.4))
    assert remove_unnecessary_nodes(flat, 40.0)[1] == 1
    assert remove_unnecessary_nodes(bent, 40.0)[1] == 0
    assert remove_unnecessary_nodes(flat, 1.0)[1] == 0


@pytest.mark.parametrize("kind, removed", [(INTERFACE, 1), (CRACK, 0)])
def test_an_unnecessary_node_of_a_curved_crack_stays(kind, removed):
    """Its lid would be off the crack by its height, here by three tenths of a percent of an edge."""
    hollow, flat = (fan(3, hub=(0, 0, height), sides=(1, 1), kind=kind) for height in (0.005, 0.0))
    assert remove_unnecessary_nodes(hollow)[1] == removed
    assert remove_unnecessary_nodes(flat)[1] == 1


def test_an_unnecessary_node_that_keeps_a_wedge_open_stays():
    """Under a pyramid of 30 degrees lies another patch: 20 degrees below its base, or 5."""
    corners = np.array([[np.cos(a), np.sin(a), 0.0] for a in np.radians([0, 120, 240])])
    for depth, removed in ((20, 1), (5, 0)):
        below = (
            np.array([-np.cos(np.pi / 3), 0, 0])
            + (0.9, 0, 0)
            - np.array([0, 0, 0.9 * np.tan(np.radians(depth))])
        )
        points = np.concatenate([corners, [[0, 0, 0.5 * np.tan(np.radians(30))], below]])
        facets = [[0, 1, 3], [1, 2, 3], [2, 0, 3], [1, 4, 2]]
        surface = Surface(points, facets, [[1, 2]] * 3 + [[2, 3]], [0] * 4)
        assert remove_unnecessary_nodes(surface)[1] == removed


def sawtooth() -> tuple[Surface, np.ndarray]:
    """Return three grains whose boundaries meet in a stair-like junction, and its inner vertices."""
    labels = np.ones((10, 10, 10), int)
    i, j, k = np.indices(labels.shape)
    labels[j + k > 9] = 2
    labels[(i > 4) & (j + k <= 9)] = 3
    surface = box_of_grains(labels)
    edges, _, count = unique_edges(surface.facets)
    return surface, edges[count > 2]


def test_equation_1_shortens_the_junctions_and_leaves_box_edges_and_planes():
    surface, lines = sawtooth()
    smooth, moved = smooth_junctions(surface, 8)
    length = [
        np.linalg.norm(s.points[lines[:, 1]] - s.points[lines[:, 0]], axis=1).sum()
        for s in (surface, smooth)
    ]
    assert moved > 10 and length[1] < length[0]
    low, high = surface.points.min(0), surface.points.max(0)
    for bound in (low, high):
        on = surface.points == bound
        assert np.array_equal(smooth.points[on], surface.points[on])
        assert np.array_equal(smooth.points == bound, on)
    corners = ((surface.points == low) | (surface.points == high)).sum(1) >= 2
    assert np.array_equal(smooth.points[corners], surface.points[corners])
    assert check_surface(smooth) == []


def test_no_junction_is_smoothed_into_a_sharp_wedge():
    """A zigzag rim between three grains; smoothed straight, two of its contacts would lie in one plane."""
    x = np.arange(9.0)
    line = np.column_stack([x, 0.9 * (np.arange(9) % 2), np.zeros(9)])
    near = np.column_stack([x, np.full(9, -2.0), np.zeros(9)])
    under = np.column_stack([x, np.full(9, -2.0), np.full(9, -0.48)])
    far = np.column_stack([x, np.full(9, 2.0), np.zeros(9)])
    points = np.concatenate([line, near, under, far])
    strips = [[[i, s + i, i + 1], [s + i, s + i + 1, i + 1]] for s in (9, 18, 27) for i in range(8)]
    sides = np.repeat([[1, 2], [2, 3], [3, 1]], 16, axis=0)
    surface = Surface(points, np.array(strips).reshape(-1, 3), sides, np.zeros(48, np.uint8))
    assert len(sharp_wedges(surface).angle) == 0
    assert len(sharp_wedges(smooth_junctions(surface, 20)[0]).angle) == 0
