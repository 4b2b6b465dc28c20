"""Charts of the report: element quality, convergence with element size, growth, and load histories.

A sweep is a set of cases that differ only in an element size. Convergence is judged as in the paper
(section 3). The converged size is the coarsest for which this and every finer size give the quantity within
a tolerance of its value at the finest size. The finest size is the reference, so it never counts as
converged: if no coarser size does, finer sizes are needed. A node of a front is reliable if its own K
counts for growth (`growth.trust`).
"""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from craftmesh.extras import extra
from craftmesh.report.case_files import Case, Increment
from craftmesh.report.measures import of_trusted, trust_of
from craftmesh.report.pictures import line_colours, new_figure, plain, with_unit
from craftmesh.report.sweeps import FEWEST, QUANTITIES, SOLVED, Sweep

with extra("pictures"):
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Axis labels of the histograms in quality.json.
HISTOGRAMS = {
    "aspect_ratio": "aspect ratio",
    "dihedral_min": "smallest dihedral angle [degrees]",
    "dihedral_max": "largest dihedral angle [degrees]",
}
BAR, GOOD = "#3b6ea5", "#2e8b57"  # both stand out from a white page and from a dark one
STYLES = ("-", "--", ":", "-.")  # line styles of the fronts of one crack
BAND = 0.2  # opacity of bands
ROOM = 0.15  # space above and below reliable values with their errors, relative to the range of these
SPAN = 20  # K_I is drawn on a logarithmic scale if the largest is over this many times the least


class Converged(NamedTuple):
    """A quantity of a sweep, with a value for each size, None where unknown.

    size: the converged size, None if no size is converged; judged: False for measures of the mesh, which
    need not converge, and for fewer than FEWEST values.
    """

    quantity: str
    values: tuple[float | None, ...]
    judged: bool
    size: float | None


def converged(
    quantity: str, sizes: Sequence[float], values: Sequence[float | None], tolerance: float
) -> Converged:
    """Return the convergence of a quantity whose `values` belong to `sizes`, from coarse to fine.

    tolerance: largest difference from the finest size's value, relative to this value.
    """
    known = [(size, value) for size, value in zip(sizes, values) if value is not None]
    judged = quantity in SOLVED and len(known) >= FEWEST
    reached = None
    if judged:
        finest = known[-1][1]
        for size, value in reversed(known[:-1]):
            if abs(value - finest) > tolerance * abs(finest):
                break
            reached = size
    return Converged(quantity, tuple(values), judged, reached)


def compared(
    sweep: Sweep, cases: Mapping[str, Case], quantity: str | None, tolerance: float
) -> tuple[str, list[Converged]]:
    """Return the name of the last increment that all cases of a sweep have, and convergence there.

    quantity: the only quantity to compare, None for all. Quantities without any value are left out.
    """
    count = min(len(cases[name].increments) for name in sweep.cases)
    increments = [cases[name].increments[count - 1] for name in sweep.cases]
    wanted = [quantity] if quantity else list(QUANTITIES)
    rows = {name: [VALUES[name](increment) for increment in increments] for name in wanted}
    found = [converged(name, sweep.sizes, row, tolerance) for name, row in rows.items()]
    return increments[0].name, [row for row in found if any(value is not None for value in row.values)]


def _mean(column: str, size: bool = False) -> Callable[[Increment], float | None]:
    """Return a function that gives an increment's mean of a column of sif.csv over nodes with a value.

    It gives None without values. size: average absolute values instead.
    """

    def mean(increment: Increment) -> float | None:
        if increment.front is None or column not in increment.front:
            return None
        values = increment.front[column][np.isfinite(increment.front[column])]
        return float(np.mean(np.abs(values) if size else values)) if len(values) else None

    return mean


def _largest(increment: Increment) -> float | None:
    if increment.front is None:
        return None
    values = of_trusted(increment.front, "K_I")
    return float(np.nanmax(values)) if np.isfinite(values).any() else None


VALUES: dict[str, Callable[[Increment], float | None]] = {
    "K_I": _mean("K_I"),
    "J": _mean("J"),
    "kink_angle": _mean("kink_angle", size=True),
    "largest_K_I": _largest,
    "reaction": lambda increment: increment.reaction,
    "crack_area": lambda increment: increment.quality["crack_area"],
    "mean_aspect_ratio": lambda increment: increment.quality["ar_mean"],
    "elements": lambda increment: increment.quality["elements"],
}


def panel(x: str, y: str) -> tuple[Figure, Axes]:
    """Return a figure with one chart, and its axes with the labels x and y.

    matplotlib draws text between `$` in the labels as formulas.
    """
    figure = new_figure(4.4, 3.2)
    figure.set_layout_engine("constrained")
    axes = figure.add_subplot()
    axes.set_xlabel(x, fontsize=9)
    axes.set_ylabel(y, fontsize=9)
    axes.tick_params(labelsize=8)
    axes.grid(alpha=0.3)
    return figure, axes


def along_front(rows: Mapping[str, Mapping[str, np.ndarray]], unit: str = "") -> list[Figure]:
    """Return charts of K_I, K_II, K_III and the kink angle along the fronts, a line per increment.

    rows: columns of sif.csv by increment name; unit: of K. There is no chart of a column that an increment
    lacks. The arc length s is divided by each front's largest s. Lines join reliable nodes, in a band of
    the error of K. Other nodes are open marks; marks beyond the axes are not shown. The scale of K_I is
    logarithmic where `_scaled` says so.
    """
    keys = ("K_I", "K_II", "K_III", "kink_angle")
    return [
        _along_front(key, rows, unit) for key in keys if all(key in columns for columns in rows.values())
    ]


def _along_front(key: str, rows: Mapping[str, Mapping[str, np.ndarray]], unit: str) -> Figure:
    figure, axes = panel("arc length along the front / its length", with_unit(key, unit))
    reliable = []
    for colour, front in zip(line_colours(len(rows)), rows.values()):
        steers, doubted = trust_of(front)
        error = front["error"] if key != "kink_angle" and "error" in front else np.zeros(len(steers))
        for number in np.unique(front["front"]):
            own = front["front"] == number
            s, values = front["s"][own] / max(front["s"][own].max(), 1e-300), front[key][own]
            kept = np.where(steers[own] & (number not in doubted), values, np.nan)
            band = np.stack([kept - error[own], kept + error[own]])
            axes.fill_between(s, *band, color=colour, alpha=BAND, lw=0)
            axes.plot(
                s, kept, STYLES[int(number - 1) % len(STYLES)], color=colour, marker=".", markersize=3
            )
            flagged = np.isnan(kept)
            axes.plot(s[flagged], values[flagged], "o", color=colour, markersize=4, fillstyle="none")
            reliable.append(band[np.isfinite(band)])
    known = np.concatenate(reliable)
    if len(known) and np.ptp(known) > 0:
        room = ROOM * np.ptp(known)
        if key == "K_I" and _scaled(axes, known):
            room = ROOM * np.array([known.min(), known.max()])
        axes.set_ylim(np.array([known.min(), known.max()]) + np.array([-1, 1]) * room)
    return figure


def _scaled(axes: Axes, values: np.ndarray) -> bool:
    """Make the y axis logarithmic if `values` are positive and the largest is over SPAN times the least.

    K_I of a crack that almost severs the body would flatten the curves of all other increments. Return
    whether the axis is logarithmic.
    """
    if not 0 < SPAN * np.nanmin(values) < np.nanmax(values):
        return False
    axes.set_yscale("log")
    return True


def histograms(qualities: Mapping[str, Mapping]) -> list[Figure]:
    """Return a chart for each histogram in quality.json: bars for the last increment, lines for others.

    qualities: contents of quality.json by increment name.
    """
    return [_histogram(key, label, qualities) for key, label in HISTOGRAMS.items()]


def _histogram(key: str, label: str, qualities: Mapping[str, Mapping]) -> Figure:
    figure, axes = panel(label, "fraction of the elements [%]")
    axes.grid(visible=False)
    for quality, colour in zip(qualities.values(), line_colours(len(qualities))):
        histogram = quality["histograms"][key]
        share = 100 * np.array(histogram["counts"]) / max(sum(histogram["counts"]), 1)
        if quality is list(qualities.values())[-1]:
            _bars(axes, share, histogram["edges"], colour)
        else:
            axes.step(np.arange(len(share)), share, where="mid", color=colour, lw=1)
    return figure


def _bars(axes: Axes, share: np.ndarray, edges: Sequence[float | None], colour: str) -> None:
    """Draw bars of equal width with heights `share` (k,) in %, and bin `edges` (k + 1) as tick labels.

    An edge None is infinity. Bars above 0 have their height as text; the axes end one bin beyond them.
    """
    axes.bar(np.arange(len(share)), share, width=0.92, color=colour)
    for place, value in enumerate(share):
        if value > 0:
            text = f"{value:.0f}" if value >= 9.5 else f"{value:.1g}"
            axes.annotate(text, (place, value), ha="center", va="bottom", fontsize=6)
    filled = np.flatnonzero(share)
    first, last = max(filled.min() - 1, 0), min(filled.max() + 1, len(share) - 1)
    axes.set_xlim(first - 0.6, last + 0.6)
    axes.margins(y=0.12)
    ticks = np.arange(first, last + 2)
    axes.set_xticks(ticks - 0.5, ["∞" if edges[k] is None else f"{edges[k]:g}" for k in ticks], fontsize=7)


def against_size(
    sweep: Sweep, found: Sequence[Converged], tolerance: float, words: Mapping[str, str], length: str = ""
) -> list[Figure]:
    """Return charts of quantities against a sweep's sizes, on a log axis, with the tolerance as a band.

    found: quantities of the sweep; words: their titles by name; length: unit of the sizes. A ring marks the
    converged size.
    """
    figures = []
    for one in found:
        figure, axes = panel(with_unit(sweep.key, length), plain(words[one.quantity]))
        known = {size: value for size, value in zip(sweep.sizes, one.values) if value is not None}
        if one.judged:
            finest = known[min(known)]
            reach = tolerance * abs(finest)
            axes.axhspan(finest - reach, finest + reach, color=GOOD, alpha=BAND, lw=0)
        axes.plot(list(known), list(known.values()), "o-", color=BAR, markersize=4)
        if one.size is not None:
            axes.plot(one.size, known[one.size], "o", color=GOOD, markersize=9, fillstyle="none")
        axes.set_xscale("log")
        axes.set_xticks(list(known), [f"{size:g}" for size in known])
        axes.minorticks_off()
        axes.invert_xaxis()
        figures.append(figure)
    return figures


def against_crack(increments: Sequence[Increment], units: Mapping[str, str]) -> list[Figure]:
    """Return charts of K, kink angle and load cycles against crack size: lines in bands.

    For K and kink angle these are mean and range at reliable nodes; for load cycles the number and its
    error. units: names by quantity. There is no chart if fewer than two increments have a size and a front.
    """
    known = [(one.size, one.front) for one in increments if one.size is not None and one.front is not None]
    if len(known) < 2:
        return []
    sizes = [size for size, _ in known]
    figures = []
    for key in ("K_I", "K_II", "K_III", "kink_angle", "cycles"):
        if not all(key in front for _, front in known):
            continue
        rows = [_cycles(front) if key == "cycles" else _range(front, key) for _, front in known]
        middle, low, high = np.transpose(rows)
        label = "load cycles" if key == "cycles" else with_unit(key, units.get("K", ""))
        figure, axes = panel(with_unit("crack size", units.get("length", "")), label)
        axes.fill_between(sizes, low, high, color=BAR, alpha=BAND, lw=0)
        axes.plot(sizes, middle, "o-", color=BAR, markersize=4)
        if key == "K_I":
            _scaled(axes, middle)
        figures.append(figure)
    return figures


def _range(front: Mapping[str, np.ndarray], key: str) -> tuple[float, float, float]:
    """Return mean, minimum and maximum of a column of sif.csv at reliable nodes."""
    values = of_trusted(front, key)
    return np.nanmean(values), np.nanmin(values), np.nanmax(values)


def _cycles(front: Mapping[str, np.ndarray]) -> tuple[float, float, float]:
    """Return the load cycles to the front of a sif.csv, and their lower and upper bounds by their error."""
    cycles, doubt = front["cycles"][0], np.nan_to_num(front["cycles_doubt"][0])
    return cycles, cycles - doubt, cycles + doubt


def loops(history: Mapping[str, np.ndarray], unit: str) -> Figure:
    """Return a figure of nominal stress against nominal strain of each face, during a load history.

    history: arrays named "<face> strain" and "<face> stress", as in `Solution`; unit: of stress.
    """
    figure, axes = panel("nominal strain", with_unit("nominal stress", unit))
    names = [name.removesuffix(" strain") for name in history if name.endswith(" strain")]
    for name, colour in zip(names, line_colours(len(names))):
        axes.plot(history[f"{name} strain"], history[f"{name} stress"], lw=1.2, color=colour, label=name)
    axes.legend(fontsize=8, frameon=False)
    return figure
