"""The documentation's site is made without a warning, and has a page for every stage, key and room."""

import re
from pathlib import Path

import pytest

pytest.importorskip("mkdocs", reason="the extra `test` is not installed")

from mkdocs.commands.build import build
from mkdocs.config import load_config

from craftmesh.campaign.config_schema import config_schema

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    config = load_config(str(ROOT / "mkdocs.yml"), site_dir=str(folder), strict=True)
    config.plugins.on_startup(command="build", dirty=False)
    build(config)  # a warning ends it
    return folder


def test_links_and_pictures_lead_to_files(site):
    for page in site.rglob("*.html"):
        for target in re.findall(r'(?:href|src)="([^"#]+)', page.read_text()):
            if not re.match(r"\w+:|//", target) and page.name != "404.html":
                assert (page.parent / target).exists(), f"{page.relative_to(site)} leads to {target}"


def test_code_within_a_list_stays_code(site):
    text = (site / "index.html").read_text()
    listed = text[text.index("Name the microstructure in a case table") :]
    assert "mine" in listed[listed.index("<code") : listed.index("</code>")]
    assert listed.index("</ol>") > listed.index("craftmesh run mine.yaml")  # three items of one list


def test_every_stage_has_a_page(site):
    verbs = re.findall(r"^## \d+\. (\w+)", (ROOT / "docs/guide.md").read_text(), flags=re.M)
    assert len(verbs) > 10
    pages = sorted((site / "stages").glob("*.html"))
    assert [path.stem[3:] for path in pages] == verbs
    without = [path.stem[3:] for path in pages if "<img " not in path.read_text()]
    assert without == []


def test_every_key_of_the_configuration_has_its_effect(site):
    text = (site / "parameters.html").read_text()
    for section in config_schema()["properties"].values():
        for key in section.get("properties", {}):
            assert f"<code>{key}</code>" in text, key


def test_the_reference_has_the_docstrings(site):
    assert "Gradate" in (site / "api/gradation.html").read_text()
    assert "craftmesh.sizing.sizing.sizing_for" in (site / "api/sizing.html").read_text()


def test_the_gallery_shows_examples_and_notebooks_and_leads_to_them(site):
    text = (site / "gallery.html").read_text()
    shown = re.findall(r'<a href="([\w-]+\.html)"><img [^>]*src="(pictures/[\w-]+\.png)"', text)
    assert len(shown) == text.count("<img ") >= 9
    notebooks = {
        f"notebook-{path.stem.replace('_', '-')}.html" for path in ROOT.glob("examples/notebooks/*.ipynb")
    }
    assert notebooks <= {page for page, _ in shown}
    assert "TetMesh(" in (site / "notebook-pipe.html").read_text()  # what a cell printed
