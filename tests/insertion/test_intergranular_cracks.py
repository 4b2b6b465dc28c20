"""Cracks in grain boundaries: made of their facets, parted at a sphere, branching at triple lines."""

from itertools import combinations

import numpy as np
import pytest
from models import voronoi

from craftmesh.assembly.assemble import assemble
from craftmesh.cracks.check_crack import check_crack
from craftmesh.cracks.in_boundaries import crack_in_boundaries
from craftmesh.cracks.options import CrackOptions
from craftmesh.errors import CraftmeshError
from craftmesh.gradation.gradate import gradate
from craftmesh.insertion.insert import insert_crack
from craftmesh.insertion.intergranular_crack import inlaid
from craftmesh.mesh.check_tets import check_tets
from craftmesh.remeshing.remesh import remesh
from craftmesh.sizing.sizing import SizingOptions
from craftmesh.sizing.sources import Defects, sizing_around
from craftmesh.surface.check_surface import check_surface
from craftmesh.surface.front import front_edges
from craftmesh.surface.measure import area_vectors, nearest_facet
from craftmesh.tetrahedra.options import TetrahedralizeOptions
from craftmesh.tetrahedra.tetrahedralize import tetrahedralize
from craftmesh.types import CRACK, Surface

SURFACE = remesh(voronoi(3, 6, (16, 16, 16)))[0]
L_MIN = 0.8
BRANCHING = ("2-4", "2-5", "4-5")  # they meet in one triple line near the middle


def triple_point(pairs) -> np.ndarray:
    """The point of SURFACE next to its middle in which just these boundaries meet."""
    on = [
        np.unique(
            SURFACE.facets[
                (np.sort(SURFACE.sides, axis=1) == [int(g) for g in pair.split("-")]).all(axis=1)
            ]
        )
        for pair in pairs
    ]
    common = on[0][np.isin(on[0], on[1]) & np.isin(on[0], on[2])]
    return SURFACE.points[common[np.linalg.norm(SURFACE.points[common] - 8, axis=1).argmin()]]


def crack_of(boundaries, **options):
    return crack_in_boundaries(
        SURFACE, CrackOptions(shape="boundaries", boundaries=boundaries, **options), 0
    )


def area(points, triangles) -> float:
    return float(np.linalg.norm(area_vectors(points, triangles), axis=1).sum())


CENTRE = tuple(triple_point(BRANCHING).tolist())
CASES = {
    "one boundary inside": (crack_of(("4-5",), centre=(9.0, 7.0, 6.0), radius=3.0), None),
    "three that branch": (crack_of(BRANCHING, centre=CENTRE, radius=4.0), 3),
    "whole boundaries": (crack_of(("2-6", "5-6")), None),
}


@pytest.mark.sampled(3)
@pytest.mark.parametrize("name", CASES)
def test_an_intergranular_crack_is_facets_of_its_boundaries_and_opens(name):
    crack, fronts = CASES[name]
    assert check_crack(crack) == []
    sizing = sizing_around(
        SURFACE,
        Defects(crack),
        SizingOptions(l_min=L_MIN, l0=1.0, l_max=2.5, r0=2.0, r1=6.0),
    )
    inserted, report = insert_crack(SURFACE, crack, sizing)
    assert check_surface(inserted) == []
    assert report["crack_area"] == pytest.approx(area(crack.points, crack.triangles), rel=1e-12)
    assert report["crack_facets_on_grain_boundaries"] == report["crack_facets"] == len(crack.triangles)
    assert np.array_equal(inserted.points[: len(SURFACE.points)], SURFACE.points)
    surface, _ = gradate(inserted, sizing, crack=crack)
    front = surface.points[front_edges(surface)]
    given = np.concatenate([crack.points[line] for line in crack.fronts])
    length = np.linalg.norm(front[:, 1] - front[:, 0], axis=1)
    # 0.56, 0.88 and 0.87: a front with few nodes keeps the edges that its bends and junctions ask for
    assert 0.5 < np.median(length) / L_MIN < 1.1
    # front nodes are on the given lines, whose own points are closer than 0.5 to each other
    assert np.linalg.norm(front.reshape(-1, 1, 3) - given, axis=2).min(axis=1).max() < 0.5
    facets = surface.facets[surface.kind == CRACK]
    corners = surface.points[facets]
    places = np.concatenate(
        [corners.mean(axis=1), *((corners[:, i] + corners[:, i - 1]) / 2 for i in range(3))]
    )
    assert nearest_facet(places, crack.points, crack.triangles)[1].max() < 0.05 * L_MIN
    assert area(surface.points, facets) == pytest.approx(report["crack_area"], rel=5e-3)
    tets, _ = tetrahedralize(surface, sizing, TetrahedralizeOptions(fallback="none"))
    mesh, opened = assemble(surface, tets)
    assert check_tets(mesh) == [] and opened["crack_facets_not_opened"] == 0
    if fronts is not None:
        assert opened["fronts"] == fronts == len(crack.fronts)


def test_the_front_lies_on_the_sphere_or_where_a_boundary_ends_and_branches_where_the_crack_does():
    crack, fronts = CASES["three that branch"]
    line = np.concatenate([crack.points[line] for line in crack.fronts])
    on_sphere = np.abs(np.linalg.norm(line - CENTRE, axis=1) - 4.0) < 1e-12
    given = {tuple(point) for point in SURFACE.points.tolist()}
    assert on_sphere.sum() > 30
    assert all(tuple(point) in given for point in line[~on_sphere].tolist())
    ends = [crack.points[line[end]] for line in crack.fronts for end in (0, -1)]
    together = [a for a, b in combinations(ends, 2) if (a == b).all()]
    assert len(crack.fronts) == fronts and len(together) >= 3  # where the triple line leaves the sphere
    whole, _ = CASES["whole boundaries"]
    inner = ((whole.points > SURFACE.box[0]) & (whole.points < SURFACE.box[1])).all(axis=1)
    for front in whole.fronts:
        assert inner[front[1:-1]].all()


def test_neighbouring_boundaries_are_turned_alike():
    crack = crack_of(BRANCHING[:2], centre=CENTRE, radius=4.0)
    triangles = crack.triangles.astype(np.int64)
    directed = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2) @ np.array([1 << 32, 1])
    assert len(np.unique(directed)) == len(directed)


def test_a_crack_of_another_surface_is_no_inlay_and_faults_are_told():
    crack, _ = CASES["one boundary inside"]
    moved = Surface(SURFACE.points + 0.01, SURFACE.facets, SURFACE.sides, SURFACE.kind)
    assert inlaid(moved, crack) is None
    with pytest.raises(CraftmeshError, match="1-2, grains that do not touch; grain 1 touches 3, 4, 5"):
        crack_of(("1-2",))
    with pytest.raises(CraftmeshError, match="'3to7'; expected two grains"):
        crack_of(("3to7",))
    with pytest.raises(CraftmeshError, match="contains no part of the boundaries 4-5"):
        crack_of(("4-5",), centre=(99.0, 0, 0), radius=1.0)


def test_a_crack_smaller_than_the_facets_is_made_of_parts_of_them():
    own = SURFACE.facets[(np.sort(SURFACE.sides, axis=1) == [4, 5]).all(axis=1)]
    centre = SURFACE.points[own.ravel()[np.bincount(own.ravel())[own.ravel()].argmax()]]
    beside = np.unique(own[(SURFACE.points[own] == centre).all(axis=2).any(axis=1)])
    away = np.linalg.norm(SURFACE.points[beside] - centre, axis=1)
    crack = crack_of(("4-5",), centre=tuple(centre.tolist()), radius=0.5 * float(away[away > 0].min()))
    assert len(crack.triangles) > 2 and (crack.points == centre).all(axis=1).sum() == 1
    found = inlaid(SURFACE, crack)
    assert found is not None and check_surface(found) == []
    given = area(crack.points, crack.triangles)
    assert area(found.points, found.facets[found.kind == CRACK]) == pytest.approx(given, rel=1e-12)


@pytest.mark.parametrize("radius", np.linspace(2.0, 5.0, 13).tolist())
def test_a_sphere_that_crosses_edges_near_their_ends_leaves_no_short_ones(radius):
    crack = crack_of(BRANCHING, centre=CENTRE, radius=radius)
    assert check_crack(crack) == []
    given = {tuple(point): row for row, point in enumerate(SURFACE.points.tolist())}
    known = np.array([given.get(tuple(point), -1) for point in crack.points.tolist()])
    edges = np.unique(np.sort(crack.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    corners = np.sort(SURFACE.facets[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    least = np.linalg.norm(SURFACE.points[corners[:, 1]] - SURFACE.points[corners[:, 0]], axis=1).min()
    new = (known[edges] < 0).sum(axis=1) == 1
    length = np.linalg.norm(crack.points[edges[new, 1]] - crack.points[edges[new, 0]], axis=1)
    assert length.min() > 0.1 * least  # 0.017 of it where every crossing is a point
