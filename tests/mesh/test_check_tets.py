"""A sound mesh has no breach; each planted breach is named."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.mesh.check_tets import check_tets
from craftmesh.mesh.second_order import raise_order


def label_of(centres):
    labels = np.where(centres[:, 0] < 3, 4, 11)
    labels[(np.abs(centres - [1.5, 1.5, 0.5]) < 0.6).all(axis=1)] = -2
    labels[(centres[:, 0] > 5) & (centres[:, 2] > 3)] = 0
    return labels


def sound():
    crack = plane_crack(2, 2, hexagon((3, 3), 2))
    return assemble(*structured_box((6, 6, 4), label_of, crack))[0]


def moved(mesh, nodes, shift):
    points = mesh.points.copy()
    points[nodes] += shift
    return replace(mesh, points=points)


def with_nodes(mesh, name, nodes):
    return replace(mesh, node_sets=dict(mesh.node_sets) | {name: nodes})


def with_faces(mesh, name, faces):
    return replace(mesh, face_sets=dict(mesh.face_sets) | {name: faces})


def turned(mesh):
    tets = mesh.tets.copy()
    tets[7] = tets[7][[1, 0, 2, 3]]
    return replace(mesh, tets=tets)


def joined(mesh, count):
    """Join `count` nodes of lip A to their partners on lip B."""
    tets = mesh.tets
    for a in np.setdiff1d(mesh.node_sets["CRACK_LIP_A"], mesh.node_sets["CRACK_FRONT"])[:count]:
        twins = np.flatnonzero((mesh.points == mesh.points[a]).all(axis=1))
        tets = np.where(tets == twins[1], twins[0], tets)
    return replace(mesh, tets=tets)


def welded(mesh):
    return joined(mesh, 1)


def shut(mesh):
    return joined(mesh, None)


def torn(mesh, node, chosen):
    """Give the elements at a node that are chosen (k,) bool, in their order, a node of their own."""
    tets, at_node = mesh.tets.copy(), np.flatnonzero((mesh.tets == node).any(axis=1))
    rows = tets[at_node[chosen]]
    tets[at_node[chosen]] = np.where(rows == node, len(mesh.points), rows)
    return replace(mesh, points=np.concatenate([mesh.points, mesh.points[[node]]]), tets=tets)


def swapped_mids(mesh):
    tets = mesh.tets.copy()
    tets[:, [7, 9]] = tets[:, [9, 7]]
    return replace(mesh, tets=tets)


def split_mid(mesh):
    tets, node = mesh.tets.copy(), mesh.tets[3, 4]
    tets[3, 4] = len(mesh.points)
    return replace(mesh, points=np.concatenate([mesh.points, mesh.points[[node]]]), tets=tets)


def folded_mid(mesh):
    """Push the mid node of the first element's first edge past the middle of the opposite edge."""
    a, b, c, d = mesh.points[mesh.tets[0, :4]]
    return moved(mesh, mesh.tets[0, 4], 0.7 * (c + d - a - b))


def slipped_lip_mid(mesh):
    own = np.setdiff1d(mesh.node_sets["CRACK_LIP_A"], mesh.node_sets["CRACK_FRONT"])
    return moved(mesh, own[own >= mesh.tets[:, :4].max() + 1][0], [1e-9, 0, 0])


BREACHES = {
    "volume <= 0": turned,
    "grain id <= 0": lambda m: replace(m, grain=np.where(np.arange(len(m.grain)) == 5, 0, m.grain)),
    "1 nodes belong to no": lambda m: replace(m, points=np.concatenate([m.points, [[1.5, 1.5, 1.5]]])),
    "no tetrahedra": lambda m: replace(m, tets=m.tets[:0], grain=m.grain[:0], face_sets={}, node_sets={}),
    "more than two": lambda m: replace(m, tets=np.r_[m.tets, m.tets[:1]], grain=np.r_[m.grain, 4]),
    "2 free faces are in no": lambda m: with_faces(m, "XMIN", m.face_sets["XMIN"][2:]),
    "set EXTERIOR have a tetrahedron on both": lambda m: with_faces(
        m, "EXTERIOR", [[100, k] for k in range(4)]
    ),
    "more than once": lambda m: with_faces(m, "VOID_9", m.face_sets["YMAX"][:1]),
    "not on the plane x = 0.0": lambda m: moved(m, m.node_sets["XMIN"][4], [1e-12, 0, 0]),
    "Node set XMIN names": lambda m: with_nodes(m, "XMIN", [0, 10**6]),
    "Face set XMIN names": lambda m: with_faces(m, "XMIN", [[0, 4]]),
    "Node set YMIN does not": lambda m: with_nodes(m, "YMIN", m.node_sets["YMIN"][:-1]),
    "Node set XMIN_YMIN does not": lambda m: with_nodes(m, "XMIN_YMIN", []),
    "FRONT does not fit the face sets: its nodes are not in order": lambda m: with_nodes(
        m, "CRACK_FRONT", m.node_sets["CRACK_FRONT"][[1, 0, *range(2, 12)]]
    ),
    "lack a coincident": lambda m: moved(
        m, np.setdiff1d(m.node_sets["CRACK_LIP_A"], m.node_sets["CRACK_FRONT"])[0], [0, 0, 1e-9]
    ),
    "1 facets of the crack's lips stand in their lip twice": lambda m: with_faces(
        m, "CRACK_LIP_A", m.face_sets["CRACK_LIP_A"][[0, *range(len(m.face_sets["CRACK_LIP_A"]))]]
    ),
    "set CRACK_LIP_A have a tetrahedron on both": welded,
    "same three nodes on both lips": shut,
}


def test_sound_meshes_have_no_breach():
    assert check_tets(sound()) == [] and check_tets(raise_order(sound())) == []


@pytest.mark.parametrize("said", BREACHES)
def test_each_planted_breach_is_named(said):
    found = check_tets(BREACHES[said](sound()))
    assert any(said in breach for breach in found), found
    assert all("\n" not in breach and breach.endswith(".") for breach in found)


@settings(max_examples=40)
@given(st.data())
def test_a_front_node_that_comes_apart_in_any_way_is_a_breach(data):
    mesh = sound()
    node = data.draw(st.sampled_from(mesh.node_sets["CRACK_FRONT"].tolist()))
    count = int((mesh.tets == node).any(axis=1).sum())
    chosen = np.array(data.draw(st.lists(st.booleans(), min_size=count, max_size=count)))
    if chosen.any() and not chosen.all():
        assert any("free faces are in no" in breach for breach in check_tets(torn(mesh, node, chosen)))


@pytest.mark.parametrize(
    "said, plant",
    [
        ("not on their edges", swapped_mids),
        ("different mid nodes", split_mid),
        ("Jacobian <= 0 at an integration point (the first is tet 0 of grain", folded_mid),
        ("lack a coincident", slipped_lip_mid),
    ],
)
def test_mid_nodes_are_checked(said, plant):
    found = check_tets(plant(raise_order(sound())))
    assert any(said in breach for breach in found), found
