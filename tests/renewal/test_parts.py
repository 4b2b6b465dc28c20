"""Cutting a part out of a mesh and putting it back: nothing changes but what the part changes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from structured_box import structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.errors import CraftmeshError
from craftmesh.mesh.check import check
from craftmesh.mesh.tet_connectivity import tet_volumes
from craftmesh.renewal.cut_out import cut_out, tets_of
from craftmesh.renewal.numbering import _numbers, renumbered
from craftmesh.renewal.put_back import put_back
from craftmesh.renewal.region import samples_of, widened
from craftmesh.renewal.whole import grain_tets_of, whole_of_mesh
from craftmesh.sizing.sizing import Sizing
from craftmesh.surface.check_surface import check_surface
from craftmesh.surface.front import front_edges
from craftmesh.types import BORDER, CRACK, Crack, Surface

SIZING = Sizing(0.5, 1.0, 1.0, 1.0, 2.0, 1.0, np.zeros((0, 3)))


def cracked(void=False):
    """Return two grains, one with a void or not, and a crack in their boundary and in a grain; its mesh."""

    def label_of(cells):
        grain = np.where(cells[:, 0] < 3, 1, 2)
        return np.where(void & (np.abs(cells - 1.5).max(axis=1) < 1), -1, grain)

    def crack_at(centres, normals):
        at_boundary = np.isclose(centres[:, 0], 3) & (centres[:, 1] < 2)
        within = np.isclose(centres[:, 2], 4) & (centres[:, 0] > 3) & (centres[:, 0] < 5)
        return at_boundary | (within & np.isclose(np.abs(normals[:, 2]), 1))

    surface, grain_tets = structured_box((6, 5, 6), label_of, crack_at)
    return surface, assemble(surface, grain_tets)[0]


def facets_of(surface: Surface) -> set:
    """Return the facets by their places, sides and kinds, whatever their order and orientation."""
    found = set()
    for corners, sides, kind in zip(surface.points[surface.facets], surface.sides, surface.kind):
        found.add((frozenset(map(tuple, corners.tolist())), frozenset(sides.tolist()), int(kind)))
    return found


@pytest.mark.parametrize("void", [False, True])
def test_a_mesh_closed_again_has_the_surface_that_it_was_assembled_from(void):
    surface, mesh = cracked(void)
    whole = whole_of_mesh(mesh, np.ones(len(mesh.points)))
    assert facets_of(whole.surface) == facets_of(surface)
    assert check_surface(whole.surface) == []
    assert np.array_equal(whole.points[whole.tets], mesh.points[mesh.tets])
    assert len(front_edges(whole.surface)) == len(front_edges(surface)) > 0


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1), st.floats(0.02, 0.9))
def test_any_part_put_back_unchanged_gives_the_mesh_with_its_numbers(seed, share):
    _, mesh = cracked()
    whole = whole_of_mesh(mesh, np.ones(len(mesh.points)))
    chosen = widened(whole, np.random.default_rng(seed).random(len(mesh.tets)) < share**3, 0)
    if not chosen.any():
        return
    part = cut_out(whole, chosen, with_crack=True)
    tets = tets_of(whole, part)
    volume = sum(
        tet_volumes(np.concatenate([part.surface.points[t.nodes], t.interior]), t.tets).sum() for t in tets
    )
    assert volume == pytest.approx(tet_volumes(whole.points, whole.tets[chosen]).sum())
    back = put_back(whole, part, part.surface, tets, SIZING)
    assert facets_of(back.surface) == facets_of(whole.surface)
    assert (back.origin >= 0).sum() == (~chosen).sum()
    grain_tets, rows = grain_tets_of(back)
    result, numbers, _ = renumbered(mesh, assemble(back.surface, grain_tets)[0], back.origin[rows])
    assert check(result) == []
    stays = np.flatnonzero(~chosen)
    assert np.array_equal(numbers.elements[stays], stays)
    assert np.array_equal(result.tets[stays], mesh.tets[stays])
    assert np.array_equal(result.points[result.tets[stays]], mesh.points[mesh.tets[stays]])
    assert {name: len(rows) for name, rows in result.face_sets.items()} == {
        name: len(rows) for name, rows in mesh.face_sets.items()
    }


def test_a_part_without_its_crack_is_a_closed_body_whose_border_is_marked():
    _, mesh = cracked()
    whole = whole_of_mesh(mesh, np.ones(len(mesh.points)))
    near = np.linalg.norm(whole.points - [3, 2, 4], axis=1) < 1.8
    part = cut_out(whole, widened(whole, near[whole.tets].any(axis=1), 0), with_crack=False)
    assert check_surface(part.surface) == []
    assert not (part.surface.kind == CRACK).any()
    border = part.surface.sides[part.surface.kind == BORDER]
    assert len(border) and (border == 0).any(axis=1).all()


def test_another_border_is_refused():
    _, mesh = cracked()
    whole = whole_of_mesh(mesh, np.ones(len(mesh.points)))
    near = np.linalg.norm(whole.points - [3, 2, 4], axis=1) < 1.8
    part = cut_out(whole, widened(whole, near[whole.tets].any(axis=1), 0), with_crack=True)
    points = part.surface.points.copy()
    points[part.surface.facets[part.surface.kind == BORDER][0, 0]] += 1e-9
    moved = Surface(points, part.surface.facets, part.surface.sides, part.surface.kind)
    with pytest.raises(CraftmeshError, match="border"):
        put_back(whole, part, moved, tets_of(whole, part), SIZING)


@given(st.lists(st.integers(-1, 12), max_size=12))
def test_numbers_are_a_permutation_that_keeps_what_it_can(wanted):
    rows = np.array(wanted, np.int64)
    found = _numbers(rows)
    assert sorted(found) == list(range(len(rows)))
    for number in set(wanted):
        if 0 <= number < len(rows):
            assert found[wanted.index(number)] == number


def test_samples_lie_no_farther_apart_than_asked():
    points = np.array([[0.0, 0, 0], [3, 0, 0], [0, 2, 0], [3, 2.5, 1]])
    crack = Crack(points, [[0, 1, 2], [1, 3, 2]], ())
    samples = samples_of(crack, 0.5)
    rng = np.random.default_rng(0)
    share = rng.dirichlet([1, 1, 1], 200)
    places = share @ points[[1, 3, 2]]
    away = np.linalg.norm(places[:, None] - samples, axis=2).min(axis=1)
    assert away.max() < 0.5  # a triangle of edges .5 at most has no place farther from its corners
