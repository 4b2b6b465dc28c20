"""Quarter points at the crack front, and the Jacobians that guard them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.errors import CraftmeshError
from craftmesh.mesh.check_tets import check_tets
from craftmesh.mesh.integration import smallest_jacobians
from craftmesh.mesh.quality import quality
from craftmesh.mesh.second_order import as_elements, move_to_quarter_points, raise_order
from craftmesh.mesh.tet_connectivity import EDGE_CORNERS, tet_volumes

SPACING = (0.3, 0.7, 1 / 3)
PENNY, AT_THE_FACE = hexagon((3, 3), 2), hexagon((0, 3), 2)


def cracked(inside=PENNY, origin=(0.1, -1 / 7, 2.3)):
    def label_of(centres):
        return np.where(centres[:, 0] < 3, 4, 11)

    box = structured_box((6, 6, 4), label_of, plane_crack(2, 2, inside), SPACING, origin)
    return raise_order(assemble(*box)[0])


def edges_by_mid(mesh):
    """Return {mid node: (end, end)}."""
    ends = mesh.tets[:, EDGE_CORNERS].reshape(-1, 2)
    return dict(zip(mesh.tets[:, 4:].ravel().tolist(), map(tuple, ends.tolist())))


def slow_jacobians(corners_and_mids):
    """Least determinant of one element, from shape functions differentiated by complex steps."""

    def place(one, two, three):
        l = (1 - one - two - three, one, two, three)
        shapes = [w * (2 * w - 1) for w in l]
        shapes += [4 * l[a] * l[b] for a, b in ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))]
        return sum(shape * node for shape, node in zip(shapes, corners_and_mids))

    found = []
    for near in range(4):
        at = [0.58541020 if corner == near else 0.13819660 for corner in range(4)][1:]
        columns = [
            place(*(w + (1e-20j if i == k else 0) for k, w in enumerate(at))).imag / 1e-20 for i in range(3)
        ]
        found.append(np.linalg.det(np.transpose(columns)))
    return min(found)


@settings(max_examples=50)
@given(st.integers(0, 10**6))
def test_jacobians_are_those_of_the_shape_functions(seed):
    element = np.random.default_rng(seed).normal(size=(10, 3))
    found = smallest_jacobians(element, np.arange(10)[None])[0]
    # Points to eight digits in the reference; sums of terms of some hundreds.
    assert found == pytest.approx(slow_jacobians(element), abs=1e-4, rel=1e-6)


def test_straight_elements_have_six_times_their_volume():
    mesh = cracked()
    expected = 6 * tet_volumes(mesh.points, mesh.tets)
    assert smallest_jacobians(mesh.points, mesh.tets) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("inside", [PENNY, AT_THE_FACE])
def test_mid_nodes_next_to_the_front_move_to_a_quarter_and_no_others(inside):
    mesh = cracked(inside)
    moved, report = move_to_quarter_points(mesh)
    front = set(mesh.node_sets["CRACK_FRONT"].tolist())
    changed = 0
    for mid, (a, b) in edges_by_mid(mesh).items():
        if len({a, b} & front) == 1:
            near, far = (a, b) if a in front else (b, a)
            expected = 0.75 * mesh.points[near] + 0.25 * mesh.points[far]
            assert np.allclose(moved.points[mid], expected, rtol=0, atol=1e-15)
            changed += 1
        else:
            assert (moved.points[mid] == mesh.points[mid]).all()
    corners = np.unique(mesh.tets[:, :4])
    assert (moved.points[corners] == mesh.points[corners]).all()
    assert report == {"quarter_points": changed, "quarter_points_refused": 0} and changed > 50


@pytest.mark.parametrize("inside", [PENNY, AT_THE_FACE])
def test_meshes_with_quarter_points_are_sound(inside):
    moved, _ = move_to_quarter_points(cracked(inside))
    assert check_tets(moved) == []  # exact box planes and coincident lips among others
    assert quality(moved)["jacobian_not_positive"] == 0


def test_moving_twice_is_moving_once():
    once, _ = move_to_quarter_points(cracked())
    assert (move_to_quarter_points(once)[0].points == once.points).all()


def bent(mesh):
    """Return `mesh` with one mid node moved so that it is sound, but would not be with quarter points.

    The element that would fold has an edge from the front along one lip only.
    """
    edges = edges_by_mid(mesh)
    front = set(mesh.node_sets["CRACK_FRONT"].tolist())
    lips = [set(mesh.node_sets[f"CRACK_LIP_{side}"].tolist()) for side in "AB"]
    movable = {mid for mid, ends in edges.items() if len(set(ends) & front) == 1}
    at_lip = movable & (lips[0] ^ lips[1])
    others = np.array(sorted(edges.keys() - movable - lips[0] - lips[1]))
    straight, _ = move_to_quarter_points(mesh)
    random = np.random.default_rng(1)
    for _ in range(5000):
        points, mid = mesh.points.copy(), random.choice(others)
        shift = random.normal(size=3) * 0.3 * SPACING
        points[mid] += shift
        naive = straight.points.copy()
        naive[mid] += shift
        folded = mesh.tets[smallest_jacobians(naive, mesh.tets) <= 0]
        if set(folded.ravel().tolist()) & at_lip and (smallest_jacobians(points, mesh.tets) > 0).all():
            return replace(mesh, points=points)
    raise AssertionError("no mid node found")


def test_quarter_points_that_fold_an_element_stay_in_the_middle_on_both_lips():
    mesh = bent(cracked())
    moved, report = move_to_quarter_points(mesh)
    assert (smallest_jacobians(moved.points, moved.tets) > 0).all()
    whole = move_to_quarter_points(cracked())[1]["quarter_points"]
    assert report["quarter_points_refused"] > 0
    assert report["quarter_points"] + report["quarter_points_refused"] == whole
    same = (moved.points == mesh.points).all(axis=1)
    front = set(mesh.node_sets["CRACK_FRONT"].tolist())
    kept = {mid for mid, ends in edges_by_mid(mesh).items() if same[mid] and len(set(ends) & front) == 1}
    assert len(kept) == report["quarter_points_refused"]
    a, b = (kept & set(mesh.node_sets[f"CRACK_LIP_{side}"].tolist()) for side in "AB")
    assert a and sorted(mesh.points[list(a)].tolist()) == sorted(mesh.points[list(b)].tolist())
    assert not [breach for breach in check_tets(moved) if "lips" in breach]


def test_what_has_no_mid_node_or_no_front():
    whole = assemble(*structured_box((2, 2, 2), lambda c: np.ones(len(c), int)))[0]
    mesh, report = as_elements(whole, "C3D10", quarter_points=True)
    assert (mesh.points == raise_order(whole).points).all()
    assert report["quarter_points"] == report["quarter_points_refused"] == 0
    with pytest.raises(CraftmeshError, match="quarter_points: C3D4 has no mid nodes"):
        as_elements(whole, "C3D4", quarter_points=True)
