"""Small volumes with tables beside their grain ids, in every format, and what is to become of them."""

import re

import h5py
import numpy as np
import pytest
import vtk_objects

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.orientation import angle_between, bunge_to_quaternion
from craftmesh.voxels.reading import ReadOptions, read_voxels

SHAPE = (3, 4, 5)
LABELS = np.ones(SHAPE, np.int32)
LABELS[1:] = 2
LABELS[1, 2, 3] = LABELS[2, 2, 3] = 3
PARENTS = np.array([0, 1, 2, 2], np.int32)
RADIANS = np.array([[0, 0, 0], [0.3, 0.7, 1.1], [2.0, 1.0, 4.0], [5.0, 2.5, 0.2]])
DEGREES = np.degrees(RADIANS)
HALF_COLUMNS = np.column_stack([DEGREES[:, 0], RADIANS[:, 1], DEGREES[:, 2]])
HALF_ROWS = np.vstack([DEGREES[:3], RADIANS[3:]])
NEITHER = RADIANS * 200
SMALL = RADIANS / 2  # angles that may be radians or degrees
OTHER = RADIANS[[0, 3, 1, 2]]
PHASES = np.array([0, 1, 1, 2], np.int32)
QUATERNIONS = bunge_to_quaternion(RADIANS)
CODES = np.where(LABELS == 3, 2, 1).astype(np.int32)  # phases by voxel


def longer(table):
    return np.vstack([table, table[:2]])


def outcome(path, right, words, options=ReadOptions(), wanted=QUATERNIONS):  # noqa: B008
    """Check that a file is refused (right: False), or read with the wanted orientations or none (None)."""
    if right is False:
        with pytest.raises(CraftmeshError, match=words) as caught:
            read_voxels(path, options)
        assert "\n" not in str(caught.value) and path.name in str(caught.value)
        return None
    raw = read_voxels(path, options)
    assert (raw.voxels.orientations is None) == (right is None)
    if right:
        assert angle_between(raw.voxels.orientations[1 : len(wanted)], wanted[1:]).max() < 0.1
    assert re.search(words, "\n".join(raw.notes)), raw.notes
    assert words or not raw.notes
    return raw.voxels


MATRICES = {4: ("CELL_DATA", "FIELD_DATA"), 5: ("CellData", "CellFeatureData")}


def dream3d(folder, version, tables=(), cells=(), parents=None):
    """Write a volume; tables: (matrix or "" for the usual one, name, values), cells: (name, values)."""
    cell_matrix, feature_matrix = MATRICES.get(version, MATRICES[5])
    with h5py.File(folder / "v.dream3d", "w") as file:
        if version == 8:
            image = file.create_group("DataStructure/Image")
            image.attrs.update({"ObjectType": "ImageGeom", "_DIMENSIONS": np.array(SHAPE, np.uint64)})
            image.attrs.update({"_SPACING": np.ones(3, "f4"), "_ORIGIN": np.zeros(3, "f4")})
        else:
            image = file.create_group("DataContainers/Image" if version == 7 else "VoxelDataContainer")
            place = image.create_group("_SIMPL_GEOMETRY") if version == 7 else image
            place["DIMENSIONS"], place["SPACING"] = np.array(SHAPE), np.ones(3, "f4")
        cells = [("FeatureIds", LABELS), *cells]
        for name, values in cells if parents is None else [*cells, ("ParentIds", parents[LABELS])]:
            width = values.shape[3] if values.ndim == 4 else 1
            turned = values.reshape(*SHAPE, width).transpose(2, 1, 0, 3)
            image[f"{cell_matrix}/{name}"] = turned.reshape(-1, width) if version == 4 else turned
        for matrix, name, values in tables:
            beside = image.parent if matrix.startswith("/") else image
            beside[f"{matrix.strip('/') or feature_matrix}/{name}"] = values
    return folder / "v.dream3d"


def ids_of(version, name="FeatureIds"):
    group = {7: "/DataContainers/Image", 8: "/DataStructure/Image"}.get(version, "/VoxelDataContainer")
    return f"{group}/{MATRICES.get(version, MATRICES[5])[0]}/{name}"


def npz(folder, **arrays):
    np.savez(folder / "v.npz", **({"labels": LABELS, "spacing": np.ones(3)} | arrays))
    return folder / "v.npz"


def labdct(folder, **arrays):
    with h5py.File(folder / "v.h5", "w") as file:
        file["LabDCT/Spacing"] = np.ones(3)
        for name, values in ({"GrainId": LABELS} | arrays).items():
            file[f"LabDCT/Data/{name}"] = values.transpose(2, 1, 0, *range(3, values.ndim))
    return folder / "v.h5"


def vti(folder, **arrays):
    from vtkmodules.vtkCommonDataModel import vtkImageData

    image = vtkImageData()
    image.SetDimensions(*(n + 1 for n in SHAPE))
    flat = {"FeatureIds": LABELS} | arrays
    flat = {k: v.transpose(2, 1, 0, *range(3, v.ndim)).reshape(-1, *v.shape[3:]) for k, v in flat.items()}
    vtk_objects.add_arrays(image.GetCellData(), flat)
    vtk_objects.write_dataset(folder / "v.vti", image, "ImageData")
    return folder / "v.vti"


def tesr(folder, ori="", oridata=b"", version="2.1", **_):
    cells = " ".join(map(str, LABELS.ravel(order="F")))
    head = f"***tesr\n **format\n {version}\n **general\n 3\n 3 4 5\n 1 1 1\n **cell\n 3\n{ori}"
    head += f" **data\n ascii\n{cells}\n"
    (folder / "v.tesr").write_bytes(head.encode() + oridata + b"***end\n")
    return folder / "v.tesr"


def text(table):
    return "\n".join(" ".join(map(repr, row)) for row in table.tolist()) + "\n"


def ori(descriptor, table):
    return {"ori": f"  *ori\n   {descriptor}\n{text(table)}"}


def oridata(descriptor, table, kind="ascii"):
    rows = table[LABELS.ravel(order="F")]
    numbers = text(rows).encode() if kind == "ascii" else rows.astype("<f8").tobytes() + b"\n"
    return {"oridata": f" **oridata\n   {descriptor}\n   {kind}\n".encode() + numbers}


VECTORS = QUATERNIONS[:, 1:] / QUATERNIONS[:, :1]
