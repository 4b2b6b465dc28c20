"""Tetrahedra fill each grain exactly, whatever its shape, and keep the surface."""

import re

import numpy as np
import pytest
from models import real_grains
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.errors import CraftmeshError, MeshingError
from craftmesh.mesh.tet_connectivity import half_faces, tet_volumes
from craftmesh.surface.connectivity import lowest_equal_point
from craftmesh.surface.measure import side_volumes
from craftmesh.tetrahedra.grain_meshing import Setting, mesh_grain
from craftmesh.tetrahedra.grain_region import WrongMesh, find_regions
from craftmesh.tetrahedra.grain_surface import grain_surfaces
from craftmesh.tetrahedra.meshing_attempts import MeshingTask, attempts
from craftmesh.tetrahedra.options import TetrahedralizeOptions
from craftmesh.tetrahedra.tetrahedralize import tetrahedralize
from craftmesh.types import CRACK, Surface
from craftmesh.voxels.islands import Island

DEFAULT = TetrahedralizeOptions()


class Constant:
    """A sizing of one length."""

    def __init__(self, length):
        self.length = length

    def at(self, points):
        return np.full(len(points), self.length)


def by_cell(labels):
    """A `label_of` that looks labels up by cell."""
    return lambda centres: labels[tuple(centres.astype(int).T)]


def row_of(shape, *blocks, fill=1):
    """Labels of `shape` filled with `fill`, and with (label, slices) of blocks over it."""
    labels = np.full(shape, fill)
    for label, *slices in blocks:
        labels[tuple(slices)] = label
    return labels


def keys_of(report):
    """All keys of a report, those of its parts included."""
    for key, value in report.items():
        yield key
        yield from keys_of(value) if isinstance(value, dict) else ()


def check_fill(surface, grain_tets):
    """Volumes, facets and the bits of surface nodes, by plain Python sets."""
    volumes = side_volumes(surface.points, surface.facets, surface.sides)
    for one in grain_tets:
        nodes = np.concatenate([surface.points[one.nodes], one.interior])
        volume = tet_volumes(nodes, one.tets)
        assert (volume > 0).all()
        # rounding of sums over some 1000 tets
        assert volume.sum() == pytest.approx(volumes[one.grain], rel=1e-11)
        count = {}
        ids = np.concatenate([one.nodes, -1 - np.arange(len(one.interior))])
        for face in half_faces(ids[one.tets]):
            key = frozenset(face.tolist())
            count[key] = count.get(key, 0) + 1
        boundary = {key for key, times in count.items() if times == 1}
        own = (surface.sides == one.grain).any(1)
        inside = (surface.sides == one.grain).all(1)
        assert boundary == {frozenset(f) for f in surface.facets[own & ~inside].tolist()}
        assert all(count[frozenset(f)] == 2 for f in surface.facets[inside].tolist())


def mesh_here(surface, sizing, options=DEFAULT):
    """The first attempt at all grains, in this process."""
    attempt = attempts(options.all_switches, options.interior_points)[0]
    tasks = [MeshingTask(one, np.zeros((0, 3)), attempt) for one in grain_surfaces(surface)]
    return [mesh_grain(Setting(options, sizing), task)[0] for task in tasks]


def shapes():
    s = slice
    ones = (5, 5, 5)
    yield "one grain", row_of((3, 2, 2))
    yield "island", row_of(ones, (2, s(2, 3), s(2, 3), s(2, 3)))
    yield "void", row_of(ones, (-1, s(2, 3), s(2, 4), s(2, 3)))
    yield (
        "island in an island",
        row_of(ones, (2, s(1, 4), s(1, 4), s(1, 4)), (3, s(2, 3), s(2, 3), s(2, 3))),
    )
    yield (
        "a piece of the host in an island",
        row_of(ones, (2, s(1, 4), s(1, 4), s(1, 4)), (1, s(2, 3), s(2, 3), s(2, 3))),
    )
    yield "islands that touch in a face", row_of(ones, (2, 1, 2, 2), (3, 2, 2, 2))
    yield "islands that touch in an edge", row_of(ones, (2, 1, 1, 2), (3, 2, 2, 2))
    yield "islands that touch in a point", row_of(ones, (2, 1, 1, 1), (3, 2, 2, 2))
    yield "a void touching an island", row_of(ones, (2, 1, 2, 2), (-1, 2, 2, 2))
    yield "two pieces", row_of((5, 2, 2), (2, s(2, 3)))
    yield "pieces touching in an edge", row_of((2, 2, 1), (2, 0, 1, 0), (2, 1, 0, 0))
    yield "pieces touching in a point", row_of((2, 2, 2), (2, 0, 0, 0), (2, 1, 1, 1))
    yield "an island touching the host's rim", row_of((3, 3, 3), (2, 0, 0, 1), (2, 1, 1, 1))
    yield "a ring", row_of((3, 3, 2), (2, 1, 1, s(None)))


@pytest.mark.parametrize("labels", [pytest.param(labels, id=name) for name, labels in shapes()])
def test_every_shape_is_filled_exactly(labels):
    surface, _ = structured_box(
        labels.shape, by_cell(labels), spacing=(0.5, 0.6, 0.7), origin=(40.0, -3.0, 9.0)
    )
    result = mesh_here(surface, Constant(0.5))
    assert [one.grain for one in result] == sorted(int(g) for g in np.unique(labels) if g > 0)
    check_fill(surface, result)
    assemble(surface, result)


def crack_model():
    """Two grains, a hexagonal crack inside the first one that does not reach its boundary."""
    return structured_box(
        (7, 6, 4), lambda c: 1 + (c[:, 0] > 6), crack_at=plane_crack(2, 2, hexagon((3, 3), 2.2))
    )


def test_crack_facets_stay_inside_and_open():
    surface, _ = crack_model()
    internal = (surface.kind == CRACK) & (surface.sides[:, 0] == surface.sides[:, 1])
    assert internal.sum() > 10
    result = mesh_here(surface, Constant(1.0))
    check_fill(surface, result)
    assert sum(len(one.interior) for one in result) > 0
    _, report = assemble(surface, result)
    assert report["crack_facets"] == internal.sum() and report["crack_facets_not_opened"] == 0


def test_the_result_does_not_depend_on_workers():
    surface, _ = structured_box((4, 3, 3), lambda c: 1 + (c[:, 0].astype(int) + c[:, 1].astype(int)) % 4)
    made = [tetrahedralize(surface, Constant(0.6), DEFAULT, workers=n) for n in (1, 2)]
    for _, report in made:
        assert report["failed"] == {} and report["tried_again"] == {}
        assert all(re.fullmatch("[a-z0-9_]+", key) for key in keys_of(report))
    for a, b in zip(made[0][0], made[1][0], strict=True):
        assert (a.grain, a.nodes.tobytes(), a.interior.tobytes(), a.tets.tobytes()) == (
            b.grain,
            b.nodes.tobytes(),
            b.interior.tobytes(),
            b.tets.tobytes(),
        )


def test_island_seeds_are_taken_where_they_lie_inside_and_found_elsewhere():
    labels = row_of((5, 5, 5), (-1, 1, 1, 1), (2, 3, 3, 3))
    surface, _ = structured_box(labels.shape, by_cell(labels))
    good = Island(1, (-1,), np.array([[1.5, 1.5, 1.5]]), (1,))
    bad = Island(1, (2,), np.array([[0.5, 3.5, 3.5]]), (1,))
    result, report = tetrahedralize(surface, None, DEFAULT, (good, bad), grains=[1])
    check_fill(surface, result)
    assert (report["holes"], report["island_seeds_off"]) == (2, 1)


def test_only_the_grains_asked_for():
    surface, _ = structured_box((3, 1, 1), lambda c: 1 + c[:, 0].astype(int))
    result, _ = tetrahedralize(surface, None, DEFAULT, grains=[3, 1])
    assert [one.grain for one in result] == [1, 3]
    with pytest.raises(CraftmeshError, match="grain 8 has no facets"):
        tetrahedralize(surface, None, DEFAULT, grains=[8])


def test_an_open_surface_fails_and_names_the_grain():
    surface, _ = structured_box((2, 1, 1), lambda c: 5 + c[:, 0].astype(int))
    keep = np.arange(len(surface.facets)) != np.flatnonzero(surface.kind == 1)[0]
    broken = Surface(surface.points, surface.facets[keep], surface.sides[keep], surface.kind[keep])
    with pytest.raises(MeshingError, match="grain 5") as caught:
        tetrahedralize(broken, None, DEFAULT)
    assert [one.grain for one in caught.value.done] == [6]


def test_points_given_twice_count_once():
    surface, _ = structured_box((2, 1, 1), lambda c: 1 + c[:, 0].astype(int))
    count = len(surface.points)
    facets = surface.facets.copy()
    second = (surface.sides[:, 0] == 2) | (surface.sides[:, 1] == 2)
    facets[second] += count
    doubled = Surface(np.concatenate([surface.points] * 2), facets, surface.sides, surface.kind)
    assert (lowest_equal_point(doubled.points) == np.tile(np.arange(count), 2)).all()
    for one in tetrahedralize(doubled, None, DEFAULT)[0]:
        assert one.nodes.max() < count


def test_grain_surfaces_are_closed_and_turn_outwards():
    surface, _ = crack_model()
    for one in grain_surfaces(surface):
        assert one.volume == pytest.approx(
            side_volumes(surface.points, surface.facets, surface.sides)[one.grain]
        )
        directed = one.facets[~one.internal][:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        assert sorted(map(tuple, directed)) == sorted(map(tuple, directed[:, ::-1]))


def test_a_facet_that_is_no_face_is_found():
    surface, (grain,) = structured_box((2, 2, 2), lambda c: np.ones(len(c), int))
    one = grain_surfaces(surface)[0]
    assert find_regions(one, grain.tets).kept.all()
    with pytest.raises(WrongMesh):
        find_regions(one, grain.tets[1:])


def test_real_grains(shared_data):
    whole, _ = real_grains(shared_data)
    grains = [3, 8]
    own = np.isin(whole.sides, grains).any(1)
    surface = Surface(whole.points, whole.facets[own], whole.sides[own], whole.kind[own])
    result, report = tetrahedralize(surface, Constant(2.0), DEFAULT, grains=grains)
    check_fill(surface, result)
    assert report["tried_again"] == {} and report["interior_points"] > 0
