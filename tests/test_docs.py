"""What the documentation names is in the tree."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", *sorted(ROOT.glob("docs/*.md")), ROOT / "config" / "README.md"]
# what a campaign or the reader makes, or lies outside the tree
ELSEWHERE = re.compile(r"results/|\.\./|.*/my\w+\.py")


def named_paths(page: Path) -> list[str]:
    """Return the paths and modules that a page names as code within its text, and in comments."""
    text = re.sub(r"```.*?```", "", page.read_text(), flags=re.S)
    words = re.findall(r"`([\w./*-]+)`", text)
    words += re.findall(r"\b[\w/]+/[\w.]*\w", " ".join(re.findall("<!--(.*?)-->", text, flags=re.S)))
    dotted = [word.replace(".", "/") for word in words if re.fullmatch(r"craftmesh(\.\w+)+", word)]
    paths = [word for word in words if "/" in word and not ELSEWHERE.match(word)]
    return dotted + [word for word in paths if re.fullmatch(r"[\w.*-]+(/[\w.*-]*)+", word)]


def is_there(name: str, page: Path) -> bool:
    """True for a file, folder, module (without suffix) or function of a module, in the tree or package."""
    parents = (ROOT, ROOT / "craftmesh", page.parent)
    found = [match for parent in parents for match in [*parent.glob(name), *parent.glob(f"{name}.py")]]
    module = ROOT / f"{Path(name).parent}.py"
    return bool(found) or (module.is_file() and f"def {Path(name).name}(" in module.read_text())


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_paths_and_modules_that_a_page_names_are_there(page):
    gone = [name for name in named_paths(page) if not is_there(name, page)]
    assert not gone, f"{page.relative_to(ROOT)} names {gone}"


def test_each_section_of_the_readme_names_what_holds_it():
    first, *sections = (ROOT / "README.md").read_text().split("\n## ")
    without = [
        section.partition("\n")[0]
        for section in (first, *sections)
        if not re.search(r"<!-- .*(?:tests|benchmarks)/", section)
    ]
    assert without == [] and len(sections) > 6


def test_gone_paths_are_seen(tmp_path):
    page = tmp_path / "page.md"
    page.write_text(
        "`gradation/gone.py`, `kernels/nothing`, `craftmesh.types`, `craftmesh.gone`, `surface/`"
    )
    gone = [name for name in named_paths(page) if not is_there(name, page)]
    assert gone == ["craftmesh/gone", "gradation/gone.py", "kernels/nothing"]


def test_the_papers_references_and_figures_are_there():
    text = (ROOT / "paper/paper.md").read_text()
    known = re.findall(r"^@\w+\{(\w+),", (ROOT / "paper/paper.bib").read_text(), flags=re.M)
    assert set(re.findall(r"@(\w+\d{4})", text)) == set(known)
    figures = re.findall(r"!\[[^\]]*\]\(([^)]+)\)", text)
    assert figures and all((ROOT / "paper" / path).is_file() for path in figures)
