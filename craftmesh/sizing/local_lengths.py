"""Lengths that single places ask for: where they are less than all others, and how they grow away."""

import numpy as np

from craftmesh.sizing.length_field import LengthField
from craftmesh.sizing.sizing import FREE_GROWTH, Sizing

# To l_min: cells of which one place gives a length, the least there.
CELLS = 2


def where_short(places: np.ndarray, lengths: np.ndarray, sizing: Sizing) -> LengthField | None:
    """Return lengths (k,) at places (k, 3) that are under the sizing's; None where there are none.

    They grow away by sizing.growth, or half the distance. In model units.
    """
    short = np.flatnonzero(lengths < sizing.l_max)
    short = short[lengths[short] < sizing.at(places[short])]
    if not len(short):
        return None
    short = short[np.argsort(lengths[short], kind="stable")]
    cells = np.floor((places[short] - places[short].min(axis=0)) * (CELLS / sizing.l_min))
    short = short[np.unique(cells, axis=0, return_index=True)[1]]
    growth = FREE_GROWTH if sizing.growth is None else sizing.growth
    return LengthField(places[short], lengths[short]).limited(growth)
