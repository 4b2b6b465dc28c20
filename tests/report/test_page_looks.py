"""Contrast by calculation and overflow by structure: what holds in any browser, at any width."""

import re
from importlib.resources import files
from pathlib import Path

import pytest

from craftmesh.report import charts
from craftmesh.report.pictures import FRONT, line_colours

TEMPLATES = Path(str(files("craftmesh.report"))) / "templates"
STYLE = (TEMPLATES / "style.css").read_text()
TEXT, MARK = 4.5, 3.0  # least contrast of text and of lines, WCAG 2.2 level AA


def luminance(colour):
    digits = colour.lstrip("#")
    digits = digits if len(digits) == 6 else "".join(2 * digit for digit in digits)
    shades = [int(digits[k : k + 2], 16) / 255 for k in (0, 2, 4)]
    linear = [s / 12.92 if s <= 0.04045 else ((s + 0.055) / 1.055) ** 2.4 for s in shades]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one, other):
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def schemes():
    """Return the colours of the page by name, light and dark."""
    light, dark = (
        dict(re.findall(r"--(\w+): (#\w+)", block)) for block in re.findall(r":root \{(.*?)\}", STYLE, re.S)
    )
    assert light.keys() == dark.keys()
    return {"light": light, "dark": dark}


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("name", ["ink", "soft", "blue", "good", "bad"])
def test_text_is_read_on_the_page_and_on_tiles(scheme, name):
    colours = schemes()[scheme]
    assert contrast(colours[name], colours["ground"]) >= TEXT
    assert contrast(colours[name], colours["pale"]) >= TEXT


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_lines_of_charts_are_seen_on_the_page(scheme):
    ground = schemes()[scheme]["ground"]
    lines = {FRONT, charts.BAR, charts.GOOD}.union(*(line_colours(count) for count in (1, 2, 5, 40)))
    assert {line: contrast(line, ground) for line in lines if contrast(line, ground) < MARK} == {}


def test_the_calculation_knows_black_on_white():
    assert contrast("#000", "#ffffff") == pytest.approx(21)
    assert contrast("#767676", "#fff") == pytest.approx(4.54, abs=0.01)


@pytest.mark.parametrize("name", ["page.html", "case.html"])
def test_every_table_scrolls_in_a_box_that_the_keyboard_reaches_or_wraps(name):
    text = (TEMPLATES / name).read_text()
    assert text.count("<table") == len(
        re.findall(r'<div class="wide" tabindex="0"><table|<div class="columns">', text)
    )


def test_no_column_of_a_grid_is_wider_than_a_narrow_screen():
    widths = re.findall(r"repeat\(auto-fit, minmax\(([^,]+(?:, 100%\))?),", STYLE)
    assert len(widths) == 3
    for width in widths:
        assert width.endswith(", 100%)") or float(width.removesuffix("rem")) * 16 < 380
    assert "white-space: normal; text-align: left; overflow-wrap: anywhere" in STYLE


def test_heads_that_sort_are_buttons():
    script = (TEMPLATES / "tables.js").read_text()
    assert 'createElement("button")' in script and "head.addEventListener" not in script
