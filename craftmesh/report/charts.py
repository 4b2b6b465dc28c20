"""Charts of measures: histograms of the elements, and quantities against element sizes."""

from collections.abc import Mapping, Sequence

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from craftmesh.report.convergence import Converged
from craftmesh.report.options import QUANTITIES
from craftmesh.report.pictures import COLOURS, new_figure, plain
from craftmesh.report.sweeps import Sweep

# Histograms of quality.json: their names in words, and whether small or large values are bad.
HISTOGRAMS = {
    "aspect_ratio": "aspect ratio",
    "dihedral_min": "smallest dihedral angle [degrees]",
    "dihedral_max": "largest dihedral angle [degrees]",
}
BAR, JUDGED, GOOD = "#3b6ea5", "#3b6ea5", "#2e8b57"
PER_ROW = 3


def histograms(qualities: Mapping[str, Mapping]) -> Figure:
    """Return histograms of quality.json by increments: bars and shares of the last, lines of others."""
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
        axes.set_ylabel("share of the elements [%]")
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        axes.legend(handles, labels, title="earlier increments", fontsize=7, title_fontsize=7)
    figure.tight_layout()
    return figure


def _bars(axes: Axes, share: np.ndarray, edges: Sequence[float | None]) -> None:
    """Draw bars of equal width between the edges' names, each with its share where there is any."""
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
    """Return quantities against a sweep's sizes, in logarithmic steps, with the band of the tolerance.

    words: what the quantities are called.
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
