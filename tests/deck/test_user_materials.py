"""Decks for user subroutines: constants by grain, steps, contact, and what is refused."""

import numpy as np
import pytest
import yaml
from deck_reader import of_kind, read_deck
from structured_box import hexagon, plane_crack, structured_box

from craftmesh.assembly.assemble import assemble
from craftmesh.deck.check_deck import check_deck
from craftmesh.deck.options import DeckOptions
from craftmesh.deck.write_deck import write_deck, write_model
from craftmesh.errors import CraftmeshError
from craftmesh.io.user_material import PRESETS, read_template
from craftmesh.mechanics.model import elastic_model
from craftmesh.mechanics.orientation import random_orientations
from craftmesh.mechanics.user_materials import parse_templates

GRAINS = (1, 2)
PHASES = np.array([0, 3, 1])


@pytest.fixture(scope="module")
def mesh():
    crack = plane_crack(2, 2, hexagon((2, 2), 1))
    return assemble(*structured_box((4, 4, 4), lambda c: np.where(c[:, 0] < 2, 1, 2), crack))[0]


def turns():
    found = random_orientations(3, np.random.default_rng(4))
    found[2] = [np.cos(0.4), 0, 0, np.sin(0.4)]  # about z: phi1 and phi2 are about one axis
    return found


def written(mesh, tmp_path, name, orientations=None, phases=None, **options):
    """Return the blocks of a deck with the user material of a preset or a file."""
    templates = parse_templates(read_template(str(name)), str(name))
    given = turns() if orientations is None else orientations
    options = DeckOptions(user_material=str(name), **options)
    write_deck(tmp_path / "model.inp", mesh, options, given, phases, templates)
    assert check_deck(tmp_path / "model.inp") == []
    return read_deck(tmp_path / "model.inp")


def constants_of(blocks):
    """Return {grain: constants} by the materials of the sections."""
    names = [p["NAME"] for p, _ in of_kind(blocks, "MATERIAL")]
    values = [[float(t) for row in rows for t in row] for _, rows in of_kind(blocks, "USER MATERIAL")]
    for (parameters, rows), found in zip(of_kind(blocks, "USER MATERIAL"), values):
        assert int(parameters["CONSTANTS"]) == len(found) and {len(row) for row in rows[:-1]} <= {8}
    by_name = dict(zip(names, values))
    sections = {p["ELSET"]: p["MATERIAL"] for p, _ in of_kind(blocks, "SOLID SECTION")}
    return {grain: by_name[sections[f"GRAIN_{grain}"]] for grain in GRAINS}


def matrix_of(quaternion):
    """Return the rotation matrix by v + 2 w (u x v) + 2 u x (u x v)."""
    w, *u = quaternion
    return np.array([v + 2 * w * np.cross(u, v) + 2 * np.cross(u, np.cross(u, v)) for v in np.eye(3)]).T


def about(axis, degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    found = np.eye(3)
    found[[i, i, j, j], [i, j, i, j]] = c, -s, s, c
    return found


@pytest.mark.parametrize("name", ["angles", "oxford"])
def test_bunge_angles_of_each_grain_are_its_rotation(mesh, tmp_path, name):
    found = constants_of(written(mesh, tmp_path, name, phases=PHASES))
    for grain in GRAINS:
        phi1, Phi, phi2, number, phase, *_ = found[grain]
        turn = about(2, phi1) @ about(0, Phi) @ about(2, phi2)
        assert np.allclose(turn, matrix_of(turns()[grain]), atol=1e-14)
        assert (number, phase) == (grain, PHASES[grain])


def test_huang_gets_two_axes_of_the_crystal_in_the_sample(mesh, tmp_path):
    blocks = written(mesh, tmp_path, "huang")
    for grain, values in constants_of(blocks).items():
        turn = matrix_of(turns()[grain])
        for first, column in ((56, 0), (64, 1)):
            assert values[first : first + 3] == np.eye(3)[column].tolist()
            assert np.allclose(values[first + 3 : first + 6], turn[:, column], atol=1e-15)
        assert values[96:99] == [541.5, 109.5, 60.8] and values[144:146] == [0.5, 1]
    assert of_kind(blocks, "ORIENTATION") == [] and of_kind(blocks, "DEPVAR")[0][1] == [["125"]]
    for parameters, rows in of_kind(blocks, "USER MATERIAL"):  # "all constants must be real numbers"
        assert "UNSYMM" in parameters and all({".", "e"} & set(text) for row in rows for text in row)
    assert all(p["NLGEOM"] == "YES" for p, _ in of_kind(blocks, "STEP"))


def test_one_material_for_all_has_an_orientation_per_grain(mesh, tmp_path):
    blocks = written(mesh, tmp_path, "single_crystal")
    assert [p["NAME"] for p, _ in of_kind(blocks, "MATERIAL")] == ["SINGLE_CRYSTAL"]
    axes = {p["NAME"]: np.array(rows[0], float).reshape(2, 3) for p, rows in of_kind(blocks, "ORIENTATION")}
    for grain in GRAINS:
        assert np.allclose(axes[f"ORI_{grain}"], matrix_of(turns()[grain])[:, :2].T, atol=1e-15)


def test_all_presets_are_sound():
    assert set(PRESETS) == {"angles", "huang", "oxford", "single_crystal"}
    for name in PRESETS:
        assert parse_templates(read_template(name), name)[None].about


def test_own_templates_hold_for_phases(mesh, tmp_path):
    own = {
        "constants": 2,
        "phases": {
            1: {"values": ["{phase}", "1.e3"], "depvar": 4},
            3: {"values": ["{q0}", "{r33}"], "name": "OWN"},
        },
    }
    path = tmp_path / "own.yaml"
    path.write_text(yaml.safe_dump(own))
    blocks = written(mesh, tmp_path, path, phases=PHASES)
    found = constants_of(blocks)
    assert found[2] == [1, 1000] and np.allclose(found[1], [turns()[1][0], matrix_of(turns()[1])[2, 2]])
    assert {p["NAME"] for p, _ in of_kind(blocks, "MATERIAL")} == {
        "OWN_PHASE_3_GRAIN_1",
        "MATERIAL_PHASE_1",
    }
    assert [p.get("ORIENTATION") for p, _ in of_kind(blocks, "SOLID SECTION")] == [None, "ORI_2"]
    with pytest.raises(CraftmeshError, match="user_material: grain 1 has phase 7"):
        written(mesh, tmp_path, path, phases=np.array([0, 7, 1]))
    with pytest.raises(CraftmeshError, match="grains have no phase"):
        written(mesh, tmp_path, path)


def test_grains_without_orientation_need_a_material_without_axes(mesh, tmp_path):
    unknown = np.full((3, 4), np.nan)
    with pytest.raises(CraftmeshError, match="user_material: grain 1 has no orientation.*oriented: false"):
        written(mesh, tmp_path, "single_crystal", unknown)
    path = tmp_path / "own.yaml"
    path.write_text("{constants: 1, values: [5], oriented: false}")
    blocks = written(mesh, tmp_path, path, unknown)
    assert constants_of(blocks) == {1: [5], 2: [5]} and of_kind(blocks, "ORIENTATION") == []


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[1, 2]", "not a template"),
        ("{constants: 1}", "has no values"),
        ("{constants: 2, values: [1]}", "values has 1 entries but constants is 2"),
        ("{constants: 1, values: ['{psi}']}", r"values has '\{psi\}'; expected numbers.*\{phi1\}"),
        ("{constants: 1, values: [1], state: 3}", "has key 'state'"),
        ("{constants: 1, values: [1], depvar: -3}", "depvar is -3; expected"),
        ("{constants: 1, phases: {a: {values: [1]}}}", "has phase 'a'"),
        ("{constants: 1, phases: 3}", "phases is 3"),
        ("{a", "expected YAML"),
    ],
)
def test_templates_that_are_none_are_refused_in_one_line(tmp_path, text, said):
    path = tmp_path / "own.yaml"
    path.write_text(text)
    with pytest.raises(CraftmeshError, match=said) as refused:
        parse_templates(read_template(str(path)), str(path))
    assert "\n" not in str(refused.value)
    with pytest.raises(CraftmeshError, match="gone.yaml does not exist; give angles, huang"):
        read_template(str(tmp_path / "gone.yaml"))


def test_steps_have_times_amplitudes_and_output(mesh, tmp_path):
    steps = ("ramp:0.5,time=2,increments=4", "sine:1,R=-1,cycles=2,time=3")
    asked = {"steps": steps, "output_every": 7, "restart_every": 5, "magnitude": 0.01}
    blocks = written(mesh, tmp_path, "single_crystal", **asked)
    ramp, cyclic = (np.array(rows[0], float) for _, rows in of_kind(blocks, "STATIC"))
    assert ramp == pytest.approx([0.5, 2, 5e-4, 0.5]) and cyclic == pytest.approx([0.15, 6, 1.5e-4, 0.15])
    ((named, rows),) = of_kind(blocks, "AMPLITUDE")
    assert {len(row) for row in rows[:-1]} == {8}  # Abaqus reads four pairs a line
    table = np.array([t for row in rows for t in row], float).reshape(-1, 2)
    assert table[0].tolist() == [0, 0.5] and table[-1].tolist() == [6, 0.5] and np.ptp(table[:, 1]) > 1.9
    first, second = of_kind(blocks, "BOUNDARY")
    moved = [float(row[3]) for _, rows in (first, second) for row in rows if row[0] == "ZMAX"]
    assert moved == pytest.approx([0.5 * 0.04, 0.04]) and second[0]["AMPLITUDE"] == named["NAME"]
    assert {p["FREQUENCY"] for p, _ in of_kind(blocks, "EL FILE")} == {"7"}
    assert {p["FREQUENCY"] for p, _ in of_kind(blocks, "RESTART")} == {"5"}


def test_a_traced_history_prints_faces_in_each_step_and_fields_after_the_last_alone(mesh, tmp_path):
    options = DeckOptions(steps=("ramp:1", "triangle:1,R=0"), magnitude=0.01)
    model, _ = elastic_model(mesh, options)
    write_model(tmp_path / "model.inp", model, options, traced=True)
    words = [block[0] for block in read_deck(tmp_path / "model.inp")]
    steps = " ".join(words).split("END STEP")[:-1]
    assert len(steps) == 4  # up, down, up again, and held for a moment
    assert all(step.count("EL PRINT") == 1 and step.count("NODE PRINT") == 1 for step in steps)
    assert ["EL FILE" in step for step in steps] == [False, False, False, True]
    assert "RESTART" not in words  # unless asked for


def test_steps_of_load_cases_replace_each_other(mesh, tmp_path):
    faces = ("ZMIN.z=fixed", "a/ZMAX.z=stress:30", "b/XMAX.z=stress:6", "b/ZMAX.x=stress:6")
    faces += ("b/XMIN.z=stress:6", "b/ZMIN.x=stress:6")
    options = DeckOptions(faces=faces, steps=("a/ramp:1", "b/ramp:2", "a/ramp:0"))
    write_deck(tmp_path / "model.inp", mesh, options)
    blocks = read_deck(tmp_path / "model.inp")
    pressures = [float(rows[0][2]) for _, rows in of_kind(blocks, "DSLOAD")]
    forces = [np.array(rows, float) for _, rows in of_kind(blocks, "CLOAD")]
    assert pressures == [-30, 0, 0] and [np.abs(f[:, 2]).sum() > 0 for f in forces] == [False, True, False]
    assert (forces[0][:, :2] == forces[1][:, :2]).all()
    with pytest.raises(CraftmeshError, match="user_material takes.*give steps, such as a/ramp:1"):
        DeckOptions(faces=faces, user_material="oxford")
    with pytest.raises(CraftmeshError, match="steps.*ZMAX.z"):
        DeckOptions(faces=("a/z=strain:1e-3", "b/z=stress:3"), steps=("a/ramp:1", "b/ramp:1"))


def test_plates_move_through_the_steps(mesh, tmp_path):
    steps = ("ramp:1", "triangle:1,R=0.5,cycles=1")
    blocks = written(mesh, tmp_path, "oxford", load="plates", magnitude=-1e-3, steps=steps)
    first = next(k for k, (keyword, _, _) in enumerate(blocks) if keyword == "STEP")
    moves = [
        row for _, rows in of_kind(blocks[first:], "BOUNDARY") for row in rows if row[0] == "PLATE_ZMAX"
    ]
    assert [(row[1], float(row[3])) for row in moves] == [("3", x * -4e-3) for x in (1, 0.5, 1)]
    names = {row[0] for _, rows in of_kind(blocks[first:], "BOUNDARY") for row in rows}
    assert {"PLATE_ZMIN", "PLATE_ZMAX"} <= names and not {"ZMIN", "ZMAX"} & names


def test_lips_get_a_contact_pair(mesh, tmp_path):
    write_deck(tmp_path / "model.inp", mesh, DeckOptions(lip_contact=True))
    blocks = read_deck(tmp_path / "model.inp")
    ((pair, rows),) = of_kind(blocks, "CONTACT PAIR")
    assert rows == [["CRACK_LIP_A", "CRACK_LIP_B"]]
    assert pair["INTERACTION"] == of_kind(blocks, "SURFACE INTERACTION")[0][0]["NAME"]
    assert not of_kind(blocks, "FRICTION")


def test_friction_of_lips_follows_the_contact_stiffness(mesh, tmp_path):
    """Abaqus reads the first number, the coefficient; CalculiX a slope too, below the contact stiffness."""
    write_deck(tmp_path / "model.inp", mesh, DeckOptions(lip_contact=True, lip_friction=0.3))
    blocks = read_deck(tmp_path / "model.inp")
    kinds = [kind for kind, *_ in blocks]
    first = kinds.index("SURFACE INTERACTION")
    assert kinds[first + 1 : first + 3] == ["SURFACE BEHAVIOR", "FRICTION"]
    ((_, [[stiffness]]),), ((_, [[coefficient, slope]]),) = (
        of_kind(blocks, kind) for kind in ("SURFACE BEHAVIOR", "FRICTION")
    )
    assert float(coefficient) == 0.3 and float(slope) == pytest.approx(0.1 * float(stiffness))
    assert check_deck(tmp_path / "model.inp") == []


def test_options_that_do_not_fit_are_refused(mesh, tmp_path):
    for options, said in (
        ({"steps": ("ramp:1",), "load": "none"}, "nothing is loaded"),
        ({"user_material": "oxford", "eigenstrain": ("isotropic:1e-3",)}, "an eigenstrain is given"),
    ):
        with pytest.raises(CraftmeshError, match=said):
            DeckOptions(**options)
    with pytest.raises(CraftmeshError, match="user_material is 'oxford', but no file is read here"):
        write_deck(tmp_path / "model.inp", mesh, DeckOptions(user_material="oxford"), turns())
