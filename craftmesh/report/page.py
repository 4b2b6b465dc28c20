"""The report on all campaigns in a results folder: one self-contained HTML page."""

import itertools
import json
import re
from collections.abc import Collection, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from craftmesh.extras import extra
from craftmesh.mechanics.units import UnitsOptions
from craftmesh.mesh.quality import drift_sentence
from craftmesh.report.case_files import Case, Failure, is_complete
from craftmesh.report.charts import against_crack, against_size, along_front, compared, histograms, loops
from craftmesh.report.measures import (
    UNIFORM_TETS,
    grown_rows,
    life,
    materials,
    outcome,
    table_row,
    totals,
    verdict,
    with_error,
)
from craftmesh.report.mesh_pictures import body_view
from craftmesh.report.pictures import as_svg, crack_path, from_webp, line_colours
from craftmesh.report.shown_mesh import fronts_of
from craftmesh.report.sweeps import MEASURED_IN, QUANTITIES, ReportOptions, sweeps

with extra("pictures"):
    from jinja2 import Environment, PackageLoader, StrictUndefined
    from markupsafe import Markup
    from matplotlib.figure import Figure

# Largest total size of the page's pictures in bytes; larger pages open slowly. If there are more, the
# pictures of increments between the first and last of a case are left out evenly. An increment's pictures
# take about 180 kB.
MOST_PICTURES = 24_000_000
CAPTIONS = {
    "grains": "The body by grain.",
    "sizes": "Element size, cut open along the crack: mean edge length at each node. Red: crack front.",
    "crack": "The crack face along its normal, by grain. Red: crack front.",
    "renewed": "New elements blue, elements of the increment before grey. Red: crack front.",
    "deformed": "The loaded body with magnified displacement.",
    "stress": "Largest principal stress on a plane through the middle of the front.",
    "slip": "Accumulated slip of all slip systems, on the same plane.",
}


K_CAPTION = (
    "Stress intensity factors and kink angle along the front. Lines: reliable nodes, in a band of the "
    "error of K; open marks: flagged nodes, as far as the axes reach{}."
)


class Chart(NamedTuple):
    """Panels (<svg> elements) with one caption; legend: pairs of an increment's name and its colour."""

    caption: str
    panels: list[Markup]
    legend: list[tuple[str, str]] = []


def page(cases: Sequence[Case], options: ReportOptions, failed: Sequence[Failure] = ()) -> str:
    """Return the HTML page of `cases`, each with at least one increment, and of the failures `failed`.

    The same input gives the same text. The costs of jobs, which differ between runs, are between
    `<!--times-->` and `<!--/times-->`.
    """
    rows = {case.name: [table_row(increment) for increment in case.increments] for case in cases}
    shown = _shown(cases)
    text = (
        _environment()
        .get_template("page.html")
        .render(
            cases=[_case(case, rows[case.name], shown[case.name]) for case in cases],
            campaigns=list(dict.fromkeys(case.record["campaign"] for case in cases)),
            failed=failed,
            verdict=verdict(cases, failed),
            totals=totals([row for own in rows.values() for row in own]),
            increments=sum(len(case.increments) for case in cases),
            seconds=sum(cost.cpu_seconds for case in cases for cost in case.costs),
            memory=max((cost.memory for case in cases for cost in case.costs), default=0),
            sweeps=_sweeps({case.name: case for case in cases}, options),
            tolerance=options.tolerance,
            uniform_tets=UNIFORM_TETS,
        )
    )
    count = itertools.count()  # each picture gets a prefix, because its ids occur in other pictures too
    return re.sub(r"<svg .*?</svg>", lambda svg: _with_own_ids(svg[0], f"p{next(count)}"), text, flags=re.S)


def _with_own_ids(svg: str, prefix: str) -> str:
    return re.sub(r'(\bid="|url\(#|href="#)', rf"\g<1>{prefix}", svg)


def _case(case: Case, rows: list, shown: list[str]) -> dict[str, Any]:
    """Return a case's variables of the HTML template.

    rows: table rows of its increments; shown: names of the increments whose pictures the page has.
    """
    last = case.increments[-1]
    return {
        "name": case.name,
        "record": case.record,
        "imported": case.imported,
        "units": _units(case),
        "labels": [*case.imported.get("changes", []), *case.imported.get("notes", [])],
        "is_made": is_complete(case),
        "outcome": outcome(case),
        "life": life(case),
        "materials": materials(case),
        "path": _crack_path(case),
        "rows": rows,
        "off": [(inc.name, drift_sentence(inc.quality.get("volume_drift", {}))) for inc in case.increments],
        "grown": grown_rows(case),
        "solved": [increment.name for increment in case.increments if increment.front is not None],
        "charts": _charts(case),
        "increments": [
            {
                "name": increment.name,
                "pictures": [
                    Chart(CAPTIONS[key], [Markup(one)]) for key, one in increment.pictures.items()
                ],
            }
            for increment in case.increments
            if increment.name in shown and increment.pictures
        ],
        "left_out": [increment.name for increment in case.increments if increment.name not in shown],
        "scene": _scene(case),
        "lengths": last.lengths,
        "costs": case.costs,
        "digests": dict(case.digests)
        | {f"{inc.name}/{name}": found for inc in case.increments for name, found in inc.digests.items()},
    }


def _units(case: Case) -> dict[str, str]:
    """Return the unit names by quantity from a case's configuration."""
    return UnitsOptions(**case.record["config"].get("units", {})).by_quantity()


def _crack_path(case: Case) -> Chart | None:
    """Return a chart of the last body cut open along the crack, with the fronts of all increments.

    It is None if the last increment has no picture of the opened body.
    """
    last = case.increments[-1]
    if last.opened is None or last.scene is None:
        return None
    scenes = {inc.name: inc.scene for inc in case.increments if inc.scene is not None}
    view = body_view(np.array(last.scene["box"]), np.array(last.scene["towards"]))
    fronts = {name: fronts_of(scene) for name, scene in scenes.items()}
    figure = crack_path(from_webp(last.opened), view, fronts, _units(case).get("length", ""))
    words = "Light: crack; lines: its front" + " in each increment" * (len(fronts) > 1)
    return Chart(f"The body cut open along the crack, by grain. {words}.", [Markup(as_svg(figure))])


def _charts(case: Case) -> list[Chart]:
    """Return a case's charts: K along the front, crack growth, load history and element shapes."""
    last, units = case.increments[-1], _units(case)
    solved = {inc.name: inc.front for inc in case.increments if inc.front is not None}
    qualities = {inc.name: inc.quality for inc in case.increments}
    several = any(columns["front"].max() > 1 for columns in solved.values())
    caption = K_CAPTION.format("; dashed: second front" * several)
    charts = [(caption, along_front(solved, units.get("K", "")), solved)] if solved else []
    counted = any("cycles" in columns for columns in solved.values())
    text = (
        "Against the crack size: mean and range at reliable nodes"
        + "; load cycles with their error" * counted
    )
    text += "."
    charts.append((text, against_crack(case.increments, units), {}))
    if last.history:
        text = f"Increment {last.name}: stress and strain of the loaded faces during the load history."
        told = "; ".join(f"{name} {value:.3g}" for name, value in last.at_fronts.items())
        text += f" At its end {told}." if told else ""
        charts.append((text, [loops(last.history, units.get("stress", ""))], {}))
    text = (
        f"Shapes of the elements: percent of the elements in each interval, bars for increment {last.name}."
    )
    charts.append((text, histograms(qualities), qualities))
    return [_chart(*chart) for chart in charts if chart[1]]


def _chart(caption: str, figures: Sequence[Figure], increments: Collection[str] = ()) -> Chart:
    """Return a chart of figures; with several `increments` (names), it has a legend of their colours."""
    legend = list(zip(increments, line_colours(len(increments)))) if len(increments) > 1 else []
    return Chart(caption, [Markup(as_svg(figure)) for figure in figures], legend)


def _shown(cases: Sequence[Case]) -> dict[str, list[str]]:
    """Return by case the names of increments whose pictures are in the page.

    These are all, or as many as MOST_PICTURES allows, but at least the first and last of each case.
    """
    sizes = [len(picture) for case in cases for inc in case.increments for picture in inc.pictures.values()]
    share = min(1.0, MOST_PICTURES / max(sum(sizes), 1))
    shown = {}
    for case in cases:
        names = [increment.name for increment in case.increments]
        count = max(min(2, len(names)), int(share * len(names)))
        places = [round(k * (len(names) - 1) / max(count - 1, 1)) for k in range(count)]
        shown[case.name] = [names[place] for place in (places if count > 1 else [len(names) - 1])]
    return shown


def _scene(case: Case) -> str | None:
    """Return JSON for the 3-D view: the last increment's body, and the crack of each increment.

    It is None if no increment has a scene (`shown_mesh.scene`).
    """
    scenes = {inc.name: inc.scene for inc in case.increments if inc.scene is not None}
    if not scenes:
        return None
    last = list(scenes.values())[-1]
    cracks = [
        {"name": name, **{key: one[key] for key in ("lip", "fronts", "box", "lengths")}}
        for name, one in scenes.items()
    ]
    whole = {key: last[key] for key in ("box", "lengths", "towards", "skin", "opened")}
    # `</` would end the HTML script element
    return Markup(json.dumps(whole | {"cracks": cracks}, separators=(",", ":")).replace("</", "<\\/"))


def _sweeps(cases: Mapping[str, Case], options: ReportOptions) -> list[dict[str, Any]]:
    found = []
    for sweep in sweeps({name: case.record for name, case in cases.items()}):
        increment, quantities = compared(sweep, cases, options.quantity, options.tolerance)
        if quantities:
            units = _units(cases[sweep.cases[0]])
            words = {
                key: f"{words} [{units[MEASURED_IN[key]]}]" if MEASURED_IN.get(key) in units else words
                for key, words in QUANTITIES.items()
            }
            figures = against_size(sweep, quantities, options.tolerance, words, units.get("length", ""))
            text = (
                f"Each quantity against {sweep.key}, coarse to fine. Green: tolerance band, converged size."
            )
            found.append(
                {
                    "sweep": sweep,
                    "increment": increment,
                    "quantities": quantities,
                    "words": words,
                    "chart": _chart(text, figures),
                }
            )
    return found


def _number(value: float | None, digits: int = 3) -> str:
    """Return a number as text: integers exactly, floats rounded to `digits` digits, None as a dash."""
    if value is None:
        return "–"
    rounded = value if isinstance(value, int) else float(f"{value:.{digits}g}")
    if isinstance(value, int) or abs(rounded) >= 10 ** (digits - 1):
        return f"{rounded:,.0f}".replace(",", "\u202f")
    return f"{value:g}" if float(value).is_integer() else f"{value:#.{digits}g}"


def _span(values: tuple[float, float] | None, digits: int = 3) -> str:
    """Return "low … high", both with the decimals that `digits` digits of the larger size leave."""
    if values is None:
        return "–"
    decimals = _number(max(values, key=abs), digits).partition(".")[2]
    is_plain = decimals.isdecimal()  # no exponent
    ends = [f"{value:.{len(decimals)}f}" if is_plain else _number(value, digits) for value in values]
    return " … ".join(dict.fromkeys(ends))


def _name(value: Any) -> Any:
    """Return the file name of an absolute path, without the machine's folders; other values unchanged."""
    return Path(value).name if isinstance(value, str) and Path(value).is_absolute() else value


def _duration(seconds: float) -> str:
    if seconds < 100:
        return f"{seconds:.2g} s"
    return f"{seconds / 60:.2g} min" if seconds < 6000 else f"{seconds / 3600:.2g} h"


@cache
def _environment() -> Environment:
    loader = PackageLoader("craftmesh.report")
    environment = Environment(
        loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters |= {"number": _number, "span": _span, "duration": _duration, "name": _name}
    environment.filters["with_error"] = lambda pair: with_error(*pair) if pair else "–"
    for name in ("style.css", "view.js", "tables.js"):
        text = loader.get_source(environment, name)[0]
        environment.globals[name.split(".")[0]] = Markup(text)
    return environment
