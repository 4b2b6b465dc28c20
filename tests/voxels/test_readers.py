"""Every format is written by the test itself and read back: shape, axes, spacing, ids, orientations."""

import gzip
import sys
import zlib

import h5py
import numpy as np
import pytest
import tifffile

from craftmesh.io import vtk
from craftmesh.io.behind import files_behind
from craftmesh.io.file_volume import of_space_group
from craftmesh.io.npz import read_labels, write_labels
from craftmesh.mechanics.orientation import (
    angle_between,
    bunge_to_quaternion,
    random_orientations,
)
from craftmesh.types import Crystal, Voxels
from craftmesh.voxels.clean import CleanOptions, clean
from craftmesh.voxels.reading import ReadOptions, read_voxels

SHAPE = (4, 5, 7)
MARKER = (1, 3, 5)
SPACING = (0.5, 0.25, 2.0)
ORIGIN = (-1.0, 2.0, 3.5)
FIRST = (-0.75, 2.125, 4.5)  # the centre of the first voxel
ANGLES = np.array([[0.0, 0.0, 0.0], [0.3, 0.7, 1.1], [2.0, 1.0, 4.0], [5.0, 2.5, 0.2]])


def volume(dtype=np.int32) -> np.ndarray:
    labels = np.ones(SHAPE, dtype)
    labels[2:] = 2
    labels[MARKER] = 3
    return labels


def write_npz(folder):
    np.savez(folder / "v.npz", labels=volume(), spacing=SPACING, origin=ORIGIN, eulers=ANGLES)
    return folder / "v.npz", ReadOptions()


def write_npy(folder):
    np.save(folder / "v.npy", volume().transpose(2, 1, 0))
    return folder / "v.npy", ReadOptions(axes="zyx", spacing=SPACING, origin=ORIGIN)


def write_simpl(folder):
    with h5py.File(folder / "v.dream3d", "w") as file:
        image = file.create_group("DataContainers/Image")
        image["_SIMPL_GEOMETRY/DIMENSIONS"] = np.array(SHAPE, np.int64)
        image["_SIMPL_GEOMETRY/SPACING"] = np.array(SPACING, np.float32)
        image["_SIMPL_GEOMETRY/ORIGIN"] = np.array(ORIGIN, np.float32)
        image["CellData/Phases"] = np.ones((*SHAPE[::-1], 1), np.int32)
        image["CellData/FeatureIds"] = volume().transpose(2, 1, 0)[..., None]
        image["CellFeatureData/AvgEulerAngles"] = ANGLES.astype(np.float32)
        image["CellFeatureData/Phases"] = np.array([[0], [1], [1], [2]], np.int32)
        image["CellEnsembleData/CrystalStructures"] = np.array([[999], [1], [0]], np.uint32)
        image["CellEnsembleData/PhaseName"] = ["Unknown Phase Type", "Iron", "Titanium"]
    return folder / "v.dream3d", ReadOptions()


def write_simplnx(folder):
    with h5py.File(folder / "v.dream3d", "w") as file:
        image = file.create_group("DataStructure/Group/Any Name")
        image.attrs.update(
            {"ObjectType": np.bytes_(b"ImageGeom"), "_DIMENSIONS": np.array(SHAPE, np.uint64)}
        )
        image.attrs.update({"_SPACING": np.array(SPACING, "f4"), "_ORIGIN": np.array(ORIGIN, "f4")})
        image["Cells/FeatureIds"] = volume().transpose(2, 1, 0)[..., None]
        image["Cells/EulerAngles"] = ANGLES[volume().transpose(2, 1, 0)].astype(np.float32)
    return folder / "v.dream3d", ReadOptions()


def write_version_4(folder):
    """DREAM.3D 4: no geometry beside the cells, and every array flat, x fastest."""
    with h5py.File(folder / "v.dream3d", "w") as file:
        image = file.create_group("VoxelDataContainer")
        image["DIMENSIONS"] = np.array(SHAPE, np.int64)
        image["SPACING"] = np.array(SPACING, np.float32)
        image["ORIGIN"] = np.array(ORIGIN, np.float32)
        image["CELL_DATA/GrainIds"] = volume().ravel(order="F")
        image["CELL_DATA/Phases"] = np.ones(volume().size, np.int32)
        image["CELL_DATA/EulerAngles"] = ANGLES[volume().ravel(order="F")].astype(np.float32)
        image["FIELD_DATA/Phases"] = np.array([0, 1, 1, 2], np.int32)
    return folder / "v.dream3d", ReadOptions()


def write_version_5(folder):
    with h5py.File(folder / "v.h5", "w") as file:
        image = file.create_group("VoxelDataContainer")
        image["DIMENSIONS"] = np.array(SHAPE, np.int64)
        image["SPACING"] = np.array(SPACING, np.float32)
        image["ORIGIN"] = np.array(ORIGIN, np.float32)
        image["CellData/GrainIds"] = volume().ravel(order="F")[:, None]
        image["CellData/Phases"] = np.ones((volume().size, 1), np.int32)
        image["CellFeatureData/AvgEulerAngles"] = ANGLES.astype(np.float32)
    return folder / "v.h5", ReadOptions(dataset="/VoxelDataContainer/CellData/GrainIds")


def tesr_text(data: str, orientations: str = "") -> str:
    sizes, lengths, origin = (" ".join(map(str, values)) for values in (SHAPE, SPACING, ORIGIN))
    return (
        f"***tesr\n **format\n   2.1\n **general\n   3\n   {sizes}\n   {lengths}\n  *origin\n   {origin}\n"
        f" **cell\n   3\n{orientations}  *crysym\n   cubic\n **data\n   {data}"
    )


def rows_of(table: np.ndarray) -> str:
    return "\n".join(" ".join(map(repr, row)) for row in table.tolist())


def write_tesr(folder):
    w, *xyz = np.moveaxis(bunge_to_quaternion(ANGLES[1:]), -1, 0)
    rodrigues = np.stack(xyz, axis=-1) / w[:, None]
    orientations = f"  *ori\n   rodrigues:passive\n{rows_of(-rodrigues)}\n"
    labels = " ".join(map(str, volume().ravel(order="F")))
    (folder / "v.tesr").write_text(tesr_text(f"ascii\n{labels}\n***end\n", orientations))
    return folder / "v.tesr", ReadOptions()


def write_tesr_binary(folder):
    """Cells go by their ids: here the file counts them the other way round."""
    orientations = f"  *id\n   3 2 1\n  *ori\n   euler-bunge\n{rows_of(np.degrees(ANGLES[3:0:-1]))}\n"
    labels = (4 - volume()).astype(">i2").ravel(order="F").tobytes()
    text = tesr_text("binary16_big\n", orientations).encode()
    (folder / "v.tesr").write_bytes(text + labels + b"\n***end\n")
    return folder / "v.tesr", ReadOptions()


def write_tesr_beside(folder):
    (folder / "v.raw").write_bytes(volume(np.uint8).ravel(order="F").tobytes())
    (folder / "v.tesr").write_text(tesr_text("binary8\n  *file v.raw\n***end\n"))
    return folder / "v.tesr", ReadOptions()


def mha_header(kind: str, file: str = "LOCAL", **others) -> bytes:
    values = {"NDims": 3, "BinaryData": True, "ElementSpacing": SPACING, "Offset": FIRST} | others
    values |= {"DimSize": SHAPE, "ElementType": kind, "ElementDataFile": file}
    texts = {key: " ".join(map(str, v)) if isinstance(v, tuple) else v for key, v in values.items()}
    return "".join(f"{key} = {text}\n" for key, text in texts.items()).encode()


def write_mha(folder):
    data = zlib.compress(volume(np.uint16).ravel(order="F").tobytes())
    header = mha_header("MET_USHORT", CompressedData=True, CompressedDataSize=len(data))
    (folder / "v.mha").write_bytes(header + data)
    return folder / "v.mha", ReadOptions()


def write_mhd(folder):
    """The file's first axis is y, run backwards."""
    turned = volume(np.dtype(">i8")).transpose(1, 0, 2)[::-1]
    values = {"DimSize": turned.shape, "ElementSpacing": (SPACING[1], SPACING[0], SPACING[2])}
    values |= {"Offset": (FIRST[0], FIRST[1] + 4 * SPACING[1], FIRST[2]), "BinaryDataByteOrderMSB": True}
    header = mha_header("MET_LONG_LONG", "v.raw", TransformMatrix=(0, -1, 0, 1, 0, 0, 0, 0, 1))
    lines = [line for line in header.decode().splitlines() if line.split(" = ")[0] not in values]
    text = {key: " ".join(map(str, v)) if isinstance(v, tuple) else v for key, v in values.items()}
    (folder / "v.mhd").write_text("\n".join([f"{k} = {v}" for k, v in text.items()] + lines))
    (folder / "v.raw").write_bytes(turned.ravel(order="F").tobytes())
    return folder / "v.mhd", ReadOptions()


def write_nrrd(folder):
    import nrrd

    header = {"space": "left-posterior-superior", "space directions": np.diag(SPACING)}
    nrrd.write(str(folder / "v.nrrd"), volume(), header | {"space origin": FIRST}, index_order="F")
    return folder / "v.nrrd", ReadOptions()


def write_nhdr(folder):
    (folder / "v.raw.gz").write_bytes(gzip.compress(volume(np.uint8).ravel(order="F").tobytes()))
    sizes, lengths = (" ".join(map(str, values)) for values in (SHAPE, SPACING))
    (folder / "v.nhdr").write_text(
        f"NRRD0004\ntype: unsigned char\ndimension: 3\nsizes: {sizes}\nspacings: {lengths}\n"
        "encoding: gzip\ndata file: v.raw.gz\n"
    )
    return folder / "v.nhdr", ReadOptions(origin=ORIGIN)


def write_damask(folder):
    text = " ".join(map(str, (volume() - 1).ravel(order="F")))
    extent = f"0 {SHAPE[0]} 0 {SHAPE[1]} 0 {SHAPE[2]}"
    (folder / "v.vti").write_text(
        '<VTKFile type="ImageData" version="0.1" byte_order="LittleEndian">'
        f'<ImageData WholeExtent="{extent}" Origin="{" ".join(map(str, ORIGIN))}"'
        f' Spacing="{" ".join(map(str, SPACING))}"><Piece Extent="{extent}"><CellData>'
        f'<DataArray type="Int64" Name="material" format="ascii">{text}</DataArray>'
        "</CellData></Piece></ImageData></VTKFile>"
    )
    return folder / "v.vti", ReadOptions()


def write_labdct(folder):
    with h5py.File(folder / "v.h5", "w") as file:
        file["LabDCT/Spacing"] = np.array(SPACING)
        file["LabDCT/Data/GrainId"] = volume(np.int64).transpose(2, 1, 0)
        file["LabDCT/Data/PhaseId"] = np.ones(SHAPE[::-1], np.uint8)
        w, *xyz = np.moveaxis(bunge_to_quaternion(ANGLES), -1, 0)
        rodrigues = np.stack(xyz, axis=-1) / w[:, None]
        file["PhaseInfo/Phase01/SpaceGroup"] = [194]
        file["PhaseInfo/Phase01/Name"] = ["Titanium"]
        file["LabDCT/Data/Rodrigues"] = rodrigues[volume().transpose(2, 1, 0)].astype(np.float32)
    return folder / "v.h5", ReadOptions(origin=ORIGIN)


def write_tiff(folder):
    tifffile.imwrite(folder / "v.tif", volume(np.uint16).transpose(2, 1, 0), photometric="minisblack")
    return folder / "v.tif", ReadOptions(spacing=SPACING, origin=ORIGIN)


def write_tiff_folder(folder):
    for z in range(SHAPE[2]):  # slice_8, slice_9, slice_10: the order of names is not that of numbers
        tifffile.imwrite(
            folder / f"slice_{z + 8}.tif", volume(np.uint8)[:, :, z].T, photometric="minisblack"
        )
    return folder, ReadOptions(spacing=SPACING, origin=ORIGIN)


WRITERS = [
    write_npz,
    write_npy,
    write_simpl,
    write_simplnx,
    write_version_4,
    write_version_5,
    write_damask,
    write_tesr,
    write_tesr_binary,
    write_tesr_beside,
    write_mha,
    write_mhd,
    write_nrrd,
    write_nhdr,
    write_labdct,
    write_tiff,
    write_tiff_folder,
]
WITH_ORIENTATIONS = [
    write_npz,
    write_simpl,
    write_simplnx,
    write_version_4,
    write_version_5,
    write_tesr,
    write_tesr_binary,
    write_labdct,
]


@pytest.mark.parametrize("write", WRITERS)
def test_volume_comes_back_with_its_axes_spacing_and_ids(tmp_path, write):
    raw = read_voxels(*write(tmp_path))
    np.testing.assert_array_equal(raw.voxels.labels, volume())
    assert raw.voxels.labels.dtype == np.int32
    np.testing.assert_array_equal(raw.voxels.spacing, SPACING)
    np.testing.assert_array_equal(raw.voxels.origin, ORIGIN)
    assert not raw.unindexed.any()
    shift = 1 if write is write_damask else 0
    assert raw.remap == {k - shift: k for k in (1, 2, 3)}
    assert any("+ 1" in note for note in raw.notes) == bool(shift)


@pytest.fixture
def opened(monkeypatch):
    """The files that Python opens while a test runs; h5py's are not heard, and it may open no others."""
    heard: list[str] = []
    monkeypatch.setattr(f"{__name__}.LISTENERS", [heard.append])
    return heard


LISTENERS: list = []
sys.addaudithook(lambda event, words: [one(str(words[0])) for one in LISTENERS if event == "open"])


@pytest.mark.parametrize("write", WRITERS)
def test_a_reader_opens_the_files_that_a_campaign_tracks(tmp_path, write, opened):
    path, options = write(tmp_path)
    tracked = {str(path), *map(str, files_behind(path))}
    opened.clear()
    read_voxels(path, options)
    assert {name for name in opened if name.startswith(str(tmp_path))} <= tracked
    beside = {str(file) for file in tmp_path.rglob("*") if file.is_file()}
    assert beside <= tracked  # the writers leave nothing else there


@pytest.mark.parametrize("write", WITH_ORIENTATIONS)
def test_orientations_come_back_by_grain_id(tmp_path, write):
    orientations = read_voxels(*write(tmp_path)).voxels.orientations
    apart = angle_between(orientations[1:], bunge_to_quaternion(ANGLES[1:]))
    assert apart.max() < 0.1  # float32 in the files: half-angles near 0 are good to 0.04 degrees
    if write is not write_npz:
        assert np.isnan(orientations[0]).all()


@pytest.mark.parametrize("write", [write_simpl, write_version_4])
def test_phases_of_features(tmp_path, write):
    assert read_voxels(*write(tmp_path)).voxels.phases.tolist() == [0, 1, 1, 2]


@pytest.mark.parametrize(
    "write, crystals",
    [
        (write_simpl, {1: Crystal("cubic", "Iron"), 2: Crystal("hexagonal", "Titanium")}),
        (write_labdct, {1: Crystal("hexagonal", "Titanium")}),
        (write_tesr, {0: Crystal("cubic")}),
        (write_damask, {}),
    ],
)
def test_crystals_go_from_the_file_into_the_labels(tmp_path, write, crystals):
    write_labels(tmp_path / "labels.npz", clean(read_voxels(*write(tmp_path)))[0])
    assert read_labels(tmp_path / "labels.npz").crystals == crystals


@pytest.mark.parametrize("structure", ["cubic", "hexagonal", "tetragonal", "orthorhombic", "trigonal"])
def test_structures_by_space_group(structure):
    """One known material each: copper, titanium, tin, uranium, quartz."""
    group = {"cubic": 225, "hexagonal": 194, "tetragonal": 141, "orthorhombic": 63, "trigonal": 152}
    assert of_space_group(group[structure]) == structure


QUATERNIONS = bunge_to_quaternion(ANGLES[1:])
HALF = np.arccos(QUATERNIONS[:, :1])


@pytest.mark.parametrize(
    "descriptor, table",
    [
        ("quaternion:active", QUATERNIONS),
        ("quaternion:passive", QUATERNIONS * [1, -1, -1, -1]),
        ("euler-bunge:passive", -np.degrees(ANGLES[1:, ::-1])),
        ("axis-angle", np.hstack([QUATERNIONS[:, 1:] / np.sin(HALF), np.degrees(2 * HALF)])),
    ],
)
def test_descriptors_of_neper_give_one_rotation(tmp_path, descriptor, table):
    labels = " ".join(map(str, volume().ravel(order="F")))
    orientations = f"  *ori\n   {descriptor}\n{rows_of(table)}\n"
    (tmp_path / "v.tesr").write_text(tesr_text(f"ascii\n{labels}\n***end\n", orientations))
    read = read_voxels(tmp_path / "v.tesr").voxels.orientations[1:]
    assert angle_between(read, QUATERNIONS).max() < 1e-5  # sixteen digits, through an arc cosine


@pytest.mark.parametrize("dtype", [np.uint8, np.int16, np.uint16, np.int64, np.uint64, np.float32])
def test_number_types_of_labels(tmp_path, dtype):
    np.savez(tmp_path / "v.npz", labels=volume(dtype))
    np.testing.assert_array_equal(read_voxels(tmp_path / "v.npz").voxels.labels, volume())


def test_ids_beyond_16_bits_are_kept(tmp_path):
    labels = np.where(volume(np.int64) == 3, 2_000_000_000, volume(np.int64) + 70_000)
    np.savez(tmp_path / "v.npz", labels=labels)
    raw = read_voxels(tmp_path / "v.npz")
    np.testing.assert_array_equal(raw.voxels.labels, labels)
    voxels, report = clean(raw)
    np.testing.assert_array_equal(voxels.labels, labels)
    assert report["remap"]["2000000000"] == [2_000_000_000]


@pytest.mark.parametrize("meaning, unindexed", [("unindexed", 1), ("void", 0), ("grain", 0)])
def test_what_zero_means_is_declared(tmp_path, meaning, unindexed):
    labels = volume() % 3
    np.savez(tmp_path / "v.npz", labels=labels)
    raw = read_voxels(tmp_path / "v.npz", ReadOptions(background=meaning))
    assert raw.unindexed.sum() == unindexed
    expected = labels + 1 if meaning == "grain" else labels
    np.testing.assert_array_equal(raw.voxels.labels, expected)


def test_background_of_another_value_and_declared_voids(tmp_path):
    labels = volume()
    labels[labels == 2] = -1
    np.savez(tmp_path / "v.npz", labels=labels)
    options = ReadOptions(background="void", background_value=-1, void_labels=(3,))
    raw = read_voxels(tmp_path / "v.npz", options)
    np.testing.assert_array_equal(np.unique(raw.voxels.labels), [-3, 0, 1])
    assert raw.voxels.labels[MARKER] == -3


def test_eight_bits_at_their_limit_are_noted(tmp_path):
    stack = volume(np.uint8).transpose(2, 1, 0) * 85  # 3 becomes 255
    tifffile.imwrite(tmp_path / "v.tif", stack, photometric="minisblack")
    assert "255" in read_voxels(tmp_path / "v.tif", ReadOptions(spacing=SPACING)).notes[0]


def voxels_with_all() -> Voxels:
    labels = np.pad(volume(), 1, constant_values=1)
    labels[2, 2, 2] = -1
    orientations = np.vstack([np.full((1, 4), np.nan), random_orientations(3, np.random.default_rng(0))])
    crystals = {1: Crystal("cubic", "Kupfer \N{LATIN SMALL LETTER U WITH DIAERESIS}"), 2: Crystal("", "?")}
    return Voxels(labels, SPACING, ORIGIN, orientations, [0, 1, 1, 2], crystals)


def assert_same(read: Voxels, written: Voxels):
    for name in ("labels", "spacing", "origin", "orientations", "phases"):
        np.testing.assert_array_equal(getattr(read, name), getattr(written, name))


def test_labels_file_comes_back_and_is_the_same_bytes(tmp_path):
    written = voxels_with_all()
    for name in ("a.npz", "b.npz"):
        write_labels(tmp_path / name, written)
    assert_same(read_labels(tmp_path / "a.npz"), written)
    assert read_labels(tmp_path / "a.npz").crystals == written.crystals
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.npz", "b.npz"]


@pytest.mark.parametrize("name, write", [("v.npz", write_labels), ("v.vti", vtk.write_voxels)])
def test_own_files_pass_the_import_unchanged(tmp_path, name, write):
    written = voxels_with_all()
    write(tmp_path / name, written)
    voxels, report = clean(read_voxels(tmp_path / name))
    assert_same(voxels, written)
    assert report["voids"] == {"1": 1}


def test_al1050_is_the_same_in_both_files(shared_data):
    npz = read_voxels(shared_data / "al1050/al1050_labdct_109x103x64.npz")
    h5 = read_voxels(shared_data / "al1050/lab_dct_Al1050.h5")
    np.testing.assert_array_equal(npz.voxels.labels, h5.voxels.labels)
    assert npz.unindexed.sum() == h5.unindexed.sum() == 542
    assert len(npz.remap) == 106
    np.testing.assert_allclose(npz.voxels.spacing / 1000, h5.voxels.spacing)  # micrometres and mm
    apart = angle_between(npz.voxels.orientations[1:], h5.voxels.orientations[1:])
    assert apart.max() < 0.01  # float32 vectors, averaged over up to 1e5 equal voxels in one file


def test_anisotropic_steel_with_gaps_in_its_ids(shared_data):
    voxels, report = clean(read_voxels(shared_data / "al6xn/prisms_al6xn_68x64x46.npz"))
    assert report["grains"] == 92
    assert voxels.labels.max() == 96
    assert voxels.spacing[0] == voxels.spacing[1] > voxels.spacing[2]


def test_damask_ids_start_at_zero(shared_data):
    raw = read_voxels(shared_data / "readers/damask_20grains.vti")
    assert raw.voxels.labels.shape == (64, 64, 64)
    assert raw.remap == {k: k + 1 for k in range(20)}


def test_copper_features_and_orientations(shared_data):
    path = shared_data / "readers/copper_v7.dream3d"
    voxels, report = clean(read_voxels(path), CleanOptions())
    assert report["grains"] == 299
    with h5py.File(path) as file:
        image = file["DataContainers/SyntheticVolumeDataContainer"]
        grain = image["CellData/FeatureIds"][7, 11, 3, 0]
        angles = image["CellData/EulerAngles"][7, 11, 3]
    assert voxels.labels[3, 11, 7] == grain
    assert angle_between(voxels.orientations[grain], bunge_to_quaternion(angles)) < 0.01
