"""Tables beside grain ids, in every format: each fault is refused or noted, and what is taken is right.

The doubles: a small volume of each format with each fault, one row a combination.
"""

import re

import h5py
import numpy as np
import pytest

from craftmesh.errors import CraftmeshError
from craftmesh.io import vtk_xml
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


# DREAM.3D: one writer, four layouts -----------------------------------------------------------------------

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


EULERS = ("", "AvgEulerAngles", RADIANS)
CELL_EULERS = ("EulerAngles", RADIANS[LABELS])
# fault: tables, cells, options, whether the orientations are right, None: none, False: refused; words
DREAM3D = {
    "degrees": ([("", "AvgEulerAngles", DEGREES)], [], {}, True, "taken as degrees"),
    "degrees by cell": ([], [("EulerAngles", DEGREES[LABELS])], {}, True, "taken as degrees"),
    "half of the angles": ([("", "EulerAngles", HALF_COLUMNS)], [], {}, False, "all in degrees"),
    "half of the grains": ([("", "EulerAngles", HALF_ROWS)], [], {}, False, "1 of 3 rows"),
    "neither": ([("", "EulerAngles", NEITHER)], [], {}, False, "reach 1000"),
    "neither by cell": ([], [("EulerAngles", NEITHER[LABELS])], {}, False, "reach 1000"),
    "the user's unit": ([("", "EulerAngles", DEGREES)], [], {"angles": "degrees"}, True, ""),
    "not the user's": ([("", "EulerAngles", DEGREES)], [], {"angles": "radians"}, False, "said to be rad"),
    "not indexed": ([], [("EulerAngles", np.where((LABELS == 1)[..., None] & (np.arange(5) > 2)[:, None],
                    4 * np.pi, RADIANS[LABELS]))], {}, True, "means over"),
    "cells only": ([], [CELL_EULERS], {}, True, "means over"),
    "two tables": ([EULERS, ("More", "EulerAngles", OTHER)], [], {}, False, "fit them.*AvgEuler.*More"),
    "table not numbered": ([("", "AvgEulerAngles", RADIANS[1:])], [], {}, None, r"unread.*\(3 rows\)"),
    "short": ([("", "AvgEulerAngles", RADIANS[:2])], [CELL_EULERS], {}, True, r"unread.*\(2 rows\)"),
    "long": ([("", "AvgEulerAngles", longer(RADIANS))], [], {}, True, "6 rows, ids reach 3"),
    "not described": ([("", "AvgEulerAngles", RADIANS), ("", "Centroids", OTHER)], [], {}, True, ""),
    "unread": ([EULERS, ("", "AvgQuats", QUATERNIONS)], [CELL_EULERS], {}, True, "unread: .*AvgQuats"),
    "beside": ([("Elsewhere", "EulerAngles", RADIANS)], [], {}, True, ""),
}  # fmt: skip


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


@pytest.mark.parametrize("version", [4, 5, 7, 8])
@pytest.mark.parametrize("fault", DREAM3D)
def test_tables_of_dream3d(tmp_path, version, fault):
    tables, cells, options, right, words = DREAM3D[fault]
    outcome(dream3d(tmp_path, version, tables, cells), right, words, ReadOptions(**options))


@pytest.mark.parametrize("version", [4, 5, 7, 8])
def test_units_in_the_words_of_the_file(tmp_path, version):
    path = dream3d(tmp_path, version, [("", "EulerAngles [deg]", SMALL)])
    outcome(path, True, "none exceeds 2 pi", wanted=bunge_to_quaternion(np.radians(SMALL)))
    path = dream3d(tmp_path, version, [("", "EulerAngles", SMALL)])
    with h5py.File(path, "a") as file:
        matrix = MATRICES.get(version, MATRICES[5])[1]
        file[ids_of(version)].parent.parent[f"{matrix}/EulerAngles"].attrs["Units"] = "degrees"
    outcome(path, True, "none exceeds 2 pi", wanted=bunge_to_quaternion(np.radians(SMALL)))


@pytest.mark.parametrize("version", [4, 5, 7, 8])
def test_one_of_several_tables_is_named(tmp_path, version):
    path = dream3d(
        tmp_path, version, [EULERS, ("More", "EulerAngles", OTHER), ("Few", "EulerAngles", OTHER[:2])]
    )
    group = ids_of(version).rsplit("/", 2)[0]
    wanted = bunge_to_quaternion(OTHER)
    for table in (f"{group}/More", f"{group}/More/EulerAngles"):
        outcome(path, True, "unread: .*AvgEulerAngles", ReadOptions(table=table), wanted)
    outcome(path, False, r"ids reach 3, and the table given has 2 rows", ReadOptions(table=f"{group}/Few"))
    outcome(path, False, "no array below Gone", ReadOptions(table="Gone"))


PARENT_TABLE = RADIANS[[0, 1, 3]]
OF_PARENTS = [EULERS, ("", "Phases", PHASES), ("NewGrainData", "AvgEulerAngles", PARENT_TABLE)]


@pytest.mark.parametrize("version", [4, 5, 7, 8])
@pytest.mark.parametrize(
    "parents, more, right",
    [
        (PARENTS, [("NewGrainData", "Phases", np.array([0, 2, 1]))], True),
        (np.array([0, 2, 1, 3]), [("", "ParentIds", np.array([0, 2, 1, 3]))], True),  # as many as features
        (np.array([0, 2, 1, 3]), [], False),
    ],
)
def test_parents_have_the_table_of_parents(tmp_path, version, parents, more, right):
    tables = OF_PARENTS + more
    if len(np.unique(parents)) == 4:
        tables[2] = ("NewGrainData", "AvgEulerAngles", OTHER)
    path = dream3d(tmp_path, version, tables, parents=parents)
    wanted = bunge_to_quaternion(tables[2][2])
    options = ReadOptions(dataset=ids_of(version, "ParentIds"))
    made = outcome(path, right, "unread: .*FeatureIds" if right else "several tables", options, wanted)
    if more and parents is not PARENTS:
        outcome(path, True, "unread: .*NewGrainData")  # what lists parents is the features'
    if parents is PARENTS:
        assert made.phases.tolist() == [0, 2, 1]
        assert outcome(path, True, "unread: .*ParentIds").phases.tolist() == PHASES.tolist()


@pytest.mark.parametrize("version", [4, 5, 7, 8])
def test_the_table_of_the_features_is_not_that_of_the_parents(tmp_path, version):
    path = dream3d(tmp_path, version, [EULERS], parents=PARENTS)
    outcome(path, None, "unread: .*AvgEulerAngles", ReadOptions(dataset=ids_of(version, "ParentIds")))


# The other formats ----------------------------------------------------------------------------------------


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
    vtk_xml.add_arrays(image.GetCellData(), flat)
    vtk_xml.write_dataset(folder / "v.vti", image, "ImageData")
    return folder / "v.vti"


def tesr(folder, ori="", oridata=b"", **_):
    cells = " ".join(map(str, LABELS.ravel(order="F")))
    head = f"***tesr\n **format\n 2.1\n **general\n 3\n 3 4 5\n 1 1 1\n **cell\n 3\n{ori}"
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
FAULTS = [
    (npz, "degrees", {"eulers": DEGREES}, True, "taken as degrees"),
    (npz, "degrees by cell", {"eulers": DEGREES[LABELS]}, True, "taken as degrees"),
    (npz, "degrees by name", {"eulers_deg": DEGREES}, True, ""),
    (
        npz,
        "degrees by words",
        {"eulers": DEGREES, "eulers_unit": np.array("radians")},
        False,
        "said to be rad",
    ),
    (npz, "half of the angles", {"eulers": HALF_COLUMNS}, False, "all in degrees"),
    (npz, "half of the grains", {"eulers": HALF_ROWS}, False, "all in degrees"),
    (npz, "neither", {"eulers": NEITHER}, False, "reach 1000"),
    (npz, "cells only", {"rodrigues": VECTORS[LABELS]}, True, "means over"),
    (npz, "two that differ", {"rodrigues": VECTORS, "eulers": OTHER}, False, "differ by"),
    (
        npz,
        "table not numbered",
        {"eulers": RADIANS[1:]},
        False,
        "3 rows for 3 ids up to 3; expected row = id",
    ),
    (npz, "long", {"eulers": longer(RADIANS)}, True, "6 rows, ids reach 3"),
    (npz, "list of voxels", {"eulers": RADIANS[LABELS].reshape(-1, 3)}, None, "unread: eulers"),
    (npz, "other shape", {"eulers": RADIANS[LABELS][1:]}, False, "has shape"),
    (npz, "unread", {"quats": QUATERNIONS, "ParentIds": LABELS}, None, "unread: quats, ParentIds"),
    (labdct, "cells only", {"Rodrigues": VECTORS[LABELS]}, True, "means over"),
    (labdct, "other shape", {"Rodrigues": VECTORS[LABELS][1:]}, None, "unread: .*Rodrigues"),
    (labdct, "unread", {"EulerAngles": RADIANS[LABELS]}, None, "unread: .*EulerAngles"),
    (vti, "cells only", {"EulerAngles": RADIANS[LABELS]}, True, "means over"),
    (vti, "degrees by cell", {"EulerAngles": DEGREES[LABELS]}, True, "taken as degrees"),
    (vti, "half of the angles", {"EulerAngles": HALF_COLUMNS[LABELS]}, False, "all in degrees"),
    (vti, "neither", {"EulerAngles": NEITHER[LABELS]}, False, "reach 1000"),
    (vti, "unread", {"Quats": QUATERNIONS[LABELS], "ParentIds": LABELS}, None, "unread: Quats, ParentIds"),
    (tesr, "radians", ori("euler-bunge", RADIANS[1:]), True, "none exceeds 2 pi"),
    (tesr, "neither", ori("euler-bunge", NEITHER[1:]), False, "reach 1000 and are said to be degrees"),
    (tesr, "short", ori("rodrigues", VECTORS[2:]), False, "expected 3 rows"),
    (tesr, "cells only", oridata("rodrigues", VECTORS), True, "means over"),
    (tesr, "radians by cell", oridata("euler-bunge", RADIANS), True, "none exceeds 2 pi"),
    (tesr, "groups", {"ori": "  *group\n   1 1 2\n"}, None, "unread: .group"),
    (tesr, "short by cell", oridata("rodrigues", VECTORS[:, :2]), False, "120 of 180"),
    (
        tesr,
        "unread",
        ori("rodrigues", VECTORS[1:]) | oridata("rodrigues", VECTORS),
        True,
        "unread: ..oridata",
    ),
]


@pytest.mark.parametrize(
    "write, fault, arrays, right, words", FAULTS, ids=lambda v: getattr(v, "__name__", None)
)
def test_tables_of_the_other_formats(tmp_path, write, fault, arrays, right, words):
    path = write(tmp_path, **arrays)
    unit = "radians" if fault.startswith("radians") else "auto"
    if unit == "radians":  # taken at the format's word, and said, until the user says otherwise
        assert any(words in note for note in read_voxels(path).notes)
        words = "means over" if "cell" in fault else ""
    outcome(path, right, words, ReadOptions(angles=unit))


def test_a_table_that_counts_the_grains_is_refused_whatever_is_ignored(tmp_path):
    """Each grain would get the next one's orientation."""
    path = npz(tmp_path, eulers=RADIANS[1:])
    outcome(path, False, "expected row = id", ReadOptions(ignore_unknown_orientations=True))
    sparse = npz(tmp_path, labels=LABELS * 4, eulers=RADIANS[1:])
    outcome(sparse, False, "3 rows for 3 ids up to 12")


def test_ids_from_0_have_the_rows_from_0(tmp_path):
    path = npz(tmp_path, labels=LABELS - 1, eulers=RADIANS[1:])
    outcome(path, True, r"id \+ 1")


def test_arrays_of_voxels_in_the_axes_of_the_labels(tmp_path):
    arrays = {"labels": LABELS, "eulers": RADIANS[LABELS], "phases": CODES}
    arrays = {k: v.transpose(2, 1, 0, *range(3, v.ndim)) for k, v in arrays.items()}
    np.savez(tmp_path / "v.npz", spacing=np.ones(3), axes="zyx", **arrays)
    assert outcome(tmp_path / "v.npz", True, "means over").phases.tolist() == [0, 1, 1, 2]


def bunge_matrices():
    from scipy.spatial.transform import Rotation

    turns = Rotation.from_quat(QUATERNIONS, scalar_first=True)
    return turns.as_matrix().transpose(0, 2, 1).reshape(-1, 9)


ANGLE = 2 * np.degrees(np.arccos(QUATERNIONS[:, :1]))
AXES = QUATERNIONS[:, 1:] / np.maximum(np.sin(np.radians(ANGLE / 2)), 1e-12)
DESCRIPTORS = {
    "rodrigues": (VECTORS, -VECTORS),
    "euler-bunge": (DEGREES, -DEGREES[:, ::-1]),
    "euler-kocks": (DEGREES * [1, 1, -1] + [-90, 0, 90], -DEGREES[:, ::-1] * [1, 1, -1] + [-90, 0, 90]),
    "euler-roe": (DEGREES + [-90, 0, 90], -DEGREES[:, ::-1] + [-90, 0, 90]),
    "rotmat": (bunge_matrices(), bunge_matrices().reshape(-1, 3, 3).transpose(0, 2, 1).reshape(-1, 9)),
    "axis-angle": (np.hstack([AXES, ANGLE]), np.hstack([-AXES, ANGLE])),
    "quaternion": (QUATERNIONS, QUATERNIONS * [1, -1, -1, -1]),
}


@pytest.mark.parametrize("descriptor", DESCRIPTORS)
@pytest.mark.parametrize("convention", ["", ":active", ":passive"])
def test_all_descriptors_of_neper_at_cells_and_voxels(tmp_path, descriptor, convention):
    table = DESCRIPTORS[descriptor][convention == ":passive"]
    outcome(tesr(tmp_path, **ori(descriptor + convention, table[1:])), True, "")
    for kind in ("ascii", "binary"):
        path = tesr(tmp_path, **oridata(descriptor + convention, table, kind))
        outcome(path, True, "means over")


@pytest.mark.parametrize("kind", ["ascii", "binary"])
def test_voxels_without_an_orientation_do_not_count(tmp_path, kind):
    """Where **oridef is 0, and beside them a file of its own for the numbers."""
    wrong = np.zeros(SHAPE, bool)
    wrong[:, :, 0] = True
    rows = np.where(wrong[..., None], [9.0, 9, 9], VECTORS[LABELS]).reshape(-1, 3, order="F")
    defined = (~wrong).astype("u1").ravel(order="F")
    (tmp_path / "o.raw").write_bytes(text(rows).encode() if kind == "ascii" else rows.tobytes())
    known = " ".join(map(str, defined)).encode() if kind == "ascii" else defined.tobytes()
    more = f" **oridata\n rodrigues\n {kind}\n *file o.raw\n **oridef\n {kind}\n".encode() + known + b"\n"
    outcome(tesr(tmp_path, oridata=more), True, "means over")


# Phases ---------------------------------------------------------------------------------------------------

MIXED = np.where(LABELS == 2, 3, CODES).astype(np.int32)
MIXED[1, 0] = 1  # 5 of the 38 voxels of grain 2


@pytest.mark.parametrize(
    "codes, phases, words", [(CODES, [0, 1, 1, 2], ""), (MIXED, [0, 1, 3, 2], r"2 \(13%\)")]
)
@pytest.mark.parametrize(
    "write",
    [
        *(lambda folder, codes, v=v: dream3d(folder, v, cells=[("Phases", codes)]) for v in (4, 5, 7, 8)),
        lambda folder, codes: npz(folder, phases=codes),
        lambda folder, codes: labdct(folder, PhaseId=codes),
        lambda folder, codes: vti(folder, phase=codes),
    ],
    ids=["4", "5", "7", "8", "npz", "labdct", "vti"],
)
def test_phases_of_voxels_stay_apart(tmp_path, write, codes, phases, words):
    raw = read_voxels(write(tmp_path, codes))
    assert raw.voxels.phases.tolist() == phases
    notes = [note for note in raw.notes if "phases" in note]
    assert len(notes) == bool(words)
    assert all(re.search(words, note) for note in notes)


@pytest.mark.parametrize("version", [4, 5, 7, 8])
def test_phases_of_a_table_that_does_not_fit_are_those_of_the_cells(tmp_path, version):
    path = dream3d(tmp_path, version, [("", "Phases", PHASES[1:])], [("Phases", CODES)])
    assert outcome(path, None, r"unread: .*Phases \(3 rows\)").phases.tolist() == [0, 1, 1, 2]


# What goes along ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("version", [4, 5, 7, 8])
@pytest.mark.parametrize("by_cell", [False, True])
def test_quaternions_of_dream3d_where_there_are_no_angles(tmp_path, version, by_cell):
    """They are (x, y, z, w) of the rotation from sample to crystal axes; row 0 is a row of zeros."""
    stored = (QUATERNIONS * [1, -1, -1, -1])[:, [1, 2, 3, 0]]
    stored[0] = 0
    tables, cells = [("", "AvgQuats", stored)], [("Quats", stored[LABELS])]
    path = dream3d(tmp_path, version, *(([], cells) if by_cell else (tables, [])))
    outcome(path, True, "means over" if by_cell else "")


@pytest.mark.parametrize("version", [7, 8])
@pytest.mark.parametrize("place", ["/Features", "/Container/Features"])
def test_a_table_beside_the_geometry_after_those_within(tmp_path, version, place):
    outcome(dream3d(tmp_path, version, [(place, "EulerAngles", RADIANS)]), True, "")
    outcome(dream3d(tmp_path, version, [(place, "EulerAngles", OTHER), EULERS]), True, "unread: .*Features")


@pytest.mark.parametrize("version", [4, 5, 7, 8])
@pytest.mark.parametrize("first", [0.0, 0.4])
def test_a_first_row_of_zeros_is_no_orientation(tmp_path, version, first):
    """A feature 0 that the user declares a grain has an orientation only where its row is not the dummy."""
    table = RADIANS.copy()
    table[0] = first
    path = dream3d(tmp_path, version, [("", "EulerAngles", table)])
    with h5py.File(path, "a") as file:
        file[ids_of(version)][:1] = 0
    options = ReadOptions(background="grain")
    if first:
        wanted = bunge_to_quaternion(np.vstack([table[:1], table]))
        outcome(path, True, r"\+ 1", options, wanted)
    else:
        outcome(path, False, "no orientation for grains 0", options)


@pytest.mark.parametrize("version", [7, 8])  # the others have one volume a file
def test_other_volumes_are_noted(tmp_path, version):
    path = dream3d(tmp_path, version, [EULERS])
    with h5py.File(path, "a") as file:
        image = file[ids_of(version)].parent.parent
        image.copy(image, image.parent, "Other")
    outcome(path, False, "several volumes")
    outcome(path, True, "unread: .*Other/CellData/FeatureIds", ReadOptions(dataset=ids_of(version)))


@pytest.mark.parametrize("version", [4, 5, 7, 8])
@pytest.mark.parametrize(
    "places, crystals, words",
    [
        ({"Ensembles": [999, 1, 0]}, {1: ("cubic", "a"), 2: ("hexagonal", "b")}, ""),
        ({"Ensembles": [999, 1, 999]}, {1: ("cubic", "a"), 2: ("", "b")}, ""),
        ({"Ensembles": [999, 1]}, {}, "unread: .*CrystalStructures"),  # no row for phase 2
        ({"Ensembles": [999, 1], "More": [999, 10, 8]}, {1: ("trigonal", "a"), 2: ("tetragonal", "b")}, ""),
        ({"Ensembles": [999, 1, 1], "More": [999, 0, 8]}, {}, "unread: .*CrystalStructures"),
    ],
)
def test_crystals_are_those_of_the_phases(tmp_path, version, places, crystals, words):
    path = dream3d(tmp_path, version, [("", "Phases", PHASES)])
    with h5py.File(path, "a") as file:
        for name, codes in places.items():
            group = file[ids_of(version)].parent.parent.create_group(name)
            group["CrystalStructures"] = np.array(codes, np.uint32)[:, None]
            group["MaterialName"] = ["?", "a", "b"][: len(codes)]
    assert outcome(path, None, words).crystals == crystals


@pytest.mark.parametrize(
    "word, structure",
    [("cubic", "cubic"), ("m-3m", "cubic"), ("6/mmm", "hexagonal"), ("-3m", "trigonal"), ("unknown", None)],
)
def test_symmetries_of_neper(tmp_path, word, structure):
    raw = read_voxels(tesr(tmp_path, ori=f"  *crysym\n   {word}\n"))
    assert [crystal.structure for crystal in raw.voxels.crystals.values()] == (
        [structure] if structure else []
    )
