"""The cracks of a growth series: prescribed or given as surfaces, each larger than the last."""

from dataclasses import dataclass

import numpy as np

from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.shapes import prescribed_crack
from craftmesh.cracks.sheets import cracks_from_triangles
from craftmesh.errors import CraftmeshError
from craftmesh.surface.measure import total_area
from craftmesh.types import Crack

ROUNDING = 1e-9  # share of its area by which a crack that does not grow may seem to shrink


@dataclass(frozen=True, eq=False)
class GivenSurface:
    """A crack's triangulated surface as a file holds it: points (n, 3), triangles (m, 3).

    fronts: polylines (k, 3) along its boundary; empty: the boundary within the box is front.
    """

    points: np.ndarray
    triangles: np.ndarray
    fronts: tuple[np.ndarray, ...] = ()


def crack_of_increment(
    options: CrackOptions,
    increment: int,
    box: np.ndarray,
    given: GivenSurface | None = None,
    heights: bool = True,
) -> Crack:
    """Return the crack of `increment` in the box (2, 3): prescribed, or the given surface.

    A surface in several pieces is several cracks. heights: as for crack_from_triangles. Raises
    CraftmeshError as prescribed_crack and crack_from_triangles do.
    """
    if given is None:
        return prescribed_crack(options, increment, box)
    return cracks_from_triangles(given.points, given.triangles, list(given.fronts) or None, box, heights)


def crack_area(crack: Crack) -> float:
    """Return the area of a crack's surface, the part outside the box included."""
    return total_area(crack.points, crack.triangles)


def refuse_shrunk(crack: Crack, before: Crack, increment: int) -> None:
    """Raise CraftmeshError where the crack of `increment` is smaller than that of the increment before."""
    was, now = crack_area(before), crack_area(crack)
    if now < was * (1 - ROUNDING):
        raise CraftmeshError(
            f"crack of increment {increment}: area {now:.6g} is below {was:.6g} of the "
            "increment before; expected a crack that grows"
        )
