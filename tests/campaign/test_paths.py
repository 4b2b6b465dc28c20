"""Paths and names that a campaign takes, expands or refuses, each in one line."""

import re
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from craftmesh.campaign.campaign import read_campaign
from craftmesh.campaign.cases import RESERVED, as_case_name
from craftmesh.campaign.paths import read_path, refuse_unexpanded, written_path
from craftmesh.errors import CraftmeshError

HEADER = "case\tmicrostructure\tcrack\tincrements\n"
IN_FOLDER = settings(max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
ODD = st.text("ab .-_~$()[]{}<>'\"`&;|*?!#%:,@=+\\äαß漢\n\t\0", min_size=1, max_size=12)


@pytest.fixture
def campaign(tmp_path, monkeypatch):
    """Return `read_campaign` for rows of a sheet in a folder that is the working one."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("SCRATCH", str(tmp_path / "scratch"))
    monkeypatch.delenv("UNSET", raising=False)

    def read(rows="one\tsynthetic\tnone\t1\n", **keys):
        (tmp_path / "cases.tsv").write_text(HEADER + rows)
        return read_campaign({"cases": "cases.tsv"} | keys)

    return read


@pytest.mark.parametrize("start", ["~", "$SCRATCH", "${SCRATCH}"])
def test_home_and_variables_are_expanded_everywhere_alike(campaign, tmp_path, start):
    folder = tmp_path / ("home" if start == "~" else "scratch")
    folder.mkdir()
    for name in ("v.npz", "crack.stl", "points.csv", "front.csv"):
        (folder / name).touch()
    cracks = {
        "c": {"shape": "surface", "increments": [f"{start}/crack.stl"], "front": f"{start}/front.csv"}
    }
    sizing = {"l0": 1.0, "points": f"{start}/points.csv"}
    rows = f"one\tv.npz\tc\t1\ntwo\t{start}/v.npz\tnone\t1\n"
    found = campaign(rows, results=f"{start}/res", data=start, cracks=cracks, sizing=sizing)
    assert found.results == str(folder / "res")
    assert found.cases["one"].microstructure == found.cases["two"].microstructure == str(folder / "v.npz")
    assert found.crack_files("one", "000") == [str(folder / "crack.stl"), str(folder / "front.csv")]
    assert found.section_files("sizing", "two") == [str(folder / "points.csv")]
    assert str(folder / "crack.stl") in found.crack_flags("one", "000")


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"results": "$UNSET/x"}, "results is '$UNSET/x', but the variable UNSET is not set"),
        ({"data": "${UNSET}"}, "data is '${UNSET}', but the variable UNSET is not set"),
        ({"sizing": {"points": "$UNSET"}}, "sizing.points is '$UNSET', but the variable UNSET"),
        ({"results": "~nobody0/x"}, "~nobody0 is no user's home folder"),
        ({"results": "res{x}"}, "results is 'res{x}'; expected a path without braces"),
        ({"results": "res<logs>"}, "expected a path without braces or <name>"),
        ({"results": "s3://bucket/x"}, "expected a path in the file system, not a URL"),
        ({"results": "a\nb"}, "expected a path of one line"),
        ({"results": "cases.tsv"}, "cases.tsv is not a folder"),
        ({"results": "cases.tsv/x"}, "cases.tsv is not a folder"),
        ({"data": "a\udcff"}, "expected a path of one line, in UTF-8"),
    ],
)
def test_paths_that_a_workflow_cannot_take_are_refused(campaign, keys, said):
    with pytest.raises(CraftmeshError, match=re.escape(said)) as caught:
        campaign(**keys)
    assert "\n" not in str(caught.value)


def test_what_is_there_by_that_very_name_is_read(campaign, tmp_path):
    for name in ("a$UNSET.npz", "~b.npz", "-c.npz"):
        (tmp_path / name).touch()
    (tmp_path / "synthetic").mkdir()
    rows = "".join(
        f"{k}\t{name}\tnone\t1\n"
        for k, name in enumerate(["a$UNSET.npz", "~b.npz", "-c.npz", "./synthetic"])
    )
    found = campaign(rows)
    names = [found.cases[str(k)].microstructure for k in range(4)]
    assert names == ["a$UNSET.npz", "~b.npz", str(tmp_path / "-c.npz"), str(tmp_path / "synthetic")]


@given(text=ODD)
@IN_FOLDER
def test_any_path_is_taken_as_it_stands_or_refused_in_one_line(campaign, tmp_path, text):
    """A file of any name is found under it; where a name is refused, it is one that Snakemake fills in."""
    path = tmp_path / "data" / text
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    except (OSError, ValueError):
        return
    try:
        found = read_path("data", text, tmp_path / "data")
    except CraftmeshError as error:
        assert re.search(r"[{}\n\t]|<[^<>]*>|\w://", text) and "\n" not in str(error)
    else:
        assert Path(found).samefile(path)
        assert not written_path("results", f"{tmp_path}/x").startswith("-")


@given(text=ODD)
@IN_FOLDER
def test_what_init_calls_a_case_is_a_name_that_the_sheet_takes(campaign, text):
    name = as_case_name(text).lstrip(".-") or "mine"
    assert list(campaign(f"{name}\tsynthetic\tnone\t1\n").cases) == [name]


@pytest.mark.parametrize(
    "name", [*RESERVED, "Logs", "REPORT.html", "a b", ".a", "-a", "a/b", "a,b", "é" * 128]
)
def test_names_that_no_case_may_have(campaign, name):
    with pytest.raises(CraftmeshError, match="line 2.*case"):
        campaign(f"{name}\tsynthetic\tnone\t1\n")


def test_cases_that_differ_in_capitals_alone_are_one_folder_elsewhere(campaign):
    with pytest.raises(CraftmeshError, match="'Gefüge' and 'gefüge' differ only in case"):
        campaign("Gefüge\tsynthetic\tnone\t1\ngefüge\tsynthetic\tnone\t1\n")


def test_a_file_in_the_place_of_a_case_is_refused(campaign, tmp_path):
    (tmp_path / "one").touch()
    with pytest.raises(CraftmeshError, match="one is not a folder"):
        campaign(results=".")


def test_a_target_that_stays_unexpanded_is_refused_with_its_path():
    refuse_unexpanded(["snakemake", "/home/me/r/v/labels.npz", "grow"], "~/r", "/home/me/r")
    refuse_unexpanded(["/bin/snakemake", "results/v/labels.npz"], "results", "results")
    with pytest.raises(CraftmeshError, match="write it as '/home/me/r/v/labels.npz'"):
        refuse_unexpanded(["snakemake", "~/r/v/labels.npz"], "~/r", "/home/me/r")
