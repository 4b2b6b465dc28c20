"""Tables of grains' eigenstrains."""

import os

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io.text_table import read_table

ONE, SIX = ("e",), ("e11", "e22", "e33", "e12", "e13", "e23")


def read_grain_strains(path: str | os.PathLike) -> tuple[list[int], np.ndarray]:
    """Return the ids of grains (k,) and their strains (k, 1 or 6): 11, 22, 33, 12, 13, 23.

    Raises CraftmeshError, naming the line, for other tables, ids that are there twice or not whole, and
    strains over 1.
    """
    table = read_table(path, ("grain", *ONE), ("grain", *SIX))
    strains = table.numbers(ONE if table.has(ONE) else SIX)
    grains = table.numbers(["grain"])[:, 0]
    for row, (grain, line) in enumerate(zip(grains.tolist(), table.lines)):
        if grain != int(grain) or grain in grains[:row]:
            raise CraftmeshError(
                f"{path}, line {line}: grain is {grain:g}; expected a whole number, and each once"
            )
        if np.abs(strains[row]).max() > 1:
            raise CraftmeshError(
                f"{path}, line {line}: a strain of {np.abs(strains[row]).max():g}; expected at most 1"
            )
    return grains.astype(int).tolist(), strains
