"""The optimiser raises quality, keeps boundary, crack facets and volume, and never inverts a tet."""

import numpy as np
import pytest
from hypothesis import assume, event, given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from craftmesh.mesh.shape_measures import (
    LARGEST_DIHEDRAL,
    LEAST_DIHEDRAL,
    LEAST_SHAPE_FACTOR,
    shape_measures,
)
from craftmesh.mesh.tet_connectivity import group_triples, half_faces, tet_volumes
from craftmesh.tetrahedra.kernels.tet_cavity import TETS, link_tets, new_scratch
from craftmesh.tetrahedra.kernels.tet_objective import (
    GAIN,
    RATIOS,
    WORST,
    Aim,
)
from craftmesh.tetrahedra.kernels.tet_operations import (
    LONGEST,
    contract,
    insert_on_edge,
    remove_edge,
    remove_face,
)
from craftmesh.tetrahedra.kernels.tet_passes import CONTRACTIONS, contraction_pass, swap_pass
from craftmesh.tetrahedra.kernels.tet_quality import (
    ANGLE_QUALITY,
    COMBINED_QUALITY,
    FACTOR_SCALE,
    POOR,
    SHAPE_QUALITY,
    VOLUME_LENGTH,
    all_qualities,
    aspect_ratio_at,
    quality_of,
)
from craftmesh.tetrahedra.optimise_tets import optimise_tets
from craftmesh.tetrahedra.tet_state import mesh_of, new_state

# A change of topology for the sum of aspect ratios has to lower it by this much.
FALL = 0.05


def plain_measures(corners):
    """Reference on one tet: volume-length measure, dihedral angles in degrees, aspect ratio."""
    volume = np.dot(np.cross(corners[1] - corners[0], corners[2] - corners[0]), corners[3] - corners[0]) / 6
    pairs = [(i, j) for i in range(4) for j in range(i)]
    lengths = [np.linalg.norm(corners[i] - corners[j]) for i, j in pairs]
    angles = []
    for i, j in pairs:
        along = (corners[j] - corners[i]) / np.linalg.norm(corners[j] - corners[i])
        arms = [corners[k] - corners[i] for k in range(4) if k not in (i, j)]
        p, q = (arm - np.dot(arm, along) * along for arm in arms)
        angles.append(np.degrees(np.arccos(np.dot(p, q) / (np.linalg.norm(p) * np.linalg.norm(q)))))
    heights = []
    for k in range(4):
        a, b, c = (corners[i] for i in range(4) if i != k)
        heights.append(6 * abs(volume) / np.linalg.norm(np.cross(b - a, c - a)))
    mean_square = np.mean(np.square(lengths))
    return 6 * np.sqrt(2) * volume / mean_square**1.5, np.array(angles), max(lengths) / min(heights)


def shape_factor(corners):
    return shape_measures(corners, np.array([[0, 1, 2, 3]]))[0, 4]


@settings(max_examples=60)
@given(st.integers(0, 10**6), st.floats(0.05, 1.0))
def test_kernels_agree_with_plain_measures(seed, flatness):
    corners = random_tet(seed, flatness)
    volume_length, angles, ratio = plain_measures(corners)
    assume(volume_length >= 1e-4)
    sines = np.sin(np.radians(angles)) * np.where(angles < 90, 1, 0.5)
    assert quality_of(corners, 0, 1, 2, 3, VOLUME_LENGTH) == pytest.approx(volume_length, rel=1e-9)
    form = min(*sines, FACTOR_SCALE * shape_factor(corners))
    assert quality_of(corners, 0, 1, 2, 3, SHAPE_QUALITY) == pytest.approx(form, rel=1e-6)
    assert quality_of(corners, 0, 1, 2, 3, ANGLE_QUALITY) == pytest.approx(
        min(*sines, 0.87 / ratio), rel=1e-6
    )
    assume(abs(form - POOR) > 1e-6)
    whole = form if form < POOR else POOR + min(form, 0.87 / ratio)
    assert quality_of(corners, 0, 1, 2, 3, COMBINED_QUALITY) == pytest.approx(whole, rel=1e-6)
    assert aspect_ratio_at(corners, 0, 1, 2, *corners[3]) == pytest.approx(ratio, rel=1e-9)
    assert quality_of(corners, 0, 2, 1, 3, ANGLE_QUALITY) < 0


def random_tet(seed, flatness):
    """Four corners with a positive volume."""
    corners = np.random.default_rng(seed).random((4, 3)) * [1, 1, flatness]
    volume = tet_volumes(corners, np.array([[0, 1, 2, 3]]))[0]
    return corners[[0, 2, 1, 3]] if volume < 0 else corners


@settings(max_examples=200)
@given(st.integers(0, 10**6), st.floats(0.05, 0.6))
def test_no_tet_is_poor_at_a_quality_of_poor(seed, flatness):
    corners = random_tet(seed, flatness)
    form, whole = (
        quality_of(corners, 0, 1, 2, 3, measure) for measure in (SHAPE_QUALITY, COMBINED_QUALITY)
    )
    assert (form < POOR) == (whole < POOR)
    if form < POOR:
        return
    _, angles, ratio = plain_measures(corners)
    assert LEAST_DIHEDRAL < angles.min() and angles.max() < LARGEST_DIHEDRAL
    assert shape_factor(corners) >= LEAST_SHAPE_FACTOR
    if quality_of(corners, 0, 1, 2, 3, ANGLE_QUALITY) >= POOR:
        assert ratio < 5 + 1e-6 and whole >= 2 * POOR - 1e-9
    elif whole >= 2 * POOR:
        assert ratio < 5 + 1e-6


def random_ball(seed, count=60):
    """Delaunay tets of random points in a ball, then stretched; the first `count` are near its surface.

    Stretching leaves tets that swaps improve; in a Delaunay mesh no face removal does.
    """
    rng = np.random.default_rng(seed)
    shell = rng.normal(size=(count, 3))
    shell *= rng.uniform(0.9, 1, (count, 1)) / np.linalg.norm(shell, axis=1, keepdims=True)
    inner = rng.uniform(-0.4, 0.4, (count, 3)) * [1, 1, 0.5] + [0, 0, 0.2]
    points = np.concatenate([shell, inner])
    tets = Delaunay(points).simplices.astype(np.int64)
    volume = tet_volumes(points, tets)
    tets[volume < 0] = tets[volume < 0][:, [0, 2, 1, 3]]
    return points * [1, 1, 3], tets, count


def faces_of(tets):
    """How often each face is there, as a dictionary of sets of corners."""
    count = {}
    for face in half_faces(tets).tolist():
        count[frozenset(face)] = count.get(frozenset(face), 0) + 1
    return count


def boundary(tets):
    return {face for face, times in faces_of(tets).items() if times == 1}


def quality(points, tets, measure=ANGLE_QUALITY):
    result = np.empty(len(tets))
    all_qualities(points, tets, len(tets), result, measure)
    return result


def aspect_ratios(points, tets):
    return np.array([aspect_ratio_at(points, a, b, c, *points[d]) for a, b, c, d in tets])


@settings(max_examples=3)
@given(st.integers(0, 10**6))
def test_a_random_mesh_gets_better_and_stays_a_mesh(seed):
    points, tets, frozen = random_ball(seed)
    assume(tet_volumes(points, tets).min() > 1e-8)
    new, better, report = optimise_tets(points, tets, frozen, np.zeros((0, 3)), np.full(len(points), 0.35))
    assert new[:frozen].tobytes() == points[:frozen].tobytes()
    assert boundary(better) == boundary(tets)
    assert max(faces_of(better).values()) == 2
    volume = tet_volumes(new, better)
    assert (volume > 0).all()
    # sums of some 500 volumes
    assert volume.sum() == pytest.approx(tet_volumes(points, tets).sum(), rel=1e-12)
    # a step keeps the worst tet by its own measure; of 100 meshes of twice the points, 2 lost by two of
    # them and none by all
    gains = [
        quality(new, better, measure).min() / quality(points, tets, measure).min()
        for measure in (ANGLE_QUALITY, VOLUME_LENGTH, SHAPE_QUALITY)
    ]
    assert max(gains) > 1 - 1e-9
    assert (quality(new, better) < POOR).mean() < (quality(points, tets) < POOR).mean()
    assert aspect_ratios(new, better).mean() < aspect_ratios(points, tets).mean()
    assert report["moves"] > 0 and report["edges_removed"] > 0


def test_blocked_facets_stay_and_are_in_no_cavity():
    points, tets, frozen = random_ball(seed=3)
    inner = [face for face, times in sorted(faces_of(tets).items(), key=str) if times == 2]
    blocked = np.array([sorted(face) for face in inner if max(face) < frozen])
    assert len(blocked) > 20
    size = np.full(len(points), 0.35)
    new, better, _ = optimise_tets(points, tets, frozen, blocked, size)
    faces = faces_of(better)
    assert all(faces[frozenset(facet)] == 2 for facet in blocked.tolist())
    assert boundary(better) == boundary(tets)
    assert quality(new, better).min() >= quality(points, tets).min()
    # left free, some are swapped away: the check above can fail
    free = faces_of(optimise_tets(points, tets, frozen, np.zeros((0, 3)), size)[1])
    assert any(free.get(frozenset(facet), 0) != 2 for facet in blocked.tolist())


def adjacency_by_groups(tets):
    """Reference: the neighbour across the face opposite each corner, by sorting."""
    faces = tets[:, [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]]].reshape(-1, 3)
    pairs = group_triples(faces).pairs
    result = np.full(len(faces), -1)
    result[pairs[:, 0]], result[pairs[:, 1]] = pairs[:, 1] // 4, pairs[:, 0] // 4
    return result.reshape(-1, 4)


def try_all(operation, seed, measure=VOLUME_LENGTH):
    """Apply an operation to all tets of a random mesh; return state and number of successes."""
    points, tets, frozen = random_ball(seed)
    state = new_state(points, tets, frozen, np.zeros((0, 3)), np.full(len(points), 0.35))
    all_qualities(state.points, state.tets, len(tets), state.quality, measure)
    work, done = new_scratch(), 0
    for t in range(len(tets)):
        for k in range(6):
            if state.tets[t, 0] >= 0:
                done += operation(state, t, k, work)
    return state, done, tet_volumes(points, tets).sum(), frozen


RAISE = Aim(WORST, VOLUME_LENGTH, 1.0, GAIN, 0.0)


def for_ratios(floor, reference, fall=FALL):
    """The aim of a change that is to lower the sum of aspect ratios less a reference."""
    return Aim(RATIOS, VOLUME_LENGTH, floor, fall, reference)


def contract_corner(state, t, k, work):
    state.size[:] = 10.0  # no edge is too long
    v = state.tets[t, k % 4]
    return not state.frozen[v] and contract(state, v, RAISE, work)


@pytest.mark.parametrize(
    "operation",
    [
        lambda state, t, k, work: remove_edge(state, t, k, RAISE, work),
        lambda state, t, k, work: k < 4 and remove_face(state, t, k, RAISE, work),
        lambda state, t, k, work: remove_edge(state, t, k, for_ratios(0.35, 2.0), work),
        lambda state, t, k, work: insert_on_edge(state, t, k, RAISE, work) >= 0,
        contract_corner,
    ],
    ids=["edge removal", "face removal", "edge for aspect", "insertion", "contraction"],
)
def test_each_operation_happens_and_keeps_the_mesh(operation):
    state, done, volume, frozen = try_all(operation, seed=5)
    assert done > 3
    assert_is_mesh(state, frozen, volume, VOLUME_LENGTH)


def assert_is_mesh(state, frozen, volume, measure):
    count = state.counts[TETS]
    alive = state.tets[:count, 0] >= 0
    new = np.cumsum(alive) - 1
    links = np.where(state.neighbours[:count] >= 0, new[state.neighbours[:count]], -1)[alive]
    tets = state.tets[:count][alive]
    assert (links == adjacency_by_groups(tets)).all()
    fresh = np.empty_like(tets)
    link_tets(tets, len(tets), state.counts[0], fresh, np.empty(state.counts[0], np.int64))
    assert (fresh == links).all()
    assert quality(state.points, tets, measure) == pytest.approx(state.quality[:count][alive])
    points, tets = mesh_of(state, frozen)
    assert tet_volumes(points, tets).sum() == pytest.approx(volume, rel=1e-12)


def test_three_tets_round_an_edge_become_two_and_back():
    angle = np.radians([90, 210, 330])
    ring = np.stack([np.cos(angle), np.sin(angle), np.zeros(3)], axis=1)
    points = np.concatenate([[[0, 0, -0.3], [0, 0, 0.3]], ring])
    two = np.array([[2, 3, 4, 1], [0, 2, 3, 4]])
    three = np.array([[0, 1, 2, 3], [0, 1, 3, 4], [0, 1, 4, 2]])
    assert (tet_volumes(points, two) > 0).all() and (tet_volumes(points, three) > 0).all()
    for tall, before, after in ((False, two, 3), (True, three, 2)):
        scaled = points * [1, 1, 6 if tall else 1]
        state = new_state(scaled, before, 5, np.zeros((0, 3)), np.ones(5))
        all_qualities(state.points, state.tets, len(before), state.quality, VOLUME_LENGTH)
        work = new_scratch()
        edge_done = any(remove_edge(state, 0, e, RAISE, work) for e in range(6))
        done = edge_done or any(remove_face(state, 0, k, RAISE, work) for k in range(4))
        assert done and len(mesh_of(state, 5)[1]) == after


def swapped_for_aspect(seed, blocked, fall=FALL):
    """A random mesh before and after swaps at all its tets, by state and number of swaps."""
    points, tets, frozen = random_ball(seed)
    state = new_state(points, tets, frozen, blocked, np.full(len(points), 0.35))
    all_qualities(state.points, state.tets, len(tets), state.quality, VOLUME_LENGTH)
    mean, work = aspect_ratios(points, tets).mean(), new_scratch()
    swap_pass(state, for_ratios(0.35, mean, fall), np.arange(len(tets)), work)
    return points, tets, frozen, state, work.done.sum(), mean


@settings(max_examples=8)
@given(st.integers(0, 10**6))
def test_swaps_for_aspect_lower_the_mean_and_keep_the_worst_the_surface_and_the_volume(seed):
    points, tets, frozen, state, swaps, mean = swapped_for_aspect(seed, np.zeros((0, 3)))
    assume(tet_volumes(points, tets).min() > 1e-8)
    new, better = mesh_of(state, frozen)
    assert swaps > 3
    # each swap lowers the sum of aspect ratio - mean by so much
    excess = (aspect_ratios(new, better) - mean).sum()
    assert excess <= -FALL * swaps + 1e-6 * aspect_ratios(points, tets).sum()
    assert aspect_ratios(new, better).mean() < mean
    assert quality(new, better, VOLUME_LENGTH).min() >= quality(points, tets, VOLUME_LENGTH).min()
    assert new.tobytes() == points.tobytes()
    assert boundary(better) == boundary(tets) and max(faces_of(better).values()) == 2
    assert tet_volumes(new, better).min() > 0
    assert tet_volumes(new, better).sum() == pytest.approx(tet_volumes(points, tets).sum(), rel=1e-12)
    assert better.tobytes() == mesh_of(swapped_for_aspect(seed, np.zeros((0, 3)))[3], frozen)[1].tobytes()


@settings(max_examples=8)
@given(st.integers(0, 10**6))
def test_swaps_that_may_raise_the_sum_raise_it_by_no_more_and_keep_the_worst(seed):
    points, tets, frozen, state, swaps, mean = swapped_for_aspect(seed, np.zeros((0, 3)), -0.5)
    assume(tet_volumes(points, tets).min() > 1e-8)
    new, better = mesh_of(state, frozen)
    before, after = (aspect_ratios(*mesh) - mean for mesh in ((points, tets), (new, better)))
    assert swaps > 3 and after.sum() - before.sum() <= 0.5 * swaps
    assert quality(new, better, VOLUME_LENGTH).min() >= quality(points, tets, VOLUME_LENGTH).min()
    assert boundary(better) == boundary(tets) and tet_volumes(new, better).min() > 0


def test_swaps_for_aspect_leave_blocked_facets():
    _, tets, frozen, state, _, _ = swapped_for_aspect(3, np.zeros((0, 3)))
    gone = set(faces_of(tets)) - set(faces_of(mesh_of(state, frozen)[1]))
    assert len(gone) > 20
    blocked = np.array(sorted(sorted(face) for face in gone))
    kept = faces_of(mesh_of(swapped_for_aspect(3, blocked)[3], frozen)[1])
    assert all(kept[face] == 2 for face in gone)


def crowded_ball(seed):
    """A random mesh with more points inside than it has room for, and its state for contractions."""
    points, tets, frozen = random_ball(seed)
    state = new_state(points, tets, frozen, np.zeros((0, 3)), np.full(len(points), 0.7))
    all_qualities(state.points, state.tets, len(tets), state.quality, VOLUME_LENGTH)
    return points, tets, frozen, state


def plain_contraction(points, tets, v, floor, reference, reach):
    """Plain reference: the least excess after a contraction of v, and the excess before."""
    star = tets[(tets == v).any(axis=1)]
    excess, floor = [], min(floor, quality(points, star, VOLUME_LENGTH).min())
    for w in np.setdiff1d(star, v):
        new = np.where(star == v, w, star)[(star != w).all(axis=1)]
        others = np.setdiff1d(new, w)
        if np.linalg.norm(points[others] - points[w], axis=1).max() > reach:
            continue
        if quality(points, new, VOLUME_LENGTH).min() > floor:
            excess.append((aspect_ratios(points, new) - reference).sum())
    return min(excess, default=np.inf), (aspect_ratios(points, star) - reference).sum()


@settings(max_examples=8)
@given(st.integers(0, 10**6))
def test_a_contraction_for_aspect_is_the_best_of_all_and_lowers_the_sum(seed):
    points, tets, frozen, _ = crowded_ball(seed)
    assume(tet_volumes(points, tets).min() > 1e-8)
    reference, floor, done = aspect_ratios(points, tets).mean(), 0.1, 0
    for v in range(frozen, len(points)):
        state = crowded_ball(seed)[3]
        best, before = plain_contraction(points, tets, v, floor, reference, LONGEST * 0.7)
        contracted = contract(state, v, for_ratios(floor, reference), new_scratch())
        assert contracted == (best < before - FALL)
        if contracted:
            new, better = mesh_of(state, frozen)
            after = (aspect_ratios(new, better) - reference).sum()
            assert after == pytest.approx((aspect_ratios(points, tets) - reference).sum() + best - before)
            assert boundary(better) == boundary(tets) and len(new) == len(points) - 1
            done += 1
    event(f"{min(done, 3)} contractions or more")


def test_contractions_for_aspect_leave_the_surface_and_are_counted():
    points, tets, frozen, state = crowded_ball(1)
    work, mean = new_scratch(), aspect_ratios(points, tets).mean()
    contraction_pass(state, for_ratios(0.0, mean), np.arange(len(points)), work)
    new, better = mesh_of(state, frozen)
    assert 0 < work.done[CONTRACTIONS] == len(points) - len(new)
    assert aspect_ratios(new, better).mean() < mean
    assert boundary(better) == boundary(tets) and tet_volumes(new, better).min() > 0
    assert new[:frozen].tobytes() == points[:frozen].tobytes()


def fans(ring):
    """Plain reference: all triangulations of a polygon, as lists of triangles."""
    if len(ring) < 3:
        yield []
        return
    for j in range(1, len(ring) - 1):
        for left in fans(ring[: j + 1]):
            for right in fans(ring[j:]):
                yield [(ring[0], ring[j], ring[-1]), *left, *right]


@settings(max_examples=20)
@given(st.integers(0, 10**6), st.integers(3, 7), st.sampled_from([FALL, -0.5, -2.0]))
def test_edge_removal_for_aspect_finds_the_best_of_all_triangulations(seed, count, fall):
    rng = np.random.default_rng(seed)
    angle = 2 * np.pi * (np.arange(count) + rng.uniform(-0.2, 0.2, count)) / count
    ring = np.stack([np.cos(angle), np.sin(angle), rng.uniform(-0.2, 0.2, count)], axis=1)
    points = np.concatenate([[[0, 0, -0.8], [0, 0, 0.8]], ring])
    nodes = list(range(2, count + 2))
    tets = np.array([[0, 1, nodes[i - 1], nodes[i]] for i in range(count)])
    assume(tet_volumes(points, tets).min() > 0)
    state = new_state(points, tets, len(points), np.zeros((0, 3)), np.ones(len(points)))
    all_qualities(state.points, state.tets, count, state.quality, VOLUME_LENGTH)
    before, best, reference, floor = (aspect_ratios(points, tets) - 1.8).sum(), np.inf, 1.8, 0.2
    limit = min(quality(points, tets, VOLUME_LENGTH).min(), floor)
    for triangles in fans(nodes):
        new = np.array([tet for i, j, k in triangles for tet in ((0, i, j, k), (i, j, k, 1))])
        if quality(points, new, VOLUME_LENGTH).min() > limit:
            best = min(best, (aspect_ratios(points, new) - reference).sum())
    done = remove_edge(state, 0, 0, for_ratios(floor, reference, fall), new_scratch())
    assert done == (best <= before - fall)
    if done:
        result = mesh_of(state, len(points))[1]
        assert (aspect_ratios(points, result) - reference).sum() == pytest.approx(best, rel=1e-9, abs=1e-9)


def test_an_edge_without_a_sound_triangulation_round_it_stays_however_poor_the_tets_count():
    angle = 2 * np.pi * np.arange(5) / 5
    ring = np.stack([np.cos(angle), np.sin(angle), np.zeros(5)], axis=1)
    points = np.concatenate([[[0, 0, -0.5], [0, 0, 0.5]], ring])
    tets = np.array([[0, 1, 2 + (i - 1) % 5, 2 + i] for i in range(5)])
    state = new_state(points, tets, len(points), np.zeros((0, 3)), np.ones(len(points)))
    all_qualities(state.points, state.tets, 5, state.quality, VOLUME_LENGTH)
    before = state.tets.tobytes()
    # five regular tets are better than any others; so low a reference counts them as flat
    aim = for_ratios(1.0, -1e300)
    assert not remove_edge(state, 0, 0, aim, new_scratch())
    assert state.tets.tobytes() == before
