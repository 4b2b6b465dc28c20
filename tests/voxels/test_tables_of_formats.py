"""Which orientations, phases and crystals of .npz, .vti, .tesr and LabDCT files are the grains'.

Each fault is refused or noted, and what is taken is right: one row a format and fault.
"""

import re

import numpy as np
import pytest
from side_tables import (
    CODES,
    DEGREES,
    HALF_COLUMNS,
    HALF_ROWS,
    LABELS,
    NEITHER,
    OTHER,
    PHASES,
    QUATERNIONS,
    RADIANS,
    SHAPE,
    VECTORS,
    dream3d,
    labdct,
    longer,
    npz,
    ori,
    oridata,
    outcome,
    tesr,
    text,
    vti,
)

from craftmesh.mechanics.orientation import angle_between, bunge_to_quaternion
from craftmesh.voxels.reading import ReadOptions, read_voxels

FAULTS = [
    (npz, "degrees", {"eulers": DEGREES}, True, "read as degrees"),
    (npz, "degrees by cell", {"eulers": DEGREES[LABELS]}, True, "read as degrees"),
    (npz, "degrees by name", {"eulers_deg": DEGREES}, True, ""),
    (
        npz,
        "degrees by words",
        {"eulers": DEGREES, "eulers_unit": np.array("radians")},
        False,
        "too much for rad",
    ),
    (npz, "half of the angles", {"eulers": HALF_COLUMNS}, False, "to radians or degrees"),
    (npz, "half of the grains", {"eulers": HALF_ROWS}, False, "to radians or degrees"),
    (npz, "neither", {"eulers": NEITHER}, False, "reach 1000"),
    (npz, "cells only", {"rodrigues": VECTORS[LABELS]}, True, "means over"),
    (npz, "two that differ", {"rodrigues": VECTORS, "eulers": OTHER}, False, "differ by"),
    (
        npz,
        "table not numbered",
        {"eulers": RADIANS[1:]},
        False,
        "3 rows for 3 ids up to 3; write row = id",
    ),
    (npz, "long", {"eulers": longer(RADIANS)}, True, "6 rows, but ids reach 3"),
    (npz, "list of voxels", {"eulers": RADIANS[LABELS].reshape(-1, 3)}, None, "not read: eulers"),
    (npz, "other shape", {"eulers": RADIANS[LABELS][1:]}, False, "has shape"),
    (npz, "unread", {"quats": QUATERNIONS, "ParentIds": LABELS}, None, "not read: quats, ParentIds"),
    (labdct, "cells only", {"Rodrigues": VECTORS[LABELS]}, True, "means over"),
    (labdct, "other shape", {"Rodrigues": VECTORS[LABELS][1:]}, None, "not read: .*Rodrigues"),
    (labdct, "unread", {"EulerAngles": RADIANS[LABELS]}, None, "not read: .*EulerAngles"),
    (vti, "cells only", {"EulerAngles": RADIANS[LABELS]}, True, "means over"),
    (vti, "degrees by cell", {"EulerAngles": DEGREES[LABELS]}, True, "read as degrees"),
    (vti, "half of the angles", {"EulerAngles": HALF_COLUMNS[LABELS]}, False, "to radians or degrees"),
    (vti, "neither", {"EulerAngles": NEITHER[LABELS]}, False, "reach 1000"),
    (vti, "unread", {"Quats": QUATERNIONS[LABELS], "ParentIds": LABELS}, None, "read: Quats, ParentIds"),
    (tesr, "radians", ori("euler-bunge", RADIANS[1:]), True, "none exceeds 2 pi"),
    (tesr, "neither", ori("euler-bunge", NEITHER[1:]), False, "reach 1000, too much for degrees"),
    (tesr, "short", ori("rodrigues", VECTORS[2:]), False, "expected a row per cell, 3"),
    (tesr, "cells only", oridata("rodrigues", VECTORS), True, "means over"),
    (tesr, "radians by cell", oridata("euler-bunge", RADIANS), True, "none exceeds 2 pi"),
    (tesr, "groups", {"ori": "  *group\n   1 1 2\n"}, None, "not read: .group"),
    (tesr, "short by cell", oridata("rodrigues", VECTORS[:, :2]), False, "120 of 180"),
    (
        tesr,
        "unread",
        ori("rodrigues", VECTORS[1:]) | oridata("rodrigues", VECTORS),
        True,
        "not read: ..oridata",
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
    outcome(path, False, "write row = id", ReadOptions(ignore_unknown_orientations=True))
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


CONVENTIONS = [
    *[(version, word) for version in ("2.0", "2.1") for word in ("", ":active", ":passive")],
    *[(version, word) for version in ("2.2", "2.3", "3.0") for word in (":active", ":passive")],
]


@pytest.mark.parametrize("descriptor", DESCRIPTORS)
@pytest.mark.parametrize("version, convention", CONVENTIONS)
def test_all_descriptors_of_neper_at_cells_and_voxels(tmp_path, descriptor, version, convention):
    """Up to format 2.1 `passive` is the inverse of Bunge's rotation, from 2.2 on `active` is."""
    is_inverse = convention == (":passive" if version < "2.2" else ":active")
    table = DESCRIPTORS[descriptor][is_inverse]
    newer = f"format {version} is newer than 2.2" if version > "2.2" else ""
    outcome(tesr(tmp_path, version=version, **ori(descriptor + convention, table[1:])), True, newer)
    for kind in ("ascii", "binary"):
        path = tesr(tmp_path, version=version, **oridata(descriptor + convention, table, kind))
        outcome(path, True, newer or "means over")


# Neper's example of both words: a turn of 30 degrees about x, whose Rodrigues vector is (tan 15, 0, 0).
@pytest.mark.parametrize("version, word", [("2.0", "active"), ("2.1", "active"), ("2.2", "passive")])
@pytest.mark.parametrize("section", [ori, oridata])
def test_the_documented_example_of_neper(tmp_path, version, word, section):
    wanted = np.tile(bunge_to_quaternion(np.radians([0, 30.0, 0])), (4, 1))
    vectors = np.tile([0.268, 0, 0], (4, 1))  # three digits: within 0.01 degrees
    for turned in (1, -1):
        name = f"rodrigues:{word if turned == 1 else {'active': 'passive', 'passive': 'active'}[word]}"
        rows = turned * (vectors[1:] if section is ori else vectors)
        path = tesr(tmp_path, version=version, **section(name, rows))
        read = read_voxels(path).voxels.orientations[1:]
        assert angle_between(read, wanted[1:]).max() < 0.01


@pytest.mark.parametrize(
    "version, descriptor, words",
    [
        ("2.2", "rodrigues", "rodrigues:passive .Bunge's rotation. or rodrigues:active"),
        ("2.3", "rodrigues", "so write rodrigues:passive"),
        ("", "rodrigues:active", "format is ''; expected 2.0, 2.1 or 2.2"),
        ("new", "rodrigues:active", "format is 'new'"),
        ("2.2", "rodrigues:other", "'rodrigues:other'"),
    ],
)
@pytest.mark.parametrize("section", [ori, oridata])
def test_orientations_that_do_not_say_their_way(tmp_path, version, descriptor, words, section):
    rows = VECTORS[1:] if section is ori else VECTORS
    outcome(tesr(tmp_path, version=version, **section(descriptor, rows)), False, words)


@pytest.mark.parametrize("version", ["", "new", "9.9"])
def test_without_orientations_the_format_does_not_matter(tmp_path, version):
    assert np.array_equal(read_voxels(tesr(tmp_path, version=version)).voxels.labels, LABELS)


@pytest.mark.parametrize("kind", ["ascii", "binary8", "binary16", "binary32_big"])
def test_the_layout_of_format_2_0(tmp_path, kind):
    """The kind of all data stands behind the version (Neper up to 4.1.2)."""
    dtype = {"binary8": "u1", "binary16": "<i2", "binary32_big": ">i4"}.get(kind)
    flat = LABELS.ravel(order="F")
    cells = flat.astype(dtype).tobytes() if dtype else " ".join(map(str, flat)).encode()
    rows = VECTORS[flat]
    numbers = rows.astype("<f8").tobytes() if dtype else text(rows).encode()
    head = f"***tesr\n **format\n   2.0 {kind}\n **general\n   3\n   3 4 5\n   1 1 1\n   *hasvoid 0\n"
    (tmp_path / "v.tesr").write_bytes(
        head.encode() + b" **data\n" + cells + b"\n **oridata\n   R\n" + numbers + b"\n***end\n"
    )
    voxels = outcome(tmp_path / "v.tesr", True, "means over")
    assert np.array_equal(voxels.labels, LABELS)


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


@pytest.mark.parametrize(
    "word, structure",
    [("cubic", "cubic"), ("m-3m", "cubic"), ("6/mmm", "hexagonal"), ("-3m", "trigonal"), ("unknown", None)],
)
def test_symmetries_of_neper(tmp_path, word, structure):
    raw = read_voxels(tesr(tmp_path, ori=f"  *crysym\n   {word}\n"))
    assert [crystal.structure for crystal in raw.voxels.crystals.values()] == (
        [structure] if structure else []
    )


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
    assert outcome(path, None, r"not read: .*Phases \(3 rows\)").phases.tolist() == [0, 1, 1, 2]
