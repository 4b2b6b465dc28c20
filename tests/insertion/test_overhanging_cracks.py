"""Cracks that are a height over no plane: hooks, overhangs, bowls and rolls, in parts that are."""

import numpy as np
import pytest
from given_cracks import bowl, over_grid
from models import voronoi
from scipy.spatial import cKDTree

from craftmesh.cracks.check_crack import check_crack
from craftmesh.cracks.series import crack_area
from craftmesh.cracks.sheets import heights_of
from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.cracks.within_box import area_within
from craftmesh.errors import CraftmeshError
from craftmesh.insertion.insert import insert_crack
from craftmesh.remeshing.remesh import remesh
from craftmesh.sizing.sizing import densify
from craftmesh.surface.check_surface import check_surface
from craftmesh.surface.connectivity import pieces
from craftmesh.surface.front import front_edges
from craftmesh.surface.measure import nearest_facet
from craftmesh.types import CRACK

SURFACE = remesh(voronoi(3, 10, (20, 20, 20)))[0]
BOX = SURFACE.box
L_MIN = 0.7


class Uniform:
    def at(self, points):
        return np.full(len(points), L_MIN)


def strips(turns, bow=0.0, step=3.2, count=30):
    """An edge crack from x = 0, kinked after each step by the next turn in degrees; bow: of its lines."""
    angle = np.radians(np.cumsum(turns))
    line = np.array([0.0, 10.0]) + np.cumsum(step * np.column_stack([np.cos(angle), np.sin(angle)]), axis=0)
    line = np.concatenate([[[-1.0, 10.0]], line])
    y = np.linspace(-1, 21, count)
    rows = [np.column_stack([x + bow * np.sin(y / 20 * np.pi) * (x > 0), y, z + 0 * y]) for x, z in line]
    a = (np.arange(len(line) - 1)[:, None] * count + np.arange(count - 1)).ravel()
    triangles = np.concatenate(
        [np.column_stack([a, a + count, a + 1]), np.column_stack([a + 1, a + count, a + count + 1])]
    )
    return np.concatenate(rows), triangles


def half_penny(tilt, radius=5.0, width=2.5, count=49):
    """A half penny on y = 0 whose last increment stands at `tilt` degrees to it, over 90 back over it."""
    centre, tilt = np.array([10, 0, 9.6]), np.radians(tilt)
    angle = np.linspace(-0.1, np.pi + 0.1, count)
    around = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    rim = centre + radius * around
    front = centre + (radius + width * np.cos(tilt)) * around + [0, 0, width * np.sin(tilt)]
    i = np.arange(count - 1)
    fan = np.column_stack([0 * i, 1 + i, 2 + i])
    lower, upper = 1 + i, 1 + count + i
    strip = np.concatenate(
        [np.column_stack([lower, upper, lower + 1]), np.column_stack([lower + 1, upper, upper + 1])]
    )
    return np.concatenate([[centre + [0, -1, 0]], rim, front]), np.concatenate([fan, strip])


HOOKS = {
    "hook of 180 degrees": strips([0, 0, 90, 90]),
    "hook of bowed lines": strips([0, 0, 90, 90], bow=1.0),
    "hook of three kinks": strips([0, 0, 70, 70, 70]),
    "right angle, a height all the same": strips([0, 0, 90]),
    "overhang of 20 degrees": half_penny(110),
    "overhang of 40 degrees": half_penny(130),
}


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", HOOKS)
def test_a_folded_crack_is_inserted_whole_and_ends_in_its_front_alone(name):
    points, triangles = HOOKS[name]
    crack = crack_from_triangles(points, triangles, None, BOX)
    assert check_crack(crack) == [] and len(crack.fronts) == 1 and len(heights_of(crack, BOX)) > 1
    result, report = insert_crack(SURFACE, crack, Uniform())
    assert check_surface(result) == []
    facets = result.facets[result.kind == CRACK]
    assert len(np.unique(pieces(facets))) == 1
    inside = np.clip(crack.points, *BOX)
    area = np.linalg.norm(
        np.cross(*(inside[crack.triangles[:, k]] - inside[crack.triangles[:, 0]] for k in (1, 2))), axis=1
    )
    assert report["crack_area"] == pytest.approx(area.sum() / 2, rel=5e-3)
    centres = result.points[facets].mean(axis=1)
    assert nearest_facet(centres, crack.points, crack.triangles)[1].max() < 0.05 * L_MIN
    front = result.points[np.unique(front_edges(result))]
    given = crack.points[crack.fronts[0]]
    step = np.linalg.norm(np.diff(given, axis=0), axis=1).max()
    off = np.linalg.norm(front[:, None] - given[None], axis=2).min(axis=1)
    assert (
        off.max() < step / 2 + 0.02 * L_MIN
    )  # every one of its nodes is on the given front: no seam is left
    length = np.linalg.norm(np.diff(given, axis=0), axis=1).sum()
    edges = result.points[front_edges(result)]
    assert np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1).sum() == pytest.approx(length, rel=2e-3)


def test_the_sides_of_a_hook_stay_those_of_one_crack():
    """Lip B lies behind the facets' normals along the whole hook: neighbours run against each other."""
    crack = crack_from_triangles(*HOOKS["hook of 180 degrees"], None, BOX)
    result, _ = insert_crack(SURFACE, crack, Uniform())
    facets = result.facets[result.kind == CRACK].astype(np.int64)
    directed = facets[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2) @ np.array([1 << 32, 1])
    assert len(np.unique(directed)) == len(directed)


def bent(place, count=40):
    """A sheet whose points are place(u, v) for u, v from 0 to 1."""
    u, v = (x.ravel() for x in np.meshgrid(*2 * [np.linspace(0, 1, count)], indexing="ij"))
    a = (np.arange(count - 1)[:, None] * count + np.arange(count - 1)).ravel()
    triangles = [np.column_stack([a, a + count, a + 1]), np.column_stack([a + 1, a + count, a + count + 1])]
    return np.column_stack(place(u, v)), np.concatenate(triangles)


def roll(u, v):
    turn = np.radians(300.0) * u
    return 10 + 5 * np.cos(turn), -1 + 22 * v, 10 + 5 * np.sin(turn)


def twisted(u, v):
    turn = np.radians(190.0) * u
    return 3.5 + 12 * u, 10 + 8 * (v - 0.5) * np.cos(turn), 10 + 8 * (v - 0.5) * np.sin(turn)


SMOOTH = {
    "bowl of 150 degrees": bowl((10.2, 9.8, 10), 4.5, 150.0),
    "roll of 300 degrees": bent(roll),
    "sheet twisted by 190": bent(twisted),
}


@pytest.mark.parametrize("name", SMOOTH)
def test_a_crack_that_folds_smoothly_is_inserted_whole(name):
    points, triangles = SMOOTH[name]
    crack = crack_from_triangles(points, triangles, None, BOX)
    assert check_crack(crack) == [] and len(heights_of(crack, BOX)) > 1
    result, report = insert_crack(SURFACE, crack, Uniform())
    assert check_surface(result) == []
    facets = result.facets[result.kind == CRACK].astype(np.int64)
    assert len(np.unique(pieces(facets))) == 1
    directed = facets[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2) @ np.array([1 << 32, 1])
    assert len(np.unique(directed)) == len(directed)  # turned alike, so that its lips are told apart
    assert report["crack_area"] == pytest.approx(area_within(crack, BOX), rel=5e-3)
    centres = result.points[facets].mean(axis=1)
    assert nearest_facet(centres, crack.points, crack.triangles)[1].max() < 0.05 * L_MIN
    given = np.concatenate([densify(crack.points[front], 0.01) for front in crack.fronts])
    nodes = result.points[np.unique(front_edges(result))]
    assert cKDTree(given).query(nodes)[0].max() < 0.02 * L_MIN  # no seam is left


def test_what_runs_through_itself_is_refused():
    with pytest.raises(CraftmeshError, match="intersects itself near"):
        crack_from_triangles(*strips([0, 0, 100, 100, 100, 60], step=2.5), None, BOX)


def test_area_of_a_crack_in_parts_is_that_of_its_parts():
    crack = crack_from_triangles(*HOOKS["hook of 180 degrees"], None, BOX)
    assert crack_area(crack) == pytest.approx(sum(map(crack_area, heights_of(crack, BOX))))


def test_a_part_that_passes_by_a_corner_of_the_box_is_left_out():
    low, high = 10.0, 30.0
    points = np.array([[-2, -2, low], [43, -2, low], [-2, 43, low], [-2, 43, high], [43, -2, high]])
    crack = crack_from_triangles(points, np.array([[0, 1, 2], [1, 3, 2], [1, 4, 3]]), None, BOX)
    (part,) = heights_of(crack, BOX)
    assert (part.points[:, 2] == low).all()


def roof(beside, slope, profile):
    """Two planes whose kink, z = 10 at a slope in the plane, passes y = 0 `beside` the edge x = 20."""
    x = np.linspace(-1, 21, 12)
    y, z = (column[:, None] + 0 * x for column in np.array(profile).T)
    return over_grid(x + 0 * y, y + (20 - beside - x) * slope, z)


OPEN = ((14.0, -1.0), (0.0, 10.0), (8.0, 14.0))
NARROW = ((14.0, -1.0), (0.0, 10.0), (9.0, 9.0))


@pytest.mark.sampled(3)
@pytest.mark.parametrize("beside", [5e-4, -4e-3], ids=["before", "past"])
@pytest.mark.parametrize("slope", [0.05, 0.2])
@pytest.mark.parametrize("profile", [OPEN, NARROW], ids=["open", "narrow"])
def test_a_kink_that_passes_an_edge_of_the_box_comes_in_whole_or_is_refused(profile, slope, beside):
    """Both parts may come in over one facet between the two faces, which would stay as a front."""
    crack = crack_from_triangles(*roof(beside, slope, profile), None, BOX)
    try:
        result, report = insert_crack(SURFACE, crack, Uniform())
    except CraftmeshError as error:
        assert "cannot be inserted as it is given: near [" in str(error)
        return
    assert check_surface(result) == []
    nodes = result.points[np.unique(front_edges(result))]
    given = np.concatenate([densify(crack.points[front], 0.01) for front in crack.fronts])
    assert cKDTree(given).query(nodes)[0].max() < 0.02 * L_MIN
    assert report["crack_off_times"] <= 1
    assert report["crack_area"] == pytest.approx(area_within(crack, BOX), rel=0.004)
