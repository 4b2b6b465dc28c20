"""Tables of what the faces bear: read, tried, and turned into supports and tractions."""

import numpy as np
import pytest
from structured_box import structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.faces import parse_faces
from craftmesh.mechanics.load import check_faces, load_on

LENGTHS = np.array([1.5, 2.0, 1.6])
SHEAR = ("ZMIN.x=stress:30", "ZMAX.x=stress:30", "XMIN.z=stress:30", "XMAX.z=stress:30")


def box(label_of=lambda c: np.ones(len(c), int)):
    return assemble(*structured_box((3, 4, 4), label_of, None, (0.5, 0.5, 0.4), (-1.0, 2.0, 5.0)))[0]


@pytest.mark.parametrize(
    "text",
    [
        "ZMAX=stress:1",
        "ZMAX.q=stress:1",
        "TOP.z=stress:1",
        "ZMAX.z=stress",
        "ZMAX.z=stress:nan",
        "ZMAX.z=fixed:1",
        "ZMAX.z=moved:1",
        "ZMAX.z",
        "",
    ],
)
def test_other_texts_are_refused(text):
    with pytest.raises(CraftmeshError, match="^faces: .* expected FACE.AXIS=fixed"):
        parse_faces([text])


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        (["ZMAX.z=strain:2"], "more than the body's length"),
        (["ZMAX.x=stress:30"], "leave a force of 30 along x on the body"),
        (["ZMIN.z=fixed", "ZMAX.x=stress:30"], "force of 30 along x"),
        (["ZMIN.x=stress:30", "ZMAX.x=stress:30"], "moment of 30 about y"),
        (["ZMAX.z=stress:5", "ZMIN.z=stress:4"], "force of 1 along z"),
        (["ZMIN.z=fixed", "XMAX.z=strain:0.01"], "meet in an edge"),
        (["XMIN.z=strain:0.01", "YMAX.z=strain:0.01"], "meet in an edge"),
    ],
)
def test_tables_that_are_wrong_in_every_body_are_refused(rows, said):
    with pytest.raises(CraftmeshError, match=said) as caught:
        check_faces(parse_faces(rows))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("rows", "single"),
    [
        ((), 6),
        (SHEAR, 6),
        (("ZMIN.z=fixed", "ZMAX.z=stress:5"), 3),
        (("ZMIN.z=fixed", "XMIN.x=fixed", "YMIN.y=fixed", "ZMAX.z=strain:0.01"), 0),
        (("ZMIN.x=fixed", "ZMIN.y=fixed", "ZMIN.z=fixed", "ZMAX.x=stress:5"), 0),
        (("ZMIN.x=fixed", "ZMAX.x=strain:0.01"), 3),
    ],
)
def test_what_a_balanced_table_leaves_free_is_held_once(rows, single):
    check_faces(parse_faces(rows))
    load = load_on(box(), parse_faces(rows))
    assert sum(len(part.nodes) == 1 for part in load.held) == single


def test_strains_are_lengths_over_that_across_the_face_outward_on_both():
    mesh = box()
    rows = parse_faces(["XMIN.y=strain:0.01", "XMAX.y=strain:0.02", "ZMIN.z=strain:-0.1"])
    near, far, up = load_on(mesh, rows).moved
    assert (near.axis, far.axis, up.axis) == (1, 1, 2)
    moves = np.array([near.displacement, far.displacement, up.displacement])
    assert moves == pytest.approx([-0.01 * LENGTHS[0], 0.02 * LENGTHS[0], 0.1 * LENGTHS[2]])


def test_a_hole_in_a_face_unbalances_the_stress_on_both():
    holed = box(lambda c: np.where((c[:, 2] > 3) & (np.abs(c[:, :2] - 1.5) < 0.6).all(axis=1), 0, 1))
    check_faces(parse_faces(["ZMIN.z=stress:8", "ZMAX.z=stress:8"]))
    with pytest.raises(CraftmeshError, match="force of -2 along z on the body"):
        load_on(holed, parse_faces(["ZMIN.z=stress:8", "ZMAX.z=stress:8"]))
