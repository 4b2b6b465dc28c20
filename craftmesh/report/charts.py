"""Charts: histograms of element quality, quantities against element size with convergence, growth, loops.

Convergence is judged as in the paper (section 3). The converged size is the coarsest for which it and every
finer size give the quantity within a tolerance of its value at the finest size. The finest size is the
reference, so it never counts as converged; then still finer sizes are needed.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from craftmesh.extras import extra
from craftmesh.report.case_files import Case, Increment
from craftmesh.report.measures import of_trusted
from craftmesh.report.pictures import COLOURS, new_figure, plain, with_unit
from craftmesh.report.sweeps import FEWEST, QUANTITIES, SOLVED, Sweep

with extra("pictures"):
    import matplotlib
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Axis labels of the histograms in quality.json.
HISTOGRAMS = {
    "aspect_ratio": "aspect ratio",
    "dihedral_min": "smallest dihedral angle [degrees]",
    "dihedral_max": "largest dihedral angle [degrees]",
}
BAR, JUDGED, GOOD = "#3b6ea5", "#3b6ea5", "#2e8b57"
PER_ROW = 3


class Converged(NamedTuple):
    """A quantity of a sweep, with a value or None for each size. size: the converged one, None if none.

    judged: False for measures of the mesh, which need not converge, and for fewer than FEWEST values.
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
    """Return the last increment that all cases of a sweep have, and the convergence of quantities in it.

    quantity: the only one to compare, None for all that have values.
    """
    count = min(len(cases[name].increments) for name in sweep.cases)
    increments = [cases[name].increments[count - 1] for name in sweep.cases]
    wanted = [quantity] if quantity else list(QUANTITIES)
    rows = {name: [VALUES[name](increment) for increment in increments] for name in wanted}
    found = [converged(name, sweep.sizes, row, tolerance) for name, row in rows.items()]
    return increments[0].name, [row for row in found if any(value is not None for value in row.values)]


def _mean(column: str, size: bool = False) -> Callable[[Increment], float | None]:
    """Return a function of an increment: the mean of a column of sif.csv where it is known, else None.

    size: average absolute values.
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


def histograms(qualities: Mapping[str, Mapping]) -> Figure:
    """Return a figure of quality.json's histograms by increment: bars for the last, lines for others."""
    figure = new_figure(11.0, 3.2)
    last = list(qualities)[-1]
    colours = matplotlib.colormaps[COLOURS](np.linspace(0.1, 0.95, len(qualities)))
    for axes, (key, label) in zip(figure.subplots(1, len(HISTOGRAMS)), HISTOGRAMS.items()):
        for (name, quality), colour in zip(qualities.items(), colours):
            histogram = quality["histograms"][key]
            share = 100 * np.array(histogram["counts"]) / max(sum(histogram["counts"]), 1)
            if name == last:
                _bars(axes, share, histogram["edges"])
            else:
                axes.step(np.arange(len(share)), share, where="mid", color=colour, lw=1, label=name)
        axes.set_xlabel(label)
        axes.set_ylabel("fraction of the elements [%]")
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        axes.legend(handles, labels, title="earlier increments", fontsize=7, title_fontsize=7)
    figure.tight_layout()
    return figure


def _bars(axes: Axes, share: np.ndarray, edges: Sequence[float | None]) -> None:
    """Draw bars of equal width, heights `share` (%), labelled if > 0, with bin `edges` as tick labels."""
    axes.bar(np.arange(len(share)), share, width=0.92, color=BAR)
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
    sweep: Sweep, found: Sequence[Converged], tolerance: float, words: Mapping[str, str] = QUANTITIES
) -> Figure:
    """Return a figure of quantities against a sweep's sizes, on a log axis, with the tolerance as a band.

    words: titles of the quantities.
    """
    columns = min(PER_ROW, len(found))
    rows = -(-len(found) // columns)
    figure = new_figure(11.0 * columns / PER_ROW, 2.9 * rows)
    places = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, one in zip(places, found):
        known = [(size, value) for size, value in zip(sweep.sizes, one.values) if value is not None]
        sizes, values = zip(*known)
        if one.judged:
            reach = tolerance * abs(values[-1])
            axes.axhspan(values[-1] - reach, values[-1] + reach, color=GOOD, alpha=0.15, lw=0)
        axes.plot(sizes, values, "o-", color=JUDGED, markersize=4)
        if one.size is not None:
            axes.plot(one.size, dict(known)[one.size], "o", color=GOOD, markersize=9, fillstyle="none")
        axes.set_xscale("log")
        axes.set_xticks(sizes, [f"{size:g}" for size in sizes])
        axes.minorticks_off()
        axes.invert_xaxis()
        axes.set_xlabel(sweep.key)
        axes.set_title(plain(words[one.quantity]), fontsize=9)
        axes.grid(alpha=0.3)
    for axes in places[len(found) :]:
        axes.set_axis_off()
    figure.tight_layout()
    return figure


def against_crack(increments: Sequence[Increment], units: Mapping[str, str]) -> Figure | None:
    """Return a figure of K, kink angle and load cycles against crack size, with mean and range.

    Nodes that are not trusted are left out. units: names by quantity. None if fewer than two increments
    have a size and a front.
    """
    known = [one for one in increments if one.size is not None and one.front is not None]
    if len(known) < 2:
        return None
    size = [one.size for one in known]
    cycles = [one.front["cycles"][0] for one in known if one.front is not None and "cycles" in one.front]
    panels = [
        key
        for key in ("K_I", "K_II", "K_III", "kink_angle")
        if all(key in (one.front or {}) for one in known)
    ]
    figure = new_figure(11.0, 2.9)
    places = figure.subplots(1, len(panels) + (len(cycles) == len(known)), squeeze=False)[0]
    for axes, key in zip(places, panels):
        values = [of_trusted(one.front, key) for one in known if one.front is not None]
        axes.fill_between(
            size, [np.nanmin(v) for v in values], [np.nanmax(v) for v in values], color=BAR, alpha=0.2, lw=0
        )
        axes.plot(size, [np.nanmean(v) for v in values], "o-", color=BAR, markersize=4)
        axes.set_title(with_unit(key, units.get("K", "")), fontsize=9)
    if len(cycles) == len(known):
        places[-1].plot(size, cycles, "o-", color=BAR, markersize=4)
        places[-1].set_title("load cycles", fontsize=9)
    for axes in places:
        axes.set_xlabel(plain(f"crack size [{units['length']}]" if "length" in units else "crack size"))
        axes.grid(alpha=0.3)
    figure.tight_layout()
    return figure


def loops(history: Mapping[str, np.ndarray], unit: str) -> Figure:
    """Return a figure of nominal stress against strain of each face; history: as in `Solution`."""
    figure = new_figure(6.0, 4.4)
    axes = figure.add_subplot()
    for name in [name.removesuffix(" strain") for name in history if name.endswith(" strain")]:
        axes.plot(history[f"{name} strain"], history[f"{name} stress"], lw=1.2, label=name)
    axes.set_xlabel("nominal strain")
    axes.set_ylabel("nominal stress" + f" [{unit}]" * bool(unit))
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    figure.tight_layout()
    return figure
