"""What cases that differ in an element size alone give against that size, and which size has converged.

The criterion is that of the paper (section 3): the coarsest size from which on every finer one gives the
quantity to within a tolerance of what the finest gives. The finest is the measure of the others, so
it cannot be the one that has converged: then the sizes have to go on.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from craftmesh.io.front_csv import has_word
from craftmesh.report.case_files import Case, Increment
from craftmesh.report.options import QUANTITIES, SOLVED
from craftmesh.report.sweeps import FEWEST, Sweep

# Flags of nodes at which K is less sure than elsewhere.
UNSURE = ("end", "short", "narrow", "error")


class Converged(NamedTuple):
    """A quantity of a sweep: a value for each size, None where there is none, and the size that converged.

    judged: False for measures of the mesh, which need not converge, and where fewer than two have values.
    """

    quantity: str
    values: tuple[float | None, ...]
    judged: bool
    size: float | None


def converged(
    quantity: str, sizes: Sequence[float], values: Sequence[float | None], tolerance: float
) -> Converged:
    """Return how a quantity converges with sizes from coarse to fine.

    Values are compared with the finest that there is, as a share of it.
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
    """Return the increment at which a sweep's cases are compared, the last of all, and how it goes."""
    count = min(len(cases[name].increments) for name in sweep.cases)
    increments = [cases[name].increments[count - 1] for name in sweep.cases]
    wanted = [quantity] if quantity else list(QUANTITIES)
    rows = {name: [VALUES[name](increment) for increment in increments] for name in wanted}
    found = [converged(name, sweep.sizes, row, tolerance) for name, row in rows.items()]
    return increments[0].name, [row for row in found if any(value is not None for value in row.values)]


def _mean(column: str, size: bool = False) -> Callable[[Increment], float | None]:
    """Return what gives the mean of a column of sif.csv over the nodes at which it is known."""

    def mean(increment: Increment) -> float | None:
        if increment.front is None or column not in increment.front:
            return None
        values = increment.front[column][np.isfinite(increment.front[column])]
        return float(np.mean(np.abs(values) if size else values)) if len(values) else None

    return mean


def _largest(increment: Increment) -> float | None:
    if increment.front is None:
        return None
    sure = ~has_word(increment.front["flags"], UNSURE)
    values = increment.front["K_I"][sure & np.isfinite(increment.front["K_I"])]
    return float(values.max()) if len(values) else None


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
