"""VTK XML files come back as VTK's own readers give them, in every encoding; false ones are one line."""

import re

import numpy as np
import pytest
import vtk_objects
from vtkmodules import vtkIOXML
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPolyData, vtkUnstructuredGrid
from vtkmodules.vtkIOCore import vtkLZ4DataCompressor, vtkLZMADataCompressor, vtkZLibDataCompressor

from craftmesh.errors import CraftmeshError
from craftmesh.io import vtk_xml

POINTS = np.random.default_rng(3).random((40, 3))
TETS = np.array([[0, 1, 2, 3], [4, 5, 6, 7], [8, 9, 10, 11]])
ENCODINGS = ("Ascii", "Binary", "AppendedRaw", "AppendedBase64")
COMPRESSORS = (None, vtkZLibDataCompressor, vtkLZ4DataCompressor, vtkLZMADataCompressor)


def image():
    made = vtkImageData()
    made.SetExtent(1, 4, 0, 3, -2, 3)
    made.SetSpacing(0.5, 1, 2)
    made.SetOrigin(1, 2, 3)
    vtk_objects.add_arrays(made.GetCellData(), {"labels": np.arange(45, dtype=np.int32) // 7})
    vtk_objects.add_arrays(made.GetCellData(), {"eulers": np.linspace(0, 1, 135).reshape(45, 3)})
    vtk_objects.add_arrays(made.GetPointData(), {"kind": np.arange(96, dtype=np.uint8)})
    vtk_objects.add_arrays(made.GetFieldData(), {"table": np.arange(12, dtype=np.uint64).reshape(3, 4)})
    return made


def poly():
    made = vtkPolyData()
    made.SetPoints(vtk_objects.vtk_points(POINTS))
    made.SetLines(vtk_objects.cell_array(np.arange(7), np.array([0, 3, 7])))
    made.SetPolys(vtk_objects.cell_array(np.arange(10), np.array([0, 3, 6, 10])))
    vtk_objects.add_arrays(made.GetCellData(), {"sides": np.arange(10, dtype=np.int16).reshape(5, 2)})
    return made


def grid():
    made = vtkUnstructuredGrid()
    made.SetPoints(vtk_objects.vtk_points(POINTS))
    made.SetCells(10, vtk_objects.uniform_cells(TETS))
    vtk_objects.add_arrays(made.GetPointData(), {"height": POINTS[:, 2].astype(np.float32)})
    return made


DATASETS = {"ImageData": image, "PolyData": poly, "UnstructuredGrid": grid}


def write(path, kind, encoding="AppendedRaw", compressor=None, word="UInt64", big=False, block=64):
    writer = getattr(vtkIOXML, f"vtkXML{kind}Writer")()
    mode = encoding.removesuffix("Raw").removesuffix("Base64")
    getattr(writer, f"SetDataModeTo{mode}")()
    writer.SetEncodeAppendedData(encoding == "AppendedBase64")
    writer.SetCompressor(compressor and compressor())
    writer.SetBlockSize(block)
    getattr(writer, f"SetHeaderTypeTo{word}")()
    writer.SetByteOrder(0 if big else 1)
    writer.SetInputData(DATASETS[kind]())
    writer.SetFileName(str(path))
    assert writer.Write()
    return path


def arrays_of(dataset) -> dict[str, np.ndarray]:
    """Return all that a data set holds, by name."""
    found = {}
    for where in ("PointData", "CellData", "FieldData"):
        data = getattr(dataset, f"Get{where}")()
        for k in range(data.GetNumberOfArrays()):
            found[f"{where}/{data.GetArrayName(k)}"] = vtk_to_numpy(data.GetArray(k))
    if dataset.IsA("vtkImageData"):
        place = (dataset.GetExtent(), dataset.GetSpacing(), dataset.GetOrigin())
        return found | {"place": np.concatenate(place)}
    for name in ("Lines", "Polys") if dataset.IsA("vtkPolyData") else ("Cells",):
        cells = getattr(dataset, f"Get{name}")()
        found[name] = np.concatenate(
            [*map(vtk_to_numpy, (cells.GetConnectivityArray(), cells.GetOffsetsArray()))]
        )
    if dataset.IsA("vtkUnstructuredGrid"):
        found["types"] = vtk_to_numpy(dataset.GetCellTypes())
    return found | {"points": vtk_to_numpy(dataset.GetPoints().GetData())}


def arrays_read(path, kind) -> dict[str, np.ndarray]:
    """Return all that craftmesh reads of a file, by the names of arrays_of."""
    data = vtk_xml.read_dataset(path, kind)
    parts = {"PointData": data.at_points, "CellData": data.at_cells, "FieldData": data.others}
    found = {
        f"{where}/{name}": values for where, arrays in parts.items() for name, values in arrays.items()
    }
    if data.place:
        return found | {
            "place": np.concatenate([data.place[key] for key in ("extent", "spacing", "origin")])
        }
    for name in ("Lines", "Polys") if kind == "PolyData" else ("Cells",):
        found[name] = np.concatenate(data.cells[name])
    return found | {"points": data.points} | ({"types": data.types} if kind == "UnstructuredGrid" else {})


@pytest.mark.parametrize("compressor", COMPRESSORS)
@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("kind", DATASETS)
def test_every_encoding_is_read_as_by_vtk(tmp_path, kind, encoding, compressor):
    for word, big, block in (("UInt32", False, 64), ("UInt64", True, 1 << 15)):
        path = write(tmp_path / "v", kind, encoding, compressor, word, big, block)
        reader = getattr(vtkIOXML, f"vtkXML{kind}Reader")()
        reader.SetFileName(str(path))
        reader.Update()
        due, found = arrays_of(reader.GetOutput()), arrays_read(path, kind)
        assert due.keys() == found.keys()
        for name, values in due.items():
            assert (values.dtype, values.shape) == (found[name].dtype, found[name].shape), name
            np.testing.assert_array_equal(values, found[name], name)


# 48 labels, 1 to 3, that VTK 9.7 wrote as two blocks packed by LZ4.
OF_VTK = """<VTKFile type="ImageData" byte_order="LittleEndian" header_type="UInt32"
 compressor="vtkLZ4DataCompressor"><ImageData WholeExtent="0 4 0 4 0 3"><Piece Extent="0 4 0 4 0 3">
<CellData><DataArray type="Int32" Name="labels" format="binary">
AgAAAIAAAABAAAAAEwAAAA4AAAA=TwEAAAAEACkfAgQAJ1AAAgAAAE8DAAAABAAkUAADAAAA
</DataArray></CellData></Piece></ImageData></VTKFile>"""


def test_blocks_of_lz4_are_read_without_vtk_and_broken_ones_are_one_line(tmp_path):
    path = tmp_path / "labels.vti"
    path.write_text(OF_VTK)
    labels = vtk_xml.read_dataset(path, "ImageData").at_cells["labels"]
    np.testing.assert_array_equal(labels, np.arange(48) // 16 + 1)
    path.write_text(OF_VTK.replace("TwEAAAAE", "TwEA////"))
    with pytest.raises(CraftmeshError, match="labels.vti: its data cannot be unpacked") as broken:
        vtk_xml.read_dataset(path, "ImageData")
    assert "\n" not in str(broken.value)


HUGE = "4000000000000"
FALSE_HEADS = [
    ("ImageData", 'Extent="1 4 0 3 -2 3"', 'Extent="1 4001 0 3000 -2 3000"'),
    ("ImageData", 'Extent="1 4 0 3 -2 3"', 'Extent="1 2000000000 0 2000000000 -2 2000000000"'),
    ("ImageData", 'Extent="1 4 0 3 -2 3"', 'Extent="1 0 0 3 -2 3"'),
    ("ImageData", 'Extent="1 4 0 3 -2 3"', 'Extent="1 4 0 3"'),
    ("ImageData", ' Extent="1 4 0 3 -2 3"', ' Extent="1 4 0 3 -2 2"'),
    ("ImageData", 'Spacing="0.5 1 2"', 'Spacing="0.5 1"'),
    ("ImageData", 'NumberOfTuples="3"', f'NumberOfTuples="{HUGE}"'),
    ("ImageData", 'NumberOfComponents="3"', f'NumberOfComponents="{HUGE}"'),
    ("ImageData", 'NumberOfComponents="3"', 'NumberOfComponents="0"'),
    ("ImageData", 'offset="0"', f'offset="{HUGE}"'),
    ("ImageData", 'offset="0"', 'offset="-1"'),
    ("PolyData", 'NumberOfPoints="40"', f'NumberOfPoints="{HUGE}"'),
    ("PolyData", 'NumberOfPoints="40"', 'NumberOfPoints="-40"'),
    ("PolyData", 'NumberOfPolys="3"', f'NumberOfPolys="{HUGE}"'),
    ("PolyData", 'NumberOfPolys="3"', 'NumberOfPolys="-3"'),
    ("PolyData", 'NumberOfLines="2"', 'NumberOfLines="1"'),
    ("UnstructuredGrid", 'NumberOfCells="3"', f'NumberOfCells="{HUGE}"'),
    ("UnstructuredGrid", 'NumberOfCells="3"', 'NumberOfCells="4"'),
    ("UnstructuredGrid", 'NumberOfPoints="40"', f'NumberOfPoints="{HUGE}"'),
    ("UnstructuredGrid", "<Piece", "<Piece/><Piece"),
]


@pytest.mark.parametrize("compressor", [None, vtkZLibDataCompressor])
@pytest.mark.parametrize("kind, true, false", FALSE_HEADS)
def test_false_heads_are_one_line(tmp_path, kind, true, false, compressor):
    path = write(tmp_path / "v.vtk", kind, compressor=compressor)
    content = path.read_bytes()
    assert true.encode() in content
    path.write_bytes(content.replace(true.encode(), false.encode()))
    refused(path, kind)


@pytest.mark.parametrize(
    "kind, array, values",
    [
        ("PolyData", "connectivity", "0 1 2 3 4 5 6 7 8 40"),
        ("PolyData", "connectivity", "0 1 2 3 4 5 6 7 8 -1"),
        ("PolyData", "connectivity", "0 1 2"),
        ("PolyData", "offsets", "3 6 " + HUGE),
        ("PolyData", "offsets", "6 3 10"),
        ("PolyData", "offsets", "-3 3 10"),
        ("UnstructuredGrid", "connectivity", "0 1 2 3 4 5 6 7 8 9 10 " + HUGE),
        ("UnstructuredGrid", "offsets", "4 8 11"),
        ("UnstructuredGrid", "types", "10 10"),
        ("UnstructuredGrid", "types", "10 24 10"),
    ],
)
def test_cells_that_cannot_be_are_one_line(tmp_path, kind, array, values):
    path = write(tmp_path / "v.vtk", kind, "Ascii")
    found = list(re.finditer(rf'Name="{array}"[^>]*>([^<]*)', path.read_text()))[-1]
    text = path.read_text()
    path.write_text(text[: found.start(1)] + values + text[found.end(1) :])
    refused(path, kind)


@pytest.mark.parametrize("encoding", ["Binary", "AppendedRaw"])
@pytest.mark.parametrize("kind", DATASETS)
def test_bytes_that_are_changed_anywhere_give_arrays_or_one_line(tmp_path, kind, encoding):
    path = write(tmp_path / "v.vtk", kind, encoding, vtkZLibDataCompressor)
    content, random = path.read_bytes(), np.random.default_rng(5)
    for _ in range(60):
        changed = bytearray(content[: random.integers(len(content) // 2, len(content))])
        for at in random.integers(0, len(changed), 3):
            changed[at] = random.integers(256)
        path.write_bytes(changed)
        try:
            arrays_read(path, kind)
        except CraftmeshError as error:
            assert str(path) in str(error) and "\n" not in str(error)


def refused(path, kind):
    with pytest.raises(CraftmeshError) as caught:
        vtk_xml.read_dataset(path, kind)
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)
