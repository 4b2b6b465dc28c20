"""Islands: enclosure by topology, nesting, clusters, and seeds that lie inside."""

import json

import networkx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from craftmesh.errors import CraftmeshError
from craftmesh.types import Voxels
from craftmesh.voxels.clean import clean, number_voids
from craftmesh.voxels.islands import find_islands, islands_as_json, islands_from_json
from craftmesh.voxels.reading import read_voxels
from craftmesh.voxels.voxel_graph import find_pieces, shared_faces


def voxels(labels, spacing=(1, 1, 1), origin=(0, 0, 0)) -> Voxels:
    return Voxels(labels, spacing, origin)


def label_at(volume: Voxels, point) -> int:
    return int(volume.labels[tuple(np.floor((point - volume.origin) / volume.spacing).astype(int))])


def assert_seeds_inside(volume: Voxels):
    for island in find_islands(volume):
        assert [label_at(volume, seed) for seed in island.seeds] == list(island.members)


def box(shape=(12, 11, 10)) -> np.ndarray:
    labels = np.ones(shape, np.int32)
    labels[: shape[0] // 2] = 2
    return labels


def test_void_and_grain_inside_one_grain():
    labels = box()
    labels[8:10, 4:6, 4:6] = -1
    labels[2:4, 4:7, 4:6] = 9
    labels[5:8, 8, 8] = -2  # on the boundary of 1 and 2: enclosed, but by neither alone
    found = find_islands(voxels(labels))
    assert [(i.host, i.members, i.kind, i.voxels) for i in found] == [
        (1, (-1,), "void", (8,)),
        (2, (9,), "grain", (12,)),
    ]
    np.testing.assert_array_equal(found[0].seeds, [[9, 5, 5]])  # the middle of 2 x 2 x 2 voxels


def test_touching_a_face_of_the_box_is_not_enclosed():
    labels = box()
    labels[8:, 4:6, 4:6] = 9
    labels[3, 3, 0] = -1
    assert find_islands(voxels(labels)) == ()


def test_open_pore_does_not_enclose_what_it_reaches():
    labels = box()
    labels[8:11, 4:8, 4:8] = 9
    labels[7, 5, 1:6] = 0  # a channel from the box to grain 9
    labels[7, 5, 0] = 0
    assert find_islands(voxels(labels)) == ()


def test_cluster_of_touching_grains_is_one_island_with_a_seed_each():
    labels = box((20, 10, 10))
    labels[12:14, 3:7, 3:7] = 5
    labels[14:16, 3:7, 3:7] = 6
    labels[16, 4, 4] = -1
    (island,) = find_islands(voxels(labels))
    assert (island.host, sorted(island.members), island.kind) == (1, [-1, 5, 6], "grain")
    assert len(island.seeds) == 3
    largest = int(np.argmax(island.voxels))
    assert label_at(voxels(labels), island.seed) == island.members[largest]


def test_islands_within_islands_belong_to_their_innermost_host():
    labels = box((24, 12, 12))
    labels[13:22, 2:11, 2:11] = 5
    labels[15:20, 4:9, 4:9] = 6
    labels[17, 6, 6] = -1
    found = {i.host: i.members for i in find_islands(voxels(labels))}
    assert found == {1: (5,), 5: (6,), 6: (-1,)}


def test_two_places_in_one_grain_are_two_islands():
    labels = box((24, 12, 12))
    labels[14:16, 4:6, 4:6] = 5
    labels[18:20, 4:6, 4:6] = 5
    found = find_islands(voxels(labels))
    assert [(i.host, i.members) for i in found] == [(1, (5,)), (1, (5,))]
    assert found[0].seeds[0, 0] < 17 < found[1].seeds[0, 0]


def test_grain_that_floats_in_a_void_has_no_host():
    labels = box((24, 12, 12))
    labels[14:21, 3:10, 3:10] = -1
    labels[17, 6, 6] = 5
    assert [(i.host, i.members) for i in find_islands(voxels(labels))] == [(1, (-1,))]


def test_seed_of_a_bent_body_lies_in_it_with_anisotropic_spacing():
    labels = np.ones((20, 20, 20), np.int32)
    labels[4:16, 4:16, 8:11] = 2
    labels[7:13, 7:13, 8:11] = 1  # a ring, its centroid is outside it
    ring = voxels(labels, (0.5, 2.0, 3.0), (10, -5, 7))
    (island,) = find_islands(ring)
    assert_seeds_inside(ring)
    seed = (island.seeds[0] - ring.origin) / ring.spacing
    assert 9 <= seed[2] <= 10  # the middle of the three slices
    with pytest.raises(ValueError):
        island.seeds[0] = 0


@settings(max_examples=10)
@given(st.integers(0, 10**6))
def test_islands_are_what_a_host_cuts_off(seed):
    rng = np.random.default_rng(seed)
    labels = number_voids(rng.choice([1] * 7 + [2, 3, 4, -1], (9, 8, 10)).astype(np.int32))
    volume = voxels(labels)
    expected = enclosed_by_removal(labels)
    found = sorted(
        (island.host, tuple(sorted(zip(island.members, island.voxels)))) for island in find_islands(volume)
    )
    assert found == expected
    assert_seeds_inside(volume)


def enclosed_by_removal(labels):
    """Slow reference: remove each piece from the graph in turn and see what loses the outside."""
    pieces = find_pieces(labels)
    graph = networkx.Graph()
    graph.add_edges_from(shared_faces(pieces.of, len(pieces.label))[0].tolist())
    graph.add_nodes_from(range(len(pieces.label)))
    graph.add_edges_from(("out", p) for p in range(len(pieces.label)) if pieces.touches_box[p])
    cut_off = {}
    for host in range(len(pieces.label)):
        rest = graph.copy()
        rest.remove_node(host)
        parts = [part for part in networkx.connected_components(rest) if "out" not in part]
        if "out" in rest and parts:
            cut_off[host] = parts
    inner = {host: set().union(*parts) for host, parts in cut_off.items()}  # members of deeper hosts too
    result = []
    for host, parts in cut_off.items():
        for part in parts:
            members = part - set().union(*(inner[h] for h in part if h in inner))
            if pieces.label[host] > 0:
                named = sorted((int(pieces.label[m]), int(pieces.voxels[m])) for m in members)
                result.append((int(pieces.label[host]), tuple(named)))
    return sorted(result)


def test_json_comes_back():
    labels = box()
    labels[8:10, 4:6, 4:6] = -1
    labels[2:4, 4:7, 4:6] = 9
    written = islands_as_json(find_islands(voxels(labels, (0.1, 0.2, 0.3))))
    assert islands_as_json(islands_from_json(json.loads(json.dumps(written)), "i.json")) == written


@pytest.mark.parametrize(
    "content",
    [{}, {"islands": [{"host": 1}]}, {"islands": [{"host": 1, "members": []}]}, {"islands": 3}],
)
def test_other_json_is_refused(content):
    with pytest.raises(CraftmeshError, match="^i.json: .*craftmesh import"):
        islands_from_json(content, "i.json")


def test_copper_has_fourteen_embedded_grains(shared_data):
    volume, _ = clean(read_voxels(shared_data / "readers/copper_v7.dream3d"))
    found = find_islands(volume)
    assert len(found) == 14
    assert all(island.kind == "grain" and len(island.members) == 1 for island in found)
    assert_seeds_inside(volume)
