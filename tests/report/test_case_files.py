"""Cases are read from their folders, whichever campaign made them, and remains of earlier runs are not."""

import json

import pytest
from shown_models import asked, write_increment

from craftmesh.cli import main
from craftmesh.growth.grow import REPAIRS
from craftmesh.report.case_files import read_case, read_cases, stage_costs
from craftmesh.report.measures import UNIFORM_TETS, outcome, table_row, totals

HEADER = "s\th:m:s\tmax_rss\tmax_vms\tmax_uss\tmax_pss\tio_in\tio_out\tmean_load\tcpu_time\n"


def report(results, campaign):
    return main(["report", str(results), "--campaign", campaign, "-o", str(results / "report.html")])


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Two campaigns in one folder, one after the other: `a` of two increments, and `b`."""
    folder = tmp_path_factory.mktemp("results")
    for place in ("a/000", "a/001", "a/002", "b/000"):
        write_increment(folder / place)
    assert report(folder, asked(folder, ["a"], "first.tsv", increments=2)) == 0
    assert report(folder, asked(folder, ["b"], "second.tsv")) == 0
    return folder


@pytest.mark.slow
def test_a_campaign_leaves_the_cases_of_another_where_they_are(results):
    cases = read_cases(results)
    assert [(case.name, case.record["campaign"]) for case in cases] == [
        ("a", "first.tsv"),
        ("b", "second.tsv"),
    ]
    page = (results / "report.html").read_text()
    assert "first.tsv" in page and "second.tsv" in page and 'id="case-a"' in page and 'id="case-b"' in page


def test_increments_that_were_not_asked_for_are_left_out(results):
    assert [increment.name for increment in read_case(results / "a").increments] == ["000", "001"]


def test_a_crack_that_stops_says_where_and_why_and_is_shown_no_further(results):
    record = json.loads((results / "a" / "case.json").read_text())
    growth = results / "a" / "000" / "growth.json"
    try:
        (results / "a" / "case.json").write_text(json.dumps(record | {"growth": "grow"}))
        growth.write_text(json.dumps({"ended": "the crack severs the body", "extension": [0.4, 0.6]}))
        case = read_case(results / "a")
        assert [increment.name for increment in case.increments] == ["000"]
        assert outcome(case) == "The crack stops after increment 000: the crack severs the body."
        growth.write_text(json.dumps({"ended": "", "extension": [0.4, 0.6]}))
        assert outcome(read_case(results / "a")) == "2 increments, as many as requested."
        growth.write_text(json.dumps({"ended": "", "extension": [0.4, 0.6], "repairs": {"loops": 2}}))
        said = f"Growth from increment 000: {REPAIRS['loops']} (2 times)."
        assert said in outcome(read_case(results / "a"))
    finally:
        growth.unlink()
        (results / "a" / "case.json").write_text(json.dumps(record))


def test_the_reduction_is_against_a_mesh_of_the_finest_edges(results):
    row = table_row(read_case(results / "b").increments[0])
    assert row.elements == 6 * 96 and row.uniform == pytest.approx(UNIFORM_TETS * 96)
    assert row.reduction == pytest.approx(100 * (1 - 6 / UNIFORM_TETS))
    assert row.drift is None and totals([row])["worst_drift"] is None


def test_a_folder_without_cases_is_refused(tmp_path, capsys):
    assert main(["report", str(tmp_path), "-o", str(tmp_path / "report.html")]) == 1
    assert "no case" in capsys.readouterr().err and not (tmp_path / "report.html").exists()


def test_costs_are_summed_by_stage_in_the_order_of_the_way(tmp_path):
    for name, seconds, memory in (
        ("000/tets/1-of-2", 3, 50),
        ("000/tets/2-of-2", 5, 70),
        ("remeshed", 2, 10),
        ("001/model", 1, "NA"),
        ("002/model", 100, 1),
    ):
        path = tmp_path / f"{name}.tsv"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(HEADER + f"{seconds}\t0:00:01\t{memory}\t1\t1\t1\t0\t0\t90\t{seconds / 2}\n")
    remesh, tets, inp = stage_costs(tmp_path, ["000", "001"])
    assert (remesh.stage, tets.stage, inp.stage) == ("remesh", "tetrahedralize", "inp")
    assert tets[1:] == (2, 8, 4, 5, 70) and inp[1:] == (1, 1, 0.5, 1, 0)
