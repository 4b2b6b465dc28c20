"""Sources of the sizing function in files: points, craftmesher's void list, fields on .vtp and .vti."""

import argparse

import numpy as np
import pytest
import vtk_objects

from craftmesh.commands.mesh_flags import add_front, add_sizing, sizing_from
from craftmesh.errors import CraftmeshError
from craftmesh.io.point_files import read_length_field, read_source_points
from craftmesh.remeshing.remesh import RemeshOptions, remesh
from craftmesh.sizing.length_field import LengthField
from craftmesh.sizing.sizing import SizingOptions
from craftmesh.sizing.sources import Defects, sizing_around
from craftmesh.types import Surface
from craftmesh.voxels.generate import GenerateOptions, generate

BOX = np.array([[1.0, 0.0, 0.0], [11.0, 10.0, 10.0]])
IN_BOX = Surface([*BOX, [1, 10, 0]], [[0, 1, 2]], [[1, 0]], [0])


def arguments_of(text: str, *paths) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    add_front(parser)
    add_sizing(parser)
    return parser.parse_args([*text.split(), *map(str, paths)])


def points_around(spheres: np.ndarray, step: float) -> np.ndarray:
    """Return the sources of a sizing function around spheres, at most `step` apart."""
    options = SizingOptions(l_min=2 * step, l0=2 * step, l_max=9 * step, r0=step, r1=2 * step)
    return sizing_around(IN_BOX, Defects(spheres=spheres), options).sources


@pytest.mark.parametrize("header", ["", "id,x,y,z,r\n"])
def test_void_list_is_in_fractions_of_the_box(tmp_path, header):
    path = tmp_path / "voids.csv"
    path.write_text(header + "0,0.5,0.5,0.5,0.2\n1,0.1,0.2,0.3,0.05\n")
    points = points_around(read_source_points(path).in_box(IN_BOX.box), 0.3)
    distance = [np.linalg.norm(points - c, axis=1) for c in ([6, 5, 5], [2, 2, 3])]
    first = distance[0] < 2.5
    assert np.allclose(distance[0][first], 2.0) and np.allclose(distance[1][~first], 0.5)
    # Every place of the sphere has a point within the step.
    places = np.random.default_rng(0).normal(size=(200, 3))
    places = np.array([6.0, 5, 5]) + 2 * places / np.linalg.norm(places, axis=1)[:, None]
    assert np.linalg.norm(places[:, None] - points[first], axis=2).min(1).max() < 0.3


def test_points_are_taken_as_they_are(tmp_path):
    path = tmp_path / "points.csv"
    path.write_text("x,y,z\n1,2,3\n4,5,6\n")
    given = read_source_points(path)
    assert np.array_equal(given.points, [[1, 2, 3], [4, 5, 6]])
    assert len(given.voids) == len(given.spheres) == 0


AVIZO = {
    "commas": '"Volume3d (\u00b5m^3) ","BaryCenterX (\u00b5m) ",BaryCenterY,BaryCenterZ,index\n'
    "{v},2.5,3,4,1\n",
    "title, semicolons": "Label Analysis;;;;\n\nindex;EqDiameter (mm);BaryCenterX (mm);BaryCenterY (mm);"
    "BaryCenterZ (mm)\n1;3,0;2,5;3;4\n",
    "tabs": "EqDiameter [um]\tBaryCenterX\tBaryCenterY\tBaryCenterZ\n3.0\t2.5\t3\t4\n",
}


@pytest.mark.parametrize("text", AVIZO.values(), ids=AVIZO)
@pytest.mark.parametrize("encoding", ["utf-8-sig", "latin-1"])
def test_pores_of_avizo_are_spheres_in_model_units(tmp_path, text, encoding):
    path = tmp_path / "pores.csv"
    path.write_text(text.format(v=4 / 3 * np.pi * 1.5**3), encoding)
    given = read_source_points(path)
    np.testing.assert_allclose(given.spheres, [[2.5, 3, 4, 1.5]], rtol=1e-15)  # a cube and its root
    assert len(given.points) == len(given.voids) == 0


def test_pores_outside_the_box_are_refused(tmp_path):
    path = tmp_path / "pores.csv"
    path.write_text("EqDiameter,BaryCenterX,BaryCenterY,BaryCenterZ\n1,0.6,5,5\n")
    flags = f"--points {path} --l-min 0.5 --l0 1 --l-max 3 --r0 1 --r1 2"
    assert len(sizing_from(arguments_of(flags), IN_BOX, None).sources) >= 12  # half of it is outside
    path.write_text("EqDiameter,BaryCenterX,BaryCenterY,BaryCenterZ\n1,400,5000,5000\n")
    with pytest.raises(CraftmeshError, match="none of its 1 pores .* units"):
        sizing_from(arguments_of(flags), IN_BOX, None)


@pytest.mark.parametrize(
    "row, words",
    [
        ("1,2,3", "line 2: has 3 cells; expected 4"),
        ("1,2,3,4\n1,2,-,4", "line 3: barycentery is '-'; expected a finite number"),
        ("0,1,2,3", "void 1 .*r > 0"),
    ],
)
def test_pores_without_numbers_are_refused(tmp_path, row, words):
    path = tmp_path / "pores.csv"
    path.write_text(f"EqDiameter,BaryCenterX,BaryCenterY,BaryCenterZ\n{row}\n")
    with pytest.raises(CraftmeshError, match=words):
        read_source_points(path)


def test_void_list_with_a_bad_radius_is_refused(tmp_path):
    path = tmp_path / "voids.csv"
    path.write_text("0,0.5,0.5,0.5,0.2\n1,0.1,0.2,0.3,-1\n")
    with pytest.raises(CraftmeshError, match="void 2 is .*r > 0"):
        read_source_points(path)
    path.write_text("id,x,y,z,r\n0,0.5,0.5,0.5,big\n")
    with pytest.raises(CraftmeshError, match="line 2: r is 'big'; expected a finite number"):
        read_source_points(path)


def test_published_void_list(shared_data):
    given = read_source_points(shared_data / "defects" / "craftmesher_VoidList.csv")
    assert len(given.points) == len(given.spheres) == 0
    points = points_around(given.in_box(IN_BOX.box), 0.1)
    assert len(points) > 250 * 12 and np.isfinite(points).all()


def write_field(path, lengths: np.ndarray, spacing: float, at_points: bool) -> None:
    from vtkmodules.vtkCommonDataModel import vtkImageData

    image = vtkImageData()
    image.SetDimensions(*(n + (not at_points) for n in lengths.shape))
    image.SetSpacing(*[spacing] * 3)
    image.SetOrigin(1.0, 0.0, 0.0)
    data = image.GetPointData() if at_points else image.GetCellData()
    vtk_objects.add_arrays(data, {"h": lengths.ravel(order="F")})
    vtk_objects.write_dataset(path, image, "ImageData")


@pytest.mark.parametrize("at_points", [True, False])
def test_field_on_an_image(tmp_path, at_points):
    lengths = 0.5 + np.arange(2 * 3 * 4).reshape(2, 3, 4)
    write_field(tmp_path / "h.vti", lengths, 2.0, at_points)
    field = LengthField(*read_length_field(tmp_path / "h.vti", "h"))
    place = np.moveaxis(np.indices(lengths.shape), 0, -1) * 2.0 + (1, 0, 0) + (0.0 if at_points else 1.0)
    assert np.allclose(field.at(place.reshape(-1, 3)), lengths.ravel(), rtol=1e-6)
    with pytest.raises(CraftmeshError, match="'size'"):
        read_length_field(tmp_path / "h.vti", "size")


@pytest.mark.parametrize("at_points", [True, False])
def test_field_on_a_surface(tmp_path, at_points):
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    points = np.array([[0.0, 0, 0], [3, 0, 0], [0, 3, 0], [3, 3, 0]])
    facets = np.array([[0, 1, 2], [1, 3, 2]])
    poly = vtkPolyData()
    poly.SetPoints(vtk_objects.vtk_points(points))
    poly.SetPolys(vtk_objects.uniform_cells(facets))
    places = points if at_points else points[facets].mean(axis=1)
    lengths = 1.0 + np.arange(len(places))
    data = poly.GetPointData() if at_points else poly.GetCellData()
    vtk_objects.add_arrays(data, {"length": lengths})
    vtk_objects.write_dataset(tmp_path / "h.vtp", poly, "PolyData")
    field = LengthField(*read_length_field(tmp_path / "h.vtp", "length"))
    assert np.allclose(field.at(places), lengths, rtol=1e-6)


@pytest.fixture(scope="module")
def voided():
    voxels = generate(GenerateOptions(shape=(20, 20, 20), grains=2, voids=1, void_radius=3.0, seed=2))
    return remesh(voxels, RemeshOptions())[0]


def test_flags_give_the_least_of_front_voids_points_and_field(tmp_path, voided):
    (tmp_path / "front.csv").write_text("x,y,z\n1,1,1\n")
    (tmp_path / "points.csv").write_text("x,y,z\n19,19,1\n")
    write_field(tmp_path / "h.vti", np.full((8, 8, 8), 2.25), 3.0, True)
    numbers = "--l-min 0.5 --l0 1 --l-max 3 --r0 2 --r1 4 --field-array h --around-voids --points"
    parsed = arguments_of(numbers, tmp_path / "points.csv", "--field", tmp_path / "h.vti")
    sizing = sizing_from(parsed, voided, tmp_path / "front.csv")
    void = voided.points[voided.facets[(voided.sides < 0).any(1)][0, 0]]
    assert np.allclose(sizing.at([[1, 1, 1], [19, 19, 1], void]), 0.5)
    far = np.array([[1.0, 19, 19], [10, 1, 19]])
    away = [np.linalg.norm(sizing.sources - p, axis=1).min() > 4 for p in far]
    assert any(away) and np.allclose(sizing.at(far[away]), 2.25)


def test_missing_files_are_named(tmp_path, voided):
    for flag in ("--points", "--field"):
        with pytest.raises(CraftmeshError, match="gone.csv"):
            sizing_from(arguments_of(flag, tmp_path / "gone.csv"), voided, None)
    (tmp_path / "a.stl").touch()
    with pytest.raises(CraftmeshError, match="suffix '.stl'"):
        sizing_from(arguments_of("--field", tmp_path / "a.stl"), voided, None)
