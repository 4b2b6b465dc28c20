"""A crack opened in any mesh: nodes come apart on it and stay single on its front, as its sets say."""

import meshio
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from plain_opening import slow_opening
from structured_box import hexagon, plane_crack, structured_box

import craftmesh
from craftmesh import open_crack
from craftmesh.assembly.assemble import assemble
from craftmesh.errors import CraftmeshError
from craftmesh.mesh.check_tets import check_tets
from craftmesh.mesh.front_frames import front_frames
from craftmesh.mesh.mesh_sets import lip_faces
from craftmesh.mesh.second_order import raise_order
from craftmesh.mesh.tet_connectivity import face_nodes, half_faces, tet_volumes
from craftmesh.types import TetMesh


def one_grain(centres):
    return np.ones(len(centres), int)


def two_grains(centres):
    return np.where(centres[:, 0] < 2, 3, 7)


def box(shape, label_of=one_grain):
    return assemble(*structured_box(shape, label_of))[0]


def facets_in(mesh, axis, at, inside):
    """Return the faces in a plane whose centres satisfy `inside`, once each, normals along +axis."""
    faces = half_faces(mesh.tets[:, :4])
    corners = mesh.points[faces]
    faces = faces[(corners[:, :, axis] == at).all(axis=1) & inside(corners.mean(axis=1))]
    _, first = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    faces = faces[first]
    a, b, c = (mesh.points[faces[:, i]] for i in range(3))
    turned = np.cross(b - a, c - a)[:, axis] < 0
    return np.where(turned[:, None], faces[:, ::-1], faces)


def places(mesh, nodes):
    """Return where nodes (k,) are, or the corners of faces (k, 3), whatever their order."""
    found = mesh.points[nodes].tolist()
    return (
        sorted(tuple(sorted(map(tuple, face))) for face in found)
        if nodes.ndim > 1
        else sorted(map(tuple, found))
    )


def same_sets(one, other):
    """Tell whether two meshes have the same sets at the same places, fronts in the same order."""
    for name in one.node_sets.keys() | other.node_sets.keys():
        a, b = (mesh.points[mesh.node_sets[name]] for mesh in (one, other))
        if "FRONT" not in name:
            a, b = (points[np.lexsort(points.T)] for points in (a, b))
        if not np.array_equal(a, b):
            return False
    names = one.face_sets.keys() | other.face_sets.keys()
    return all(
        places(one, face_nodes(one.tets, one.face_sets[n]))
        == places(other, face_nodes(other.tets, other.face_sets[n]))
        for n in names
    )


MADE = {
    "penny": (2, 2, hexagon((3, 3), 2)),
    "edge": (2, 2, lambda c: c[:, 0] < 2),
    "through a boundary": (2, 2, lambda c: (c[:, 0] > 1) & (c[:, 1] < 4)),
    "in a boundary": (0, 2, lambda c: c[:, 1] < 2),
    "severed": (2, 2, lambda c: c[:, 0] < 100),
}


@pytest.mark.parametrize("name", MADE)
def test_a_mesh_opened_afterwards_is_the_mesh_that_was_assembled_with_its_crack(name):
    axis, at, inside = MADE[name]
    wanted, numbers = assemble(*structured_box((6, 6, 4), two_grains, plane_crack(axis, at, inside)))
    closed = box((6, 6, 4), two_grains)
    found, report = open_crack(closed, facets_in(closed, axis, at, inside))
    assert check_tets(found) == []
    assert places(found, found.tets.ravel()) == places(wanted, wanted.tets.ravel())
    assert same_sets(found, wanted)
    assert report["crack_area"] == pytest.approx(numbers["crack_area"])
    assert all(report[key] == numbers[key] for key in report.keys() & numbers.keys() - {"crack_area"})
    assert np.array_equal(found.points[: len(closed.points)], closed.points)


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1))
@example(18)  # the only front ends on another branch
@example(4444)  # a front touches another branch between its ends
def test_nodes_of_any_crack_come_apart_as_a_slow_reference_says(seed):
    """Rectangles in random planes: they cross, branch, touch the boundary, each other, or lie apart."""
    random, mesh = np.random.default_rng(seed), box((4, 3, 3), two_grains)
    parts = []
    for _ in range(random.integers(1, 5)):
        axis = int(random.integers(3))
        at = random.integers(1, (4, 3, 3)[axis])
        low = random.integers(0, 3, 3)
        high = low + random.integers(1, 4, 3)
        across = [k for k in range(3) if k != axis]
        parts.append(
            facets_in(
                mesh, axis, at,
                lambda c, a=across, low=low, high=high: ((c[:, a] > low[a]) & (c[:, a] < high[a])).all(1),
            )
        )  # fmt: skip
    facets = np.concatenate(parts)
    if not len(facets):
        return
    for raised in (mesh, raise_order(mesh)):
        faces = {frozenset(face) for face in facets.tolist()}
        if slow_opening(mesh.tets, faces) == len(mesh.points):
            with pytest.raises(CraftmeshError, match="none of the .* opens"):
                open_crack(raised, facets)
            continue
        opened, report = open_crack(raised, random.permutation(facets))
        turned = np.array([random.permutation(face) for face in random.permutation(facets)])
        again, numbers = open_crack(raised, np.concatenate([turned, turned[:3]]))
        assert np.array_equal(again.tets, opened.tets) and same_sets(again, opened) and numbers == report
        assert np.array_equal(opened.points[opened.tets], raised.points[raised.tets])
        shut = report["crack_facets_not_opened"]
        corners = len(np.unique(opened.tets[:, :4]))
        assert corners == slow_opening(mesh.tets, faces)
        assert report["crack_facets"] == len(faces)
        a, b = (face_nodes(opened.tets, lip) for lip in lip_faces(opened.face_sets))
        assert len(a) == len(b) == len(faces) - shut and places(opened, a) == places(opened, b)
        assert check_tets(opened) == []


@pytest.mark.parametrize("name", MADE)
def test_mid_nodes_open_as_in_a_mesh_that_gets_them_afterwards(name):
    mesh = box((6, 6, 4), two_grains)
    facets = facets_in(mesh, *MADE[name])
    first, _ = open_crack(raise_order(mesh), facets)
    last = raise_order(open_crack(mesh, facets)[0])
    assert check_tets(first) == [] and same_sets(first, last)
    assert len(first.points) == len(last.points)


def tee(mesh):
    """A crack at z = 2 through the box, and a branch up from it at x = 2 with its front at z = 4."""
    branch = facets_in(mesh, 0, 2, lambda c: (c[:, 2] > 2) & (c[:, 2] < 4))
    return np.concatenate([facets_in(mesh, 2, 2, lambda c: c[:, 0] < 3), branch])


def test_branches_come_apart_where_they_meet_and_keep_their_fronts():
    mesh = box((4, 3, 5))
    opened, report = open_crack(mesh, tee(mesh))
    assert report["cracks"] == 1 and report["fronts"] == 2 and check_tets(opened) == []
    junction = (mesh.points[:, 0] == 2) & (mesh.points[:, 2] == 2)
    copies = [(opened.points == place).all(axis=1).sum() for place in mesh.points[junction]]
    assert copies == [3] * 4
    fronts = [opened.points[opened.node_sets[f"CRACK_FRONT_{k}"]] for k in (1, 2)]
    assert [set(map(tuple, front[:, [0, 2]])) for front in fronts] == [{(2, 4)}, {(3, 2)}]
    assert all(np.array_equal(np.sort(front[:, 1]), np.arange(4)) for front in fronts)
    assert check_tets(raise_order(opened)) == []


def test_cracks_apart_are_numbered_in_the_order_of_their_facets_also_when_opened_one_by_one():
    mesh = box((6, 4, 4))
    left = facets_in(mesh, 2, 2, lambda c: c[:, 0] < 2)
    right = facets_in(mesh, 2, 1, lambda c: c[:, 0] > 4)
    both, report = open_crack(mesh, np.concatenate([right, left]))
    assert report["cracks"] == 2 and check_tets(both) == []
    assert "CRACK_LIP_A" not in both.face_sets and "CRACK_LIP_A" not in both.node_sets
    assert set(both.points[both.node_sets["CRACK_1_FRONT"]][:, 0]) == {4.0}
    assert set(both.points[both.node_sets["CRACK_2_FRONT"]][:, 0]) == {2.0}
    assert len(both.node_sets["CRACK_FRONT"]) == 10
    one, _ = open_crack(mesh, right)
    assert "CRACK_LIP_A" in one.face_sets
    again, _ = open_crack(one, left)
    assert same_sets(again, both) and len(front_frames(again).s) == 10


def test_sets_keep_the_nodes_that_come_apart_and_a_named_set_can_be_opened():
    mesh = box((4, 3, 4))
    groups = half_faces(mesh.tets)
    rows = np.flatnonzero(
        (mesh.points[groups][:, :, 2] == 2).all(axis=1)
        & (mesh.points[mesh.tets].mean(axis=1)[:, 2] > 2).repeat(4)
    )
    named = TetMesh(
        mesh.points, mesh.tets, mesh.grain,
        dict(mesh.node_sets) | {"MINE": np.flatnonzero(mesh.points[:, 2] == 2)},
        dict(mesh.face_sets) | {"MIDDLE": np.stack([rows // 4, rows % 4], axis=1)},
    )  # fmt: skip
    opened, report = open_crack(named, "MIDDLE")
    assert report["fronts"] == 0 and "MIDDLE" not in opened.face_sets
    assert len(opened.node_sets["MINE"]) == 2 * len(named.node_sets["MINE"]) == 2 * 5 * 4
    assert set(opened.points[opened.node_sets["MINE"]][:, 2]) == {2.0}
    centres = opened.points[opened.tets].mean(axis=1)
    assert (centres[opened.face_sets["CRACK_LIP_A"][:, 0], 2] > 2).all()


def foreign(mesh, facets, flip=0, raised=False):
    """Return a meshio mesh with two blocks of tetrahedra, the crack and the top as named triangles."""
    source = raise_order(mesh) if raised else mesh
    tets = source.tets.copy()
    if flip:
        order = [1, 0, 2, 3, 4, 6, 5, 8, 7, 9][: tets.shape[1]]
        tets[::flip] = tets[::flip][:, order]
    half = len(tets) // 2
    top = source.outward_triangles("ZMAX")
    line = np.array([[a, b] for a, b in zip(facets[:1, 0], facets[:1, 1])])
    kinds = ("tetra10", "triangle6") if raised else ("tetra", "triangle")
    cells = [
        (kinds[0], tets[:half]),
        ("line", line),
        ("triangle", facets),
        (kinds[1], top),
        (kinds[0], tets[half:]),
    ]
    data = {"gmsh:physical": [np.full(len(c), k, np.int32) for k, (_, c) in enumerate(cells, 1)]}
    data["gmsh:geometrical"] = data["gmsh:physical"]
    data["weight"] = [np.arange(len(c), dtype=float) for _, c in cells]
    names = {"BREAK": np.array([3, 2]), "TOP": np.array([4, 2])}
    return meshio.Mesh(source.points, cells, {"x": source.points[:, 0]}, data, names)


@pytest.mark.parametrize(("flip", "raised"), [(0, False), (3, False), (1, True)])
def test_a_mesh_of_meshio_opens_as_ours_does(flip, raised):
    mesh = box((6, 6, 4), two_grains)
    facets = facets_in(mesh, 2, 2, lambda c: c[:, 0] < 3)
    given_mesh = foreign(mesh, facets, flip, raised)
    found, report = open_crack(given_mesh, "BREAK")
    wanted, numbers = open_crack(raise_order(mesh) if raised else mesh, facets)
    assert report == pytest.approx(numbers) and np.array_equal(found.points, wanted.points)
    tets = np.concatenate([b.data for b in found.cells if b.type.startswith("tetra")])
    given_tets = np.concatenate([b.data for b in given_mesh.cells if b.type.startswith("tetra")])
    assert np.array_equal(found.points[tets], given_mesh.points[given_tets])
    assert np.array_equal(np.sort(tets, axis=1), np.sort(wanted.tets, axis=1))
    assert np.array_equal(found.point_sets["CRACK_FRONT"], wanted.node_sets["CRACK_FRONT"])
    blocks = {name: found.cells[-2 + k].data for k, name in enumerate(("CRACK_LIP_A", "CRACK_LIP_B"))}
    assert all(np.array_equal(data, wanted.outward_triangles(name)) for name, data in blocks.items())
    lip = wanted.node_sets["CRACK_LIP_A"]
    assert np.isin(found.cells[2].data, lip).all()  # the crack's own triangles are on lip A
    assert np.array_equal(found.point_data["x"], found.points[:, 0])
    assert [len(part) for part in found.cell_data["weight"]] == [len(block.data) for block in found.cells]


def test_a_mesh_of_gmsh_comes_back_from_its_file_with_named_lips(tmp_path):
    mesh = box((4, 4, 4))
    source = foreign(mesh, facets_in(mesh, 2, 2, lambda c: c[:, 0] < 2))
    del source.cell_data["weight"]  # meshio does not read back other data of several blocks of a kind
    opened, _ = open_crack(source, "BREAK")
    meshio.gmsh.write(tmp_path / "opened.msh", opened, "2.2", binary=True)
    again = meshio.read(tmp_path / "opened.msh")
    tag = int(again.field_data["CRACK_LIP_B"][0])
    found = [c.data[t == tag] for c, t in zip(again.cells, again.cell_data["gmsh:physical"])]
    assert sum(map(len, found)) == 2 * 2 * 4
    nodes = np.unique(np.concatenate([part.ravel() for part in found if part.size]))
    assert set(again.points[nodes][:, 2]) == {2.0}
    with pytest.raises(CraftmeshError, match="no set of triangles 'GONE'; its sets are .*BREAK"):
        open_crack(again, "GONE")


def test_what_is_no_crack_of_the_mesh_is_refused():
    mesh = box((3, 3, 3))
    facets = facets_in(mesh, 2, 1, lambda c: c[:, 0] < 2)
    with pytest.raises(CraftmeshError, match="2 of 13 facets are no faces of the mesh"):
        open_crack(mesh, np.concatenate([facets[:11], [[0, 1, 63], [0, 2, 63]]]))
    with pytest.raises(CraftmeshError, match="facets refers to nodes 0..64; there are 64 nodes"):
        open_crack(mesh, [[0, 1, 64]])
    with pytest.raises(CraftmeshError, match="facets has shape .2, 4.; expected .n, 3."):
        open_crack(mesh, np.zeros((2, 4), int))
    with pytest.raises(CraftmeshError, match="boundary, with a tetrahedron on one side"):
        open_crack(mesh, facets_in(mesh, 2, 0, lambda c: c[:, 0] < 2))
    with pytest.raises(CraftmeshError, match="no face set 'GONE'; it has XMIN"):
        open_crack(mesh, "GONE")
    turned = TetMesh(mesh.points, mesh.tets[:, [1, 0, 2, 3]], mesh.grain)
    assert (tet_volumes(turned.points, turned.tets) < 0).all()
    with pytest.raises(CraftmeshError, match="no positive volume"):
        open_crack(turned, facets)
    twice = TetMesh(mesh.points, np.concatenate([mesh.tets, mesh.tets[:1]]), np.ones(len(mesh.tets) + 1))
    with pytest.raises(CraftmeshError, match="more than two tetrahedra"):
        open_crack(twice, facets)
    hexahedra = meshio.Mesh(mesh.points, [("hexahedron", np.arange(8)[None])])
    with pytest.raises(CraftmeshError, match="the mesh has hexahedron; expected tetrahedra"):
        open_crack(hexahedra, facets)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_lips_a_of_flat_cracks_are_on_one_side_however_the_facets_are_turned(axis):
    mesh, random = box((4, 4, 4)), np.random.default_rng(axis)
    parts = [facets_in(mesh, axis, at, lambda c: c[:, (axis + 1) % 3] < 2) for at in (1, 3)]
    facets = np.array([random.permutation(face) for face in random.permutation(np.concatenate(parts))])
    for order in (facets, facets[:, ::-1]):
        opened, report = open_crack(mesh, order)
        assert report["cracks"] == 2 and check_tets(opened) == []
        for number, at in ((1, 1), (2, 3)):
            tets = opened.tets[opened.face_sets[f"CRACK_{number}_LIP_A"][:, 0]]
            assert (opened.points[tets].mean(axis=1)[:, axis] > at).all()


def test_a_closed_crack_has_lip_a_outside():
    mesh = box((4, 4, 4))
    inner = ((mesh.points[mesh.tets].mean(axis=1) > 1) & (mesh.points[mesh.tets].mean(axis=1) < 3)).all(
        axis=1
    )
    faces = np.sort(half_faces(mesh.tets[inner]), axis=1)
    facets = np.array(
        [face for face, count in zip(*np.unique(faces, axis=0, return_counts=True)) if count < 2]
    )
    opened, report = open_crack(mesh, facets)
    assert report["fronts"] == 0 and not inner[opened.face_sets["CRACK_LIP_A"][:, 0]].any()


def one_facet(mesh):
    return facets_in(mesh, 2, 1, lambda c: (c[:, :2] > 1).all(axis=1) & (c[:, :2] < 2).all(axis=1))[:1]


@pytest.mark.parametrize(
    ("said", "facets"),
    [
        ("none of the 1 crack facets", one_facet),
        ("facets is empty", lambda mesh: np.zeros((0, 3), int)),
        ("facets has shape .3,.", lambda mesh: one_facet(mesh)[0]),
        ("facets refers to nodes -1", lambda mesh: -one_facet(mesh) // 100),
        ("facets holds", lambda mesh: one_facet(mesh) + 0.5),
        ("facets is an array of bool", lambda mesh: one_facet(mesh) > 0),
    ],
)
@pytest.mark.parametrize("as_meshio", [False, True])
def test_facets_that_cannot_open_are_one_line_for_both_kinds_of_mesh(said, facets, as_meshio):
    mesh = box((3, 3, 3))
    given_mesh = meshio.Mesh(mesh.points, [("tetra", mesh.tets)]) if as_meshio else mesh
    with pytest.raises(CraftmeshError, match=said) as error:
        open_crack(given_mesh, facets(mesh))
    assert "\n" not in str(error.value)


def test_a_crack_opens_once_and_other_libraries_meshes_are_refused():
    mesh = box((3, 3, 3))
    facets = facets_in(mesh, 2, 1, lambda c: c[:, 0] < 2)
    for one in (mesh, meshio.Mesh(mesh.points, [("tetra", mesh.tets)])):
        with pytest.raises(
            CraftmeshError,
            match="only once|not opened before|opened before; open all cracks in one call",
        ):
            open_crack(open_crack(one, facets)[0], facets)
    with pytest.raises(CraftmeshError, match="mesh is a ndarray; expected a TetMesh or a meshio.Mesh"):
        open_crack(mesh.points, facets)


def test_the_library_exports_it():
    assert craftmesh.open_crack is open_crack
