"""Load cycles of a load history, counted by rainflow."""

from collections import Counter
from collections.abc import Iterable

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.extras import extra
from craftmesh.growth.options import LEAST_RATIO


def rainflow_blocks(loads: Iterable[float]) -> tuple[str, ...]:
    """Return the rows "NUMBER,LARGEST,SMALLEST" of `GrowthOptions.blocks` for a load history.

    loads: factors on the first load case, in order of time; the history is repeated without end. Counting
    starts at the largest load, so all cycles are whole (ASTM E1049-85, 5.4.5). Equal cycles share a row.
    Cycles without tension are left out. A smallest load under LEAST_RATIO times the largest is raised to
    this value. Raises CraftmeshError if a load is not finite, or if no cycle is left.
    """
    with extra("spectrum"):
        import rainflow
    history = np.asarray(tuple(loads), float)
    if not np.isfinite(history).all():
        raise CraftmeshError("load history: a load is not a finite number; give finite factors")
    if len(history):
        history = np.roll(history, -int(np.argmax(history)))
    numbers: Counter[tuple[float, float]] = Counter()
    for span, mean, number, *_ in rainflow.extract_cycles([*history, *history[:1]]):
        # rounded, because these sums differ from the given loads in the last digits
        largest, smallest = (float(f"{mean + half:.12g}") for half in (span / 2, -span / 2))
        if span > 0 and largest > 0:
            numbers[largest, max(smallest, LEAST_RATIO * largest)] += number
    if not numbers:
        raise CraftmeshError(
            f"load history: its {len(history)} loads have no cycle with tension; give two different loads "
            "or more, one of them positive"
        )
    rows = sorted(numbers.items(), reverse=True)
    return tuple(f"{number:g},{largest!r},{smallest!r}" for (largest, smallest), number in rows)
