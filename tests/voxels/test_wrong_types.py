"""Arrays of other types than expected: the same grains where no number changes, else one line."""

import h5py
import numpy as np
import pytest

from craftmesh.errors import CraftmeshError
from craftmesh.voxels.reading import read_voxels


def labels() -> np.ndarray:
    made = np.ones((3, 4, 5), np.int32)
    made[1:] = 2
    return made


def npz(tmp_path, **arrays):
    np.savez(tmp_path / "v.npz", **({"labels": labels()} | arrays))
    return tmp_path / "v.npz"


@pytest.mark.parametrize(
    "changed, words",
    [
        ({"labels": labels() + 0.5j}, "labels have the type complex128"),
        ({"labels": labels().astype(np.uint64) * 2**40}, "2199023255552.*int32"),
        ({"labels": np.where(labels() == 1, np.inf, 2)}, "labels range from 2.0 to inf"),
        ({"labels": labels().astype("f4") * 2**23}, "float32, which rounds ids above 16777216"),
        ({"labels": labels().astype("f2") * 1024}, "float16, which rounds ids above 2048"),
        ({"spacing": np.full(3, 1e-110)}, "1e-110.*not so small that volumes underflow"),
        ({"spacing": np.full(3, 1e110)}, r"1e\+110; expected finite numbers"),
        ({"spacing": np.array("1 1 1")}, "spacing is an array of <U5; expected"),
        ({"origin": np.array(["0", "0", "0"])}, "origin is an array of <U1"),
        ({"origin": np.array([1e200, 0, 0])}, r"origin\[0\] is 1e\+200; expected finite numbers"),
        ({"orientations": np.full((3, 4), "a")}, "orientations is of type <U1"),
        ({"orientations": np.ones((3, 4), complex)}, "orientations is of type complex128"),
        ({"orientations": np.full((3, 4), 1e200)}, "no orientation for grains 1, 2"),
        ({"rodrigues": np.full((3, 3), 1e200)}, "no orientation for grains 1, 2"),
        ({"eulers": np.full((3, 3), "a")}, "eulers is of type <U1"),
        ({"eulers": np.full((3, 3), np.inf)}, "no orientation for grains 1, 2"),
        ({"phases": np.array(["a", "b", "c"])}, "phases is of type <U1"),
        ({"phases": np.array([0, 1.5, 1])}, "phase of grain 1 is 1.5; expected an integer"),
        ({"phases": np.array([0, 1, np.nan])}, "phase of grain 2 is nan"),
        ({"phases": np.array([0, -1, 1])}, "phase of grain 1 is -1"),
        ({"phases": np.ones((3, 2), int)}, r"phases has shape \(3, 2\)"),
        ({"phases": np.array([0, 1])}, "no phase for grains 2, the table has 2 rows; .*row 0 for id 0"),
    ],
)
def test_arrays_of_wrong_types(tmp_path, recwarn, changed, words):
    with pytest.raises(CraftmeshError, match=words) as caught:
        read_voxels(npz(tmp_path, **changed))
    assert "v.npz" in str(caught.value) and "\n" not in str(caught.value)
    assert not recwarn.list


@pytest.mark.parametrize("kind", ["float16", "float64", "uint8", "uint64", ">i4", "int64"])
def test_whole_labels_of_any_type_are_the_same_grains(tmp_path, recwarn, kind):
    """Also in a .dream3d, where filters may have left FeatureIds as floats."""
    table = np.array([np.nan, 0, 3])  # row 0 is no grain's
    np.testing.assert_array_equal(
        read_voxels(npz(tmp_path, labels=labels().astype(kind), phases=table)).voxels.labels, labels()
    )
    with h5py.File(tmp_path / "v.dream3d", "w") as file:
        image = file.create_group("DataContainers/Image")
        image["_SIMPL_GEOMETRY/DIMENSIONS"] = np.array([3, 4, 5])
        image["_SIMPL_GEOMETRY/SPACING"] = image["_SIMPL_GEOMETRY/ORIGIN"] = np.ones(3)
        image["CellData/Confidence"] = np.ones((5, 4, 3, 1))
        image["CellData/FeatureIds"] = labels().transpose(2, 1, 0)[..., None].astype(kind)
    np.testing.assert_array_equal(read_voxels(tmp_path / "v.dream3d").voxels.labels, labels())
    assert not recwarn.list
