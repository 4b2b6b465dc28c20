"""Cleaning: nothing unindexed is left, every change is counted, ids are kept."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from craftmesh.errors import CraftmeshError
from craftmesh.types import Voxels
from craftmesh.voxels.clean import CleanOptions, clean, fill_unindexed, number_voids
from craftmesh.voxels.islands import find_islands
from craftmesh.voxels.reading import ReadOptions, read_voxels
from craftmesh.voxels.remapping import RawVolume


def voxels(labels, orientations=None) -> Voxels:
    return Voxels(labels, (1, 1, 1), (0, 0, 0), orientations)


def raw(labels, unindexed) -> RawVolume:
    ids = np.unique(labels).tolist()
    return RawVolume(voxels(labels), unindexed, dict(zip(ids, ids)))


def halves(shape=(6, 5, 4)) -> np.ndarray:
    labels = np.full(shape, 7, np.int32)
    labels[: shape[0] // 2] = 4
    return labels


def components(labels, label) -> int:
    return ndimage.label(labels == label)[1]


def test_clean_volume_stays_as_it_is():
    made, report = clean(voxels(halves()))
    np.testing.assert_array_equal(made.labels, halves())
    assert report["grains"] == 2
    assert report["remap"] == {"4": [4], "7": [7]}
    assert report["filled_voxels"] == report["absorbed_voxels"] == 0


def test_unindexed_voxels_take_the_majority_then_the_lowest_id():
    labels = halves((4, 3, 3))
    unindexed = np.zeros(labels.shape, bool)
    unindexed[1, 1, 1] = unindexed[2, 0, 0] = True  # 5 of 6 neighbours are 4; one is 4 and two are 7
    labels[unindexed] = 0
    filled, count = fill_unindexed(labels, unindexed)
    assert count == 2
    np.testing.assert_array_equal(filled, halves((4, 3, 3)))
    row = np.array([9, 0, 5], np.int32).reshape(3, 1, 1)
    assert fill_unindexed(row, row == 0)[0][1, 0, 0] == 5


def test_filling_goes_ring_by_ring():
    row = np.array([9, 0, 0, 0, 0, 5], np.int32).reshape(6, 1, 1)
    assert fill_unindexed(row, row == 0)[0].ravel().tolist() == [9, 9, 9, 5, 5, 5]


def test_unindexed_voxels_beside_voids_become_grain():
    labels = np.full((5, 5, 5), 2, np.int32)
    labels[:2] = 3
    labels[2, 2, 2], labels[3, 2, 2] = -1, 0
    unindexed = labels == 0
    made, report = clean(raw(labels, unindexed), CleanOptions(fill_unindexed=True))
    assert made.labels[3, 2, 2] == 2
    assert report["voids"] == {"1": 1}


def test_unindexed_voxels_have_to_be_decided_on():
    labels = halves()
    labels[2, 2, 2] = 0
    with pytest.raises(CraftmeshError, match=r"^1 voxels.*fill_unindexed.*background to void"):
        clean(raw(labels, labels == 0))


def test_voids_are_numbered_and_open_ones_are_outside():
    labels = halves((9, 9, 9))
    labels[0, 4, 4] = 0  # on the box
    labels[2, 2, 2] = 0
    labels[6, 6, 6] = 0
    labels[4, 4, 4] = -1  # declared
    labels[8, 1:3, 1] = -5  # declared, but open to the box
    made = number_voids(labels)
    assert made[0, 4, 4] == made[8, 1, 1] == 0
    assert (made[2, 2, 2], made[4, 4, 4], made[6, 6, 6]) == (-2, -1, -3)
    assert made.min() == -3


def test_touching_empty_voxels_are_one_void_with_the_declared_id():
    labels = halves((7, 7, 7))
    labels[3, 3, 2:4] = 0
    labels[3, 3, 4] = -9
    assert number_voids(labels)[3, 3, 2:5].tolist() == [-9, -9, -9]


def test_islands_join_the_neighbour_with_most_faces():
    labels = halves((8, 6, 6))
    labels[3, 2, 2] = 11  # five faces with 4, one with 7
    labels[6, 3, 3] = 4  # a piece of grain 4 within 7
    made, report = clean(voxels(labels), CleanOptions(min_island_voxels=2))
    np.testing.assert_array_equal(made.labels, halves((8, 6, 6)))
    assert (report["absorbed_pieces"], report["absorbed_voxels"]) == (2, 2)
    assert report["absorbed_grains"] == [11]
    assert report["remap"]["11"] == []
    assert report["grains_in_pieces_before"] == 1


def test_islands_of_enough_voxels_stay():
    labels = halves((8, 6, 6))
    labels[5:7, 3, 3] = 11
    made, _ = clean(voxels(labels), CleanOptions(min_island_voxels=2))
    np.testing.assert_array_equal(made.labels, labels)


def test_small_void_becomes_grain_and_floating_speck_becomes_void():
    labels = halves((12, 9, 9))
    labels[8, 4, 4] = -2
    labels[2:5, 2:5, 2:5] = -1
    labels[3, 3, 3] = 7
    made, report = clean(voxels(labels), CleanOptions(min_island_voxels=3))
    assert made.labels[8, 4, 4] == 7
    assert made.labels[3, 3, 3] == -1
    assert report["absorbed_voids"] == [2]
    assert report["voids"] == {"1": 27}


def test_pieces_become_grains_with_their_parents_orientation():
    labels = halves((8, 6, 6))
    labels[6, 3, 2:4] = 4
    labels[5, 0, 0] = 4
    orientations = np.full((8, 4), np.nan)
    orientations[4], orientations[7] = [1, 0, 0, 0], [0, 1, 0, 0]
    made, report = clean(voxels(labels, orientations), CleanOptions(split_pieces=True))
    assert report["grains_in_pieces"] == {"4": 3}
    assert report["split_grains"] == {"8": 4, "9": 4}
    assert report["remap"]["4"] == [4, 8, 9]
    assert (made.labels[6, 3, 2], made.labels[5, 0, 0]) == (8, 9)
    np.testing.assert_array_equal(made.orientations[[4, 8, 9]], np.tile([1.0, 0, 0, 0], (3, 1)))
    assert all(components(made.labels, k) == 1 for k in (4, 7, 8, 9))


def precipitates() -> np.ndarray:
    """Grain 1, and 27 voxels of grain 2 apart from one another."""
    labels = np.ones((9, 9, 9), np.int32)
    labels[1::3, 1::3, 1::3] = 2
    return labels


def test_an_absorption_that_leaves_one_grain_names_what_it_took():
    options = CleanOptions(min_island_voxels=2)
    words = r"^min_island_voxels 2 leaves only grain 1 .*grain 2 \(27 pieces, 27 voxels, to grain 1\)"
    with pytest.raises(CraftmeshError, match=words):
        clean(voxels(precipitates()), options)
    labels = precipitates()
    labels[:2] = 3
    (change,) = clean(voxels(labels), options)[1]["changes"]
    assert (
        "18 pieces, 18 voxels (2.5 %)" in change and "grain 2 (18 pieces, 18 voxels, to grain 1)" in change
    )


def test_every_step_says_its_share_and_its_option():
    labels = halves((10, 10, 10))
    labels[2, 2, 2] = labels[7, 7, 7] = 0
    labels[5, 4, 4], labels[8, 2:4, 2] = 4, 11
    labels[0, 0, 0], labels[4:6, 7, 7] = -5, -6
    labels[9, 9, 8:] = 4
    options = CleanOptions(fill_unindexed=True, min_island_voxels=2, split_pieces=True)
    report = clean(raw(labels, labels == 0), options)[1]
    said = {
        "fill_unindexed": r"2 voxels \(0.2 %\) without a grain",
        "void_labels": r"3 voxels \(0.3 %\) are empty: 1 enclosed voids, and 1 voxels.*; voids 5 touch",
        "min_island_voxels": r"1 pieces, 1 voxels \(0.1 %\)",
        "split_pieces": r"1 pieces of 1 grains, 2 voxels \(0.2 %\)",
    }
    for change, (option, words) in zip(report["changes"], said.items(), strict=True):
        assert option in change and re.search(words, change), (option, change)


@settings(max_examples=15)
@given(
    st.integers(0, 10**6),
    st.lists(st.integers(1, 2**31 - 20), min_size=4, max_size=4, unique=True).map(sorted),
    st.booleans(),
)
def test_how_large_ids_are_makes_no_difference(seed, ids, split):
    few = np.random.default_rng(seed).choice([-1, 1, 2, 3, 4], (6, 7, 5), p=[0.1, 0.3, 0.2, 0.2, 0.2])
    many = np.array([0, *ids, -1], np.int32)[few]
    options = CleanOptions(min_island_voxels=4, smoothing_rounds=1, split_pieces=split)
    (made, report), (other, others) = (clean(voxels(labels), options) for labels in (few, many))
    ids += range(ids[-1] + 1, ids[-1] + 1 + len(report["split_grains"]))
    named = np.where(made.labels > 0, np.array([0, *ids])[np.maximum(made.labels, 0)], made.labels)
    np.testing.assert_array_equal(named, other.labels)
    assert [island.voxels for island in find_islands(made)] == [one.voxels for one in find_islands(other)]
    for count in ("grains", "absorbed_pieces", "smoothed_voxels", "roughness"):
        assert report[count] == others[count]


def test_volumes_without_boundary_are_refused():
    with pytest.raises(CraftmeshError, match="no grain"):
        clean(voxels(np.zeros((3, 3, 3))))
    with pytest.raises(CraftmeshError, match="grain 5.*allow_single_grain"):
        clean(voxels(np.full((3, 3, 3), 5)))
    assert clean(voxels(np.full((3, 3, 3), 5)), CleanOptions(allow_single_grain=True))[1]["grains"] == 1
    holed = np.full((3, 3, 3), 5)
    holed[1, 1, 1] = -1
    assert clean(voxels(holed))[1]["grains"] == 1


@settings(max_examples=25)
@given(st.integers(0, 10**6), st.integers(0, 6), st.booleans())
def test_noise_becomes_clean(seed, minimum, split):
    labels = np.random.default_rng(seed).integers(-1, 4, (6, 7, 5)).astype(np.int32)
    unindexed = labels == 0
    options = CleanOptions(fill_unindexed=True, min_island_voxels=minimum, split_pieces=split)
    made, report = clean(raw(labels, unindexed), options)
    empty, count = ndimage.label(made.labels <= 0)
    inner = np.zeros(made.labels.shape, bool)
    inner[1:-1, 1:-1, 1:-1] = True
    for piece in range(1, count + 1):
        ids = np.unique(made.labels[empty == piece])
        assert len(ids) == 1
        assert (ids[0] < 0) == inner[empty == piece].all()
    sizes = [n for k in np.unique(made.labels) for n in component_sizes(made.labels == k)]
    assert min(sizes) >= minimum or len(sizes) == 1
    if split:
        assert all(components(made.labels, k) == 1 for k in np.unique(made.labels) if k > 0)
    assert report["grains"] == len(np.unique(made.labels[made.labels > 0]))
    again, second = clean(made, CleanOptions(min_island_voxels=minimum))
    np.testing.assert_array_equal(again.labels, made.labels)
    assert second["absorbed_pieces"] == 0


def component_sizes(mask) -> list[int]:
    return np.bincount(ndimage.label(mask)[0].ravel())[1:].tolist()


def test_al1050_becomes_meshable(shared_data):
    path = shared_data / "al1050/al1050_labdct_109x103x64.npz"
    with pytest.raises(CraftmeshError, match="542 voxels"):
        clean(read_voxels(path))
    made, report = clean(read_voxels(path), CleanOptions(fill_unindexed=True, min_island_voxels=8))
    assert report["filled_voxels"] == 542
    assert report["grains_in_pieces_before"] == 48
    assert made.labels.min() >= 1
    assert report["smallest_grains"][0][1] >= 8
    before = read_voxels(path, ReadOptions()).voxels.labels
    assert (made.labels != before).sum() <= 542 + report["absorbed_voxels"]
