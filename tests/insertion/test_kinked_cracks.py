"""The creases and corners of a given crack: traces and facets follow them."""

import numpy as np
import pytest
from given_cracks import over_grid
from structured_box import structured_box

from craftmesh.cracks.sheets import heights_of, seam_ends
from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.insertion.insert import insert_crack
from craftmesh.insertion.sheet import sheet_of
from craftmesh.sizing.sizing import Sizing, densify
from craftmesh.surface.check_surface import check_surface
from craftmesh.surface.kernels.holding import bins_of, holding
from craftmesh.surface.measure import facet_angles
from craftmesh.types import CRACK, Crack, Surface

BOX = np.array([[0.0, 0.0, 0.0], [8.0, 8.0, 8.0]])
SHARES = np.array([[i, j, 6 - i - j] for i in range(7) for j in range(7 - i)]) / 6
PROMISED = 0.15  # l_min: what facets may be off the given surface


def grid(u: np.ndarray, v: np.ndarray, height) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles of a sheet over the grid of u and v."""
    x, y = np.meshgrid(u, v, indexing="ij")
    return over_grid(x, y, height(x, y))


def two_grains(c: np.ndarray) -> np.ndarray:
    return 1 + (c[:, 1] + 0.3 * c[:, 0] > 5.0).astype(int)


def two_below_one(c: np.ndarray) -> np.ndarray:
    """A triple line along x at y = 4, z = 3, boundaries in z = 3 and y = 4."""
    return np.where(c[:, 2] < 3, np.where(c[:, 1] > 4, 2, 1), 3)


def inserted(crack: Crack, l_min: float, l_max: float, label_of=two_grains) -> Surface:
    model, _ = structured_box((8, 8, 8), label_of)
    sources = np.concatenate([densify(crack.points[front], l_min / 2) for front in crack.fronts])
    surface, _ = insert_crack(model, crack, Sizing(l_min, l_min, l_max, 2.0, 5.0, 1.0, sources))
    assert check_surface(surface) == []
    return surface


def farthest_off(surface: Surface, crack: Crack) -> float:
    sheet = sheet_of(crack, BOX)
    corners = surface.points[surface.facets[surface.kind == CRACK]]
    samples = np.einsum("sk,mkx->msx", SHARES, corners).reshape(-1, 3)
    return float((np.abs(sheet.offset(samples)) / np.linalg.norm(sheet.gradient(samples), axis=1)).max())


@pytest.mark.sampled(3)
@pytest.mark.parametrize("crease", [3.9, 4.6])
@pytest.mark.parametrize("turn", [30.0, 60.0])
def test_facets_and_traces_follow_a_crease(turn, crease):
    """A crease across two box faces and a bent boundary; it fell between points of traces and facets."""
    slope = np.tan(np.radians(turn))
    u = np.unique(np.append(np.linspace(-2, 6.5, 18), crease))
    points, triangles = grid(
        u, np.linspace(-2, 10, 20), lambda x, y: 3.1 + 0.05 * y + slope * np.maximum(x - crease, 0)
    )
    crack = crack_from_triangles(points, triangles, None, BOX)
    surface = inserted(crack, 0.8, 1.6)
    assert farthest_off(surface, crack) < PROMISED * 0.8


def creased(angle: float, crease: float, turn: float, height: float) -> Crack:
    """A sheet that turns up by `turn` degrees along a line at `crease` along a direction in the plane."""
    along = np.array([np.cos(angle), np.sin(angle)])
    a, b = np.unique(np.append(np.linspace(crease - 10, crease + 3, 18), crease)), np.linspace(-14, 14, 40)
    flat, triangles = grid(a, b, lambda x, y: height + np.tan(np.radians(turn)) * np.maximum(x - crease, 0))
    points = np.column_stack([flat[:, :2] @ [along, [-along[1], along[0]]], flat[:, 2]])
    return crack_from_triangles(points, triangles, None, BOX)


@pytest.mark.sampled(3)
@pytest.mark.parametrize("past", [0.0, 0.2])
@pytest.mark.parametrize("turn", [30.0, 45.0])
def test_facets_follow_a_crease_along_a_jagged_boundary(turn, past):
    """The crease crosses its trace again and again, and facets between trace points are split there."""
    crack = creased(np.arctan2(1.0, 0.3), 5.0 / np.hypot(0.3, 1.0) + past, turn, 3.1)
    surface = inserted(crack, 0.8, 1.6)
    assert farthest_off(surface, crack) < PROMISED * 0.8
    # a crease laid through past a corner of a trace made angles of 0.9 degrees
    assert facet_angles(surface.points, surface.facets[surface.kind == CRACK]).min() > 3


@pytest.mark.parametrize("past", [0.0, 0.2])
def test_facets_follow_a_crease_along_a_jagged_boundary_where_edges_are_long(past):
    """The crease is joined between traces nearer to it than a share of edges of 8 l_min."""
    crack = creased(np.arctan2(1.0, 0.3), 5.0 / np.hypot(0.3, 1.0) + past, 57.0, 3.1)
    assert farthest_off(inserted(crack, 0.25, 2.0), crack) < PROMISED * 0.25


@pytest.mark.parametrize(
    "angle, crease, turn, height, l_min",
    [
        (-0.411, 3.812, 31.221, 3.027, 0.8),
        (-0.095, 2.146, 55.635, 2.937, 0.4),
    ],
)
def test_facets_follow_a_crease_over_boundaries_that_the_crack_lies_in(angle, crease, turn, height, l_min):
    crack = creased(angle, crease, turn, height)
    surface = inserted(crack, l_min, 2 * l_min, two_below_one)
    # a place between those at which the insertion measures was 0.155 off
    assert farthest_off(surface, crack) < 1.1 * PROMISED * l_min


def test_a_rough_crack_is_followed_by_its_own_corners():
    """Triangles of 1.7 l_min that turn by some 10 degrees at every edge: facets share their corners."""
    rng = np.random.default_rng(3)
    u, v = np.linspace(-1, 6.5, 31), np.linspace(-1, 9, 41)
    points, triangles = grid(u, v, lambda x, y: 4.1 + 0.02 * rng.standard_normal(x.shape))
    crack = crack_from_triangles(points, triangles, None, BOX)
    surface = inserted(crack, 0.15, 2.0)
    # with circumcentres in place of the given corners as many again as a sixth of these
    assert farthest_off(surface, crack) < PROMISED * 0.15
    assert (surface.kind == CRACK).sum() < 5700


def test_the_triangle_that_holds_a_place_is_the_one_found_by_trying_all():
    rng = np.random.default_rng(0)
    points, triangles = grid(np.linspace(0, 3, 7), np.linspace(0, 1, 9), lambda x, y: 0 * x)
    nodes = points[:, :2] + 0.02 * rng.standard_normal((len(points), 2))
    places = np.concatenate([rng.uniform(-0.5, 3.5, (2000, 2)), nodes])
    found = holding(places, nodes, triangles, bins_of(nodes, triangles))
    corner = nodes[triangles]
    edge = np.roll(corner, -1, axis=1) - corner
    step = places[:, None, None] - corner
    side = edge[..., 0] * step[..., 1] - edge[..., 1] * step[..., 0]
    holds = (side >= -1e-12).all(axis=2)
    assert np.array_equal(found >= 0, holds.any(axis=1))
    inside = np.flatnonzero(found >= 0)
    assert holds[inside, found[inside]].all()


def test_the_part_behind_a_strip_that_ends_in_its_front_has_nodes_there():
    """The strip stands up at 70 degrees from a piece of one side of a square."""
    square = [[2.5, 2.5, 4], [5.5, 2.5, 4], [5.5, 5.5, 4], [2.5, 5.5, 4]]
    ends = np.array([[5.5, 3.3, 4.0], [5.5, 4.7, 4.0]])
    top = [[5.5 + 0.8 * np.cos(np.radians(70)), y, 4 + 0.8 * np.sin(np.radians(70))] for y in (3.9, 4.1)]
    triangles = [[0, 1, 4], [0, 4, 5], [0, 5, 2], [0, 2, 3], [4, 6, 5], [5, 6, 7]]
    crack = crack_from_triangles(np.array([*square, *ends, *top]), np.array(triangles), None, BOX)
    parts = heights_of(crack, BOX)
    assert len(parts) == 2 and np.array_equal(seam_ends(parts), ends)
    rim = sheet_of(parts[0], BOX, ends).rim
    assert len(rim.corners(0)) == 4 + 2 and len(sheet_of(parts[0], BOX).rim.corners(0)) == 4
