"""Other programs' files: what meshio and VTK read from them is the mesh, with its grains and sets."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.io import netcdf_file
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.cli import main
from craftmesh.errors import CraftmeshError
from craftmesh.io.mesh_formats import read_exodus, write_msh
from craftmesh.io.npz import write_labels
from craftmesh.io.stage_npz import write_sizing
from craftmesh.io.vtk import read_tets, write_tets
from craftmesh.mechanics.orientation import normalized, quaternion_to_matrix
from craftmesh.mesh.check_tets import check_tets
from craftmesh.mesh.lips import lips_apart
from craftmesh.mesh.second_order import as_elements
from craftmesh.mesh.tet_connectivity import face_nodes, tet_volumes
from craftmesh.sizing.sizing import Sizing
from craftmesh.sizing.stored import arrays_of
from craftmesh.types import BOX_PLANES, Voxels

SUFFIXES = ("vtu", "msh", "e", "exo")
BLOCK = Voxels(np.full((2, 2, 2), 14, np.int32), np.ones(3), np.zeros(3))


def turns():
    """Quaternions of the grains 0 to 19."""
    return normalized(np.random.default_rng(3).normal(size=(20, 4)))


def label_of(centres):
    labels = np.where(centres[:, 0] < 3, 14, 11)  # the grain of the first elements has the higher id
    labels[(np.abs(centres - [1.5, 1.5, 0.5]) < 0.6).all(axis=1)] = -2
    labels[(centres[:, 0] > 5) & (centres[:, 2] > 3)] = 0
    return labels


def cracked_mesh():
    crack = plane_crack(2, 2, hexagon((3, 3), 2))
    return assemble(*structured_box((6, 6, 4), label_of, crack, (0.1, 1 / 3, 2e-5 / 3), (-0.7, 12, -1e-5)))[
        0
    ]


def edge_cracked():
    """A box sheared along z, and a crack from XMIN half through it, whose normal leans towards -x."""
    crack = plane_crack(2, 2, lambda centres: centres[:, 0] < 3)
    mesh = assemble(*structured_box((6, 6, 4), lambda centres: np.ones(len(centres), int), crack))[0]
    return replace(mesh, points=mesh.points + mesh.points[:, :1] * [0.0, 0.0, 0.25])


def exported(folder, suffix, element):
    """Return the file that the command writes and the mesh it should hold; C3D10 with quarter points."""
    write_tets(folder / "volume.vtu", cracked_mesh())
    target = folder / f"model.{suffix}"
    flags = ["--element", element, *(["--quarter-points"] if element == "C3D10" else [])]
    assert main(["export", str(folder / "volume.vtu"), "-o", str(target), *flags]) == 0
    return target, as_elements(cracked_mesh(), element, element == "C3D10")[0]


def read_with_meshio(path):
    meshio = pytest.importorskip("meshio")
    if path.suffix in (".e", ".exo"):
        pytest.importorskip("netCDF4")
    return meshio.read(path)


def triangles(mesh):
    """Return {name: nodes of the faces (k, 3 or 6)} of a TetMesh."""
    return {name: face_nodes(mesh.tets, faces) for name, faces in mesh.face_sets.items()}


def of_vtu(found):
    tets, faces = found.cells[0].data, found.cells[1].data
    grain, number = (found.cell_data[name] for name in ("grain", "face_set"))
    assert (grain[1] == 0).all() and (number[0] == 0).all()
    named = {
        kind: {n[len(kind) :]: v for n, v in found.field_data.items() if n.startswith(kind)}
        for kind in ("node_set:", "face_set:")
    }
    for name, nodes in named["node_set:"].items():
        assert (np.flatnonzero(found.point_data[name]) == np.unique(nodes)).all()
    face_sets = {name: faces[number[1] == k] for k, name in enumerate(named["face_set:"], 1)}
    return tets, grain[0], named["node_set:"], face_sets


def of_msh(found):
    names = {(dimension, tag): name for name, (tag, dimension) in found.field_data.items()}
    assert len({tag for _, tag in names}) == len(names)  # over all dimensions
    tags = found.cell_data["gmsh:physical"]
    groups = ({}, {}, {}, {})
    for block, own in zip(found.cells, tags):
        dimension = {"vertex": 0, "triangle": 2, "triangle6": 2, "tetra": 3, "tetra10": 3}[block.type]
        for tag in np.unique(own).tolist():
            groups[dimension][names.pop((dimension, tag))] = block.data[own == tag]
    assert not names
    nodes = {name.removesuffix("_NODES"): cells.ravel() for name, cells in groups[0].items()}
    for name, cells in groups[3].items():
        tag = int(name.removeprefix("GRAIN_"))
        assert (cells == found.cells[0].data[tags[0] == tag]).all()
    return found.cells[0].data, tags[0], nodes, groups[2]


def of_exodus(found, path):
    import netCDF4

    tets = np.concatenate([block.data for block in found.cells])
    grain = np.concatenate(found.cell_data["grain"])
    with netCDF4.Dataset(path) as file:
        file.set_auto_mask(False)
        names = [b"".join(row).decode() for row in file["ss_names"][:]]
        ids = [b"".join(row).decode() for row in file["eb_names"][:]]
        assert ids == [f"GRAIN_{g}" for g in file["eb_prop1"][:]] == ["GRAIN_11", "GRAIN_14"]
        assert [set(b) for b in found.cell_data["grain"]] == [{11}, {14}]
        number = file["elem_num_map"][:]
        faces = {}
        # sides of a tetrahedron in the Exodus II manual, corners then mid nodes
        sides = [(0, 1, 3, 4, 8, 7), (1, 2, 3, 5, 9, 8), (0, 3, 2, 7, 9, 6), (0, 2, 1, 6, 5, 4)]
        for k, name in enumerate(names, 1):
            local = np.array(sides)[file[f"side_ss{k}"][:] - 1, : 3 if tets.shape[1] == 4 else 6]
            faces[name] = tets[file[f"elem_ss{k}"][:][:, None] - 1, local]
    back = np.argsort(number)
    assert (number[back] == np.arange(1, len(tets) + 1)).all()
    return tets[back], grain[back], found.point_sets, faces


@pytest.mark.parametrize("element", ["C3D4", "C3D10"])
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_meshio_reads_the_mesh_its_grains_and_every_set(suffix, element, tmp_path):
    path, mesh = exported(tmp_path, suffix, element)
    found = read_with_meshio(path)
    parts = {"vtu": of_vtu, "msh": of_msh}.get(suffix, lambda found: of_exodus(found, path))(found)
    tets, grain, node_sets, face_sets = parts
    assert (found.points == mesh.points).all()
    assert (tets == mesh.tets).all() and (grain == mesh.grain).all()
    assert set(node_sets) == set(mesh.node_sets) and set(face_sets) == set(mesh.face_sets)
    assert {"VOID_2", "EXTERIOR", "CRACK_LIP_A", "ZMAX"} <= set(face_sets)
    for name, nodes in mesh.node_sets.items():
        assert (node_sets[name] == nodes).all(), name  # in order, as the front has to be
    for name, nodes in triangles(mesh).items():
        assert (np.sort(face_sets[name], axis=1) == np.sort(nodes, axis=1)).all(), name
        corners = mesh.points[face_sets[name][:, :3]]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        inside = mesh.points[mesh.tets[mesh.face_sets[name][:, 0], :4]].mean(axis=1)
        assert (((corners[:, 0] - inside) * normals).sum(axis=1) > 0).all(), name
        for i, j, k in ((0, 1, 3), (1, 2, 4), (2, 0, 5)) if element == "C3D10" else ():
            ends = {frozenset(row) for row in face_sets[name][:, [i, j, k]].tolist()}
            edges = {
                frozenset(row) for row in nodes[:, [0, 1, 3, 1, 2, 4, 2, 0, 5]].reshape(-1, 3).tolist()
            }
            assert ends <= edges, name


def exported_again(folder, suffix, element, *flags):
    """Return the file that the command writes with the grains' orientations and an l_min of 1e-5 given."""
    write_tets(folder / "volume.vtu", cracked_mesh())
    write_labels(folder / "labels.npz", replace(BLOCK, orientations=turns(), phases=np.arange(20)))
    sizing = Sizing(1e-5, 1.0, 2.0, 1.0, 2.0, 1.0, np.zeros((0, 3)))
    write_sizing(folder / "sizing.npz", arrays_of(sizing))
    beside = ["--microstructure", str(folder / "labels.npz"), "--sizing", str(folder / "sizing.npz")]
    target = folder / f"model.{suffix}"
    command = [
        "export",
        str(folder / "volume.vtu"),
        "-o",
        str(target),
        "--element",
        element,
        *beside,
        *flags,
    ]
    assert main(command) == 0
    return target


@pytest.mark.parametrize("element", ["C3D4", "C3D10"])
def test_msh_as_text_is_the_binary_one(element, tmp_path):
    binary = exported_again(tmp_path, "msh", element).rename(tmp_path / "binary.msh")
    text = exported_again(tmp_path, "msh", element, "--ascii")
    assert text.read_bytes().isascii() and text.read_text().startswith("$MeshFormat\n2.2 0 8\n")
    found, wanted = read_with_meshio(text), read_with_meshio(binary)
    assert (found.points == wanted.points).all() and list(found.field_data) == list(wanted.field_data)
    for one, other in zip(found.cells, wanted.cells, strict=True):
        assert one.type == other.type and (one.data == other.data).all()
    for name in ("gmsh:physical", "gmsh:geometrical"):
        assert all(map(np.array_equal, found.cell_data[name], wanted.cell_data[name]))


@pytest.mark.parametrize("element", ["C3D4", "C3D10"])
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_lips_that_are_apart_stay_so_where_nodes_in_one_place_are_joined(suffix, element, tmp_path, capsys):
    quarter = ["--quarter-points"] if element == "C3D10" else []
    closed = as_elements(cracked_mesh(), element, element == "C3D10")[0]
    path = exported_again(tmp_path, suffix, element, "--opening", "0.02", *quarter)
    assert capsys.readouterr().out == ""  # nothing to note
    found = read_with_meshio(path)
    lips = np.union1d(closed.node_sets["CRACK_LIP_A"], closed.node_sets["CRACK_LIP_B"])
    _, place, count = np.unique(closed.points, axis=0, return_inverse=True, return_counts=True)
    twins = np.flatnonzero(count[place.ravel()] > 1)
    assert len(twins) > 10 and np.isin(twins, lips).all()
    assert len(np.unique(found.points, axis=0)) == len(closed.points) > len(count)
    moved = found.points - closed.points
    assert (np.flatnonzero(moved.any(axis=1)) == twins).all()
    assert np.allclose(np.linalg.norm(moved[twins], axis=1), 1e-7, rtol=1e-6, atol=0)  # half of 0.02 l_min
    on_a = np.setdiff1d(
        np.intersect1d(twins, closed.node_sets["CRACK_LIP_A"]), closed.node_sets["CRACK_LIP_B"]
    )
    assert (moved[on_a, 2] > 0).all()  # the crack is level


def test_lips_move_within_the_faces_of_the_box_and_never_through_elements():
    mesh = edge_cracked()
    opened = lips_apart(mesh, 1e-3)
    on_box = 0
    for number, plane in enumerate(BOX_PLANES):
        nodes = mesh.node_sets[plane]
        assert (opened.points[nodes, number // 2] == mesh.points[nodes, number // 2]).all()
        on_box += int((opened.points[nodes] != mesh.points[nodes]).any(axis=1).sum())
    assert on_box > 0 and (tet_volumes(opened.points, opened.tets) > 0).all()
    with pytest.raises(
        CraftmeshError, match="lips moved 9 apart invert .* elements; give a smaller opening"
    ):
        lips_apart(mesh, 9.0)


@pytest.mark.parametrize("suffix", ["vtu", "csv"])
def test_orientations_are_told_in_the_convention_of_the_files(suffix, tmp_path):
    path = exported_again(tmp_path, suffix, "C3D4")
    if suffix == "vtu":
        found = read_with_meshio(path)
        tets, triangles = found.cell_data["orientation"]
        assert (tets == turns()[found.cell_data["grain"][0]]).all() and np.isnan(triangles).all()
        return
    table = np.genfromtxt(path, delimiter=",", names=True)
    assert table["grain"].tolist() == table["phase"].tolist() == [11, 14]
    for row in table:
        assert [row[name] for name in "wxyz"] == turns()[int(row["grain"])].tolist()
        g = turned([row["phi1"], row["Phi"], row["phi2"]])  # Bunge's, from sample to crystal axes
        assert np.allclose(g.T, quaternion_to_matrix(turns()[int(row["grain"])]), atol=1e-9)


def test_a_largest_id_that_leaves_no_tags_is_refused(tmp_path):
    mesh = cracked_mesh()
    with pytest.raises(
        CraftmeshError, match=r"largest grain id 2147483640 plus \d+ sets exceeds the largest tag"
    ):
        write_msh(tmp_path / "m.msh", replace(mesh, grain=np.where(mesh.grain == 14, 2147483640, 11)))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("element", ["C3D4", "C3D10"])
def test_vtk_reads_the_blocks_and_sets_of_exodus(element, tmp_path):
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOExodus import vtkExodusIIReader

    path, mesh = exported(tmp_path, "exo", element)
    points = mesh.points.astype(np.float32)  # all that VTK's reader keeps
    reader = vtkExodusIIReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    blocks_sides_nodes = (reader.ELEM_BLOCK, reader.SIDE_SET, reader.NODE_SET)
    for kind in blocks_sides_nodes:
        for i in range(reader.GetNumberOfObjects(kind)):
            reader.SetObjectStatus(kind, i, 1)
    reader.Update()
    found = []
    for kind, place in zip(blocks_sides_nodes, (0, 4, 7)):
        found.append({})
        for i in range(reader.GetNumberOfObjects(kind)):
            grid = reader.GetOutput().GetBlock(place).GetBlock(i)
            nodes = vtk_to_numpy(grid.GetCells().GetConnectivityArray())
            own = vtk_to_numpy(grid.GetPoints().GetData())
            found[-1][reader.GetObjectName(kind, i)] = own[nodes.reshape(grid.GetNumberOfCells(), -1)]
    blocks, sides, node_sets = found
    assert list(blocks) == ["GRAIN_11", "GRAIN_14"]
    for grain in (11, 14):
        assert (blocks[f"GRAIN_{grain}"] == points[mesh.tets[mesh.grain == grain]]).all()
    for name, nodes in triangles(mesh).items():
        places = [np.sort(faces.view("f4,f4,f4")[..., 0], axis=1) for faces in (sides[name], points[nodes])]
        assert (places[0] == places[1]).all(), name
    for name, nodes in mesh.node_sets.items():
        assert (node_sets[name][:, 0] == points[nodes]).all(), name


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_same_input_gives_the_same_bytes_and_no_other_file(suffix, tmp_path, capfd):
    files = [exported(tmp_path / folder, suffix, "C3D10")[0] for folder in ("a", "b")]
    assert files[0].read_bytes() == files[1].read_bytes()
    assert {path.name for path in (tmp_path / "a").iterdir()} == {"volume.vtu", f"model.{suffix}"}
    said, error = capfd.readouterr()
    assert said.count("\n") == 2 and said.startswith("note: both faces of a crack coincide") and not error


def test_an_exported_vtu_is_a_mesh_of_ours(tmp_path):
    path, mesh = exported(tmp_path, "vtu", "C3D10")
    found = read_tets(path)
    assert (found.tets == mesh.tets).all() and (found.grain == mesh.grain).all()
    assert list(found.face_sets) == list(mesh.face_sets) and check_tets(found) == []


@pytest.mark.parametrize("element", ["C3D4", "C3D10"])
def test_check_reads_exodus_and_finds_what_is_wrong_in_it(element, tmp_path, capsys):
    path, mesh = exported(tmp_path, "e", element)
    found = read_exodus(path)
    assert (found.points == mesh.points).all() and (found.tets == mesh.tets).all()
    assert (found.grain == mesh.grain).all()
    for one, other in ((found.node_sets, mesh.node_sets), (found.face_sets, mesh.face_sets)):
        assert list(one) == list(other) and all((one[name] == other[name]).all() for name in other)
    assert main(["check", str(path)]) == 0
    with netcdf_file(path, "a", mmap=False) as file:  # two corners change places
        rows = file.variables["connect1"]
        rows[0, :2] = rows[0, 1::-1].copy()
    assert main(["check", str(path)]) == 1
    assert "1 tetrahedra have a volume <= 0" in capsys.readouterr().out
    path.write_bytes(b"CDF\x02")
    assert main(["check", str(path)]) == 1
    assert "not an Exodus file of craftmesh" in capsys.readouterr().err


def turned(angles):
    """Return RotationTensor(phi1, PHI, phi2) of MOOSE, whose transpose turns from crystal to sample."""
    (c1, c, c2), (s1, s, s2) = np.cos(np.radians(angles)), np.sin(np.radians(angles))
    return np.array(
        [
            [c1 * c2 - c * s1 * s2, s1 * c2 + c * c1 * s2, s * s2],
            [-c1 * s2 - c * c2 * s1, c * c1 * c2 - s1 * s2, c2 * s],
            [s1 * s, -c1 * s, c],
        ]
    )


def test_moose_gets_a_row_of_angles_for_each_block(tmp_path, capsys):
    quaternions = turns()
    labels, table = tmp_path / "labels.npz", tmp_path / "orientations.csv"
    write_labels(labels, replace(BLOCK, orientations=quaternions))
    write_tets(tmp_path / "volume.vtu", cracked_mesh())
    files = (tmp_path / "volume.vtu", "-o", tmp_path / "m.e", "--angles", table)
    flags = ["export", *map(str, files)]
    assert main(flags) == 1 and "give --microstructure" in capsys.readouterr().err
    assert main([*flags, "--microstructure", str(labels)]) == 0
    rows = np.loadtxt(table, delimiter=",")  # blocks 1 to 14, of which the mesh has 11 and 14
    assert rows.shape == (14, 3) and not rows[[*range(10), 11, 12]].any()
    for grain in (11, 14):
        assert np.allclose(turned(rows[grain - 1]).T, quaternion_to_matrix(quaternions[grain]), atol=1e-9)
    quaternions[11] = np.nan
    write_labels(labels, replace(BLOCK, orientations=quaternions))
    (tmp_path / "m.e").unlink()
    assert main([*flags, "--microstructure", str(labels)]) == 1 and not (tmp_path / "m.e").exists()
    assert "grain 11 has no orientation (1 such grains)" in capsys.readouterr().err


def test_what_cannot_be_exported_is_refused_in_one_line(tmp_path, capsys):
    path = tmp_path / "volume.vtu"
    mesh = cracked_mesh()
    write_tets(path, mesh)
    before = path.read_bytes()
    long = type(mesh)(mesh.points, mesh.tets, mesh.grain, {"N" * 33: [1]}, mesh.face_sets)
    write_tets(tmp_path / "long.vtu", long)
    for source, target, said in (
        ("volume.vtu", "model.stp", "suffix '.stp'; expected one of .vtu, .msh, .e, .exo, .csv"),
        (
            "volume.vtu",
            "model.csv",
            "model.csv needs the orientations of the grains; give --microstructure",
        ),
        ("volume.vtu", "volume.vtu", "is the input mesh"),
        ("long.vtu", "model.e", "names in Exodus have at most 32 ASCII characters"),
    ):
        assert main(["export", str(tmp_path / source), "-o", str(tmp_path / target)]) == 1
        error = capsys.readouterr().err
        assert said in error and error.count("\n") == 1
    assert path.read_bytes() == before and sorted(p.name for p in tmp_path.iterdir()) == [
        "long.vtu",
        "volume.vtu",
    ]


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("sets", [({}, {}), ({"EMPTY": []}, {"EMPTY": np.zeros((0, 2))})])
def test_a_mesh_without_sets_is_exported_too(suffix, sets, tmp_path):
    corners = np.concatenate([np.zeros((1, 3)), np.eye(3)])
    write_tets(tmp_path / "volume.vtu", type(cracked_mesh())(corners, [[0, 1, 2, 3]], [7], *sets))
    target = tmp_path / f"model.{suffix}"
    assert main(["export", str(tmp_path / "volume.vtu"), "-o", str(target), "--element", "C3D4"]) == 0
    found = read_with_meshio(target)
    assert (found.points == corners).all()
    assert {block.type: block.data.tolist() for block in found.cells} == {"tetra": [[0, 1, 2, 3]]}
