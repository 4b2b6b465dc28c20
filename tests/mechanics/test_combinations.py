"""Load cases and their sums, as texts say them."""

import numpy as np
import pytest
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.faces import parse_faces, rows_of
from craftmesh.mechanics.load import Fixed, Load, Traction, combined, nodal_forces
from craftmesh.mechanics.model import elastic_model
from craftmesh.mechanics.model_options import ModelOptions

HELD = ("ZMIN.x=fixed", "ZMIN.y=fixed", "ZMIN.z=fixed")
FACES = (*HELD, "pull/ZMAX.z=stress:5", "shear/ZMAX.x=stress:2", "lift/ZMAX.z=strain:0.001")


@pytest.mark.parametrize(
    ("combine", "said"),
    [
        ("peak", "'peak'; expected NAME=CASE:FACTOR"),
        ("peak=", "'peak='; expected NAME=CASE:FACTOR"),
        ("peak=pull", "expected NAME=CASE:FACTOR"),
        ("peak=pull:one", "expected NAME=CASE:FACTOR"),
        ("peak=pull:1,pull:2", "each load case once"),
        ("peak=pul:1", "has load case 'pul'; expected one of pull, shear, lift"),
        ("pull=pull:1", "'pull' is an invalid or duplicate name .* each name once"),
        ("a b=pull:1", "'a b' is an invalid or duplicate name"),
        ("peak=pull:1,lift:1", "adds pull and lift, but only one of these holds or moves ZMAX.z"),
    ],
)
def test_sums_that_are_none_are_refused_in_a_line(combine, said):
    with pytest.raises(CraftmeshError, match=f"^combine: .*{said}") as caught:
        ModelOptions(faces=FACES, combine=(combine,))
    assert "\n" not in str(caught.value)


def test_a_face_and_axis_has_one_row_in_each_load_case():
    for faces in (("ZMAX.z=fixed", "zmax.z=stress:1"), ("ZMAX.z=fixed", "a/ZMAX.z=stress:1")):
        with pytest.raises(CraftmeshError, match="^faces: ZMAX.z has several rows"):
            ModelOptions(faces=faces)
    ModelOptions(faces=("b/ZMAX.z=fixed", "a/ZMAX.z=stress:1"))


def test_without_sums_each_load_case_counts_and_a_single_load_has_no_name():
    cases = ModelOptions(faces=FACES, lip_pressure=3.0).combinations
    names = ("pull", "shear", "lift", "lip_pressure")
    assert [(one.name, one.factors) for one in cases] == [(name, {name: 1.0}) for name in names]
    assert ModelOptions(faces=HELD, lip_pressure=3.0).combinations == ()


def test_an_axis_alone_is_the_tension_along_it():
    rows = parse_faces(["y=strain:0.001", "pull/z=stress:5"])
    assert rows == parse_faces(
        ["YMIN.y=fixed", "YMAX.y=strain:0.001", "pull/ZMIN.z=fixed", "pull/ZMAX.z=stress:5"]
    )
    assert rows_of(rows, "pull") == rows and rows_of(rows, "") == rows[:2]


def test_a_sum_has_the_supports_of_its_cases_and_the_sum_of_what_they_bear():
    mesh, _ = assemble(*structured_box((2, 2, 2), lambda c: np.ones(len(c), int)))
    faces = (
        "ZMIN.z=fixed",
        "XMIN.x=strain:0.01",
        "a/ZMAX.z=stress:5",
        "b/YMAX.y=stress:2",
        "b/YMIN.y=stress:2",
    )
    model, _ = elastic_model(mesh, ModelOptions(faces=faces, combine=("sum=a:2,b:-3",)))
    loads = model.under(model.combinations[0]).load, *model.cases.values()
    both, a, b = ({(*p.nodes.tolist(), p.axis): p.displacement for p in (*l.held, *l.moved)} for l in loads)
    assert both.keys() == a.keys() == b.keys()
    assert all(both[key] == pytest.approx(2 * a[key] - 3 * b[key]) for key in both)
    forces, of_a, of_b = (nodal_forces(load.pulled, model.mesh) for load in loads)
    assert np.allclose(forces, 2 * of_a - 3 * of_b, atol=1e-12) and np.abs(forces).max() > 1


@pytest.mark.parametrize("factor", [1.0, 2.0, -0.5, 0.0])
def test_one_load_times_a_factor_is_each_part_of_it_times_the_factor(factor):
    nodes = np.arange(3)
    load = Load(
        (Fixed(nodes, 0, name="XMIN"), Fixed(nodes[:1], 1, 0.2)),
        (Fixed(nodes, 2, np.array([0.1, 0.3, -0.2]), "ZMAX"),),
        (Traction(np.zeros((1, 2), int), 4.0, "YMAX"), Traction(np.zeros((1, 2), int), -3.0, "YMAX", 0)),
        heat=2.0,
    )
    found = combined([(factor, load)])
    for one, other in zip((*found.held, *found.moved), (*load.held, *load.moved), strict=True):
        assert (one.name, one.axis) == (other.name, other.axis)
        assert one.displacement == pytest.approx(factor * other.displacement)
    for one, other in zip(found.pulled, load.pulled, strict=True):
        assert (one.name, one.axis, one.stress) == (other.name, other.axis, factor * other.stress)
    assert found.heat == factor * load.heat
    twice = combined([(factor, load), (factor, load)])
    assert [one.stress for one in twice.pulled] == [2 * one.stress for one in found.pulled]
    assert twice.heat == 2 * found.heat


def test_a_pressure_on_lips_is_a_load_case_beside_others():
    crack = plane_crack(2, 1, hexagon((2, 2), 1))
    mesh, _ = assemble(*structured_box((4, 4, 2), lambda c: np.ones(len(c), int), crack))
    options = ModelOptions(
        faces=(*HELD, "pull/ZMAX.z=stress:5"), lip_pressure=3.0, combine=("sum=pull:1,lip_pressure:-2",)
    )
    model, _ = elastic_model(mesh, options)
    pulled = {one.name: one.stress for one in model.under(model.combinations[0]).load.pulled}
    assert pulled == {"ZMAX": 5.0, "CRACK_LIP_A": 6.0, "CRACK_LIP_B": 6.0}
