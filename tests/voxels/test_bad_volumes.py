"""Bad microstructure files end in one line that says what is wrong and what to do."""

import h5py
import numpy as np
import pytest
import tifffile
import vtk_objects

from craftmesh.errors import CraftmeshError
from craftmesh.io.npz import read_labels
from craftmesh.voxels.reading import ReadOptions, read_voxels


def refuse(path, words: str, options: ReadOptions = ReadOptions()):  # noqa: B008
    with pytest.raises(CraftmeshError, match=words) as caught:
        read_voxels(path, options)
    assert "\n" not in str(caught.value)
    assert path.name in str(caught.value)


def labels() -> np.ndarray:
    made = np.ones((3, 4, 5), np.int32)
    made[1:] = 2
    return made


def npz(tmp_path, **arrays):
    np.savez(tmp_path / "bad.npz", **{"labels": labels(), **arrays})
    return tmp_path / "bad.npz"


def test_missing_file(tmp_path):
    refuse(tmp_path / "none.npz", "no such file")


def test_unknown_suffix_names_the_formats(tmp_path):
    (tmp_path / "v.xyz").write_text("1 2 3")
    refuse(tmp_path / "v.xyz", "format.*npz, npy, dream3d, vti, labdct, tiff, tesr, metaimage, nrrd")


@pytest.mark.parametrize("suffix", [".ang", ".ctf", ".h5oina"])
def test_orientation_maps_point_to_segmentation(tmp_path, suffix):
    (tmp_path / f"v{suffix}").write_text("#")
    refuse(tmp_path / f"v{suffix}", "segment it first")


@pytest.mark.parametrize(
    "suffix, way",
    [
        (".stl", "craftmesh stitch"),
        (".inp", "library.md"),
        (".tess", "-format tesr"),
        (".vtk", r"\.vti"),
        (".am", r"\.nrrd"),
        (".raw", r"\.mhd"),
        (".xdmf", r"\.dream3d"),
        (".png", r"\.tif"),
        (".csv", r"\.npz"),
    ],
)
def test_files_without_grains_point_to_the_way_from_there(tmp_path, suffix, way):
    (tmp_path / f"v{suffix}").write_text("#")
    refuse(tmp_path / f"v{suffix}", way)


def test_orientation_maps_in_hdf5_point_to_segmentation(tmp_path):
    with h5py.File(tmp_path / "v.h5", "w") as file:
        file["1/EBSD/Data/Phase"] = np.ones(4)
    refuse(tmp_path / "v.h5", "segment it first")


def tesr(folder, **changed):
    """Return a .tesr of 2 x 2 x 2 voxels with some of its fields changed."""
    fields = {
        "**general": "3\n2 2 2\n1 1 1",
        "**cell": "2",
        "*id": "7 8",
        "*ori": "rodrigues\n0 0 0\n0 0 1",
        "**data": "ascii\n1 1 1 1 2 2 2 0",
    }
    fields |= {name: changed[name.strip("*")] for name in fields if name.strip("*") in changed}
    text = "".join(f" {name}\n{value}\n" for name, value in fields.items())
    (folder / "v.tesr").write_text(f"***tesr\n{text}***end\n")
    return folder / "v.tesr"


@pytest.mark.parametrize(
    "changed, words",
    [
        ({"general": "2\n2 2\n1 1"}, "expected 3, three numbers of voxels"),
        ({"data": "ascii\n1 1 1"}, "3 of 8"),
        ({"data": "ascii\n1 1 1 1 2 2 2 -1"}, "labels range from -1"),
        ({"data": "ascii\n1 1 1 1 2 2 2 2.0"}, "label 2.0 is not an integer"),
        ({"data": f"ascii\n1 1 1 1 2 2 2 {10**30}"}, "label 1000.* is not an integer"),
        ({"data": "ascii\n1 1 1 1 2 2 2 3"}, "labels range from 1 to 3"),
        ({"data": "binary9\n11111111"}, "binary8"),
        ({"data": "binary8\n*file gone.raw"}, "gone.raw is missing"),
        ({"id": "7"}, r"\*id has 1"),
        ({"id": "7 7"}, r"\*id has 2 numbers, 1 of them different"),
        ({"id": "7 7.5"}, r"\*id has 2 numbers, 1 of them different"),
        ({"ori": "euler-matthies\n0 0 0\n0 0 1"}, "-oridescriptor rodrigues"),
        ({"ori": "rodrigues:left\n0 0 0\n0 0 1"}, "known: rodrigues"),
        ({"ori": "rodrigues\n0 0 0"}, r"\*ori has 1 rows"),
        ({"ori": "rodrigues\n0 0 x\n0 0 1"}, "expected numbers"),
    ],
)
def test_broken_tesr(tmp_path, changed, words):
    assert read_voxels(tesr(tmp_path)).voxels.labels.max() == 8
    refuse(tesr(tmp_path, **changed), words)


def metaimage(folder, **changed):
    values = {
        "DimSize": "2 2 2",
        "ElementSpacing": "1 1 1",
        "ElementType": "MET_UCHAR",
        "TransformMatrix": "1 0 0 0 1 0 0 0 1",
    }
    values |= {"ElementDataFile": "LOCAL"} | changed
    values["ElementDataFile"] = values.pop("ElementDataFile")
    text = "".join(f"{key} = {value}\n" for key, value in values.items())
    (folder / "v.mha").write_bytes(text.encode() + bytes([1, 1, 1, 1, 2, 2, 2, 2]))
    return folder / "v.mha"


@pytest.mark.parametrize(
    "changed, words",
    [
        ({"DimSize": "2 2"}, "DimSize is 2 2"),
        ({"DimSize": "2 2 a"}, "DimSize is '2 2 a'"),
        ({"DimSize": "2 2 3"}, "needs 12 bytes, but the file has 8"),
        ({"ElementSpacing": "1 1"}, "ElementSpacing is '1 1'; write 3 numbers"),
        ({"ElementSpacing": "1 0 1"}, "expected finite numbers, and a spacing that is not 0"),
        ({"BinaryData": "False"}, "is damaged or incomplete"),
        ({"ElementType": "MET_OTHER"}, "MET_UCHAR"),
        ({"ElementNumberOfChannels": "3"}, "one label per voxel"),
        ({"ElementDataFile": "gone.raw"}, "gone.raw is missing"),
        ({"ElementDataFile": "LIST"}, "one .mha"),
        ({"CompressedData": "True"}, "cannot be unpacked"),
        ({"TransformMatrix": "0.8 0.6 0 -0.6 0.8 0 0 0 1"}, "axes are oblique"),
        ({"TransformMatrix": "1 0 0 1 0 0 0 0 1"}, "axes are oblique"),
    ],
)
def test_broken_metaimage(tmp_path, changed, words):
    np.testing.assert_array_equal(read_voxels(metaimage(tmp_path)).voxels.labels[1, 1], [1, 2])
    refuse(metaimage(tmp_path, **changed), words)


def test_nrrd_of_turned_axes_or_several_numbers(tmp_path):
    import nrrd

    path = tmp_path / "v.nrrd"
    header = {"space": "RAS", "space directions": [[1, 1, 0], [-1, 1, 0], [0, 0, 1]]}
    nrrd.write(str(path), labels(), header, index_order="F")
    refuse(path, "axes are oblique")
    nrrd.write(str(path), np.stack([labels()] * 2), {}, index_order="F")
    refuse(path, "4 axes")
    nrrd.write(str(path), labels(), {}, index_order="F")
    refuse(path, "set spacing")


@pytest.mark.parametrize(
    "name",
    [
        "v.npz",
        "v.npy",
        "v.dream3d",
        "v.h5",
        "v.vti",
        "v.tif",
        "v.tesr",
        "v.mha",
        "v.mhd",
        "v.nrrd",
        "v.nhdr",
    ],
)
def test_damaged_files(tmp_path, name):
    (tmp_path / name).write_bytes(b"not what the name says" * 20)
    refuse(tmp_path / name, "v\\.", ReadOptions(axes="xyz"))


@pytest.mark.parametrize("table", [["1", "cubic"], [["a", "cubic", ""]], [["1", "cubic"]], 7])
def test_broken_crystals_of_labels(tmp_path, table):
    path = npz(tmp_path, spacing=np.ones(3), origin=np.zeros(3), crystals=np.array(table))
    with pytest.raises(CraftmeshError, match="bad.npz: cannot read entry crystals .*rows of phase"):
        read_labels(path)


def test_truncated_npz(tmp_path):
    path = npz(tmp_path)
    path.write_bytes(path.read_bytes()[:-40])
    refuse(path, "not an .npz")


def test_wrong_dataset_lists_those_present(tmp_path):
    refuse(npz(tmp_path), "no dataset grains.*labels", ReadOptions(dataset="grains"))
    with h5py.File(tmp_path / "v.dream3d", "w") as file:
        image = file.create_group("DataContainers/Image")
        image["_SIMPL_GEOMETRY/DIMENSIONS"] = np.array([3, 4, 5])
        image["_SIMPL_GEOMETRY/SPACING"] = image["_SIMPL_GEOMETRY/ORIGIN"] = np.ones(3)
        image["CellData/Ids"] = labels().transpose(2, 1, 0)
        image["CellData/Parents"] = labels().transpose(2, 1, 0)
    refuse(
        tmp_path / "v.dream3d",
        "/DataContainers/Image/CellData/Ids, /DataContainers/Image/CellData/Parents",
        ReadOptions(dataset="/Ids"),
    )


def test_other_hdf5_files_list_their_groups(tmp_path):
    with h5py.File(tmp_path / "v.h5", "w") as file:
        file.create_group("Measurement")
    refuse(tmp_path / "v.h5", "Measurement.*LabDCT")


@pytest.mark.parametrize("place", ["LabDCT/Data", "LabDCT/Data/GrainId", "LabDCT/Data/GrainId/Group"])
@pytest.mark.parametrize("shape", [(), (2, 3), (2, 2, 2, 2)])
def test_labdct_without_ids_over_three_axes(tmp_path, place, shape):
    with h5py.File(tmp_path / "v.h5", "w") as file:
        file["LabDCT/Spacing"], file[place] = np.ones(3), np.ones(shape, int)
    refuse(tmp_path / "v.h5", "no /LabDCT/Data/GrainId of three axes")


def test_flat_and_empty_volumes(tmp_path):
    refuse(npz(tmp_path, labels=labels()[:, :1]), "3 x 1 x 5 voxels.*at least 2")
    refuse(npz(tmp_path, labels=labels()[:0]), "is empty")
    refuse(npz(tmp_path, labels=labels()[0]), r"shape \(4, 5\)")


def test_measured_slice_is_refused(shared_data):
    refuse(shared_data / "readers/ebsd_slice_nx_v8.dream3d", "201 x 101 x 1 voxels")


@pytest.mark.parametrize("spacing", [(1, 0, 1), (1, 1, -2), (np.nan, 1, 1)])
def test_spacing_has_to_be_positive(tmp_path, spacing):
    refuse(npz(tmp_path, spacing=np.array(spacing, float)), r"spacing(\[0\])? is .* (> 0|finite numbers)")
    with pytest.raises(CraftmeshError, match="spacing is .* > 0"):
        ReadOptions(spacing=spacing)


def test_spacing_and_axes_that_no_file_gives(tmp_path):
    np.save(tmp_path / "v.npy", labels())
    refuse(tmp_path / "v.npy", "set axes")
    refuse(tmp_path / "v.npy", "set spacing", ReadOptions(axes="xyz"))
    tifffile.imwrite(tmp_path / "v.tif", labels().astype(np.uint8), photometric="minisblack")
    refuse(tmp_path / "v.tif", "set spacing")


def test_labels_have_to_be_integers_of_32_bits(tmp_path):
    refuse(npz(tmp_path, labels=labels() + 0.5), "1.5 is not an integer")
    refuse(npz(tmp_path, labels=np.where(labels() == 1, np.nan, 1.0)), "nan is not an integer")
    refuse(npz(tmp_path, labels=labels().astype(np.int64) * 2_000_000_000), "4000000000.*int32")
    refuse(npz(tmp_path, labels=labels().astype("U3")), "type <U3")


def test_undeclared_negative_ids_and_absent_voids(tmp_path):
    refuse(npz(tmp_path, labels=labels() - 2), "label -1 is negative.*background_value")
    refuse(npz(tmp_path), "void label 8 does not occur", ReadOptions(void_labels=(8,)))


def test_grains_without_orientation_are_named_unless_ignored(tmp_path):
    quaternions = np.array([[np.nan] * 4, [1.0, 0, 0, 0], [np.nan] * 4])
    path = npz(tmp_path, orientations=quaternions)
    refuse(path, "grains 2;.*ignore_unknown_orientations")
    refuse(npz(tmp_path, orientations=quaternions[:1]), "grains 1, 2;")
    ignored = read_voxels(path, ReadOptions(ignore_unknown_orientations=True)).voxels.orientations
    assert np.isnan(ignored[2]).all()


def test_orientation_tables_of_other_meaning(tmp_path):
    refuse(npz(tmp_path, eulers=np.array([[0.0, 0, 0], [120, 30, 70], [1, 2, 3]])), "radians")
    refuse(npz(tmp_path, rodrigues=np.zeros((3, 4))), r"rodrigues has shape \(3, 4\)")
    tables = {"rodrigues": np.tile([0.0, 0, 1], (3, 1)), "eulers": np.zeros((3, 3))}
    refuse(npz(tmp_path, **tables), "rodrigues and eulers differ by 90")


def test_sparse_ids_with_orientations(tmp_path):
    refuse(npz(tmp_path, labels=labels() * 20_000_000, eulers=np.zeros((3, 3))), "renumber")


def test_slices_that_differ_and_folders_without_slices(tmp_path):
    refuse(tmp_path, "no .tif slices")
    for name, shape in (("a1.tif", (4, 5)), ("a2.tif", (4, 6))):
        tifffile.imwrite(tmp_path / name, np.ones(shape, np.uint8), photometric="minisblack")
    refuse(tmp_path, "slices differ", ReadOptions(spacing=(1, 1, 1)))


def test_labels_file_of_another_kind(tmp_path):
    np.savez(tmp_path / "v.npz", points=np.zeros((3, 3)))
    with pytest.raises(CraftmeshError, match="no entry labels"):
        read_labels(tmp_path / "v.npz")


@pytest.mark.parametrize(
    "at_points, at_cells, dataset, named",
    [
        ("FeatureIds", "", "", "FeatureIds"),
        ("scalars", "", "", "scalars"),
        ("labels", "quality", "", "labels"),
        ("ids", "labels", "ids", "ids"),
    ],
)
def test_labels_as_point_data_are_told_what_to_do(tmp_path, at_points, at_cells, dataset, named):
    from vtkmodules.vtkCommonDataModel import vtkImageData

    image = vtkImageData()
    image.SetDimensions(4, 5, 6)
    vtk_objects.add_arrays(image.GetPointData(), {at_points: np.ones(120, np.uint16)})
    if at_cells:
        vtk_objects.add_arrays(image.GetCellData(), {at_cells: np.ones(60, np.int32)})
    vtk_objects.write_dataset(tmp_path / "v.vti", image, "ImageData")
    way = f"{named} is point data.*points_to_cells.*Point Data to Cell Data"
    refuse(tmp_path / "v.vti", way, ReadOptions(dataset=dataset))
