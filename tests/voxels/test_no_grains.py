"""Volumes that hold no grains, or hold them in another way: one row a format and fault.

Each is refused in one line that says what the array is and what to do, or read as its program meant it.
"""

import json

import h5py
import numpy as np
import pytest
import tifffile
import vtk_objects

from craftmesh.errors import CraftmeshError
from craftmesh.voxels.reading import ReadOptions, read_voxels

SHAPE = (9, 10, 11)
RANDOM = np.random.default_rng(0)
GRAINS = 1 + (np.indices(SHAPE)[0] > 4) + 2 * (np.indices(SHAPE)[1] > 4) + 4 * (np.indices(SHAPE)[2] > 4)
NUMBERS = np.arange(GRAINS.size).reshape(SHAPE)
SCAN = np.clip(40 * (GRAINS % 3) + RANDOM.normal(90, 4, SHAPE), 0, 255).astype(np.int64)
PLACE = ReadOptions(spacing=(1.0, 1.0, 1.0))


def flat(values):
    return values.ravel(order="F")


def npz(folder, values, name="labels"):
    np.savez(folder / "v.npz", **{name: values, "spacing": np.ones(3)})
    return folder / "v.npz"


def npy(folder, values, name=""):
    np.save(folder / "v.npy", values.transpose(2, 1, 0))
    return folder / "v.npy"


def dream3d(folder, values, name="FeatureIds"):
    with h5py.File(folder / "v.dream3d", "w") as file:
        image = file.create_group("DataContainers/Image")
        place = image.create_group("_SIMPL_GEOMETRY")
        place["DIMENSIONS"], place["SPACING"] = np.array(SHAPE), np.ones(3, "f4")
        image[f"CellData/{name}"] = values.transpose(2, 1, 0)[..., None]
    return folder / "v.dream3d"


def labdct(folder, values, name="GrainId"):
    with h5py.File(folder / "v.h5", "w") as file:
        file["LabDCT/Spacing"] = np.ones(3)
        file["LabDCT/Data/GrainId"] = values.transpose(2, 1, 0)
    return folder / "v.h5"


def vti(folder, values, name="labels"):
    from vtkmodules.vtkCommonDataModel import vtkImageData

    image = vtkImageData()
    image.SetDimensions(*(n + 1 for n in SHAPE))
    vtk_objects.add_arrays(image.GetCellData(), {name: flat(values)})
    vtk_objects.write_dataset(folder / "v.vti", image, "ImageData")
    return folder / "v.vti"


def tif(folder, values, name="", **how):
    dtype = np.float32 if values.dtype.kind == "f" else np.int32 if values.min() < 0 else np.uint16
    pages = values.transpose(2, 1, 0).astype(how.pop("dtype", dtype))
    tifffile.imwrite(folder / "v.tif", pages, **{"photometric": "minisblack", **how})
    return folder / "v.tif"


def mha(folder, values, name=""):
    kind = "MET_DOUBLE" if values.dtype.kind == "f" else "MET_LONG_LONG"
    sizes = " ".join(map(str, SHAPE))
    head = f"NDims = 3\nDimSize = {sizes}\nElementType = {kind}\nElementSpacing = 1 1 1\n"
    (folder / "v.mha").write_bytes(f"{head}ElementDataFile = LOCAL\n".encode() + flat(values).tobytes())
    return folder / "v.mha"


def nrrd(folder, values, name=""):
    import nrrd as library

    library.write(str(folder / "v.nrrd"), values, {"spacings": [1.0, 1.0, 1.0]}, index_order="F")
    return folder / "v.nrrd"


def tesr(folder, values, name=""):
    sizes, cells = " ".join(map(str, SHAPE)), " ".join(map(str, flat(values)))
    head = f"***tesr\n **format\n 2.2\n **general\n 3\n {sizes}\n 1 1 1\n **data\n ascii\n"
    (folder / "v.tesr").write_text(f"{head}{cells}\n***end\n")
    return folder / "v.tesr"


NAMED = {npz: "labels", vti: "labels", dream3d: "CellData/FeatureIds", labdct: "GrainId"}
FORMATS = [npz, npy, vti, dream3d, labdct, tif, mha, nrrd, tesr]
FAULTS = {
    "voxel numbers": (NUMBERS, "989 labels in 990 .*0 % .*voxel numbers; .*set dataset"),
    "voxel numbers from 1": (NUMBERS + 1, "voxel numbers"),
    "columns": (NUMBERS // SHAPE[2], "89 labels in 990"),
    "grey values": (SCAN, "labels in 990 voxels, but only .* % of neighbours have .*grey values.*segment"),
    "grey values of 16 bits": (SCAN * 200 + RANDOM.integers(0, 200, SHAPE), "voxel numbers|grey"),
    "grey values in a mask": (np.where(GRAINS == 1, SCAN, 0), "grey values"),
    "negative grey values": (SCAN - 300, "grey values"),
    "fractions": (SCAN / 7, "is not an integer grain id; .*segment"),
    "negative ids": (np.where(GRAINS == 3, -9, GRAINS), "label -9 is negative; .*numpy.abs"),
    "negative ids, both signs": (np.where(GRAINS == 3, -1, GRAINS), "negative; .*numpy.unique"),
    "several negative ids": (np.where(GRAINS > 6, -10 * GRAINS, GRAINS), "labels -80, -70 are negative"),
}


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("write", FORMATS, ids=lambda write: write.__name__)
def test_what_is_no_grain_is_refused_by_what_it_is(tmp_path, write, fault):
    values, words = FAULTS[fault]
    if write is tesr and values.min() < 0:
        words = "-80|labels range|negative|grey values"
    if fault == "fractions":
        words = {tesr: "is not an integer", labdct: "add a dataset such as"}.get(write, words)
    path = write(tmp_path, values)
    options = ReadOptions(axes="zyx", spacing=(1.0, 1.0, 1.0)) if write is npy else PLACE
    with pytest.raises(CraftmeshError, match=words) as caught:
        read_voxels(path, options)
    line = str(caught.value)
    assert "\n" not in line and path.name in line
    if "of neighbours have" in line:
        assert NAMED.get(write, "the volume") in line


def noisy(share):
    values = GRAINS.copy()
    hit = RANDOM.random(SHAPE) < share
    values[hit] = RANDOM.integers(20, 500, int(hit.sum()))
    return values


CLEAN = {
    "grains": GRAINS,
    "one-voxel grains": np.where(NUMBERS % 40 == 7, 100 + NUMBERS, GRAINS),
    "a fifth of all voxels is noise": noisy(0.2),
    "slabs of one voxel": 1 + np.indices(SHAPE)[2],
    "grains of 27 voxels": 1 + np.ravel_multi_index(tuple(i // 3 for i in np.indices(SHAPE)), (3, 4, 4)),
    "one-voxel particles in 0": np.where(NUMBERS % 3 == 1, 1 + NUMBERS, 0) * (np.indices(SHAPE).sum(0) % 2),
    "two phases, finely mixed": 1 + np.indices(SHAPE).sum(axis=0) % 2,
}


@pytest.mark.parametrize("kind", CLEAN)
def test_labels_that_are_rough_are_read(tmp_path, kind):
    """One noisy voxel in five leaves 0.64 of the neighbours inside a grain alike."""
    volume = read_voxels(npz(tmp_path, CLEAN[kind]), ReadOptions(background="void"))
    assert volume.voxels.labels.shape == SHAPE


def test_public_volumes_are_read(shared_data):
    files = [
        "al1050/al1050_labdct_109x103x64.npz",
        "al1050/lab_dct_Al1050.h5",
        "readers/damask_20grains.vti",
    ]
    for name in [*files, "al6xn/prisms_al6xn_68x64x46.npz", "readers/copper_v7.dream3d"]:
        assert read_voxels(shared_data / name).voxels.labels.size


def test_the_confidence_map_beside_public_grains_is_refused(shared_data):
    path = shared_data / "al1050/al1050_labdct_109x103x64.npz"
    with pytest.raises(CraftmeshError, match="array completeness_u8 has 170 labels"):
        read_voxels(path, ReadOptions(dataset="completeness_u8"))


FOREIGN = {
    "v.mat": "MATLAB.*scipy.io.loadmat.*h5py.*npz with labels",
    "v.vtk": "legacy VTK; save an image as .vti.*pyvista.read",
    "v.json": "Kanapy.*numpy.reshape.*npz.*labels and spacing",
    "v.nii": "nrrd",
    "v.am": "nrrd",
    "v.raw": "has no header; write a .mhd",
    "v.ctf": "without grain ids",
}


@pytest.mark.parametrize("name", FOREIGN)
def test_foreign_formats_say_the_way(tmp_path, name):
    if name == "v.mat":
        with h5py.File(tmp_path / name, "w") as file:
            file["grainId"] = GRAINS
    else:
        shape = {"Shape": SHAPE, "Order": "C", "Values": GRAINS.ravel().tolist()}
        (tmp_path / name).write_text(json.dumps({"Model": {"Size": [9, 10, 11]}, "Data": shape}))
    with pytest.raises(CraftmeshError, match=FOREIGN[name]) as caught:
        read_voxels(tmp_path / name)
    assert "\n" not in str(caught.value)


def ome(folder, lengths, channels=1, times=1, unit="mm"):
    """Write what OME calls XYZCT: all slices of a channel, one channel after the other."""
    sizes = {"SizeX": SHAPE[0], "SizeY": SHAPE[1], "SizeZ": SHAPE[2], "SizeC": channels, "SizeT": times}
    sizes |= {f"PhysicalSize{axis}": length for axis, length in lengths.items()}
    sizes |= {f"PhysicalSize{axis}Unit": unit for axis in lengths if unit}
    text = " ".join(f'{key}="{value}"' for key, value in sizes.items())
    space = "http://www.openmicroscopy.org/Schemas/OME/2016-06"
    head = f'<?xml version="1.0"?><OME xmlns="{space}"><Image><Pixels Type="uint16" {text}/></Image></OME>'
    return tif(folder, np.concatenate([GRAINS] * channels * times, axis=2), description=head, metadata=None)


def imagej(folder, resolution=(2.0, 4.0), **metadata):
    return tif(folder, GRAINS, imagej=True, resolution=resolution, metadata={"axes": "ZYX", **metadata})


LENGTHS = {"X": 0.5, "Y": 0.25, "Z": 2.0}
TIFF_SPACINGS = [
    (imagej, {"spacing": 2.0, "unit": "um"}, "um"),
    (imagej, {"spacing": 2.0, "unit": r"\u00B5m"}, "µm"),
    (imagej, {"spacing": 2.0}, "an unknown unit"),
    (ome, {"lengths": LENGTHS}, "mm"),
    (ome, {"lengths": LENGTHS, "unit": ""}, "µm"),
    (ome, {"lengths": LENGTHS, "times": 1}, "mm"),
]


@pytest.mark.parametrize("write, how, unit", TIFF_SPACINGS)
def test_spacing_of_a_tiff_is_what_its_program_wrote(tmp_path, write, how, unit):
    raw = read_voxels(write(tmp_path, **how))
    np.testing.assert_allclose(raw.voxels.spacing, [0.5, 0.25, 2.0], rtol=1e-6)  # rationals in the file
    np.testing.assert_array_equal(raw.voxels.labels, GRAINS)
    assert any(f"lengths are in {unit}, spacing [0.5, 0.25, 2.0]" in note for note in raw.notes)


def test_imagej_leaves_out_a_depth_of_1(tmp_path):
    raw = read_voxels(imagej(tmp_path, unit="mm"))
    np.testing.assert_allclose(raw.voxels.spacing, [0.5, 0.25, 1.0], rtol=1e-6)


def test_a_spacing_that_is_given_holds(tmp_path):
    raw = read_voxels(imagej(tmp_path, spacing=2.0, unit="um"), ReadOptions(spacing=(3.0, 3.0, 3.0)))
    assert raw.voxels.spacing.tolist() == [3, 3, 3]


TIFF_FAULTS = [
    (imagej, {}, "no voxel spacing"),
    (imagej, {"unit": "pixel"}, "no voxel spacing"),
    (imagej, {"spacing": 2.0, "unit": "um", "zunit": "mm"}, "no voxel spacing"),
    (imagej, {"spacing": -2.0, "unit": "um"}, "no voxel spacing"),
    (ome, {"lengths": {"X": 0.5, "Y": 0.5}}, "no voxel spacing"),
    (ome, {"lengths": LENGTHS, "channels": 2}, "has 2 channels.*save only the channel of the labels"),
    (ome, {"lengths": LENGTHS, "times": 3}, "1 channels, 3 times, 11 slices"),
]


@pytest.mark.parametrize("write, how, words", TIFF_FAULTS)
def test_what_a_tiff_does_not_say_is_asked_for(tmp_path, write, how, words):
    with pytest.raises(CraftmeshError, match=words):
        read_voxels(write(tmp_path, **how))


@pytest.mark.parametrize("axes", ["ZCYX", "CYX", "TZYX", "TZCYX"])
def test_channels_of_imagej_are_refused(tmp_path, axes):
    pages = np.zeros(
        {"ZCYX": (4, 2, 5, 6), "CYX": (4, 5, 6), "TZYX": (2, 4, 5, 6)}.get(axes, (2, 3, 2, 5, 6))
    )
    tifffile.imwrite(tmp_path / "v.tif", pages.astype(np.uint8), imagej=True, metadata={"axes": axes})
    with pytest.raises(CraftmeshError, match="channels, . times.*save only the channel"):
        read_voxels(tmp_path / "v.tif", PLACE)


def vtr(folder, planes, values=GRAINS):
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkRectilinearGrid

    grid = vtkRectilinearGrid()
    grid.SetDimensions(*map(len, planes))
    for name, at in zip("XYZ", planes):
        getattr(grid, f"Set{name}Coordinates")(numpy_to_vtk(np.asarray(at, float), deep=True))
    vtk_objects.add_arrays(grid.GetCellData(), {"GrainID": flat(values)})
    vtk_objects.write_dataset(folder / "v.vtr", grid, "RectilinearGrid")
    return folder / "v.vtr"


def planes_of(*lengths):
    return [k + np.arange(n + 1) * length for k, (n, length) in enumerate(zip(SHAPE, lengths))]


def test_an_even_rectilinear_grid_is_an_image(tmp_path):
    raw = read_voxels(vtr(tmp_path, planes_of(0.5, 0.25, 2.0)))
    np.testing.assert_array_equal(raw.voxels.labels, GRAINS)
    np.testing.assert_allclose(raw.voxels.spacing, [0.5, 0.25, 2.0])
    np.testing.assert_allclose(raw.voxels.origin, [0, 1, 2])


def test_uneven_and_false_rectilinear_grids(tmp_path):
    planes = planes_of(1.0, 1.0, 1.0)
    planes[1] = planes[1] ** 1.2
    with pytest.raises(CraftmeshError, match="sizes along y range from 1.* to 1.*resample .* .vti"):
        read_voxels(vtr(tmp_path, planes))
    planes[1] = planes_of(1.0, 1.0, 1.0)[1] * [1] * 11
    path = vtr(tmp_path, planes)
    text = path.read_bytes().replace(b'Extent="0 9 0 10 0 11"', b'Extent="0 9 0 11 0 10"')
    path.write_bytes(text)
    with pytest.raises(CraftmeshError, match="is not an intact VTK XML RectilinearGrid"):
        read_voxels(path)
    path.write_bytes(b"<VTKFile type='RectilinearGrid'>")
    with pytest.raises(CraftmeshError, match="not an intact"):
        read_voxels(path)
