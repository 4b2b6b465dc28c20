"""What the report is told of a campaign, and which cases it has solved."""

import json

import pytest

from craftmesh.campaign.campaign import read_campaign
from craftmesh.campaign.record import campaign_record, solved_for_report

HEADER = "case\tmicrostructure\tcrack\tincrements\tsizing.l_min\tsolve.tolerance\n"
ROWS = "a\tsynthetic\tedge\t1\t[0.5, 0.7]\t\nb\tsynthetic\tedge\t1\t0.6\t1e-6\n"


def campaign(folder, **keys):
    (folder / "cases.tsv").write_text(HEADER + ROWS)
    cracks = {"edge": {"shape": "penny", "centre": [0.0, 20.0, 20.0], "radius": 5.0}, "other": {}}
    cracks["other"] = cracks["edge"] | {"radius": 7.0}
    return read_campaign({"cases": str(folder / "cases.tsv"), "cracks": cracks, **keys})


def test_the_record_has_what_a_case_changes_and_no_places(tmp_path):
    record = json.loads(campaign_record(campaign(tmp_path, chunks=3)))
    assert list(record["cases"]) == ["a-l_min-0.5", "a-l_min-0.7", "b"]
    assert {"chunks", "results", "data", "node"} & record["config"].keys() == set()
    changed = record["cases"]["b"]["settings"]
    assert changed["sizing"]["l_min"] == 0.6 and changed["solve"]["tolerance"] == 1e-6
    assert changed.keys() == {"sizing", "solve"} and record["cases"]["b"]["cracks"] == ["edge"]


@pytest.mark.parametrize(("quantity", "solved"), [("K_I", True), ("elements", False), (None, False)])
def test_cases_that_differ_in_a_size_alone_are_solved_where_the_quantity_asks(tmp_path, quantity, solved):
    found = solved_for_report(campaign(tmp_path, report={"quantity": quantity}))
    assert found == ({"a-l_min-0.5", "a-l_min-0.7"} if solved else set())


def test_increments_of_solved_cases_are_asked_for(tmp_path):
    asked = campaign(tmp_path)
    assert asked.increments(growing=True, others={"b"}) == [("b", "000")]
