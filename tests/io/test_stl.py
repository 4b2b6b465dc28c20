import numpy as np
import pytest
from structured_box import structured_box

from craftmesh.errors import CraftmeshError
from craftmesh.io.stl import read_stl, read_stl_folder, write_stl, write_stl_folder
from craftmesh.types import CRACK

TETRAHEDRON = (
    np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.5]]),
    np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]),
)


def ascii_stl(points, triangles) -> str:
    lines = ["solid grain"]
    for triangle in triangles:
        lines += [" facet normal 0 0 0", "  outer loop"]
        lines += ["   vertex " + " ".join(f"{x:.9e}" for x in points[corner]) for corner in triangle]
        lines += ["  endloop", " endfacet"]
    return "\n".join([*lines, "endsolid grain", ""])


def test_a_binary_file_comes_back(tmp_path):
    write_stl(tmp_path / "a_1.stl", *TETRAHEDRON)
    points, triangles = read_stl(tmp_path / "a_1.stl")
    assert np.array_equal(points[triangles], TETRAHEDRON[0][TETRAHEDRON[1]])


def test_an_ascii_file_reads_as_the_binary_one(tmp_path):
    (tmp_path / "a_1.stl").write_text(ascii_stl(*TETRAHEDRON))
    points, triangles = read_stl(tmp_path / "a_1.stl")
    assert np.array_equal(points[triangles], TETRAHEDRON[0][TETRAHEDRON[1]])


def test_a_binary_file_whose_header_says_solid_is_read_as_binary(tmp_path):
    write_stl(tmp_path / "a_1.stl", *TETRAHEDRON)
    data = (tmp_path / "a_1.stl").read_bytes()
    (tmp_path / "a_1.stl").write_bytes(b"solid" + data[5:])
    assert len(read_stl(tmp_path / "a_1.stl")[1]) == 4


def test_a_folder_is_read_by_grain_id(tmp_path):
    for name in ("grain_12.stl", "grain_3.STL", "part_7.stl"):
        write_stl(tmp_path / name, *TETRAHEDRON)
    (tmp_path / "notes.txt").write_text("not a surface")
    assert [grain for grain, _, _ in read_stl_folder(tmp_path)] == [3, 7, 12]


@pytest.mark.parametrize(
    "content", [b"", b"solid\nvertex 1 2 x\n", b"garbage" * 30, b"solid\n  vertex 0 0 nan\n"]
)
def test_broken_files_are_refused_by_name(tmp_path, content):
    (tmp_path / "grain_5.stl").write_bytes(content)
    with pytest.raises(CraftmeshError, match=r"grain_5\.stl"):
        read_stl_folder(tmp_path)


def test_empty_folders_and_ids_met_twice_are_refused(tmp_path):
    with pytest.raises(CraftmeshError, match="no file"):
        read_stl_folder(tmp_path)
    write_stl(tmp_path / "a_4.stl", *TETRAHEDRON)
    write_stl(tmp_path / "b_4.stl", *TETRAHEDRON)
    with pytest.raises(CraftmeshError, match="grain 4"):
        read_stl_folder(tmp_path)


def test_a_surface_is_written_grain_by_grain_without_its_crack(tmp_path):
    surface, _ = structured_box(
        (2, 2, 2), lambda c: 1 + (c[:, 2] > 1).astype(int), lambda c, n: (c[:, 0] == 1) & (n[:, 0] == 1)
    )
    assert (surface.kind == CRACK).any()
    paths = write_stl_folder(tmp_path, surface)
    assert [path.name for path in paths] == ["grain_1.stl", "grain_2.stl"]
    for _, points, triangles in read_stl_folder(tmp_path):
        a, b, c = (points[triangles[:, i]] for i in range(3))
        assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6 == pytest.approx(4.0)
