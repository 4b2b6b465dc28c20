"""Words of docstrings, comments and pages: rules that a machine can hold."""

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
MODULES = sorted((ROOT / "craftmesh").rglob("*.py"))
PAGES = [*sorted(ROOT.glob("docs/*.md")), *(ROOT / f"{name}.md" for name in ("README", "CHANGELOG"))]
# Words that the code or its pages once had for terms of the field, and what is said instead.
COINED = {
    r"anew": "again",
    r"at fault": "faulty, invalid",
    r"beside": "next to",
    r"but for": "except",
    r"in place of": "instead of",
    r"hangs? together": "is connected",
    r"laps?": "pass of smoothing",
    r"mend(s|ed)?": "fix",
    r"parted": "split, severed",
    r"sheets? of cases": "case table",
    r"so many": "this number of",
    r"square to": "perpendicular to",
    r"truth values?": "boolean",
    r"verbs?": "subcommand",
    r"whole floats?": "integer-valued float",
}
WORD = re.compile(rf"\b({'|'.join(COINED)})\b", re.IGNORECASE)
CODE = re.compile(r"```.*?```|`[^`]*`|<!--.*?-->|\]\([^)]*\)", re.DOTALL)  # and targets of links
UNNAMED = re.compile(r"Return (how|what|where|which|why)\b")


def docstrings(source: str) -> Iterator[str]:
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            yield ast.get_docstring(node) or ""


def comments(source: str) -> Iterator[str]:
    """Yield comments, successive lines that have nothing else as one."""
    block: list[str] = []
    last = -1
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            alone = token.line.lstrip().startswith("#")
            if block and not (alone and token.start[0] == last + 1):
                yield " ".join(block)
                block = []
            block.append(token.string.lstrip("#").strip())
            last = token.start[0] if alone else -1
    yield " ".join(block)


def coined(text: str) -> list[str]:
    return [match[0] for match in WORD.finditer(CODE.sub("", text))]


def faults(source: str) -> list[str]:
    """Return the words and beginnings in the docstrings and comments of a module that break a rule."""
    found = [text[:60] for text in docstrings(source) if UNNAMED.match(text)]
    found += [text[:60] for text in comments(source) if text.lower().startswith("of ")]
    return found + [word for text in (*docstrings(source), *comments(source)) for word in coined(text)]


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(ROOT)))
def test_docstrings_and_comments_have_plain_words(path):
    assert faults(path.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_pages_have_plain_words(path):
    assert coined(path.read_text(encoding="utf-8")) == []


def test_faults_are_seen():
    source = '''"""Return which grains are `beside` a void, made anew."""
SHARE = 0.5  # of l_min
# Largest share
# of l_min
x = 1  # besides, no word of the list
# Of the rest: square to it.
'''
    assert faults(source) == [
        "Return which grains are `beside` a void, made anew.",
        "of l_min",
        "Of the rest: square to it.",
        "anew",
        "square to",
    ]
