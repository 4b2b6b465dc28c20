"""What a stage would refuse is refused before any job, in one line that names the key (and its case)."""

import sys
from types import SimpleNamespace

import pytest

from craftmesh.campaign.campaign import Campaign, read_campaign
from craftmesh.errors import CraftmeshError

HEADER = "case\tmicrostructure\tcrack\tincrements\tgrowth"
PENNY = {"shape": "penny", "centre": [8, 0, 8], "normal": [0, 0, 1], "radius": 4}
ISOTROPIC = "isotropic:70000,0.33"


@pytest.fixture
def read(tmp_path, monkeypatch):
    """Return a function that reads a campaign of one case, in a folder with a volume and other files."""
    monkeypatch.chdir(tmp_path)
    for name in ("v.npz", "v.stl", "v.xyz", "a.stl", "b.stl", "a.csv"):
        (tmp_path / name).touch()

    def campaign(config, increments=1, growth="prescribed", volume="v.npz", column="", cell="") -> Campaign:
        lines = [f"{HEADER}\t{column}".strip(), f"one\t{volume}\ta\t{increments}\t{growth}\t{cell}"]
        (tmp_path / "c.tsv").write_text("\n".join(lines))
        return read_campaign({"cases": "c.tsv", "cracks": {"a": PENNY}} | config)

    return campaign


WRONG_SECTIONS = [
    (
        {"inp": {"material": ["cubic:168400,121400"]}},
        "inp.material.* 2 constants; expected 3: c11, c12, c44",
    ),
    ({"inp": {"material": ["cubic 168400,121400,75400"]}}, "inp.material.*expected KIND:CONSTANTS"),
    (
        {"inp": {"material": ["cubc:168400,121400,75400"]}},
        "inp.material.*'cubc' is unknown; expected one of",
    ),
    ({"inp": {"material": ["cubic:100,200,50"]}}, "inp.material.*no positive strain energy"),
    ({"inp": {"material": ["isotropic:70000,0.5"]}}, "inp.material.*no positive strain energy"),
    ({"inp": {"material": ["isotropic:nan,0.3"]}}, "inp.material.*no positive strain energy"),
    ({"inp": {"material": ["isotropic:70e3;0.3"]}}, "inp.material.*expected KIND:CONSTANTS"),
    ({"inp": {"material": ["1=" + ISOTROPIC, ISOTROPIC]}}, "inp.material.*or one per phase"),
    ({"inp": {"material": ["1=" + ISOTROPIC] * 2}}, "inp.material.*second entry for its phase"),
    ({"inp": {"material": ["-1=" + ISOTROPIC]}}, "inp.material.*expected KIND:CONSTANTS"),
    ({"inp": {"material": []}}, "inp.material.*give one for all phases"),
    ({"inp": {"element": "C3D4", "quarter_points": True}}, "inp.quarter_points is true, .*C3D4"),
    ({"inp": {"magnitude": 100}}, "inp.magnitude is 100, a strain over 1 in size"),
    ({"inp": {"eigenstrain": ["1e-3"]}}, "inp.eigenstrain: '1e-3'; expected KIND:VALUES"),
    ({"inp": {"lip_traction": [1, 2]}}, "inp.lip_traction has 2 numbers; expected 3"),
    ({"inp": {"lip_field": "gone.csv"}}, "inp.lip_field: gone.csv does not exist"),
    ({"inp": {"residual_stress": "s.csv"}}, "inp.residual_stress: s.csv does not exist"),
    ({"inp": {"eigenstrain_file": "gone.csv"}}, "inp.eigenstrain_file: gone.csv does not exist"),
    (
        {"inp": {"temperature": "gone.csv", "eigenstrain": ["isotropic:1e-5"]}},
        "inp.temperature: gone.csv does not exist",
    ),
    ({"inp": {"user_material": "gone.yaml"}}, "inp.user_material: gone.yaml does not exist"),
    ({"inp": {"steps": ["saw:1"]}}, "inp.steps: 'saw:1'; expected ramp:LEVEL"),
    ({"inp": {"lip_pressure": "high"}}, "inp.lip_pressure is 'high'; expected a number"),
    ({"inp": {"axis": "zz"}}, "inp.axis is 'zz'; expected one of x, y, z"),
    ({"inp": {"load": "force"}}, "inp.load is 'force'; expected one of strain, stress, plates, none"),
    ({"tetrahedralize": {"mesher": "tetgn"}}, "tetrahedralize.mesher is 'tetgn'.* did you mean 'tetgen'"),
    ({"tetrahedralize": {"mesher": "gone:Mesher"}}, "tetrahedralize.mesher 'gone:Mesher' cannot be loaded"),
    ({"tetrahedralize": {"mesher": "math:Mesher"}}, "tetrahedralize.mesher 'math:Mesher' cannot be loaded"),
    ({"tetrahedralize": {"mesher": "math:pi"}}, "tetrahedralize.mesher 'math:pi' is 3.14"),
    ({"tetrahedralize": {"mesher": "math:sqrt"}}, "tetrahedralize.mesher 'math:sqrt': .*without arguments"),
    ({"tetrahedralize": {"mesher": "builtins:dict"}}, "tetrahedralize.mesher .* has no method mesh"),
    (
        {"tetrahedralize": {"mesher": "tetwild"}, "renew": {"reuse": "auto"}},
        "tetrahedralize.mesher is tetwild, .* but renew.reuse is auto; set reuse to never",
    ),
    ({"grow": {"criterion": "mts"}}, "grow.criterion is 'mts'; expected one of tangential_stress"),
    ({"grow": {"criterion": "broken_rule:angle"}}, "grow.criterion 'broken_rule:angle' cannot be loaded"),
    ({"grow": {"criterion": "math:angel"}}, "grow.criterion 'math:angel' cannot be loaded"),
    ({"inp": {"faces": ["ZMAX.q=stress:1"]}}, "inp.faces: 'ZMAX.q=stress:1'; expected FACE.AXIS=fixed"),
    (
        {"inp": {"faces": ["ZMAX.x=stress:30"]}},
        r"inp.faces cannot be applied \(tested .* force of 30 along x",
    ),
    (
        {"inp": {"faces": ["a/z=stress:1", "b/ZMAX.x=stress:1"]}},
        r"inp.faces cannot be applied \(tested .* force of 1 along x",
    ),
    ({"inp": {"combine": ["peak=a:1"]}}, "inp.combine: 'peak=a:1' has load case 'a'; expected one of none"),
    ({"grow": {"cycle": ["peak"]}}, "grow.cycle: unknown load case 'peak'; known: none"),
    ({"grow": {"cycle": ["a", "b", "c"]}}, "grow.cycle is a, b, c; name the largest load"),
    (
        {"inp": {"cohesive": ["all:stiffness=1e6"]}, "solve": {"solver": "calculix"}},
        "solve.solver is calculix, but its fields are not read from decks .*; use builtin",
    ),
    (
        {"inp": {"lip_contact": True}, "solve": {"solver": "abaqus"}},
        "solve.solver is abaqus, .* linear elastic, and the load comes in steps",
    ),
    (
        {
            "inp": {"load": "plates", "magnitude": -1e-3, "steps": ["ramp:1"]},
            "solve": {"solver": "calculix"},
        },
        "solve.solver is calculix, but it has no rigid plates",
    ),
    ({"solve": {"command": ["ccx {jb}"]}}, "solve.command 'ccx {jb}' is invalid .'jb'"),
    ({"solve": {"command": ["ccx '{job}"]}}, "solve.command .*No closing quotation"),
    ({"solve": {"command": [""]}}, "solve.command '' is empty"),
    ({"sizing": {"l_min": 3, "l_max": 2}}, "sizing.l_min is 3; expected at most l_max"),
    ({"sizing": {"points": "gone.csv"}}, "sizing.points: gone.csv does not exist"),
    ({"sizing": {"l_min": 4}, "import": {"spacing": [1, 1, 1]}}, "sizing.l_min is 4.* l_max, which is 3"),
]


@pytest.mark.parametrize(("config", "said"), WRONG_SECTIONS)
def test_sections_that_a_stage_would_refuse(read, tmp_path, monkeypatch, config, said):
    (tmp_path / "broken_rule.py").write_text("def angle(k:\n")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(CraftmeshError, match=f"^{said}") as caught:
        read(config)
    assert "\n" not in str(caught.value)


def without(key: str) -> dict:
    return {name: value for name, value in PENNY.items() if name != key}


ELLIPSE = PENNY | {"shape": "ellipse"}
PATH = PENNY | {"shape": "path", "file": "a.csv"}
BOUNDARIES = {"shape": "boundaries", "boundaries": ["3-7"]}
WRONG_CRACKS = [
    (without("radius"), "radius is not given; expected a radius or depth > 0, for shape penny"),
    (without("centre"), "centre is not given; expected three finite numbers"),
    (PENNY | {"normal": [0, 0, 0]}, "normal is .0.0, 0.0, 0.0.; expected a vector that is not zero"),
    (PENNY | {"normal": [0, 0, ".nan"]}, "normal.2 is '.nan'; expected a number"),
    (PENNY | {"radius": -4}, "radius is -4; expected a number > 0"),
    (PENNY | {"radius": "four"}, "radius is 'four'; expected a number > 0"),
    (PENNY | {"raduis": 4}, "raduis'; did you mean 'radius'"),
    (PENNY | {"file": "a.stl"}, "file is 'a.stl', but shape penny has no such parameter; it has centre"),
    (PENNY | {"semi_axes": [4, 3]}, "semi_axes is .4, 3., but shape penny has no such"),
    (ELLIPSE, "radius is 4, but shape ellipse has no such"),
    (without("radius") | {"shape": "ellipse"}, "semi_axes is not given"),
    (without("radius") | {"shape": "ellipse", "semi_axes": [4]}, "semi_axes is .4.; expected a list of 2"),
    (
        PENNY | {"shape": "through_edge", "normal": [1, 0, 0]},
        "axis is .*not parallel to the normal",
    ),
    (PENNY | {"shape": "through_edge", "axis": [0, 0, 0]}, "axis is .*not parallel to the normal"),
    (PENNY | {"increments": ["a.stl"]}, "increments.0. is 'a.stl'; expected a radius"),
    ({"shape": "surface"}, "file is None; expected triangles"),
    ({"shape": "surface", "file": "gone.stl"}, "file: gone.stl does not exist"),
    ({"shape": "surface", "file": "a.stl", "front": "gone.csv"}, "front: gone.csv does not exist"),
    ({"shape": "surface", "file": "a.stl", "radius": 4}, "radius is 4, but shape surface has no such"),
    ({"shape": "surface", "increments": [4.0]}, "file is 4.0; expected triangles"),
    ({"shape": "points", "file": "a.csv"}, "front is not given; give the CSV file of the front"),
    ({"shape": "fronts", "increments": ["gone.csv"]}, "increments.0.: gone.csv does not exist"),
    ({"shape": "fronts", "file": "a.csv", "front": "a.csv"}, "front is 'a.csv', but shape fronts"),
    ({"shape": "voxels", "file": "v.npz", "label": "one"}, "label is 'one'; expected a whole number"),
    (PATH | {"normal": [0, 0, 0]}, "normal is .*not zero"),
    (PATH | {"slant": 85}, "slant is 85; expected a number >= -80 and <= 80"),
    ({**PATH, "file": None}, "file is None; expected the columns x and y"),
    (BOUNDARIES | {"boundaries": ["3"]}, "boundaries has '3'; expected two grains"),
    ({"shape": "boundaries"}, "boundaries is not given"),
    (BOUNDARIES | {"radius": 4}, "centre is not given"),
    ({"shape": "slip_plane", "grain": 3}, "grain is 3 and crack.plane not given; shape slip_plane needs"),
]


@pytest.mark.parametrize(("crack", "said"), WRONG_CRACKS)
def test_cracks_that_no_box_could_take(read, crack, said):
    with pytest.raises(CraftmeshError, match=f"^(unknown key ')?cracks.a.{said}") as caught:
        read({"cracks": {"a": crack}})
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("crack", "increments"),
    [
        (PENNY, 1),
        (PENNY | {"growth": 1}, 3),
        (PENNY | {"normal": [1, 0, 0], "increments": [4, 5]}, 2),
        ({"shape": "surface", "increments": ["a.stl", "b.stl"]}, 2),
        ({"shape": "points", "file": "a.csv", "front": "a.csv"}, 1),
        (PATH | {"growth": 1}, 2),
        (BOUNDARIES, 1),
        (BOUNDARIES | {"radius": 4, "centre": [0, 0, 0], "growth": 1}, 2),
    ],
)
def test_cracks_that_are_sound(read, crack, increments):
    read({"cracks": {"a": crack}}, increments)


@pytest.mark.parametrize(
    ("crack", "said"),
    [
        (
            PENNY,
            "increments is 3, but increment 1 is the same as 0; set cracks.a.growth or .increments",
        ),
        (PENNY | {"increments": [4, 4, 5]}, "increment 1 is the same as 0"),
        (PENNY | {"increments": [4, 5, 5]}, "increment 2 is the same as 1"),
        ({"shape": "surface", "file": "a.stl"}, "increment 1 is the same as 0"),
        (BOUNDARIES | {"growth": 1}, "increment 1 is the same as 0"),
    ],
)
def test_increments_that_would_be_the_same_deck(read, crack, said):
    with pytest.raises(CraftmeshError, match=f"^c.tsv, line 2, case 'one': .*{said}"):
        read({"cracks": {"a": crack}}, 3)
    read({"cracks": {"a": {**crack, "increments": crack.get("increments")}}}, 3, growth="grow")


def test_a_crack_that_shrinks_or_lacks_an_increment(read):
    with pytest.raises(CraftmeshError, match="^cracks.a.increments: the crack shrinks from .5.0, 5.0. to"):
        read({"cracks": {"a": PENNY | {"increments": [5, 4]}}}, 2)
    with pytest.raises(CraftmeshError, match="^cracks.a.increments lists 1 increments, but case 'one'"):
        read({"cracks": {"a": PENNY | {"increments": [5]}}}, 2)


@pytest.mark.parametrize(
    "inp", [{"load": "none"}, {"magnitude": 0}, {"element": "C3D4"}, {"faces": ["ZMIN.z=fixed"]}]
)
def test_a_crack_that_grows_needs_a_load_and_its_elements(read, inp):
    read({"inp": inp})
    with pytest.raises(CraftmeshError, match="^c.tsv, line 2, case 'one': inp..* but the crack grows"):
        read({"inp": inp}, 2, growth="grow")


@pytest.mark.parametrize(
    ("volume", "config", "said"),
    [
        ("v.stl", {}, "import: v.stl: is a surface"),
        ("v.xyz", {}, "import: v.xyz: unknown suffix"),
        ("synthetic", {"generate": {"shape": [2, 2, 2], "grains": 9}}, "generate.grains is 9; expected"),
        ("synthetic", {"generate": {"voids": 1, "void_radius": 1}}, "generate.void_radius is 1; expected"),
        (
            "synthetic",
            {"inp": {"material": [f"{k}={ISOTROPIC}" for k in (2, 3)]}},
            "inp.material: .* phase 1",
        ),
        ("synthetic", {"sizing": {"l_min": 4}}, "sizing.l_min is 4.* l_max, which is 3"),
    ],
)
def test_what_is_known_of_the_volume(read, volume, config, said):
    with pytest.raises(CraftmeshError, match=f"^{said}"):
        read(config, volume=volume)


@pytest.mark.parametrize(
    ("column", "cell", "said"),
    [
        ("tetrahedralize.mesher", "tetgn", "tetrahedralize.mesher is 'tetgn'"),
        ("inp.material", '["cubic:1,2"]', "inp.material: cubic material has 2 constants"),
        ("cracks.a.normal", "[0, 0, 0]", "cracks.a.normal is"),
        ("cracks.a.shape", "[penny, ellipse]", "cracks.a.radius is 4, but shape ellipse has no such"),
    ],
)
def test_a_fault_of_one_case_names_its_line(read, column, cell, said):
    with pytest.raises(CraftmeshError, match=f"^c.tsv, line 2, case 'one.*': {said}"):
        read({}, column=column, cell=cell)


def test_plug_ins_that_are_there_are_taken(read, monkeypatch):
    own = SimpleNamespace(rule=lambda k: k[:, 0], Mesher=type("Mesher", (), {"mesh": None.__init__}))
    monkeypatch.setitem(sys.modules, "own", own)
    read({"tetrahedralize": {"mesher": "own:Mesher"}, "grow": {"criterion": "own:rule"}})


def test_a_small_crack_is_noted_once_for_all_its_cases(read):
    assert read({"sizing": {"l_min": 0.4}}).notes == []
    assert read({"sizing": {"l0": 0.8}}).notes == [] and read({}).notes == []
    (note,) = read({"sizing": {"l_min": 0.41}}).notes
    assert note.startswith("case one: crack a has size 4, its front edges sizing.l_min 0.41; at least")
    two = read({"sizing": {"l0": 1}}, column="inp.load", cell="[strain, stress]").notes
    assert len(two) == 1 and two[0].startswith("case one-load-strain and 1 more: crack a")
