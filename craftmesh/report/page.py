"""The report on all campaigns in a results folder: one self-contained HTML page."""

import base64
import json
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from craftmesh.extras import extra
from craftmesh.mechanics.units import UnitsOptions
from craftmesh.mesh.quality import drift_sentence
from craftmesh.report.case_files import Case, Failure
from craftmesh.report.charts import against_crack, against_size, compared, histograms, loops
from craftmesh.report.measures import UNIFORM_TETS, grown_rows, outcome, table_row, totals
from craftmesh.report.pictures import along_front, as_webp, crack_by_increment
from craftmesh.report.sweeps import MEASURED_IN, QUANTITIES, ReportOptions, sweeps

with extra("pictures"):
    from jinja2 import Environment, PackageLoader, StrictUndefined
    from markupsafe import Markup

# Largest total size of pictures in bytes; larger pages open slowly. Beyond it, increments between a case's
# first and last are left out evenly. The pictures of an increment take about 180 kB.
MOST_PICTURES = 24_000_000
CAPTIONS = {
    "grains": "The body by grain, whole and cut open along the crack. Light: crack; red: crack front.",
    "sizes": "Element size: mean length of the edges at each node, fine at the front, coarse far from it.",
    "crack": "The crack face seen along its normal, by grain and by element size. Red: crack front.",
    "deformed": "The loaded body with magnified displacement.",
    "stress": "Largest principal stress on a plane through the middle of the front.",
    "slip": "Accumulated slip of all slip systems, on the same plane.",
}


def page(cases: Sequence[Case], options: ReportOptions, failed: Sequence[Failure] = ()) -> str:
    """Return the HTML page of cases, each with increments, and of failures; same input gives same text.

    The costs of jobs, which differ between runs, are between `<!--times-->` and `<!--/times-->`.
    """
    rows = {case.name: [table_row(increment) for increment in case.increments] for case in cases}
    shown = _shown(cases)
    return (
        _environment()
        .get_template("page.html")
        .render(
            cases=[_case(case, rows[case.name], shown[case.name]) for case in cases],
            campaigns=list(dict.fromkeys(case.record["campaign"] for case in cases)),
            failed=failed,
            totals=totals([row for own in rows.values() for row in own]),
            increments=sum(len(case.increments) for case in cases),
            seconds=sum(cost.cpu_seconds for case in cases for cost in case.costs),
            memory=max((cost.memory for case in cases for cost in case.costs), default=0),
            sweeps=_sweeps({case.name: case for case in cases}, options),
            tolerance=options.tolerance,
            uniform_tets=UNIFORM_TETS,
        )
    )


def _case(case: Case, rows: list, shown: list[str]) -> dict[str, Any]:
    """Return the variables of the template of a case; shown: names of increments with pictures."""
    last = case.increments[-1]
    return {
        "name": case.name,
        "record": case.record,
        "imported": case.imported,
        "units": _units(case),
        "labels": [*case.imported.get("changes", []), *case.imported.get("notes", [])],
        "outcome": outcome(case),
        "rows": rows,
        "off": [(inc.name, drift_sentence(inc.quality.get("volume_drift", {}))) for inc in case.increments],
        "grown": grown_rows(case),
        "solved": [increment.name for increment in case.increments if increment.front is not None],
        "charts": _charts(case),
        "increments": [
            {
                "name": increment.name,
                "pictures": [(CAPTIONS[key], _embedded(one)) for key, one in increment.pictures.items()],
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


def _charts(case: Case) -> list[tuple[str, str]]:
    """Return captions and pictures of a case's charts: crack growth, load history and element shapes."""
    charts = []
    last = case.increments[-1]
    solved = {inc.name: inc.front for inc in case.increments if inc.front is not None}
    cracks = {inc.name: inc.crack for inc in case.increments if inc.crack is not None}
    if solved:
        text = "Stress intensity factors and kink angle along the front by increment; dashed: second front."
        charts.append((text, along_front(solved, _units(case).get("K", ""))))
    grown = against_crack(case.increments, _units(case))
    if grown is not None:
        text = "Against the crack size: mean along the front, and range, without uncertain nodes."
        charts.append((text, grown))
    if solved and len(cracks) > 1 and last.scene is not None:
        text = "The crack in the body, and along its normal: extension in each increment, and fronts."
        box, towards = np.array(last.scene["box"]), np.array(last.scene["towards"])
        charts.append((text, crack_by_increment(cracks, box, towards)))
    if last.history:
        text = f"Increment {last.name}: stress and strain of the loaded faces during the load history."
        told = "; ".join(f"{name} {value:.4g}" for name, value in last.at_fronts.items())
        text += f" At its end {told}." if told else ""
        charts.append((text, loops(last.history, _units(case).get("stress", ""))))
    text = f"Shapes of the elements in increment {last.name}: percent of the elements in each interval."
    charts.append((text, histograms({increment.name: increment.quality for increment in case.increments})))
    return [(caption, _embedded(as_webp(figure))) for caption, figure in charts]


def _shown(cases: Sequence[Case]) -> dict[str, list[str]]:
    """Return the increments with pictures in the page, by case: all, or as many as MOST_PICTURES allows."""
    sizes = [len(picture) for case in cases for inc in case.increments for picture in inc.pictures.values()]
    share = min(1.0, MOST_PICTURES / max(sum(sizes) * 4 / 3, 1))
    shown = {}
    for case in cases:
        names = [increment.name for increment in case.increments]
        count = max(min(2, len(names)), int(share * len(names)))
        places = [round(k * (len(names) - 1) / max(count - 1, 1)) for k in range(count)]
        shown[case.name] = [names[place] for place in (places if count > 1 else [len(names) - 1])]
    return shown


def _scene(case: Case) -> str | None:
    """Return JSON for the 3-D view: the last body, and each increment's crack; None without scenes."""
    scenes = {inc.name: inc.scene for inc in case.increments if inc.scene is not None}
    if not scenes:
        return None
    last = list(scenes.values())[-1]
    cracks = [
        {"name": name, **{key: one[key] for key in ("lip", "fronts", "box", "lengths")}}
        for name, one in scenes.items()
    ]
    whole = {key: last[key] for key in ("box", "lengths", "normal", "towards", "skin")}
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
            picture = against_size(sweep, quantities, options.tolerance, words)
            found.append(
                {
                    "sweep": sweep,
                    "increment": increment,
                    "quantities": quantities,
                    "words": words,
                    "picture": _embedded(as_webp(picture)),
                }
            )
    return found


def _embedded(picture: bytes) -> str:
    return "data:image/webp;base64," + base64.b64encode(picture).decode("ascii")


def _number(value: float | None, digits: int = 4) -> str:
    """Return a number as text: counts with thin spaces, others with `digits` digits, None as a dash."""
    if value is None:
        return "–"
    if isinstance(value, int) or abs(value) >= 10**digits:
        return f"{value:,.0f}".replace(",", "\u202f")
    return f"{value:.{digits}g}"


def _span(values: tuple[float, float] | None, digits: int = 3) -> str:
    return "–" if values is None else f"{_number(values[0], digits)} … {_number(values[1], digits)}"


def _name(value: Any) -> Any:
    """Return the file name of an absolute path, without the machine's folders; other values unchanged."""
    return Path(value).name if isinstance(value, str) and Path(value).is_absolute() else value


def _duration(seconds: float) -> str:
    if seconds < 100:
        return f"{seconds:.3g} s"
    return f"{seconds / 60:.3g} min" if seconds < 6000 else f"{seconds / 3600:.3g} h"


@cache
def _environment() -> Environment:
    loader = PackageLoader("craftmesh.report")
    environment = Environment(
        loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters |= {"number": _number, "span": _span, "duration": _duration, "name": _name}
    for name in ("style.css", "view.js", "tables.js"):
        text = loader.get_source(environment, name)[0]
        environment.globals[name.split(".")[0]] = Markup(text)
    return environment
