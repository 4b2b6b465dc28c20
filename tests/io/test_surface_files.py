"""Surface files come back as they were written, in every format; broken ones are refused by name."""

import importlib
import subprocess
import sys

import meshio
import numpy as np
import pytest
import trimesh
import vtk_objects
from grain_folders import write_grain_folder
from structured_box import structured_box
from surface_writer import write_triangles

from craftmesh.errors import CraftmeshError
from craftmesh.io.surface_files import (
    SUFFIXES,
    read_grain_folder,
    read_triangles,
)
from craftmesh.stitching.stitch import stitch_grains
from craftmesh.types import CRACK

# The third of 1.0 has no short decimals: it shows whether a format keeps float64.
TETRAHEDRON = (
    np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1 / 3, 0, 1.5]]),
    np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]),
)
FLOAT32 = TETRAHEDRON[0].astype(np.float32).astype(float)
INDEXED = [suffix for suffix in SUFFIXES if suffix != ".stl"]  # points shared by triangles


def ascii_stl(points, triangles) -> str:
    lines = ["solid grain"]
    for triangle in triangles:
        lines += [" facet normal 0 0 0", "  outer loop"]
        lines += ["   vertex " + " ".join(f"{x:.17e}" for x in points[corner]) for corner in triangle]
        lines += ["  endloop", " endfacet"]
    return "\n".join([*lines, "endsolid grain", ""])


def ascii_ply(points, triangles) -> str:
    lines = ["ply", "format ascii 1.0", f"element vertex {len(points)}"]
    lines += [f"property double {axis}" for axis in "xyz"]
    lines += [f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header"]
    lines += [" ".join(f"{x:.17e}" for x in point) for point in points]
    lines += ["3 " + " ".join(map(str, triangle)) for triangle in triangles.tolist()]
    return "\n".join([*lines, ""])


def binary_ply_of_doubles(points, triangles) -> bytes:
    head = ascii_ply(points[:0], triangles[:0]).replace("ascii", "binary_little_endian")
    head = head.replace("vertex 0", f"vertex {len(points)}").replace("face 0", f"face {len(triangles)}")
    rows = np.zeros(len(triangles), [("count", "u1"), ("corners", "<i4", 3)])
    rows["count"], rows["corners"] = 3, triangles
    return head.encode() + points.astype("<f8").tobytes() + rows.tobytes()


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_every_format_comes_back(tmp_path, suffix):
    write_triangles(tmp_path / f"a_1{suffix}", *TETRAHEDRON)
    points, triangles = read_triangles(tmp_path / f"a_1{suffix}")
    assert (points.dtype, triangles.dtype) == (np.float64, np.int64)
    kept = FLOAT32 if suffix in (".stl", ".ply") else TETRAHEDRON[0]
    assert np.array_equal(points[triangles], kept[TETRAHEDRON[1]])


@pytest.mark.parametrize("suffix", INDEXED)
def test_points_keep_their_order_and_are_not_joined(tmp_path, suffix):
    points = np.concatenate([TETRAHEDRON[0], TETRAHEDRON[0]])  # two grains that touch, in one file
    triangles = np.concatenate([TETRAHEDRON[1], TETRAHEDRON[1] + 4])
    write_triangles(tmp_path / f"a{suffix}", points, triangles)
    read_points, read = read_triangles(tmp_path / f"a{suffix}")
    assert np.array_equal(read, triangles)
    assert np.allclose(read_points, points, atol=1e-7)


@pytest.mark.parametrize("suffix", INDEXED)
def test_points_of_no_triangle_are_left_out(tmp_path, suffix):
    points = np.concatenate([[[9.0, 9, 9]], TETRAHEDRON[0]])
    write_triangles(tmp_path / f"a{suffix}", points, TETRAHEDRON[1] + 1)
    read_points, read = read_triangles(tmp_path / f"a{suffix}")
    assert len(read_points) == 4 and np.array_equal(read, TETRAHEDRON[1])


@pytest.mark.parametrize(
    ("name", "written"),
    [("a.stl", ascii_stl), ("a.ply", ascii_ply), ("b.ply", binary_ply_of_doubles)],
)
def test_text_and_doubles_keep_every_bit(tmp_path, name, written):
    content = written(*TETRAHEDRON)
    (tmp_path / name).write_bytes(content.encode() if isinstance(content, str) else content)
    points, triangles = read_triangles(tmp_path / name)
    assert np.array_equal(points[triangles], TETRAHEDRON[0][TETRAHEDRON[1]])


@pytest.mark.parametrize("binary", [False, True])
@pytest.mark.parametrize("suffix", [".stl", ".ply", ".obj", ".off"])
def test_files_of_meshio_are_read(tmp_path, suffix, binary):
    kind = {"binary": binary} if suffix in (".stl", ".ply") else {}
    meshio.Mesh(TETRAHEDRON[0], [("triangle", TETRAHEDRON[1])]).write(tmp_path / f"a{suffix}", **kind)
    points, triangles = read_triangles(tmp_path / f"a{suffix}")
    np.testing.assert_allclose(points[triangles], TETRAHEDRON[0][TETRAHEDRON[1]], atol=1e-7)


@pytest.mark.parametrize("binary", [False, True])
@pytest.mark.parametrize(
    ("module", "writer", "suffix"),
    [("vtkIOGeometry", "vtkSTLWriter", ".stl"), ("vtkIOPLY", "vtkPLYWriter", ".ply")],
)
def test_files_of_vtk_are_read(tmp_path, module, writer, suffix, binary):
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    poly = vtkPolyData()
    poly.SetPoints(vtk_objects.vtk_points(TETRAHEDRON[0]))
    poly.SetPolys(vtk_objects.uniform_cells(TETRAHEDRON[1]))
    vtk_writer = getattr(importlib.import_module(f"vtkmodules.{module}"), writer)()
    vtk_writer.SetInputData(poly)
    vtk_writer.SetFileName(str(tmp_path / f"a{suffix}"))
    vtk_writer.SetFileType(2 if binary else 1)
    assert vtk_writer.Write()
    points, triangles = read_triangles(tmp_path / f"a{suffix}")
    np.testing.assert_allclose(points[triangles], TETRAHEDRON[0][TETRAHEDRON[1]], atol=1e-6)


def test_a_binary_file_whose_header_says_solid_is_read_as_binary(tmp_path):
    write_triangles(tmp_path / "a_1.stl", *TETRAHEDRON)
    data = (tmp_path / "a_1.stl").read_bytes()
    (tmp_path / "a_1.stl").write_bytes(b"solid" + data[5:])
    assert len(read_triangles(tmp_path / "a_1.stl")[1]) == 4


def test_solids_of_an_ascii_file_come_one_after_the_other(tmp_path):
    points, triangles = TETRAHEDRON
    (tmp_path / "a.stl").write_text(ascii_stl(points, triangles) + ascii_stl(points + 2, triangles))
    read_points, read = read_triangles(tmp_path / "a.stl")
    assert np.array_equal(read_points[read], np.concatenate([points[triangles], points[triangles] + 2]))


def test_normals_textures_and_materials_of_an_obj_change_no_point(tmp_path):
    text = [
        "mtllib not_there.mtl",
        "o grain",
        *(f"v {x!r} {y!r} {z!r}" for x, y, z in TETRAHEDRON[0].tolist()),
    ]
    text += ["vt 0 0", "vt 1 0", "vn 0 0 1", "vn 1 0 0"]
    for k, (a, b, c) in enumerate((TETRAHEDRON[1] + 1).tolist()):
        text += [f"usemtl colour{k % 2}", f"f {a}/1/{k % 2 + 1} {b}/2/1 {c}/{k % 2 + 1}/2"]
    (tmp_path / "a.obj").write_text("\n".join([*text, ""]))
    points, triangles = read_triangles(tmp_path / "a.obj")
    found = sorted(points[triangles].reshape(-1, 9).tolist())
    assert found == sorted(TETRAHEDRON[0][TETRAHEDRON[1]].reshape(-1, 9).tolist())


def test_bodies_of_a_3mf_are_moved_to_their_places(tmp_path):
    scene = trimesh.Scene()
    body = trimesh.Trimesh(*TETRAHEDRON, process=False)
    scene.add_geometry(body, transform=trimesh.transformations.translation_matrix([2.0, 0, 0]))
    (tmp_path / "a.3mf").write_bytes(scene.export(file_type="3mf"))
    points, triangles = read_triangles(tmp_path / "a.3mf")
    assert np.array_equal(points[triangles], (TETRAHEDRON[0] + [2, 0, 0])[TETRAHEDRON[1]])


def test_a_folder_is_read_by_grain_id(tmp_path):
    for name in ("grain_12.stl", "grain_3.STL", "part_7.stl"):
        write_triangles(tmp_path / name, *TETRAHEDRON)
    (tmp_path / "notes.txt").write_text("not a surface")
    assert [grain for grain, _, _ in read_grain_folder(tmp_path)] == [3, 7, 12]


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("content", [b"", b"garbage" * 30, b"\x00" * 84])
def test_broken_files_are_refused_by_name(tmp_path, suffix, content):
    (tmp_path / f"grain_5{suffix}").write_bytes(content)
    with pytest.raises(CraftmeshError, match=rf"grain_5\{suffix}"):
        read_grain_folder(tmp_path)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("grain_5.stl", "solid\nvertex 1 2 x\n"),
        ("grain_5.stl", ascii_stl(*TETRAHEDRON).replace("1.50000000000000000e+00", "1.5.0")),
        ("grain_5.stl", ascii_stl(*TETRAHEDRON).replace("1.50000000000000000e+00", "nan")),
        ("grain_5.ply", ascii_ply(*TETRAHEDRON).replace("3 0 3 2\n", "3 0 3 4\n")),
        ("grain_5.ply", ascii_ply(*TETRAHEDRON).replace("3 0 3 2\n", "")),
        ("grain_5.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
        ("grain_5.off", "OFF\n# two faces\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
        ("grain_5.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 inf\n3 0 1 2\n"),
        ("grain_5.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"),
        ("grain_5.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"),
    ],
)
def test_wrong_numbers_are_refused_by_name(tmp_path, name, content):
    (tmp_path / name).write_text(content)
    with pytest.raises(CraftmeshError, match=name):
        read_grain_folder(tmp_path)


def test_empty_folders_and_ids_met_twice_are_refused(tmp_path):
    with pytest.raises(CraftmeshError, match="no file"):
        read_grain_folder(tmp_path)
    write_triangles(tmp_path / "a_4.stl", *TETRAHEDRON)
    write_triangles(tmp_path / "b_4.stl", *TETRAHEDRON)
    with pytest.raises(CraftmeshError, match="grain 4"):
        read_grain_folder(tmp_path)


def test_mixed_formats_missing_files_and_unknown_suffixes_are_refused(tmp_path):
    write_triangles(tmp_path / "a_4.stl", *TETRAHEDRON)
    write_triangles(tmp_path / "a_5.ply", *TETRAHEDRON)
    with pytest.raises(CraftmeshError, match=r"\.stl and \.ply files \(a_4\.stl, a_5\.ply\)"):
        read_grain_folder(tmp_path)
    with pytest.raises(CraftmeshError, match="no such file"):
        read_triangles(tmp_path / "a_6.ply")
    (tmp_path / "a.step").touch()
    with pytest.raises(CraftmeshError, match=r"'\.step' is not known; expected \.stl, .* or \.3mf, or"):
        read_triangles(tmp_path / "a.step")
    (tmp_path / "a.glb").touch()
    with pytest.raises(CraftmeshError, match="is not a complete GLB file"):
        read_triangles(tmp_path / "a.glb")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_surface_is_written_grain_by_grain_without_its_crack(tmp_path, suffix):
    surface, _ = structured_box(
        (2, 2, 2), lambda c: 1 + (c[:, 2] > 1).astype(int), lambda c, n: (c[:, 0] == 1) & (n[:, 0] == 1)
    )
    assert (surface.kind == CRACK).any()
    paths = write_grain_folder(tmp_path, surface, suffix=suffix)
    assert [path.name for path in paths] == [f"grain_1{suffix}", f"grain_2{suffix}"]
    grains = read_grain_folder(tmp_path)
    for _, points, triangles in grains:
        a, b, c = (points[triangles[:, i]] for i in range(3))
        assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6 == pytest.approx(4.0)
    stitched, _ = stitch_grains(grains)
    assert stitched.grains.tolist() == [1, 2]
    assert len(stitched.facets) == (surface.kind != CRACK).sum()


def test_the_command_line_starts_without_trimesh():
    code = "import sys, craftmesh.cli, craftmesh.commands.stitch; sys.exit('trimesh' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
