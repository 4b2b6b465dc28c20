"""The deck says what the mesh is, in a form that both solvers read."""

import errno
import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from deck_reader import (
    elements_of,
    load_judge,
    node_sets_of,
    of_kind,
    points_of,
    read_deck,
    surfaces_of,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.deck.check_deck import check_deck
from craftmesh.deck.includes import read_blocks, read_deck_text
from craftmesh.deck.inp_format import number
from craftmesh.deck.parts import NAMING
from craftmesh.deck.step_lines import step_lines
from craftmesh.deck.write_deck import DeckOptions, write_deck
from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.load import Fixed, Load
from craftmesh.mesh.second_order import raise_order

ROOT = Path(__file__).resolve().parents[2]
COPPER = ("cubic:168.4e3,121.4e3,75.4e3",)


def label_of(centres):
    labels = np.where(centres[:, 0] < 3, 4, 11)
    labels[(np.abs(centres - [1.5, 1.5, 0.5]) < 0.6).all(axis=1)] = -2
    labels[(centres[:, 0] > 5) & (centres[:, 2] > 3)] = 0
    return labels


def cracked_mesh():
    crack = plane_crack(2, 2, hexagon((3, 3), 2))
    return assemble(
        *structured_box((6, 6, 4), label_of, crack, (0.1, 1 / 3, 1e-5 / 3), (-0.7, 12.0, -1e-5))
    )[0]


def quaternions(count=12):
    rows = np.random.default_rng(5).normal(size=(count, 4))
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


@settings(max_examples=300)
@given(st.floats(min_value=-1e300, max_value=1e300))
def test_numbers_fit_a_field_and_read_back(value):
    text = number(value)
    assert len(text) <= 20
    # Cut numbers keep 13 digits at the least: sign, point and a three-digit exponent leave no more.
    assert float(text) == (value if len(repr(value)) <= 20 else pytest.approx(value, rel=5e-13, abs=1e-310))


@settings(max_examples=300)
@given(st.floats(min_value=1e-6, max_value=1e9))
def test_coordinates_keep_every_bit_or_fifteen_digits(value):
    for signed in (value, -value):
        exact = value >= 0.1
        assert float(number(signed)) == (signed if exact else pytest.approx(signed, rel=5e-15))


@pytest.mark.parametrize("element", ["C3D4", "C3D10"])
def test_the_deck_holds_the_mesh(element, tmp_path):
    mesh = cracked_mesh()
    write_deck(tmp_path / "model.inp", mesh, DeckOptions(element=element))
    blocks = read_deck(tmp_path / "model.inp")
    mesh = mesh if element == "C3D4" else raise_order(mesh)
    found = points_of(blocks)
    assert (found[:, :2] == mesh.points[:, :2]).all()
    assert np.allclose(found, mesh.points, rtol=5e-15, atol=0)
    elements, sets = elements_of(blocks)
    assert (np.array([elements[i + 1] for i in range(len(mesh.tets))]) == mesh.tets + 1).all()
    for grain in (4, 11):
        assert sets[f"GRAIN_{grain}"] == (np.flatnonzero(mesh.grain == grain) + 1).tolist()
    assert sorted(sets["EALL"]) == list(range(1, len(mesh.tets) + 1))
    assert node_sets_of(blocks) == {name: (nodes + 1).tolist() for name, nodes in mesh.node_sets.items()}
    assert surfaces_of(blocks) == {
        name: set(map(tuple, (faces + 1).tolist())) for name, faces in mesh.face_sets.items()
    }
    assert {"VOID_2", "EXTERIOR", "CRACK_LIP_A", "CRACK_LIP_B"} <= set(surfaces_of(blocks))
    assert {p["TYPE"] for p, _ in of_kind(blocks, "ELEMENT")} == {element}


@pytest.mark.parametrize("element", ["C3D4", "C3D10"])
def test_the_judge_finds_no_fault(element, tmp_path):
    judge = load_judge(ROOT)
    write_deck(
        tmp_path / "model.inp", cracked_mesh(), DeckOptions(element=element, material=COPPER), quaternions()
    )
    found = judge.judge(tmp_path / "model.inp")
    assert found["faults"] == [] and found["grain_sets"] == 2 and found["crack_lip_faces"] == 2 * 24
    assert found["front_nodes_missed_by_set"] == found["front_set_extra"] == 0
    assert found["front_edges"] == 12 and found["front_ends"] == 0 and all(found["has"].values())


def test_orientations_are_columns_of_the_rotation(tmp_path):
    orientations = quaternions()
    write_deck(tmp_path / "model.inp", cracked_mesh(), DeckOptions(material=COPPER), orientations)
    blocks = read_deck(tmp_path / "model.inp")
    axes = {p["NAME"]: np.array(rows[0], float).reshape(2, 3) for p, rows in of_kind(blocks, "ORIENTATION")}
    assert sorted(axes) == ["ORI_11", "ORI_4"]
    for grain in (4, 11):
        w, *v = orientations[grain]
        for crystal, sample in zip(
            np.eye(3), axes[f"ORI_{grain}"]
        ):  # rotate by v + 2 w (u x v) + 2 u x (u x v)
            turned = crystal + 2 * w * np.cross(v, crystal) + 2 * np.cross(v, np.cross(v, crystal))
            assert np.allclose(sample, turned, atol=1e-15)
    sections = {p["ELSET"]: p["ORIENTATION"] for p, _ in of_kind(blocks, "SOLID SECTION")}
    assert sections == {"GRAIN_4": "ORI_4", "GRAIN_11": "ORI_11"}
    ((_, rows),) = of_kind(blocks, "ELASTIC")
    assert [len(row) for row in rows] == [8, 8, 5]


def test_grains_without_orientation(tmp_path):
    orientations = quaternions()
    orientations[11] = np.nan
    with pytest.raises(CraftmeshError, match="cubic needs an orientation.* 1 have none.*11"):
        write_deck(tmp_path / "model.inp", cracked_mesh(), DeckOptions(material=COPPER), orientations)
    assert list(tmp_path.iterdir()) == []
    write_deck(tmp_path / "model.inp", cracked_mesh(), DeckOptions(), orientations)
    sections = of_kind(read_deck(tmp_path / "model.inp"), "SOLID SECTION")
    assert [p.get("ORIENTATION") for p, _ in sections] == ["ORI_4", None]
    write_deck(tmp_path / "model.inp", cracked_mesh(), DeckOptions())
    assert of_kind(read_deck(tmp_path / "model.inp"), "ORIENTATION") == []


def test_materials_follow_the_phases(tmp_path):
    phases = np.zeros(12, int)
    phases[[4, 11]] = 2, 1
    options = DeckOptions(material=("1=isotropic:1,0", "2=isotropic:2,0"))
    write_deck(tmp_path / "model.inp", cracked_mesh(), options, phases=phases)
    sections = of_kind(read_deck(tmp_path / "model.inp"), "SOLID SECTION")
    assert {p["ELSET"]: p["MATERIAL"] for p, _ in sections} == {"GRAIN_4": "PHASE_2", "GRAIN_11": "PHASE_1"}
    phases[4] = 7
    with pytest.raises(CraftmeshError, match="grain 4 has phase 7"):
        write_deck(tmp_path / "model.inp", cracked_mesh(), options, phases=phases)
    with pytest.raises(CraftmeshError, match="grains have no phase"):
        write_deck(tmp_path / "model.inp", cracked_mesh(), options)


def test_the_step_pulls_along_the_axis(tmp_path):
    mesh = cracked_mesh()
    write_deck(tmp_path / "a.inp", mesh, DeckOptions(axis="y", magnitude=0.01, sides="rollers"))
    fixed, pulled = (rows for _, rows in of_kind(read_deck(tmp_path / "a.inp"), "BOUNDARY"))
    assert fixed == [["XMIN", "1", "1"], ["YMIN", "2", "2"], ["ZMIN", "3", "3"]]
    assert pulled[0][:3] == ["YMAX", "2", "2"] and float(pulled[0][3]) == pytest.approx(0.01 * 2)
    write_deck(tmp_path / "b.inp", mesh, DeckOptions(load="stress", magnitude=50))
    blocks = read_deck(tmp_path / "b.inp")
    ((_, held),) = of_kind(blocks, "BOUNDARY")
    assert [row[1:] for row in held] == [["3", "3"], ["1", "1"], ["2", "2"], ["2", "2"]]
    assert held[1][0] == held[2][0] != held[3][0]
    assert of_kind(blocks, "DSLOAD")[0][1] == [["ZMAX", "P", "-50.0"]]
    write_deck(tmp_path / "c.inp", mesh, DeckOptions(load="none"))
    assert of_kind(read_deck(tmp_path / "c.inp"), "STEP") == []


@pytest.mark.parametrize("axis", "xyz")
def test_plates_face_the_body_and_close_in_on_it(axis, tmp_path):
    mesh, k = cracked_mesh(), "xyz".index(axis)
    write_deck(tmp_path / "a.inp", mesh, DeckOptions(load="plates", axis=axis, magnitude=-0.02))
    blocks = read_deck(tmp_path / "a.inp")
    assert check_deck(tmp_path / "a.inp") == []
    nodes = {p["NSET"]: rows for p, rows in of_kind(blocks, "NODE")}
    touching = [rows[0] for _, rows in of_kind(blocks, "CONTACT PAIR")]
    planes = [f"{axis.upper()}{end}" for end in ("MIN", "MAX")]
    assert touching == [[plane, f"PLATE_{plane}"] for plane in planes]
    discs = {p["NAME"]: rows for p, rows in of_kind(blocks, "SURFACE")}
    for node, plane in enumerate(planes, start=len(nodes["NALL"]) + 1):
        place, start, line = discs[f"PLATE_{plane}"]
        at, towards = np.array(place, float).reshape(2, 3)
        assert nodes[f"PLATE_{plane}"] == [[str(node), *place[:3]]]
        assert at[k] == mesh.points[mesh.node_sets[plane][0], k]
        # from the axis outwards the left side of the profile is ahead on the axis, and there the body is
        assert start == ["START", "0.0", "0.0"] and line[2] == "0.0"
        assert (np.sign(mesh.points[:, k] - at[k]) * np.sign((towards - at)[k]) >= 0).all()
        assert float(line[1]) > np.linalg.norm(np.delete(mesh.points - at, k, axis=1), axis=1).max()
    moved = of_kind(blocks, "BOUNDARY")[-1][1]
    way = -0.02 * np.ptp(mesh.points[:, k])
    assert [row[:3] for row in moved] == [[f"PLATE_{planes[1]}", str(k + 1), str(k + 1)]]
    assert float(moved[0][3]) == pytest.approx(way)
    held = [row[0] for _, rows in of_kind(blocks, "BOUNDARY") for row in rows]
    assert not {*planes} & {*held}  # the body's own nodes are free to leave the plates
    with pytest.raises(CraftmeshError, match="plates only compress"):
        DeckOptions(load="plates", magnitude=0.01)


def test_a_pressure_on_the_lips_comes_to_the_load_or_acts_alone(tmp_path):
    mesh = cracked_mesh()
    lips = [[f"CRACK_LIP_{side}", "P", "3.0"] for side in "AB"]
    write_deck(tmp_path / "a.inp", mesh, DeckOptions(load="stress", magnitude=50, lip_pressure=3))
    assert of_kind(read_deck(tmp_path / "a.inp"), "DSLOAD")[0][1] == [["ZMAX", "P", "-50.0"], *lips]
    write_deck(tmp_path / "b.inp", mesh, DeckOptions(load="none", lip_pressure=3))
    blocks = read_deck(tmp_path / "b.inp")
    assert of_kind(blocks, "DSLOAD")[0][1] == lips and check_deck(tmp_path / "b.inp") == []
    ((_, held),) = of_kind(blocks, "BOUNDARY")
    assert len(held) == 6  # as few as hold a body
    whole = assemble(*structured_box((2, 2, 2), lambda centres: np.ones(len(centres), int)))[0]
    severed = plane_crack(2, 2, lambda centres: np.ones(len(centres), bool))
    parted = assemble(*structured_box((2, 2, 4), lambda centres: np.ones(len(centres), int), severed))[0]
    for other, said in ((whole, "no lips"), (parted, "force of .* along z on the separate piece")):
        with pytest.raises(CraftmeshError, match=said):
            write_deck(tmp_path / "c.inp", other, DeckOptions(load="none", lip_pressure=3))


def test_same_input_gives_the_same_bytes_in_files_and_streams(tmp_path):
    write_deck(tmp_path / "a.inp", cracked_mesh())
    stream = io.StringIO()
    write_deck(stream, cracked_mesh())
    assert (tmp_path / "a.inp").read_bytes() == stream.getvalue().encode("ascii")


@pytest.mark.parametrize("includes", [False, True])
def test_a_deck_of_parts_is_the_flat_one_in_another_order(includes, tmp_path):
    mesh = cracked_mesh()
    flat = DeckOptions(
        material=COPPER, lip_contact=True, faces=("ZMIN.z=fixed", "ZMAX.z=strain:1e-3", "XMAX.y=stress:9")
    )
    flat = replace(flat, faces=(*flat.faces, "XMIN.y=fixed", "XMIN.x=fixed"))
    for name, options in (("flat", flat), ("parts", replace(flat, style="parts", includes=includes))):
        write_deck(tmp_path / f"{name}.inp", mesh, options, quaternions())
    assert check_deck(tmp_path / "parts.inp") == []
    assert load_judge(ROOT).judge(tmp_path / "parts.inp")["faults"] == []
    one, other = (read_blocks(read_deck_text(tmp_path / f"{name}.inp")) for name in ("flat", "parts"))
    levels = [block.keyword for block in other]
    part, model = levels.index("PART"), levels.index("END ASSEMBLY")
    assert levels[part + 1] == "NODE" and levels[part + 1 : model].count("SOLID SECTION") == 2
    assert set(levels[:part]) == {"HEADING"} and "STEP" in levels[model:] and "MATERIAL" in levels[model:]
    loads = "".join(block.data for block in other if block.keyword in NAMING)
    named = {row.split(",")[0] for row in loads.split("\n") if row}
    assert {"BODY-1.ZMAX", "BODY-1.CRACK_LIP_A"} <= named and all(w.startswith("BODY-1.") for w in named)
    assert any(word.removeprefix("BODY-1.").isdecimal() for word in named)  # forces of single nodes
    of_parts = ("PART", "END PART", "ASSEMBLY", "INSTANCE", "END INSTANCE", "END ASSEMBLY")
    words = [
        sorted(
            (block.keyword, sorted(block.parameters.items()), block.data.replace("BODY-1.", "").split())
            for block in blocks
            if block.keyword not in of_parts
        )
        for blocks in (one, other)
    ]
    assert words[0] == [(k, p, [w for w in d if w]) for k, p, d in words[1]]


def test_a_deck_of_the_mesh_alone_has_its_sets_and_no_more(tmp_path):
    write_deck(tmp_path / "flat.inp", cracked_mesh(), DeckOptions())
    write_deck(tmp_path / "mesh.inp", cracked_mesh(), DeckOptions(style="mesh", lip_contact=True))
    assert check_deck(tmp_path / "mesh.inp") == []
    assert load_judge(ROOT).judge(tmp_path / "mesh.inp")["faults"] == []
    flat, mesh = ((tmp_path / f"{name}.inp").read_text() for name in ("flat", "mesh"))
    assert flat.startswith(mesh) and "*MATERIAL" in flat[len(mesh) :] and "*STEP" in flat[len(mesh) :]
    with pytest.raises(CraftmeshError, match="includes is true, but style mesh writes only the mesh"):
        DeckOptions(style="mesh", includes=True)


def files_in(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_a_deck_with_includes_is_the_flat_one_in_two_files(tmp_path):
    options = DeckOptions(material=COPPER, quarter_points=True)
    write_deck(tmp_path / "flat.inp", cracked_mesh(), options, quaternions())
    for folder in ("a", "b"):
        model = tmp_path / folder / "Model-1.inp"
        write_deck(model, cracked_mesh(), replace(options, includes=True), quaternions())
    found = files_in(tmp_path / "a")
    assert found == files_in(tmp_path / "b") and sorted(found) == ["Model-1.inp", "Model-1_mesh.inp"]
    line = b"*INCLUDE, INPUT=Model-1_mesh.inp\n"
    note, _, mesh = found["Model-1_mesh.inp"].partition(b"\n")
    assert note.startswith(b"** ") and found["Model-1.inp"].count(line) == 1
    assert found["Model-1.inp"].replace(line, mesh) == (tmp_path / "flat.inp").read_bytes()
    assert b"\n*NODE," not in found["Model-1.inp"] and check_deck(tmp_path / "a" / "Model-1.inp") == []


def test_a_deck_with_includes_is_there_whole_or_not_at_all(tmp_path, monkeypatch):
    options = DeckOptions(includes=True)
    write_deck(tmp_path / "m.inp", cracked_mesh(), options)
    before = files_in(tmp_path)

    def no_space(mesh):
        yield "*NSET, NSET=HALF\n"
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr("craftmesh.deck.write_deck.set_lines", no_space)
        with pytest.raises(CraftmeshError, match="No space left"):
            write_deck(tmp_path / "m.inp", cracked_mesh(), replace(options, magnitude=0.9))
    assert files_in(tmp_path) == before
    (tmp_path / "m_mesh.inp").unlink()
    (tmp_path / "m_mesh.inp").mkdir()
    with pytest.raises(CraftmeshError, match="m.inp: cannot be written"):
        write_deck(tmp_path / "m.inp", cracked_mesh(), replace(options, magnitude=0.9))
    assert (tmp_path / "m.inp").read_bytes() == before["m.inp"]


def test_includes_need_a_plain_name_and_a_folder(tmp_path):
    for name in ("my model.inp", "größe.inp", "a,b.inp"):
        with pytest.raises(CraftmeshError, match="includes need a plain file name"):
            write_deck(tmp_path / name, cracked_mesh(), DeckOptions(includes=True))
    with pytest.raises(CraftmeshError, match="a stream has no place"):
        write_deck(io.StringIO(), cracked_mesh(), DeckOptions(includes=True))
    assert list(tmp_path.iterdir()) == []


def test_quarter_points_reach_the_deck(tmp_path):
    report = write_deck(tmp_path / "m.inp", cracked_mesh(), DeckOptions(quarter_points=True))
    straight = raise_order(cracked_mesh()).points
    found = points_of(read_deck(tmp_path / "m.inp"))
    moved = ~np.isclose(found, straight, rtol=1e-12, atol=0).all(axis=1)
    assert moved.sum() == report["quarter_points"] > 0 and report["quarter_points_refused"] == 0


def test_what_the_deck_cannot_say_is_refused(tmp_path):
    with pytest.raises(CraftmeshError, match="10-node tetrahedra"):
        write_deck(tmp_path / "a.inp", raise_order(cracked_mesh()), DeckOptions(element="C3D4"))

    def ball(centres):
        return np.where(np.abs(centres - 2).max(axis=1) < 1, 1, 0)

    foam = assemble(*structured_box((4, 4, 4), ball))[0]
    with pytest.raises(CraftmeshError, match="no nodes on ZMIN"):
        write_deck(tmp_path / "a.inp", foam)
    write_deck(tmp_path / "a.inp", foam, DeckOptions(load="none"))


def test_moves_of_single_nodes_are_written_in_the_step():
    nodes = np.array([4, 9])
    held = (Fixed(nodes, 0), Fixed(nodes, 1, np.array([0.25, -1.0])))
    load = Load(held, moved=(Fixed(nodes, 2, 0.5), Fixed(nodes, 0, 0.5, "ZMAX")))
    before, after = "".join(step_lines(load, cracked_mesh())).split("*STEP\n*STATIC\n")
    assert before.split() == "*BOUNDARY 5, 1, 1 10, 1, 1".split()
    moves = after.partition("*NODE FILE")[0].splitlines()
    assert moves[0] == "*BOUNDARY" and moves[1:] == [
        "5, 2, 2, 0.25",
        "10, 2, 2, -1.0",
        "5, 3, 3, 0.5",
        "10, 3, 3, 0.5",
        "ZMAX, 1, 1, 0.5",
    ]


def test_shear_is_written_as_the_forces_of_its_nodes(tmp_path):
    """CalculiX reads no other: on 10-node elements the middles of edges bear all of it."""
    rows = [f"{face}=stress:30" for face in ("ZMIN.x", "ZMAX.x", "XMIN.z", "XMAX.z")]
    mesh, _ = assemble(*structured_box((2, 3, 4), lambda c: np.ones(len(c), int), None, (0.5, 1.0, 0.25)))
    write_deck(tmp_path / "a.inp", mesh, DeckOptions(faces=(*rows, "ZMIN.z=stress:7", "ZMAX.z=stress:7")))
    deck = (tmp_path / "a.inp").read_text()
    step = deck.partition("*STEP")[2]
    assert "*DSLOAD\nZMIN, P, -7.0\nZMAX, P, -7.0\n*CLOAD\n" in step
    lines = step.partition("*CLOAD\n")[2].partition("*NODE FILE")[0].split()
    loads = np.array(lines, object).reshape(-1, 3)
    node, axis = (np.array([int(text.rstrip(",")) for text in column]) for column in loads.T[:2])
    force = loads[:, 2].astype(float)
    assert node.min() > len(mesh.points)  # corners of the linear mesh keep their numbers
    lengths = np.ptp(mesh.points, axis=0)
    assert set(axis.tolist()) == {1, 3}
    for k, faces in ((1, 2), (3, 0)):
        area = lengths.prod() / lengths[faces]
        assert np.abs(force[axis == k]).sum() == pytest.approx(2 * 30 * area, rel=1e-12)
        assert force[axis == k].sum() == pytest.approx(0, abs=1e-9 * area)
