"""YAML and sheets of any kind: taken as meant, or refused in one line that names the place."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from craftmesh.campaign.campaign import read_campaign
from craftmesh.campaign.workflow_location import read_config
from craftmesh.cli import main
from craftmesh.errors import CraftmeshError
from craftmesh.io.npz import write_labels
from craftmesh.io.user_material import read_template
from craftmesh.io.yaml_file import parse_yaml
from craftmesh.types import Voxels

HEAD = "case\tmicrostructure\tcrack\tincrements"
CRACK = "{shape: penny, centre: [8, 0, 8], normal: [0, 0, 1], radius: 4}"
BASE = "cases: cases.tsv\nsizing: {l0: 1}\n"


@pytest.fixture(autouse=True)
def in_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("v.npz").touch()


def campaign(config: str | bytes, crack: str = "none", head: str = HEAD, more: str = ""):
    """Return the campaign of a configuration file and a sheet of one row."""
    Path("c.yaml").write_bytes(config if isinstance(config, bytes) else config.encode())
    Path("cases.tsv").write_text(f"{head}\na\tv.npz\t{crack}\t1{more}\n")
    return read_campaign(read_config(Path("c.yaml")))


def refusal(config: str | bytes, *row, **words) -> str:
    with pytest.raises(CraftmeshError) as caught:
        campaign(config, *row, **words)
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize(
    ("text", "key", "lines"),
    [
        ("a: 1\nb: 2\na: 3\n", "a", (1, 3)),
        ("a: 1\nb: 2\n'a': 3\n", "a", (1, 3)),
        ("a:\n  b: {c: 1,\n   c: 2}\n", "a.b.c", (2, 3)),
        ("a:\n- b: 1\n  b: 2\n", "a[0].b", (2, 3)),
        ("a: &x {b: 1}\nc:\n  <<: *x\n  d: 1\n  d: 2\n", "c.d", (4, 5)),
        ('{"a": 1,\n\t"b": 2,\n\t"a": 3}', "a", (1, 3)),  # JSON
        ("1: a\n2: b\n1: c\n", "1", (1, 3)),
        ("no: a\nno: b\n", "no", (1, 2)),
    ],
)
def test_a_key_that_is_given_twice_is_refused_with_both_lines(text, key, lines):
    said = f"c.yaml: duplicate key {key} on lines {lines[0]} and {lines[1]}; keep one"
    with pytest.raises(CraftmeshError, match=f"^{re.escape(said)}$"):
        parse_yaml(text, "c.yaml")
    assert said in refusal(text)
    Path("own.yaml").write_text(text)
    with pytest.raises(CraftmeshError, match=f"duplicate key {re.escape(key)}"):
        read_template("own.yaml")


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("a: &x {b: 1, c: 2}\nd: {<<: *x, b: 3}\n", {"a": {"b": 1, "c": 2}, "d": {"b": 3, "c": 2}}),
        ("\ufeffa: 1\n", {"a": 1}),
        ('{\n\t"a": "b\\tc"\n}', {"a": "b\tc"}),
        (
            "a: '0012'\nb: 0\nc: -0.5\nd: 0x1F\n",
            {"a": "0012", "b": 0, "c": -0.5, "d": 31},
        ),
        ("", None),
    ],
)
def test_what_is_no_fault_is_read(text, found):
    Path("c.yaml").write_text(text, encoding="utf-8")
    assert parse_yaml(text.removeprefix("\ufeff"), "c.yaml") == found
    if found:
        assert read_config(Path("c.yaml")) == found


KEYS = {
    "1": "has the key 1, which is not text; put names",
    "1.5": "has the key 1.5, which is not text",
    "no": "has the key False, which is not text",
    "null": "has the key None, which is not text",
    "2024-01-31": "has the key 2024-01-31, which is not text",
    "0012": "line 4: YAML reads 0012 as an octal",
    "12:30": "line 4: YAML reads 12:30 as an octal or sexagesimal",
    "1_000": "has the key 1000, which is not text",
    ".nan": "has the key nan, which is not text",
    "? [a, b]\n  ": "unhashable",
}


@pytest.mark.parametrize("key", KEYS)
@pytest.mark.parametrize("section", ["cracks", "sizing", "sweep"])
def test_keys_that_are_no_text_are_one_line(key, section):
    text = f"cases: cases.tsv\n\n{section}:\n  {key}: {CRACK}\n"
    assert KEYS[key] in refusal(text)


@pytest.mark.parametrize(
    "name", ["1e3", "0012", "1_000", "12:30", "no", "on", "null", "2024-01-31", "12", "~"]
)
@pytest.mark.parametrize("listed", [False, True])
def test_names_in_quotes_are_taken_and_words_of_the_sheet_are_names(name, listed):
    config = f'{BASE}cracks: {{"{name}": {CRACK}, other: {CRACK}}}\n'
    found = campaign(config, f"[{name}, other]" if listed and name not in ("null", "~") else name)
    assert {crack for case in found.cases.values() for crack in case.cracks} >= {name}


@pytest.mark.parametrize(
    ("radius", "said"),
    [
        ("4,5", "cracks.a has the key 5, which is not text; a decimal comma. write 4.5"),
        ("'4,5'", "cracks.a.radius is '4,5'; expected a number > 0 .*; write 4.5"),
        ("1" + "0" * 400, r"cracks.a.radius is 1000+\.\.\.0+; expected a number > 0"),
        ("1" + "0" * 5000, "c.yaml: .* expected YAML"),
        (".nan", "cracks.a.radius is nan; expected a number > 0"),
        (".inf", "cracks.a.radius is inf; expected"),
        ("yes", "cracks.a.radius is True; expected a number"),
        ("null", "cracks.a.radius is not given"),
        ("2024-01-31", "cracks.a.radius is 2024-01-31; expected a number"),
        ("2024-13-45", "c.yaml: month must be in 1..12"),
        ("010", "c.yaml: line 4: YAML reads 010 as an octal"),
        ("1:30.5", "c.yaml: line 4: YAML reads 1:30.5 as an octal or sexagesimal"),
        ("[4]", r"cracks.a.radius is \[4\]; expected a number"),
        ("{b: 4}", "cracks.a.radius is {'b': 4}; expected a number"),
        ("!!set {4}", "cracks.a.* expected"),
        ("!!python/name:os.system ''", "c.yaml: could not determine a constructor"),
        ("&x [*x]", "anchor"),
    ],
)
def test_values_of_any_kind_are_one_line(radius, said):
    crack = CRACK.replace("radius: 4", f"radius: {radius}")
    assert re.search(said, refusal(f"{BASE}cracks:\n  a: {crack}\n", "a"))


@pytest.mark.parametrize(
    ("config", "said"),
    [
        (b"cases: cases.tsv\nsizing:\n\tl0: 1\n", "indent with spaces, not with tabs"),
        ("cases: cases.tsv\n".encode("utf-16"), "c.yaml: is UTF-16; save it as YAML in UTF-8"),
        ("results: é\n".encode("latin-1"), "save it as YAML in UTF-8"),
        (b"a\0b", "expected YAML"),
        (b"", "found NoneType; expected keys with values"),
        (b"- a\n", "found list; expected keys"),
        (b"cases: a\n---\ncases: b\n", "expected a single document"),
        (
            b"cases: cases.tsv\nimport: {dataset: 12}\n",
            "import.dataset is 12; .*; put a name",
        ),
        (b"cases: cases.tsv\nresults: on\n", "results is True; expected text .*; put a name"),
        (b"cases: cases.tsv\nsizing:\n", "sizing is None; expected keys with values"),
        (b"a: &a {b: *a}\ncases: cases.tsv\n", "anchor"),
    ],
)
def test_files_of_any_kind_are_one_line(config, said):
    assert re.search(said, refusal(config))


HEADS = {
    "Case\tMicrostructure\tCRACK\tIncrements": "",
    ' case \t microstructure\tcrack \t"increments"': "",
    f"{HEAD}\tSizing.L_min": "\t0.5",
    f"{HEAD}\tsizing . l_min": "\t0.5",
    f"{HEAD}\tcracks.a.Radius": "\t3",
    f"{HEAD}\tGROWTH": "\tprescribed",
}


@pytest.mark.parametrize("head", HEADS)
def test_capitals_and_blanks_in_a_head_do_not_count(head):
    found = campaign(f"{BASE}cracks: {{a: {CRACK}}}\n", "a", head, HEADS[head])
    assert list(found.cases) == ["a"]
    if "min" in head:
        assert found.cases["a"].settings["sizing"]["l_min"] == 0.5


@pytest.mark.parametrize(
    ("head", "said"),
    [
        (f"{HEAD}\tCase", "each once"),
        (f"{HEAD}\tsizing.l_min\tSizing.l_min", "each once"),
        (f"{HEAD}\tcracks.A.radius", "unknown key 'cracks.A.radius'"),  # there are a and Ä
    ],
)
def test_columns_that_are_there_twice_or_nowhere_are_refused(head, said):
    cracks = f"{{a: {CRACK}}}" if "A" not in head else f"{{b: {CRACK}}}"
    assert said in refusal(f"{BASE}cracks: {cracks}\n", head=head, more="\t3\t3")


def test_capitals_count_where_two_cracks_differ_in_them():
    config = f"{BASE}cracks: {{a: {CRACK}, A: {CRACK}}}\n"
    found = campaign(config, "a,A", f"{HEAD}\tcracks.A.radius", "\t3").cases["a"].settings["cracks"]
    assert (found["a"]["radius"], found["A"]["radius"]) == (4, 3)


@pytest.mark.parametrize(
    ("column", "cell", "value"),
    [
        ("import.dataset", "0012", "0012"),
        ("import.dataset", "no", "no"),
        ("import.dataset", "12:30", "12:30"),
        ("sizing.l_min", "0012", 12),
        ("inp.magnitude", "1e-3", 0.001),
        ("sizing.around_voids", "yes", True),
    ],
)
def test_cells_are_read_as_their_keys_ask(column, cell, value):
    found = campaign(BASE.replace("l0: 1", "l0: 40"), "none", f"{HEAD}\t{column}", f"\t{cell}")
    section, _, key = column.partition(".")
    assert found.cases["a"].settings[section][key] == value


@pytest.mark.parametrize("cell", ["{a: 1, a: 2}", "12:30", "1" + "0" * 400])
def test_cells_that_are_no_value_are_one_line(cell):
    said = refusal(BASE, head=f"{HEAD}\tsizing.l_min", more=f"\t{cell}")
    assert "line 2" in said and "sizing.l_min" in said


@pytest.mark.parametrize(
    ("material", "said"),
    [
        (["1=isotropic:1e5,0.3", "3=isotropic:1e5,0.3"], []),
        (["isotropic:1e5,0.3"], []),
        (
            ["1=isotropic:1e5,0.3", "2=isotropic:1e5,0.3"],
            [
                "case a: inp.material names phase 2, but no grain has it; phases: 1, 3",
                "case a: inp.material has no entry for phase 3, which grains have; add one",
            ],
        ),
    ],
)
def test_materials_of_absent_phases_are_told(material, said):
    labels = np.ones((2, 2, 2), np.int32)
    labels[1] = 2
    write_labels("v.npz", Voxels(labels, np.ones(3), np.zeros(3), phases=np.array([0, 1, 3])))
    for _ in range(2):  # as read, and as kept
        assert campaign(f"{BASE}inp: {json.dumps({'material': material})}\n").notes == said


def test_a_faulty_file_is_one_line_on_the_command_line(capsys):
    Path("c.yaml").write_text("cases: a\ncases: b\n")
    for verb in ("plan", "run"):
        assert main([verb, "c.yaml"]) == 1
        assert capsys.readouterr().err.count("\n") == 1
