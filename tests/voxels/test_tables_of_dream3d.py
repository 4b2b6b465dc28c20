"""Which orientations, phases and crystals of a .dream3d are its grain ids', in all four layouts.

Each fault is refused or noted, and what is taken is right: one row a fault.
"""

import h5py
import numpy as np
import pytest
from side_tables import (
    DEGREES,
    HALF_COLUMNS,
    HALF_ROWS,
    LABELS,
    MATRICES,
    NEITHER,
    OTHER,
    PARENTS,
    PHASES,
    QUATERNIONS,
    RADIANS,
    SMALL,
    dream3d,
    ids_of,
    longer,
    outcome,
)

from craftmesh.mechanics.orientation import bunge_to_quaternion
from craftmesh.voxels.reading import ReadOptions

EULERS = ("", "AvgEulerAngles", RADIANS)
CELL_EULERS = ("EulerAngles", RADIANS[LABELS])


# fault: tables, cells, options, whether the orientations are right, None: none, False: refused; words
DREAM3D = {
    "degrees": ([("", "AvgEulerAngles", DEGREES)], [], {}, True, "read as degrees"),
    "degrees by cell": ([], [("EulerAngles", DEGREES[LABELS])], {}, True, "read as degrees"),
    "half of the angles": ([("", "EulerAngles", HALF_COLUMNS)], [], {}, False, "to radians or degrees"),
    "half of the grains": ([("", "EulerAngles", HALF_ROWS)], [], {}, False, "1 of 3 rows"),
    "neither": ([("", "EulerAngles", NEITHER)], [], {}, False, "reach 1000"),
    "neither by cell": ([], [("EulerAngles", NEITHER[LABELS])], {}, False, "reach 1000"),
    "the user's unit": ([("", "EulerAngles", DEGREES)], [], {"angles": "degrees"}, True, ""),
    "not the user's": ([("", "EulerAngles", DEGREES)], [], {"angles": "radians"}, False, "too much for"),
    "not indexed": ([], [("EulerAngles", np.where((LABELS == 1)[..., None] & (np.arange(5) > 2)[:, None],
                    4 * np.pi, RADIANS[LABELS]))], {}, True, "means over"),
    "cells only": ([], [CELL_EULERS], {}, True, "means over"),
    "two tables": ([EULERS, ("More", "EulerAngles", OTHER)], [], {}, False, "fit ids up.*AvgEuler.*More"),
    "table not numbered": ([("", "AvgEulerAngles", RADIANS[1:])], [], {}, None, r"not read.*\(3 rows\)"),
    "short": ([("", "AvgEulerAngles", RADIANS[:2])], [CELL_EULERS], {}, True, r"not read.*\(2 rows\)"),
    "long": ([("", "AvgEulerAngles", longer(RADIANS))], [], {}, True, "6 rows, but ids reach 3"),
    "not described": ([("", "AvgEulerAngles", RADIANS), ("", "Centroids", OTHER)], [], {}, True, ""),
    "unread": ([EULERS, ("", "AvgQuats", QUATERNIONS)], [CELL_EULERS], {}, True, "not read: .*AvgQuats"),
    "beside": ([("Elsewhere", "EulerAngles", RADIANS)], [], {}, True, ""),
}  # fmt: skip


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
        outcome(path, True, "not read: .*AvgEulerAngles", ReadOptions(table=table), wanted)
    outcome(path, False, r"ids reach 3, but the table given has 2 rows", ReadOptions(table=f"{group}/Few"))
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
    made = outcome(path, right, "not read: .*FeatureIds" if right else "several tables", options, wanted)
    if more and parents is not PARENTS:
        outcome(path, True, "not read: .*NewGrainData")  # what lists parents is the features'
    if parents is PARENTS:
        assert made.phases.tolist() == [0, 2, 1]
        assert outcome(path, True, "not read: .*ParentIds").phases.tolist() == PHASES.tolist()


@pytest.mark.parametrize("version", [4, 5, 7, 8])
def test_the_table_of_the_features_is_not_that_of_the_parents(tmp_path, version):
    path = dream3d(tmp_path, version, [EULERS], parents=PARENTS)
    outcome(path, None, "not read: .*AvgEulerAngles", ReadOptions(dataset=ids_of(version, "ParentIds")))


@pytest.mark.parametrize("version", [4, 5, 7, 8])
@pytest.mark.parametrize("by_cell", [False, True])
def test_quaternions_of_dream3d_where_there_are_no_angles(tmp_path, version, by_cell):
    """They are (x, y, z, w) of the rotation from sample to crystal axes, up to version 5 of its inverse.

    Row 0 is a row of zeros.
    """
    stored = (QUATERNIONS * ([1, 1, 1, 1] if version < 6 else [1, -1, -1, -1]))[:, [1, 2, 3, 0]]
    stored[0] = 0
    tables, cells = [("", "AvgQuats", stored)], [("Quats", stored[LABELS])]
    path = dream3d(tmp_path, version, *(([], cells) if by_cell else (tables, [])))
    outcome(path, True, "means over" if by_cell else "")


@pytest.mark.parametrize("version", [7, 8])
@pytest.mark.parametrize("place", ["/Features", "/Container/Features"])
def test_a_table_beside_the_geometry_after_those_within(tmp_path, version, place):
    outcome(dream3d(tmp_path, version, [(place, "EulerAngles", RADIANS)]), True, "")
    outcome(dream3d(tmp_path, version, [(place, "EulerAngles", OTHER), EULERS]), True, "read: .*Features")


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
    outcome(path, True, "not read: .*Other/CellData/FeatureIds", ReadOptions(dataset=ids_of(version)))


@pytest.mark.parametrize("version", [4, 5, 7, 8])
@pytest.mark.parametrize(
    "places, crystals, words",
    [
        ({"Ensembles": [999, 1, 0]}, {1: ("cubic", "a"), 2: ("hexagonal", "b")}, ""),
        ({"Ensembles": [999, 1, 999]}, {1: ("cubic", "a"), 2: ("", "b")}, ""),
        ({"Ensembles": [999, 1]}, {}, "not read: .*CrystalStructures"),  # no row for phase 2
        ({"Ensembles": [999, 1], "More": [999, 10, 8]}, {1: ("trigonal", "a"), 2: ("tetragonal", "b")}, ""),
        ({"Ensembles": [999, 1, 1], "More": [999, 0, 8]}, {}, "not read: .*CrystalStructures"),
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
