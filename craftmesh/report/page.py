"""One self-contained html page with the measures of every case and increment."""

import base64
import html
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from craftmesh.atomic import atomic_path

STYLE = """body{font:14px sans-serif;margin:2em;color:#222}table{border-collapse:collapse}
th,td{padding:.25em .7em;border-bottom:1px solid #ddd;text-align:right}
th:first-child,td:first-child{text-align:left}
figure{display:inline-block;margin:.5em 1em .5em 0}figcaption{font-size:12px}
img{max-width:100%}rect{fill:#3b6ea5}"""
WIDTH, HEIGHT = 260, 90


class GrowingCase(NamedTuple):
    """What is shown of a crack that grows.

    outcome: a sentence on how far it came; rows: numbers by increment; pictures: captions and .png images.
    """

    outcome: str
    rows: Mapping[str, dict]
    pictures: Sequence[tuple[str, bytes]]


def write_report(
    path: str | os.PathLike,
    rows: Sequence[tuple[str, str, dict]],
    growing: Mapping[str, GrowingCase] = MappingProxyType({}),
) -> None:
    """Write the page for `rows` of (case, increment, quality): a table of the numbers, and histograms.

    `histograms` of a quality holds dicts of `edges` (n + 1), null for infinite, and `counts` (n). Rows are
    taken in the order given. growing: cases whose cracks grow, by name, shown after the table.
    """
    title = "craftmesh: measures of every case and increment"
    body = [f"<h1>{title}</h1>", _table(rows)]
    body += [_growth(case, shown) for case, shown in growing.items()]
    body += [_figures(*row) for row in rows]
    page = (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{title}</title>'
        f"<style>{STYLE}</style>\n" + "\n".join(body) + "\n</html>\n"
    )
    with atomic_path(Path(path)) as temporary:
        temporary.write_text(page, encoding="utf-8")


def _growth(case: str, shown: GrowingCase) -> str:
    rows = [(case, increment, numbers) for increment, numbers in shown.rows.items()]
    heading = f"<h2>{html.escape(case)}</h2>\n<p>{html.escape(shown.outcome)}</p>\n"
    return heading + _table(rows) + _gallery(shown.pictures)


def _gallery(images: Sequence[tuple[str, bytes]]) -> str:
    figures = [
        f'<figure><img alt="{html.escape(caption)}" src="data:image/png;base64,'
        f'{base64.b64encode(image).decode("ascii")}"><figcaption>{html.escape(caption)}</figcaption></figure>'
        for caption, image in images
    ]
    return "".join(figures)


def _table(rows: Sequence[tuple[str, str, dict]]) -> str:
    numbers = [_numbers(quality) for _, _, quality in rows]
    keys = list(dict.fromkeys(key for row in numbers for key in row))
    head = "".join(f"<th>{html.escape(key)}</th>" for key in ("case", "increment", *keys))
    lines = []
    for (case, increment, _), row in zip(rows, numbers):
        cells = [html.escape(case), html.escape(increment), *(_number(row.get(key)) for key in keys)]
        lines.append("<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>")
    return f"<table><tr>{head}</tr>\n" + "\n".join(lines) + "</table>"


def _numbers(quality: dict) -> dict[str, float]:
    """Return the plain numbers of a quality.json and of its dicts, but for those of single grains."""
    found = {key: value for key, value in quality.items() if _is_number(value)}
    for name, inner in quality.items():
        if isinstance(inner, dict):
            found |= {f"{name} {key}": value for key, value in inner.items() if _is_number(value)}
    return {key.replace("_", " "): value for key, value in found.items()}


def _figures(case: str, increment: str, quality: dict) -> str:
    figures = [
        f"<figure>{_histogram(value['edges'], value['counts'])}"
        f"<figcaption>{html.escape(key.replace('_', ' '))}</figcaption></figure>"
        for key, value in quality.get("histograms", {}).items()
    ]
    heading = f"<h2>{html.escape(case)} {html.escape(increment)}</h2>"
    return heading + "".join(figures) if figures else ""


def _histogram(edges: Sequence[float | None], counts: Sequence[int]) -> str:
    """Return an inline picture of bars with the first and the last edge written under them."""
    top = max([*counts, 1])
    wide = WIDTH / max(len(counts), 1)
    bars = "".join(
        f'<rect x="{i * wide:.1f}" y="{HEIGHT * (1 - n / top):.1f}" width="{wide * 0.9:.1f}" '
        f'height="{HEIGHT * n / top:.1f}"/>'
        for i, n in enumerate(counts)
    )
    first, last = ("∞" if edge is None else f"{edge:g}" for edge in (edges[0], edges[-1]))
    ends = (
        f'<text x="0" y="{HEIGHT + 14}" font-size="11">{first}</text>'
        f'<text x="{WIDTH}" y="{HEIGHT + 14}" font-size="11" text-anchor="end">{last}</text>'
    )
    return f'<svg width="{WIDTH}" height="{HEIGHT + 18}">{bars}{ends}</svg>'


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _number(value: float | None) -> str:
    if value is None:
        return "–"
    return f"{value:,}" if isinstance(value, int) else f"{value:.5g}"
