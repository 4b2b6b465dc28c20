"""Every stage file comes back as it was written, and says what it lacks."""

import zipfile

import numpy as np
import pytest
import pyvista
import vtk_objects
from vtkmodules import vtkIOXML

from craftmesh.atomic import atomic_path
from craftmesh.errors import CraftmeshError
from craftmesh.io import stage_npz, vtk
from craftmesh.io.surface_files import read_triangles
from craftmesh.types import CRACK, Crack, GrainTets, Surface, TetMesh, Voxels

AWKWARD = np.array([0.1, 1 / 3, np.nextafter(1.0, 2.0), 1e-300, -9.876543210987654e99, 5e-324])


def cube_surface() -> Surface:
    points = np.array([[x, y, z] for x in (0.1, 1.1) for y in (0.0, 2 / 3) for z in (-1.0, 1e-17)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    facets = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))] + [(0, 3, 7)]
    kind = np.r_[np.repeat(np.arange(1, 7), 2), CRACK]
    return Surface(points, facets, np.array([[3, 0]] * 12 + [[3, 3]]), kind)


def crack_with_two_fronts() -> Crack:
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1 / 3, 0], [9, 9, 9.0]])
    return Crack(points, [[0, 1, 2], [0, 2, 3]], ([0, 1, 2, 0], [2, 3]))


def voxels(**known) -> Voxels:
    labels = np.arange(24, dtype=np.int32).reshape(2, 3, 4) - 2
    return Voxels(labels, [0.1, 1 / 3, 2.5e-6], [-1e-7, 12345.678901234567, 0.0], **known)


def tets(width: int) -> TetMesh:
    points = np.arange(30.0).reshape(10, 3) / 7
    points[:2] = AWKWARD.reshape(2, 3)
    sets = {"CRACK_FRONT": [3, 1, 2], "EMPTY": []}, {"XMIN": [[0, 3], [0, 1]], "VOID_1": np.zeros((0, 2))}
    return TetMesh(points, [np.arange(width)], [12], *sets)


def grains() -> list[GrainTets]:
    only_surface = GrainTets(2, [5, 7, 8, 11], np.zeros((0, 3)), [[0, 1, 2, 3]])
    return [only_surface, GrainTets(9, [5, 7, 8], AWKWARD.reshape(2, 3), [[0, 1, 2, 3], [0, 1, 2, 4]])]


CASES = {
    "surface.vtp": (vtk.write_surface, vtk.read_surface, cube_surface()),
    "crack.vtp": (vtk.write_crack, vtk.read_crack, crack_with_two_fronts()),
    "voxels.vti": (vtk.write_voxels, vtk.read_voxels, voxels()),
    "oriented.vti": (
        vtk.write_voxels,
        vtk.read_voxels,
        voxels(orientations=np.r_[[[np.nan] * 4], np.eye(4)], phases=[0, 1, 1, 2]),
    ),
    "linear.vtu": (vtk.write_tets, vtk.read_tets, tets(4)),
    "quadratic.vtu": (vtk.write_tets, vtk.read_tets, tets(10)),
    "chunk.npz": (stage_npz.write_grain_tets, stage_npz.read_grain_tets, grains()),
    "no_grains.npz": (stage_npz.write_grain_tets, stage_npz.read_grain_tets, []),
}


def assert_same(found, expected):
    """Compare dataclasses, mappings, sequences and arrays, arrays bit for bit with their dtypes."""
    if hasattr(expected, "__dataclass_fields__"):
        assert type(found) is type(expected)
        for name in expected.__dataclass_fields__:
            assert_same(getattr(found, name), getattr(expected, name))
    elif hasattr(expected, "items"):
        assert list(found) == list(expected)
        for name in expected:
            assert_same(found[name], expected[name])
    elif isinstance(expected, list | tuple):
        assert len(found) == len(expected)
        for a, b in zip(found, expected):
            assert_same(a, b)
    elif isinstance(expected, np.ndarray):
        assert found.dtype == expected.dtype and found.shape == expected.shape
        assert found.tobytes() == expected.tobytes()
    else:
        assert found == expected


@pytest.mark.parametrize("name", CASES)
def test_what_is_written_comes_back(name, tmp_path):
    write, read, value = CASES[name]
    write(tmp_path / name, value)
    assert_same(read(tmp_path / name), value)


@pytest.mark.parametrize("name", CASES)
def test_same_input_gives_the_same_bytes_and_no_other_file(name, tmp_path):
    write, read, value = CASES[name]
    for folder in ("a", "b"):
        write(tmp_path / folder / name, value)
    assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    assert [p.name for p in (tmp_path / "a").iterdir()] == [name]


@pytest.mark.parametrize("name", CASES)
def test_missing_and_truncated_files_are_named_in_one_line(name, tmp_path, capfd):
    write, read, value = CASES[name]
    path = tmp_path / name
    with pytest.raises(CraftmeshError, match=name) as missing:
        read(path)
    write(path, value)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(CraftmeshError, match=name) as broken:
        read(path)
    assert "\n" not in str(missing.value) + str(broken.value)
    assert capfd.readouterr().err == ""


def test_chunk_files_carry_no_clock_time(tmp_path):
    stage_npz.write_grain_tets(tmp_path / "chunk.npz", grains())
    with zipfile.ZipFile(tmp_path / "chunk.npz") as archive:
        assert {entry.date_time[0] for entry in archive.infolist()} == {1980}


def write_poly(path, surface, **cell_data):
    """Write a surface with the cell data given only, and with a vertex cell before the triangles."""
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    poly = vtkPolyData()
    poly.SetPoints(vtk_objects.vtk_points(surface.points))
    poly.SetVerts(vtk_objects.uniform_cells(np.array([[0]])))
    poly.SetPolys(vtk_objects.uniform_cells(surface.facets))
    padded = {name: np.concatenate([values[:1], values]) for name, values in cell_data.items()}
    vtk_objects.add_arrays(poly.GetCellData(), padded)
    vtk_objects.write_dataset(path, poly, "PolyData")


def test_kind_is_found_from_crack_and_box(tmp_path):
    surface = cube_surface()
    write_poly(tmp_path / "s.vtp", surface, sides=surface.sides, crack=np.uint8(surface.kind == CRACK))
    assert_same(vtk.read_surface(tmp_path / "s.vtp"), surface)


def test_missing_arrays_are_named(tmp_path):
    surface = cube_surface()
    write_poly(tmp_path / "s.vtp", surface, kind=surface.kind)
    with pytest.raises(CraftmeshError, match="'sides'.*found: kind"):
        vtk.read_surface(tmp_path / "s.vtp")
    write_poly(tmp_path / "s.vtp", surface, sides=surface.sides)
    with pytest.raises(CraftmeshError, match="'kind' or 'crack'"):
        vtk.read_surface(tmp_path / "s.vtp")


def test_cracks_and_surfaces_are_told_apart(tmp_path):
    vtk.write_surface(tmp_path / "s.vtp", cube_surface())
    vtk.write_crack(tmp_path / "c.vtp", crack_with_two_fronts())
    with pytest.raises(CraftmeshError, match="is a surface of grains .cell data 'sides'"):
        vtk.read_crack(tmp_path / "s.vtp")
    with pytest.raises(CraftmeshError, match="'sides'"):
        vtk.read_surface(tmp_path / "c.vtp")


def test_a_file_of_another_kind_is_refused(tmp_path):
    vtk.write_surface(tmp_path / "s.vtp", cube_surface())
    with pytest.raises(CraftmeshError, match="UnstructuredGrid"):
        vtk.read_tets(tmp_path / "s.vtp")


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path):
    path = tmp_path / "out.txt"
    path.write_text("old")
    with pytest.raises(RuntimeError), atomic_path(path) as temporary:
        temporary.write_text("half")
        raise RuntimeError
    assert path.read_text() == "old" and list(tmp_path.iterdir()) == [path]


def test_a_full_disk_is_said_in_one_line(tmp_path):
    with pytest.raises(CraftmeshError, match="out.txt: cannot be written .No space left"):
        with atomic_path(tmp_path / "out.txt") as temporary:
            temporary.write_text("half")
            with open("/dev/full", "w") as full:
                full.write("x")
    assert list(tmp_path.iterdir()) == []


def test_a_place_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(CraftmeshError, match="cannot be written"):
        vtk.write_surface(tmp_path / "file" / "s.vtp", cube_surface())


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e200])
@pytest.mark.parametrize("suffix", [".vtp", ".ply", ".obj"])
def test_points_that_are_no_places_are_refused_with_their_file(value, suffix, tmp_path):
    corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, value, 0.0]]
    path = tmp_path / f"bad{suffix}"
    if suffix == ".obj":
        path.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "f 1 2 3\n")
    else:
        pyvista.PolyData.from_regular_faces(np.array(corners), [[0, 1, 2]]).save(path)
    read = vtk.read_crack if suffix == ".vtp" else read_triangles
    with pytest.raises(CraftmeshError, match=rf"bad{suffix}: points\[2, 1\] is .*expected finite numbers"):
        read(path)


def as_vtk_reads_it(path):
    """Return the data set that VTK's own reader gives."""
    kind = {".vtp": "PolyData", ".vti": "ImageData", ".vtu": "UnstructuredGrid"}[path.suffix]
    reader = getattr(vtkIOXML, f"vtkXML{kind}Reader")()
    reader.SetFileName(str(path))
    reader.Update()
    assert not reader.GetErrorCode()
    return pyvista.wrap(reader.GetOutput())


def test_vtk_reads_what_is_written(tmp_path):
    """Points, cells and arrays of more than one block, without cells, with rows of several numbers."""
    many = np.random.default_rng(0).random((60_000, 3))  # 1.4 MB
    facets = np.arange(60_000).reshape(-1, 3)
    mesh = tets(10)
    vtk.write_facets(tmp_path / "s.vtp", many, facets, {"area": many[:20_000, 0]})
    vtk.write_crack(tmp_path / "c.vtp", crack_with_two_fronts())
    vtk.write_tets(tmp_path / "m.vtu", mesh)
    vtk.write_voxels(tmp_path / "v.vti", voxels(phases=[0, 1, 1, 2]))
    poly, crack = as_vtk_reads_it(tmp_path / "s.vtp"), as_vtk_reads_it(tmp_path / "c.vtp")
    assert (poly.points == many).all() and (poly.regular_faces == facets).all()
    assert (poly.cell_data["area"] == many[:20_000, 0]).all()
    assert (crack.n_lines, crack.n_faces) == (2, 2)
    grid, image = as_vtk_reads_it(tmp_path / "m.vtu"), as_vtk_reads_it(tmp_path / "v.vti")
    assert (grid.points == mesh.points).all() and (grid.cells_dict[24] == mesh.tets).all()
    assert (grid.field_data["node_set:CRACK_FRONT"] == [3, 1, 2]).all()
    assert (grid.field_data["face_set:XMIN"] == [[0, 3], [0, 1]]).all()
    assert image.dimensions == (3, 4, 5) and image.spacing == (0.1, 1 / 3, 2.5e-6)
    assert (image.cell_data["labels"] == voxels().labels.ravel(order="F")).all()
