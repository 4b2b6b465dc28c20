"""Preparation before meshing: merge overlapping surfaces, end grazing fronts, reject unmeshable cracks."""

from collections.abc import Collection, Sequence
from itertools import combinations

import numpy as np

from craftmesh.cracks.crack_tolerances import PREPARATION
from craftmesh.cracks.grazing_fronts import ending_on_faces
from craftmesh.cracks.merged_sheets import (
    SPACING,
    SheetPair,
    grid_points_in,
    merged_sheets,
    sheet_pair,
)
from craftmesh.cracks.near_faces import FLATTEST, LEAST_AREA, NEAR, refuse_near_faces
from craftmesh.cracks.sheets import one_crack, sheets
from craftmesh.errors import CraftmeshError, rounded_values
from craftmesh.surface.measure import unit_normals
from craftmesh.surface.rounding import SAME_PLACE
from craftmesh.types import Crack


def refuse_along_sheets(crack: Crack, box: np.ndarray, l_min: float) -> None:
    """Raise CraftmeshError if two surfaces run along each other in the box (2, 3); l_min in model units.

    They do if they are nearer than NEAR l_min at an angle below FLATTEST over more than LEAST_AREA, where
    only flat tetrahedra fit in between. Surfaces nearer than SAME_PLACE l_min are one surface and are
    accepted.
    """
    parts = sheets(crack)
    for low, high in combinations(range(len(parts)), 2):
        pair = sheet_pair(parts[low], parts[high], NEAR * l_min)
        if pair is not None and pair.common.area > LEAST_AREA * l_min**2:
            _refuse(pair, (low + 1, high + 1), np.asarray(box, float), l_min)


def _refuse(pair: SheetPair, numbers: tuple[int, int], box: np.ndarray, l_min: float) -> None:
    """Raise CraftmeshError if the two surfaces of a pair, with these numbers, run along each other."""
    at = grid_points_in(pair.common, SPACING * l_min)
    (first, triangle), (second, other) = (pair.heights(k, at) for k in range(2))
    places = pair.plane.lifted(np.column_stack([at, first]))
    normals = [unit_normals(pair.places[k], pair.triangles[k]) for k in range(2)]
    cosine = np.abs((normals[0][triangle] * normals[1][other]).sum(axis=1))
    tilt = np.degrees(np.arccos(np.minimum(cosine, 1.0)))
    off = (second - first) * np.abs(normals[0][triangle, 2])
    inside = ((places > box[0]) & (places < box[1])).all(axis=1) & np.isfinite(off)
    near = np.flatnonzero(inside & (np.abs(off) < NEAR * l_min) & (np.abs(off) > SAME_PLACE * l_min))
    counted = near[tilt[near] < FLATTEST]
    area = len(counted) * (SPACING * l_min) ** 2
    if area > LEAST_AREA * l_min**2:
        way = np.abs(off[counted])
        place = rounded_values(places[counted][way.argmin()])
        raise CraftmeshError(
            f"cracks {numbers[0]} and {numbers[1]} run {way.min():.3g} to {way.max():.3g} from each other "
            f"near {place}, at {np.mean(tilt[counted]):.3g} degrees, over an area of {area:.3g}; move one "
            f"until they are 0.2 l_min ({NEAR * l_min:.3g}) apart or form one surface, or turn one until "
            f"they cross at {FLATTEST:g} degrees or more"
        )


def prepare_crack(
    cracks: Sequence[Crack],
    box: np.ndarray,
    l_min: float,
    of_facets: Collection[int] = (),
    is_guess: bool = False,
) -> Crack:
    """Return the cracks as one that `insert_crack` can mesh in the box (2, 3) with front edges of l_min.

    Fronts that graze a box face are made to end on it. Surfaces that touch, or overlap with a gap of at
    most PREPARATION.facets l_min, are merged. of_facets: indices of cracks that consist of facets of the
    body's surface; these keep their fronts. is_guess: l_min is a guess; fronts, kinks and mouths near a
    face are then accepted. Raise CraftmeshError if a surface runs along a box face, or along another
    surface, so close that only flat tets fit in between.
    """
    parts = []
    for number, crack in enumerate(cracks):
        for sheet in sheets(crack):
            if number not in of_facets:
                sheet = ending_on_faces(sheet, box, l_min)
            refuse_near_faces(sheet, box, l_min, lines_too=not is_guess)
            parts.append(sheet)
    merged = merged_sheets(one_crack(parts), box, l_min, PREPARATION.facets * l_min)
    refuse_along_sheets(merged, box, l_min)
    return merged
