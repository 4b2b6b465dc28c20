"""Each breach of a surface's invariants is found when it is planted, and none is found without."""

from dataclasses import replace

import numpy as np
import pytest
from plain_topology import tied_vertices

from craftmesh.remeshing.kernels.marching import march
from craftmesh.surface.check_surface import check_surface
from craftmesh.types import BORDER, CRACK, INTERFACE, Surface


@pytest.fixture(scope="module")
def sound():
    labels = np.ones((4, 4, 4), np.int32)
    labels[2:], labels[:2, 2:] = 2, 3
    return Surface(*march(labels))


def breach(surface):
    """The only sentence that the check says."""
    sentences = check_surface(surface)
    assert len(sentences) == 1, sentences
    return sentences[0]


def without(surface, facet):
    kept = np.arange(len(surface.facets)) != facet
    return Surface(surface.points, surface.facets[kept], surface.sides[kept], surface.kind[kept])


def with_facets(surface, facets, sides, kind):
    count = len(facets)
    return Surface(
        surface.points,
        np.vstack([surface.facets, facets]),
        np.vstack([surface.sides, [sides] * count]),
        np.append(surface.kind, [kind] * count),
    )


def moved(surface, vertex, point):
    points = surface.points.copy()
    points[vertex] = point
    return replace(surface, points=points)


def inner_vertex(surface):
    """A vertex that only facets between two grains use."""
    on_box = np.isin(np.arange(len(surface.points)), surface.facets[surface.kind != INTERFACE])
    return int(np.flatnonzero(~on_box)[0])


def test_a_sound_surface_has_no_breach(sound):
    assert check_surface(sound) == []
    assert tied_vertices(sound) == {}


def test_a_hole_is_found(sound):
    facet = int(np.flatnonzero(sound.kind == INTERFACE)[5])
    sentence = breach(without(sound, facet))
    assert sentence.startswith("6 edges have no partner")
    assert all(f"grain {g}" in sentence for g in sound.sides[facet])


def test_a_turned_facet_is_found(sound):
    facets = sound.facets.copy()
    facet = int(np.flatnonzero(sound.kind == INTERFACE)[5])
    facets[facet] = facets[facet, ::-1]
    assert "not oriented consistently" in breach(replace(sound, facets=facets))


def test_a_grain_turned_inside_out_is_found(sound):
    sentences = check_surface(replace(sound, sides=sound.sides[:, ::-1]))
    assert sum("volume" in s for s in sentences) == 3
    assert sum("outside the box" in s for s in sentences) == 6


def test_a_duplicate_facet_is_found(sound):
    pair = np.stack([sound.facets[0], sound.facets[0, ::-1]])
    sentences = check_surface(with_facets(sound, pair, sound.sides[0], sound.kind[0]))
    assert any("3 facets lie on the same three points" in s for s in sentences)


@pytest.mark.parametrize("corner", [0, 1, 2])
def test_a_facet_with_a_point_twice_is_degenerate(sound, corner):
    facets = sound.facets.copy()
    facets[0, corner] = facets[0, corner - 1]
    assert any("degenerate" in s for s in check_surface(replace(sound, facets=facets)))


def test_a_degenerate_facet_is_found(sound):
    a, b, c = sound.facets[np.flatnonzero(sound.kind == INTERFACE)[0]]
    broken = moved(sound, c, (sound.points[a] + sound.points[b]) / 2)
    assert any("degenerate" in s for s in check_surface(broken))


def test_an_unused_point_is_found(sound):
    sentence = breach(replace(sound, points=np.vstack([sound.points, [[1, 2, 3]]])))
    assert sentence == "1 points belong to no facet; first at (1, 2, 3)"


def test_a_point_off_its_plane_by_one_bit_is_found(sound):
    facet = sound.facets[(sound.kind == 6)][0]
    level = np.nextafter(4.0, 0)
    point = sound.points[facet[0]].copy()
    point[2] = level
    assert "ZMAX are not exactly" in " ".join(check_surface(moved(sound, facet[0], point)))


def test_points_past_the_box_are_found(sound):
    vertex = inner_vertex(sound)
    point = sound.points[vertex] - (0, 0, 10)
    assert any("of ZMIN are not exactly" in s for s in check_surface(moved(sound, vertex, point)))


def test_sides_that_do_not_fit_the_kind_are_found(sound):
    inner = np.flatnonzero(sound.kind == INTERFACE)
    kind = sound.kind.copy()
    kind[inner[0]] = 1
    assert any("on the box have no outside" in s for s in check_surface(replace(sound, kind=kind)))
    sides = sound.sides.copy()
    sides[inner[0]] = 2
    assert any("same grain on both sides" in s for s in check_surface(replace(sound, sides=sides)))
    sides[inner[0]] = (0, -1)
    assert any("bound no grain" in s for s in check_surface(replace(sound, sides=sides)))


def test_an_intersection_is_found_with_its_place(sound):
    vertex = inner_vertex(sound)
    sentence = " ".join(check_surface(moved(sound, vertex, sound.points[vertex] + (1.9, 0.1, 0.2))))
    assert "pairs of facets intersect, between" in sentence and "first at (" in sentence


def test_crack_facets_inside_a_grain_bound_nothing(sound):
    points = np.vstack([sound.points, [[2.6, 1, 1.1], [3.2, 1.5, 1.2], [2.7, 1.9, 2.3]]])
    n = len(sound.points)
    cracked = with_facets(replace(sound, points=points), [[n, n + 1, n + 2]], (2, 2), CRACK)
    assert check_surface(cracked) == []


def test_a_crack_along_a_grain_boundary_is_part_of_it(sound):
    kind = sound.kind.copy()
    kind[np.flatnonzero(kind == INTERFACE)[:4]] = CRACK
    assert check_surface(replace(sound, kind=kind)) == []


def test_tied_vertices_are_counted_per_grain():
    """Two tetrahedra of one grain that touch in one point."""
    points = np.array(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]], float
    )
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    second = np.array([0, 4, 5, 6])[faces][:, ::-1]
    facets = np.vstack([faces, second])
    surface = Surface(points, facets, [(7, 0)] * 8, np.zeros(8))
    assert check_surface(surface) == []
    assert tied_vertices(surface) == {7: 1}


def test_an_empty_surface_is_a_breach():
    assert check_surface(Surface(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 2)), np.zeros(0))) == [
        "the surface has no facets"
    ]


@pytest.mark.parametrize(
    ("count", "named"),
    [
        (2, "between void 1, outside, grain 1, grain 2; first"),
        (3, "between void 1, outside, grain 1, grain 2, grain 3; first"),
        (8, "between void 1, outside, grain 1, grain 2, grain 3 and 5 more; first"),
    ],
)
def test_five_of_the_labels_at_a_breach_are_named_as_what_they_are(count, named):
    labels = np.repeat(np.arange(1, count + 1, dtype=np.int32), 3)[:, None, None] * np.ones(
        (1, 3, 3), np.int32
    )
    labels[1, 1, 1] = -1
    surface = Surface(*march(labels))
    kinds = replace(surface, kind=np.full(len(surface.kind), BORDER + 1))
    (told,) = (one for one in check_surface(kinds) if "have a kind above" in one)
    assert named in told
