"""The page: all in itself, the same bytes each time, names of users kept from being read as html."""

import json
import re
import shutil
from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest
from shown_models import asked, write_front, write_increment

from craftmesh.cli import main
from craftmesh.report import page as page_module
from craftmesh.report.case_files import read_cases
from craftmesh.report.measures import grown_rows
from craftmesh.report.page import page
from craftmesh.report.sweeps import ReportOptions


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    write_increment(folder / "one" / "000")
    write_front(folder / "one" / "000", [1.0, 2.0, 3.0])
    shutil.copytree(folder / "one" / "000", folder / "one" / "001")
    shutil.copytree(folder / "one" / "000", folder / "one" / "002")
    campaign = asked(folder, ["one"], "a <b>.tsv", increments=3)
    flags = ["--campaign", campaign, "-o", str(folder / "report.html")]
    assert main(["report", str(folder), *flags]) == 0
    return folder


def test_nothing_is_fetched_from_elsewhere(results):
    text = (results / "report.html").read_text()
    assert not re.search(r'(src|href)="(?!data:|#|one/)', text)
    text = text.replace("http://www.w3.org/", "")  # names of the formats, not addresses
    assert not re.search(r"@import|url\((?!#)|https?://", text)
    # three pictures of each increment with a colour bar, the path of the crack and its colour bar
    assert text.count("data:image/webp;base64,") == 3 * 4 + 2 and "<img" not in text


def test_names_are_not_html(results):
    text = (results / "report.html").read_text()
    assert "a &lt;b&gt;.tsv" in text and "<b>.tsv" not in text


def test_changed_labels_and_grains_off_their_voxels_are_said(results):
    (case,) = read_cases(results)
    case = replace(
        case, imported={"grains": 2, "voids": {}, "changes": ["9 voxels <gone>"], "notes": ["0 is a grain"]}
    )
    drift = {"grains": 2, "by_grain": {"1": 0.0, "7": -0.4}}
    case.increments[1] = replace(
        case.increments[1], quality=case.increments[1].quality | {"volume_drift": drift}
    )
    text = page([case], ReportOptions())
    assert "9 voxels &lt;gone&gt;" in text and "0 is a grain" in text
    assert text.count("grain 7 by -40.0%") == 1 and "Increment 001:</strong> 1 of 2 grains" in text


def test_what_was_renewed_and_what_was_made_from_scratch_is_said(results):
    (case,) = read_cases(results)
    assert "<th>Renewed</th>" not in page([case], ReportOptions())
    told = {"share": 0.25, "elements_kept": case.increments[1].quality["elements"] // 2}
    whole = {"share": 1.0, "elements_kept": 0, "from_scratch": "2 tetrahedra would be <poor>"}
    for number, one in ((1, told), (2, whole)):
        quality = case.increments[number].quality | {"renewed": one}
        case.increments[number] = replace(case.increments[number], quality=quality)
    text = page([case], ReportOptions())
    assert "<td>– %</td><td>– %</td>" in text and "<td>25 %</td><td>50 %</td>" in text
    assert "Increment 002:</strong> made from scratch because 2 tetrahedra would be &lt;poor&gt;." in text


def test_the_same_cases_give_the_same_text(results):
    assert page(read_cases(results), ReportOptions()) == page(read_cases(results), ReportOptions())


def test_times_alone_stand_between_their_marks(results):
    before = (results / "report.html").read_text()
    benchmark = results / "benchmarks" / "one" / "remeshed.tsv"
    benchmark.parent.mkdir(parents=True)
    benchmark.write_text("s\tmax_rss\tcpu_time\n77.7\t123\t66.6\n")
    after = page(read_cases(results), ReportOptions())
    assert "78 s" in after and "67 s" in after
    assert re.sub("<!--times-->.*?<!--/times-->", "", after, flags=re.DOTALL) == (
        re.sub("<!--times-->.*?<!--/times-->", "", before, flags=re.DOTALL)
    )
    benchmark.unlink()


def test_a_page_of_too_many_pictures_keeps_the_first_and_the_last(results, monkeypatch):
    monkeypatch.setattr(page_module, "MOST_PICTURES", 1)
    text = page(read_cases(results), ReportOptions())
    assert re.findall(r'data-increment="(\d+)"', text) == ["000", "002"]
    assert "increments 001" in text


def test_the_view_has_the_last_body_and_every_crack(results):
    text = (results / "report.html").read_text()
    found = re.search(r'<script type="application/json" id="scene-one">(.*?)</script>', text, re.DOTALL)
    scene = json.loads(found[1])
    assert [crack["name"] for crack in scene["cracks"]] == ["000", "001", "002"]
    assert len(found[1]) < 5_000_000 and scene["skin"]["triangles"]
    script = (files("craftmesh.report") / "templates" / "view.js").read_text()
    assert set(re.findall(r"\bscene\.(\w+)", script)) == scene.keys()
    assert set(re.findall(r"\bcrack\.(\w+)", script)) == scene["cracks"][0].keys()


def test_units_are_beside_what_they_measure(results):
    (case,) = read_cases(results)
    plain = page([case], ReportOptions())
    assert "[" not in re.sub(r"<(script|style).*?</\1>", "", plain.split('class="case"')[1], flags=re.S)[:0]
    named = {"length": "<µm>", "stress": "$MPa$"}
    record = case.record | {"config": case.record["config"] | {"units": named}}
    text = page([replace(case, record=record)], ReportOptions())
    for label in ("Crack area [&lt;µm&gt;^2]", "Front length [&lt;µm&gt;]", "[$MPa$ sqrt(&lt;µm&gt;)]"):
        assert label in text and label not in plain


def test_k_is_shown_against_the_crack_without_uncertain_nodes_and_linked(results):
    (case,) = read_cases(results)
    front = case.increments[0].front | {
        "K_I": np.array([9.0, 2.0, 3.0]),
        "flags": np.array(["end", "", ""]),
    }
    case.increments[0] = replace(case.increments[0], front=front, size=4.0)
    # an edge apart: the second node lies within two edges of the end, as growth has it
    assert grown_rows(case)[0].k_1 == (3.0, 3.0)
    text = page([case], ReportOptions())
    assert "Against the crack" not in text, "one size makes no curve"
    assert 'href="one/000/sif.csv"' in text and 'href="one/000/front.csv"' in text
    case.increments[1] = replace(case.increments[1], front=front, size=5.0)
    assert "Against the crack" in page([case], ReportOptions())


def test_a_front_without_a_k_to_be_trusted_is_told(results):
    (case,) = read_cases(results)
    flags = np.array(["end+error", "error", "short"])
    case.increments[0] = replace(case.increments[0], front=case.increments[0].front | {"flags": flags})
    said = "Increment 000: no node of front 1 has a reliable K"
    assert said in page([case], ReportOptions())
    assert grown_rows(case)[0].k_1 == pytest.approx((case.increments[0].front["K_I"][2],) * 2)


def test_no_folder_of_the_machine_is_on_the_page(results):
    (case,) = read_cases(results)
    config = case.record["config"] | {
        "cracks": {"edge": {"shape": "surface", "file": "/some/where/own.stl"}}
    }
    case = replace(
        case, record=dict(case.record) | {"microstructure": "/some/where/s.npz", "config": config}
    )
    text = page([case], ReportOptions())
    assert "/some/where" not in text and "own.stl" in text and "s.npz" in text
