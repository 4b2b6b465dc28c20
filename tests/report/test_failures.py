"""Cases that fail are told with their error, and take no page away."""

import json

import pytest

from craftmesh.cli import main
from craftmesh.report.case_files import Case, failures


def case(increments=2):
    return Case("a", {"increments": increments, "growth": "prescribed"}, {}, {}, {}, [], [])


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("note\ncraftmesh: error: v.npz: no grain\n\n", "v.npz: no grain"),
        ("craftmesh: error: once\nwrote it\n", "not made yet, and no log ends in an error"),
    ],
)
def test_the_error_in_which_a_log_ends_is_told(tmp_path, text, told):
    log = tmp_path / "logs" / "a" / "000" / "volume.log"
    log.parent.mkdir(parents=True)
    log.write_text(text)
    (failure,) = failures(case(), tmp_path)
    assert failure.line == told
    assert failures(case(0), tmp_path) == []


def test_a_page_is_written_where_all_cases_failed(tmp_path, capsys):
    asked = {"campaign": "cases.tsv", "config": {"cracks": {}}, "cases": {}}
    for name in ("a", "b"):
        told = {"microstructure": "v.npz", "cracks": [], "increments": 1, "growth": "prescribed"}
        asked["cases"][name] = told | {"settings": {}}
        (tmp_path / "logs" / name).mkdir(parents=True)
        (tmp_path / "logs" / name / "microstructure.log").write_text(f"craftmesh: error: {name} <fails>\n")
    (tmp_path / "asked.json").write_text(json.dumps(asked))
    words = ["--campaign", str(tmp_path / "asked.json"), "-o", str(tmp_path / "page.html")]
    assert main(["report", str(tmp_path), *words]) == 0
    page = (tmp_path / "page.html").read_text()
    assert "a &lt;fails&gt;" in page and "b &lt;fails&gt;" in page
    assert "case a, a/microstructure.log: a <fails>" in capsys.readouterr().err
