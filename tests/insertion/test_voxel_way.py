"""The voxel way against the cut where both apply, and cracks that are a height over no plane."""

from dataclasses import replace

import numpy as np
import pytest
from given_cracks import bowl, wavy_disc
from models import voronoi

from craftmesh.cracks.check_crack import check_crack
from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.series import prescribed_crack
from craftmesh.cracks.sheets import joined
from craftmesh.cracks.split_voxels import split_along
from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.errors import CraftmeshError
from craftmesh.insertion.contract import contracted
from craftmesh.insertion.cut import uncut
from craftmesh.insertion.insert import insert_crack
from craftmesh.insertion.insert_split import (
    NARROW,
    fault_of,
    insert_by_voxels,
    insert_split,
    narrowest_strip,
)
from craftmesh.remeshing.remesh import remesh, voxel_volumes
from craftmesh.remeshing.split import remesh_split
from craftmesh.surface.check_surface import check_surface
from craftmesh.surface.connectivity import pieces
from craftmesh.surface.front import front_edges
from craftmesh.surface.measure import area_vectors, distances_and_sides, side_volumes
from craftmesh.surface.wedges import sharp_wedges
from craftmesh.types import CRACK, Crack, Surface

VOXELS = voronoi(3, 8, (18, 18, 18))
BOX = VOXELS.box
L_MIN = 0.6
SHARES = np.linspace(0, 1, 9)


class Uniform:
    def at(self, points):
        return np.full(len(points), L_MIN)


def by_voxels(crack: Crack) -> tuple[Surface, dict]:
    split = split_along(VOXELS, crack)
    surface, bits, _ = remesh_split(split)
    return insert_split(surface, bits, split, Uniform())


def penny(**options) -> Crack:
    return prescribed_crack(CrackOptions(**options), 0, BOX)


def grid(place, count=40) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles of a sheet whose points are place(u, v) for u, v from 0 to 1."""
    u, v = (
        x.ravel() for x in np.meshgrid(np.linspace(0, 1, count), np.linspace(0, 1, count), indexing="ij")
    )
    a = (np.arange(count - 1)[:, None] * count + np.arange(count - 1)).ravel()
    triangles = [np.column_stack([a, a + count, a + 1]), np.column_stack([a + 1, a + count, a + count + 1])]
    return np.column_stack(place(u, v)), np.concatenate(triangles)


def roll(u, v):
    turn = np.radians(300.0) * u
    return 9 + 5 * np.cos(turn), -1 + 20 * v, 9 + 5 * np.sin(turn)


def twisted(u, v):
    turn = np.radians(190.0) * u
    return 3.5 + 11 * u, 9 + 11 * (v - 0.5) * np.cos(turn), 9 + 11 * (v - 0.5) * np.sin(turn)


def off_front(surface: Surface, cracks: list[Crack]) -> float:
    """The largest distance of places on front edges from the given fronts."""
    ends = surface.points[front_edges(surface)]
    places = (ends[:, None, 0] + SHARES[:, None] * (ends[:, 1] - ends[:, 0])[:, None]).reshape(-1, 3)
    nearest = np.full(len(places), np.inf)
    for start, end in ((c.points[f][:-1], c.points[f][1:]) for c in cracks for f in c.fronts):
        step = end - start
        share = np.einsum("nkx,kx->nk", places[:, None] - start, step) / np.einsum("kx,kx->k", step, step)
        foot = start + np.clip(share, 0, 1)[..., None] * step
        nearest = np.minimum(nearest, np.linalg.norm(places[:, None] - foot, axis=2).min(axis=1))
    return float(nearest.max())


def off_crack(surface: Surface, crack: Crack) -> np.ndarray:
    """How far corners and centres of the crack's facets are off the given crack."""
    facets = surface.facets[surface.kind == CRACK]
    places = np.concatenate([surface.points[np.unique(facets)], surface.points[facets].mean(axis=1)])
    return distances_and_sides(places, crack.points, crack.triangles)[0]


def area(surface: Surface) -> float:
    return float(
        np.linalg.norm(area_vectors(surface.points, surface.facets[surface.kind == CRACK]), axis=1).sum()
    )


def front_length(surface: Surface) -> float:
    ends = surface.points[front_edges(surface)]
    return float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum())


def assert_sound(surface: Surface) -> None:
    assert check_surface(surface) == []
    volumes, wanted = side_volumes(surface.points, surface.facets, surface.sides), voxel_volumes(VOXELS)
    # 5e-4 is what remeshing keeps to, and as much again what restoring them leaves here
    assert max(abs(volumes[k] / wanted[k] - 1) for k in wanted) < 1e-3


CRACKS = {
    "inner penny": penny(centre=(9, 8.4, 9.2), normal=(0.2, 0.3, 1), radius=5.5),
    "penny at a face": penny(centre=(9, 0, 9.2), normal=(0.2, 0.3, 1), radius=5.5),
    "penny in a voxel plane": penny(centre=(9, 9, 9), normal=(0, 0, 1), radius=5.5),
    "wavy disc": crack_from_triangles(
        wavy_disc(5.5, 0.6, 24)[0] + [9.1, 8.7, 9.3], wavy_disc(5.5, 0.6, 24)[1], None, BOX
    ),
}


@pytest.fixture(scope="module")
def remeshed() -> Surface:
    return remesh(VOXELS)[0]


@pytest.mark.parametrize("name", CRACKS)
def test_both_ways_give_one_crack(remeshed, name):
    """Measured: area 0.2 %, front 0.0195 l_min, facets 0.04 l_min apart at most."""
    crack = CRACKS[name]
    cut, _ = insert_crack(remeshed, crack, Uniform())
    surface, report = by_voxels(crack)
    assert_sound(surface)
    assert report["crack_area"] == pytest.approx(area(surface))
    assert area(surface) == pytest.approx(area(cut), rel=5e-3)
    assert front_length(surface) == pytest.approx(front_length(cut), rel=2e-3)
    assert off_front(surface, [crack]) < 0.0201 * L_MIN
    assert off_crack(surface, crack).max() < 0.05 * L_MIN
    # a boundary that the crack crosses may come out half a voxel aside, over a trace of six
    assert np.abs(of_grains(cut) - of_grains(surface)).max() < 3.0


def of_grains(surface: Surface) -> np.ndarray:
    """The crack's area in each grain, half of it on either side."""
    crack = surface.kind == CRACK
    size = np.linalg.norm(area_vectors(surface.points, surface.facets[crack]), axis=1)
    return sum(np.bincount(side, size / 2, 9) for side in surface.sides[crack].T)


def test_boundaries_away_from_the_crack_stay(remeshed):
    """Smoothing reaches as far as its laps, and volumes are restored together: 0.002 voxels at most."""
    crack = penny(centre=(0, 0, 9.2), normal=(0, 0.1, 1), radius=4.0)
    surface, _ = by_voxels(crack)
    far = np.linalg.norm(surface.points[:, :2], axis=1) > 12
    boundary = surface.facets[(surface.kind == 0) & far[surface.facets].all(axis=1)]
    rows = np.unique(boundary)
    assert len(rows) > 500
    off = distances_and_sides(surface.points[rows], remeshed.points, remeshed.facets)[0]
    assert off.max() < 0.01


OPEN = {
    "bowl of 120 degrees": bowl((9, 9, 9), 5.5, 120.0),
    "roll of 300 degrees": grid(roll),
    "sheet twisted by 190": grid(twisted),
}


@pytest.mark.sampled(3)
@pytest.mark.parametrize("name", OPEN)
def test_cracks_that_fold_smoothly_come_in_by_voxels(name):
    points, triangles = OPEN[name]
    with pytest.raises(CraftmeshError, match="is folded near"):
        crack_from_triangles(points, triangles, None, BOX)
    crack = crack_from_triangles(points, triangles, None, BOX, heights=False)
    assert check_crack(crack) == []
    surface, _ = by_voxels(crack)
    assert_sound(surface)
    facets = surface.facets[surface.kind == CRACK]
    assert len(np.unique(pieces(facets))) == 1
    inside = np.clip(crack.points, *BOX)
    given = np.linalg.norm(area_vectors(inside, crack.triangles), axis=1).sum()
    assert area(surface) == pytest.approx(given, rel=5e-3)
    # 0.0205 beside a corner of the front, where an edge is too short to be halved
    assert off_front(surface, [crack]) < 0.021 * L_MIN
    assert off_crack(surface, crack).max() < 0.05 * L_MIN
    directed = facets.astype(np.int64)[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2) @ np.array([1 << 32, 1])
    assert len(np.unique(directed)) == len(directed)  # turned alike, so that its lips are told apart


def test_pennies_that_have_grown_together_have_one_front():
    """Two overlapping discs in one plane: the area is that of their union, less 0.3 %."""
    pennies = [penny(centre=(x, 9.2, 9), normal=(0, 0, 1), radius=3.5) for x in (6.8, 11.2)]
    surface, _ = by_voxels(joined(pennies))
    assert_sound(surface)
    apart, r = 4.4, 3.5
    lens = 2 * r**2 * np.arccos(apart / 2 / r) - apart / 2 * np.sqrt(4 * r**2 - apart**2)
    assert area(surface) == pytest.approx(2 * np.pi * r**2 - lens, rel=1e-2)
    assert len(np.unique(pieces(surface.facets[surface.kind == CRACK]))) == 1
    middle = surface.points[np.unique(front_edges(surface))]
    inner = np.linalg.norm(middle[:, :2] - [9, 9.2], axis=1)
    assert inner.min() > np.sqrt(r**2 - apart**2 / 4) - 0.1  # none of it is left inside


def test_a_branch_ends_on_the_crack_that_it_leaves():
    main = crack_from_triangles(*grid(lambda u, v: (-1 + 12 * u, -1 + 20 * v, 8.2 + 1.0 * u)), None, BOX)
    side = grid(lambda u, v: (5 + 1.5 * u, -1 + 20 * v, 8.7 + 6 * u))
    branch = crack_from_triangles(*side, None, BOX)
    surface, _ = by_voxels(joined([main, branch]))
    assert_sound(surface)
    assert len(np.unique(pieces(surface.facets[surface.kind == CRACK]))) == 1
    # two fronts through the box, none where the branch leaves
    assert front_length(surface) == pytest.approx(2 * 18, rel=5e-3)


def test_points_in_the_way_of_a_mouth_make_room():
    """A wavy disc leaves the box at a small angle; a point of the face kept its mouth 0.17 l_min off."""
    points, triangles = wavy_disc(5.96, 0.89)
    cosine, sine = np.cos(np.radians(44.5)), np.sin(np.radians(44.5))
    turned = points @ [[1, 0, 0], [0, cosine, sine], [0, -sine, cosine]] + [9.1, 10.13, 0.32]
    crack = crack_from_triangles(turned, triangles, None, BOX)
    surface, report = by_voxels(crack)
    assert_sound(surface)
    assert off_crack(surface, crack).max() < 0.05 * L_MIN
    assert report["crack_moved_most"] < 0.05 * L_MIN


@pytest.mark.parametrize("seed", [3, 8, 16])
def test_mouths_of_ellipses_have_no_notches(seed):
    """Told by what is half a voxel within the box, the 8th had a corner of its mouth 0.8 l_min off."""
    voxels, generator = voronoi(seed, 8, (16, 16, 16)), np.random.default_rng(seed)
    centre, normal = 16 * generator.random(3), generator.normal(size=3)
    options = CrackOptions(
        shape="ellipse",
        centre=tuple(centre),
        normal=tuple(normal),
        semi_axes=tuple(3 + 4 * generator.random(2)),
    )
    crack = prescribed_crack(options, 0, voxels.box)
    split = split_along(voxels, crack)
    surface, bits, _ = remesh_split(split)
    surface, report = insert_split(surface, bits, split, Uniform())
    assert check_surface(surface) == []
    assert report["crack_moved_most"] < 0.01 * L_MIN
    ends = surface.points[front_edges(surface)].reshape(-1, 3)
    assert np.linalg.norm(split.sheets[0].nearest_on_front(ends) - ends, axis=1).max() < 0.02 * L_MIN


def test_facets_that_end_before_the_front_are_refused():
    small, large = (penny(centre=(9, 9, 9.2), normal=(0.2, 0.1, 1), radius=r) for r in (4.0, 7.0))
    surface, bits, _ = remesh_split(split_along(VOXELS, small))
    with pytest.raises(CraftmeshError, match="ends near .* off its given front: voxels are too coarse"):
        insert_split(surface, bits, split_along(VOXELS, large), Uniform())


@pytest.mark.slow
def test_cracks_that_voxels_do_not_bring_in_are_cut():
    """Halves of a smaller crack stand for voxels that are too coarse."""
    small, large = (penny(centre=(9, 9, 9.2), normal=(0.2, 0.1, 1), radius=r) for r in (4.0, 7.0))
    whole, _ = remesh(VOXELS)
    split = split_along(VOXELS, large)
    surface, bits, _ = remesh_split(split_along(VOXELS, small))
    found, report = insert_by_voxels(whole, large, (surface, bits), split, Uniform())
    assert "voxels are too coarse" in report["cut_instead"]
    assert_sound(found)
    assert off_front(found, [large]) < 0.02 * L_MIN and off_crack(found, large).max() < 0.02 * L_MIN
    surface, bits, _ = remesh_split(split)
    found, report = insert_by_voxels(whole, large, (surface, bits), split, Uniform())
    assert "cut_instead" not in report
    assert (found.points == insert_split(surface, bits, split, Uniform())[0].points).all()


def test_a_crack_that_voxels_lay_flat_beside_a_boundary_is_cut():
    """The crack passes along a boundary; voxels leave a wedge of 0.2 degrees between the two."""
    crack = penny(centre=(8.17, 9.68, 5.92), normal=(0.5, 0.56, 0.66), radius=3.5)
    whole, _ = remesh(VOXELS)
    split = split_along(VOXELS, crack)
    surface, bits, _ = remesh_split(split)
    found, report = insert_by_voxels(whole, crack, (surface, bits), split, Uniform())
    assert "a wedge of 0.16 degrees" in report["cut_instead"]
    assert_sound(found)
    wedges = sharp_wedges(found)
    assert wedges.angle[(found.kind[wedges.facets] == CRACK).any(axis=1)].min() > 5.0


def test_a_narrow_strip_beside_the_front_is_a_fault():
    """The front of an inner penny passes triple lines and boundaries."""
    surface, report = by_voxels(CRACKS["inner penny"])
    width = narrowest_strip(surface)
    assert width == pytest.approx(shortest_from_front(surface))
    report |= {"crack_off_most": 0.0, "front_off_most": 0.0}
    assert fault_of(surface, report, width / (1.1 * NARROW)) is None
    fault = fault_of(surface, report, width / (0.8 * NARROW))
    assert "a strip 0.04 l_min wide between the crack's front and another line" in fault


def shortest_from_front(surface: Surface) -> float:
    """Edge by edge: inside one patch, between one pair of grains, from the front to other lines."""
    front = set(front_edges(surface).ravel().tolist())
    around: dict[tuple[int, int], list[tuple[int, ...]]] = {}
    for facet, kind, sides in zip(surface.facets.tolist(), surface.kind.tolist(), surface.sides.tolist()):
        a, b, c = sorted(facet)
        for edge in ((a, b), (a, c), (b, c)):
            around.setdefault(edge, []).append((kind, *sorted(sides)))
    inside = {edge for edge, of in around.items() if len(of) == 2 and of[0] == of[1]}
    on_lines = {point for edge in around.keys() - inside for point in edge}
    return min(
        np.linalg.norm(surface.points[u] - surface.points[v])
        for u, v in inside
        if u in on_lines and v in on_lines and (u in front) != (v in front)
    )


@pytest.mark.slow
def test_what_neither_way_brings_in_is_refused_for_the_voxels():
    whole, _ = remesh(VOXELS)
    given = crack_from_triangles(*bowl((9, 9, 9), 5.5, 120.0), None, BOX, heights=False)
    split = split_along(VOXELS, given)
    small = penny(centre=(9, 9, 9), normal=(0, 0, 1), radius=4)
    surface, bits, _ = remesh_split(split_along(VOXELS, small))
    with pytest.raises(CraftmeshError, match="voxels are too coarse"):
        insert_by_voxels(whole, given, (surface, bits), split, Uniform())


@pytest.mark.parametrize("degrees", [8.0, 12.0, 20.0])
def test_mouths_at_small_angles_to_a_face_are_where_the_crack_meets_it(degrees):
    normal = (np.sin(np.radians(degrees)), 0.0, np.cos(np.radians(degrees)))
    crack = penny(centre=(6.0, 9.0, 1.1), normal=normal, radius=5.0)
    surface, _ = by_voxels(crack)
    assert_sound(surface)
    assert off_crack(surface, crack).max() < 0.02 * L_MIN


@pytest.mark.sampled(4)
@pytest.mark.parametrize("fold", [30.0, 60.0, 100.0])
@pytest.mark.parametrize("turn", [0.0, 33.0])
def test_facets_follow_the_kinks_of_a_crack(fold, turn):
    """Facets across a fold are off it, however short their edges are: by 0.04 l_min at 30 degrees, 0.11 and
    more at 60 and 100.
    """
    half, cosine, sine = np.radians(fold / 2), np.cos(np.radians(turn)), np.sin(np.radians(turn))

    def place(u, v):
        x, y = 11 * (u - 0.5), 11 * (v - 0.5)
        z = np.abs(x) * np.sin(half)
        x = x * np.cos(half)
        return cosine * x - sine * y + 9.1, sine * x + cosine * y + 8.9, z + 7.3

    crack = crack_from_triangles(*grid(place, 3), None, BOX, heights=False)
    surface, _ = by_voxels(crack)
    assert_sound(surface)
    assert off_crack(surface, crack).max() < 0.08 * L_MIN  # 0.07 where a point of a boundary is in the way


def test_more_sheets_than_fit_are_refused():
    eight = [penny(centre=(9, 9, 2 + 2 * k), radius=3.0) for k in range(8)]
    with pytest.raises(CraftmeshError, match="8 sheets; expected at most 7"):
        split_along(VOXELS, joined(eight))


def test_a_short_edge_at_a_corner_of_the_crack_goes_to_the_corner():
    points = np.array([[0.1, 0, 0], [0, 0, 0], [1, 1, 0], [2, 0, 0]], float)
    facets, kind = np.array([[1, 0, 2], [0, 3, 2]], np.int32), np.full(2, CRACK, np.uint8)
    surface = uncut(Surface(points, facets, np.ones((2, 2), np.int32), kind))
    cut = contracted(replace(surface, size=np.ones(4)), np.zeros(0, np.int64), np.zeros((0, 3)))
    assert cut.facets.tolist() == [[1, 3, 2]]
