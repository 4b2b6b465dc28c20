"""The page holds a table, histograms and pictures in itself."""

from craftmesh.report.page import GrowingCase, write_report

QUALITY = {"elements": 12, "histograms": {"angles": {"edges": [0, 1, None], "counts": [2, 3]}}}


def test_pictures_are_in_the_page_under_their_case(tmp_path):
    shown = GrowingCase("It stops.", {"000": {"crack_area": 12.5}}, [("crack <by> increment", b"PNG")])
    write_report(tmp_path / "r.html", [("one", "000", QUALITY)], {"one": shown})
    page = (tmp_path / "r.html").read_text()
    assert "data:image/png;base64,UE5H" in page and "crack &lt;by&gt; increment" in page
    assert page.index("<h2>one</h2>") > page.index("<table>")
    assert page.index("<p>It stops.</p>") < page.index("crack area") < page.index("12.5")
    assert 'src="http' not in page


def test_a_page_without_pictures_has_none(tmp_path):
    write_report(tmp_path / "r.html", [("one", "000", QUALITY)])
    assert "<img" not in (tmp_path / "r.html").read_text()
