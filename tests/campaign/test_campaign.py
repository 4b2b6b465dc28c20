"""Each mistake in a configuration or sheet is one line: the key or file, the value, what is expected."""

from pathlib import Path

import pytest
import yaml

from craftmesh.campaign.campaign import Campaign, command_flags, read_campaign
from craftmesh.errors import CraftmeshError

HEADER = "case\tmicrostructure\tcrack\tincrements\n"
PENNY = {"centre": [0.0, 0.0, 0.0], "radius": 5.0, "growth": 1.0}
GROWING = "case\tmicrostructure\tcrack\tincrements\tgrowth\n"


@pytest.fixture
def campaign(tmp_path):
    """Return a function that reads a configuration with the given keys and sheet rows."""

    def read(rows: str = "one\tsynthetic\tpenny\t3\n", header: str = HEADER, **keys) -> Campaign:
        sheet = tmp_path / "cases.tsv"
        sheet.write_text(header + rows)
        config = {"cases": str(sheet), "data": str(tmp_path), "sizing": {"l0": 1.0}}
        config["cracks"] = {"penny": PENNY}
        return read_campaign(config | keys)

    return read


def test_sound_campaign_has_defaults_cases_and_files(campaign):
    found = campaign()
    assert found.config["results"] == "results" and found.chunks == 2
    assert found.cases["one"].increment_names == ("000", "001", "002")
    assert found.increments() == [("one", "000"), ("one", "001"), ("one", "002")]
    assert found.generated("one") == ["results/one/generated.npz"]
    assert found.crack("one", "001") == {"crack": "results/one/001/crack.vtp"}
    assert found.previous_crack("one", "000") == {}
    assert found.previous_crack("one", "002") == {"previous": "results/one/001/crack.vtp"}
    assert "--radius 5.0" in found.crack_flags("one", "001") and "--l0 1.0" in found.crack_flags(
        "one", "001"
    )


def test_a_case_has_several_cracks_with_commas_between_them(campaign):
    cracks = {
        "penny": PENNY,
        "given": {"shape": "surface", "file": "a.stl"},
        "big": PENNY | {"radius": 9.0},
    }
    found = campaign("one\tsynthetic\tpenny, big\t2\n", cracks=cracks)
    assert found.cases["one"].cracks == ("penny", "big")
    first, second = found.crack_flags("one", "001").split(" --and ")
    assert "--l0 1.0" in first and "--radius 5.0" in first and "--radius 9.0" in second
    assert found.crack_files("one", "001") == [] and found.crack("one", "000")["crack"]
    with pytest.raises(CraftmeshError, match="cracks.given.file: a.stl does not exist"):
        campaign("one\tsynthetic\tpenny,given\t2\n", cracks=cracks)
    with pytest.raises(CraftmeshError, match="unknown crack 'small'; known .*, or several"):
        campaign("one\tsynthetic\tpenny,small\t2\n", cracks=cracks)
    with pytest.raises(CraftmeshError, match="name each crack once"):
        campaign("one\tsynthetic\tpenny,penny\t2\n", cracks=cracks)


def test_a_growing_case_takes_the_crack_that_the_increment_before_left(campaign):
    found = campaign("one\tsynthetic\tpenny\t3\tgrow\n", GROWING)
    assert found.growths() == [("one", "000"), ("one", "001")]
    assert found.crack_files("one", "000") == [] and "--radius 5.0" in found.crack_flags("one", "000")
    assert found.crack_files("one", "002") == ["results/one/001/grown.vtp"]
    assert "--shape surface --file results/one/001/grown.vtp" in found.crack_flags("one", "002")
    assert found.previous_crack("one", "002") == {
        "previous": "results/one/001/crack.vtp",
        "grown": "results/one/001/grown.vtp",
    }
    assert found.last_step("one", "000") == found.last_front("one", "000") == {}
    assert set(found.last_front("one", "002").values()) == {
        "results/one/001/fracture.json",
        "results/one/001/growth.json",
    }
    assert set(found.last_step("one", "002").values()) == {
        "results/one/001/base.vtp",
        "results/one/001/step.csv",
    }


def test_only_the_first_crack_of_a_growing_case_has_to_be_prescribed(campaign):
    given = {"given": PENNY | {"increments": [5.0]}}
    campaign("one\tsynthetic\tgiven\t3\tgrow\n", GROWING, cracks=given)
    with pytest.raises(CraftmeshError, match="lists 1 increments"):
        campaign("one\tsynthetic\tgiven\t3\tprescribed\n", GROWING, cracks=given)


@pytest.mark.parametrize("word", ["grow", "until"])
def test_a_case_has_the_increments_that_its_crack_reached(campaign, tmp_path, word):
    found = campaign(f"one\tsynthetic\tpenny\t9\t{word}\n", GROWING)
    for inc in ("000", "001", "002"):
        report = tmp_path / f"one_{inc}.json"
        report.write_text('{"ended": "%s"}' % ("left the body" if inc == "002" else ""))
    reached = [inc for case, inc in found.increments() if found.is_reached(case, inc, growth_in(tmp_path))]
    assert reached == ["000", "001", "002"]
    (tmp_path / "one_002.json").unlink()  # as in a dry run: nothing says that it ends
    assert all(found.is_reached(case, inc, growth_in(tmp_path)) for case, inc in found.increments())


def growth_in(folder):
    return lambda case, inc: str(folder / f"{case}_{inc}.json")


def test_paths_of_microstructures_start_at_the_data_folder(campaign, tmp_path):
    (tmp_path / "volume.npz").touch()
    assert campaign("one\tvolume.npz\tnone\t1\n").cases["one"].microstructure == str(
        tmp_path / "volume.npz"
    )


def test_files_that_options_name_are_inputs(campaign, tmp_path):
    names = {name: str(tmp_path / name) for name in ("a.stl", "b.stl", "front.csv", "voids.csv")}
    for name in names.values():
        Path(name).touch()
    grown = {
        "shape": "surface",
        "increments": [names["a.stl"], names["b.stl"]],
        "front": names["front.csv"],
    }
    sizing = {"l0": 1.0, "points": names["voids.csv"]}
    found = campaign("one\tsynthetic\tgrown\t2\n", cracks={"grown": grown}, sizing=sizing)
    assert found.crack_files("one", "001") == [names["b.stl"], names["front.csv"]]
    assert found.section_files("sizing", "one") == [names["voids.csv"]]
    prescribed = campaign()
    assert prescribed.crack_files("one", "002") == prescribed.section_files("sizing", "one") == []


def test_case_without_crack_has_no_crack_file(campaign):
    found = campaign("one\tsynthetic\tnone\t1\n")
    assert found.crack("one", "000") == {}


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"sizng": {}}, "unknown key 'sizng'; did you mean 'sizing'"),
        ({"sizing": {"l0": 1, "zzz": 2}}, "unknown key 'sizing.zzz'; known: l_min"),
        ({"sizing": {"l_min": 4, "l_max": 3}}, "sizing.l_min is 4.* l_max.* 3"),
        ({"sizing": {"l0": float("nan")}}, "sizing.l0 is nan; expected a number > 0"),
        ({"sizing": {"l0": "1,5"}}, "sizing.l0 is '1,5'; expected a number > 0.*write 1.5"),
        ({"sizing": {"l0": "nan"}}, "sizing.l0 is 'nan'; expected a number > 0"),
        ({"gradate": {"passes": "1e-3"}}, "gradate.passes is '1e-3'; expected a whole number >= 0"),
        ({"sizing": {"l0": 1, "r0": 8, "r1": 4}}, "sizing.r1 is 4.* r0.* 8"),
        ({"sizing": {"l0": 1, "r0": 20, "r1": 10}}, "sizing.r1 is 10.* r0.* 20"),
        ({"sizing": {"l0": 1, "l_min": 4}}, "sizing.l_min is 4.* l_max.* 3"),
        ({"chunks": 0}, "chunks is 0; expected a whole number >= 1"),
        ({"cracks": {"penny": {"shape": "star"}}}, "cracks.penny.shape is 'star'; expected one of penny"),
        ({"cracks": {"penny": {"centre": [1, 2]}}}, "cracks.penny.centre is .1, 2.; expected a list of 3"),
        (
            {"cracks": {"penny": PENNY | {"increments": [1.0]}}},
            "cracks.penny.increments lists 1 increments, .*'one'.* 3",
        ),
        ({"cases": "gone.tsv"}, "gone.tsv does not exist"),
    ],
)
def test_mistakes_in_the_configuration(campaign, keys, said):
    with pytest.raises(CraftmeshError, match=said) as caught:
        campaign(**keys)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", ["4e-6", "4E-06", "+4e-6", ".4e-5", "4.e-6", "0.000004", "40e-7"])
def test_numbers_that_yaml_takes_for_text_are_numbers(campaign, text):
    def as_yaml(source: str) -> dict:
        return yaml.safe_load(source.replace("4e-6", text))

    crack = as_yaml("{centre: [4e-6, 0, 4e-6], normal: [0, 0, 1], increments: [4e-6, '8.0e-6']}")
    sizing = as_yaml("{l0: 4e-6}")
    sweep = as_yaml("{solve.tolerance: [4e-6, 8.0e-6]}")
    found = campaign("one\tsynthetic\tpenny\t2\n", cracks={"penny": crack}, sizing=sizing, sweep=sweep)
    assert list(found.cases) == ["one-tolerance-4e-06", "one-tolerance-8e-06"]
    settings = found.cases["one-tolerance-4e-06"].settings
    assert settings["sizing"]["l0"] == settings["solve"]["tolerance"] == 4e-6
    assert settings["cracks"]["penny"]["centre"] == [4e-6, 0, 4e-6]
    assert settings["cracks"]["penny"]["increments"] == [4e-6, 8e-6]
    passes = campaign(gradate={"passes": "1e1"}, tetrahedralize={"switches": "4e-6"}).config
    assert repr(passes["gradate"]["passes"]) == "10" and passes["tetrahedralize"]["switches"] == "4e-6"


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ("one\tsynthetic\tpenny\t3\n" * 2, "line 3: duplicate case name 'one'"),
        (
            "one\tsynthetic\tpenny\tx\n",
            "line 2, case 'one': increments is 'x'; expected a whole number >= 1",
        ),
        ("one\tsynthetic\tpenny\t0\n", "case 'one': increments is 0"),
        ("one\tsynthetic\tpenny\n", "case 'one': 3 cells; expected 4: case, mic"),
        ("a/b\tsynthetic\tpenny\t1\n", "invalid case name 'a/b'"),
        ("logs\tsynthetic\tpenny\t1\n", "case name 'logs' is reserved"),
        ("one\tsynthetic\tpeny\t1\n", "case 'one': unknown crack 'peny'; known .*: penny, none"),
        ("one\tsynthetic\tnone\t2\n", "increments is 2 without a crack; set it to 1"),
        ("one\tgone.npz\tpenny\t1\n", "case 'one': microstructure .*gone.npz does not exist"),
        ("", "no case"),
    ],
)
def test_mistakes_in_the_sheet(campaign, rows, said):
    with pytest.raises(CraftmeshError, match=said) as caught:
        campaign(rows)
    assert "cases.tsv" in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "content",
    [
        b"\xef\xbb\xbf" + (HEADER + "one\tsynthetic\tpenny\t2\n").encode(),
        (HEADER + "one\tsynthetic\tpenny\t2\n").replace("\n", "\r\n").encode(),
        b" case \tmicrostructure\tcrack \tincrements  \n\n one\t synthetic \tpenny\t2 \n  \n",
        b"case\tmicrostructure\tcrack\tincrements\t\t\none\tsynthetic\tpenny\t2\t\t\n\t\t\t\t\t\n",
        b'"case"\t"microstructure"\t"crack"\t"increments"\n"one"\t"synthetic"\t"penny"\t"2"\n',
        b"case\tmicrostructure\tcrack\tincrements\tgrowth\tinp.load\none\tsynthetic\tpenny\t2\n",
        b"# cases\n" + (HEADER + "one\tsynthetic\tpenny\t2\n").encode(),
        (HEADER + "one\tsynthetic\tpenny\t2\n").encode("utf-16"),
        b"case\tgrowth\tmicrostructure\tcrack\tincrements\none\t\tsynthetic\tpenny\t2\n",
    ],
    ids=[
        "BOM",
        "CRLF",
        "blanks",
        "empty columns",
        "quotes",
        "missing cells",
        "comment",
        "UTF-16",
        "no growth",
    ],
)
def test_what_spreadsheets_write_is_the_same_sheet(tmp_path, content):
    (tmp_path / "cases.tsv").write_bytes(content)
    keys = {"cases": str(tmp_path / "cases.tsv"), "cracks": {"penny": PENNY}}
    (case,) = read_campaign(keys).cases.values()
    assert (case.name, case.microstructure, case.crack) == ("one", "synthetic", "penny")
    assert (case.increments, case.growth) == (2, "prescribed")


@pytest.mark.parametrize("between", [",", ";", "  ", " ; "])
def test_a_sheet_may_have_other_separators_than_tabs(campaign, between):
    rows = 'one\tsynthetic\t"penny, big"\t2\n'
    cracks = {"penny": PENNY, "big": PENNY}
    found = campaign(rows.replace("\t", between), HEADER.replace("\t", between), cracks=cracks)
    found = found.cases["one"]
    assert (found.microstructure, found.cracks, found.increments) == ("synthetic", ("penny", "big"), 2)


@pytest.mark.parametrize(
    ("column", "said"),
    [
        ("sizing.lmin", "column sizing.lmin: unknown key 'sizing.lmin'; did you mean 'sizing.l_min'?"),
        ("comment", "column comment: unknown key 'comment'; expected section.key"),
        ("case", "columns case, microstructure, crack, increments, case; expected .* each once"),
        ("node.cpus", "node.cpus applies to all cases"),
    ],
)
def test_columns_that_are_no_keys_or_there_twice(campaign, column, said):
    with pytest.raises(CraftmeshError, match=said):
        campaign("one\tsynthetic\tpenny\t3\t1\n", f"{HEADER.strip()}\t{column}\n")


def test_growth_without_a_crack_is_refused(campaign):
    with pytest.raises(CraftmeshError, match="case 'one': growth is grow without a crack"):
        campaign("one\tsynthetic\tnone\t1\tgrow\n", GROWING)


def test_a_sheet_in_another_encoding_is_refused(campaign, tmp_path):
    text = HEADER + "one\tk\u00f6rner.npz\tnone\t1\n"
    (tmp_path / "excel.tsv").write_text(text, encoding="latin-1")
    with pytest.raises(CraftmeshError, match=r"excel.tsv, line 2: .*save the file as UTF-8"):
        read_campaign({"cases": str(tmp_path / "excel.tsv")})


def test_wrong_columns_are_named(campaign):
    with pytest.raises(CraftmeshError, match="columns case, crack; expected case, microstructure"):
        campaign(header="case\tcrack\n")


def test_empty_values_make_no_flags():
    assert command_flags({"a": None, "b": [], "c": "", "d_e": 0, "f": True}) == "--d-e 0 --f"
