"""Which campaign runs when little or nothing is configured, and where the workflow lies."""

import os
import sys
from pathlib import Path

import pytest
import yaml

from craftmesh.campaign.campaign import read_campaign
from craftmesh.campaign.workflow_location import command_on_path, home, or_default, snakefile
from craftmesh.errors import CraftmeshError


def test_workflow_and_demo_lie_at_home():
    assert snakefile().is_file() and (home() / "config" / "config.yaml").is_file()


def test_demo_is_the_default_of_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    campaign = read_campaign(or_default({}))
    assert list(campaign.cases) == ["demo"] and campaign.results == "results"


def test_default_of_a_folder_is_its_own_configuration(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("config").mkdir()
    Path("config", "config.yaml").write_text("cases: sheet.tsv\nchunks: 5\n")
    assert or_default({}) == {"cases": "sheet.tsv", "chunks": 5}


def test_keys_of_a_run_are_laid_over_the_default(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    given = {"results": "there", "chunks": 7, "exports": ["msh"], "data": "scans"}
    found = or_default(given)
    demo = yaml.safe_load((home() / "config" / "config.yaml").read_text())
    assert found == demo | given | {"cases": str(home() / demo["cases"])}


@pytest.mark.parametrize("key", ["cases", "sizing", "gradate", "cracks", "unknown"])
def test_any_other_key_makes_a_campaign_of_its_own(key):
    assert or_default({key: {}, "results": "there"}) == {key: {}, "results": "there"}


@pytest.mark.parametrize(
    ("text", "said"), [("- a list", "found list"), ("a: [", "expected YAML"), ("", "found NoneType")]
)
def test_broken_default_is_one_line(tmp_path, monkeypatch, text, said):
    monkeypatch.chdir(tmp_path)
    Path("config").mkdir()
    Path("config", "config.yaml").write_text(text)
    with pytest.raises(CraftmeshError, match=said) as error:
        or_default({})
    assert "\n" not in str(error.value) and "config.yaml" in str(error.value)


def test_command_beside_python_is_put_on_the_path_first(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", "/nowhere")
    command_on_path()
    assert os.environ["PATH"] == f"{Path(sys.executable).parent}{os.pathsep}/nowhere"


def test_missing_command_is_said_with_what_to_do(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", "/nowhere")
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    with pytest.raises(CraftmeshError, match="the command craftmesh, .* is neither in .* -m pip install"):
        command_on_path()
