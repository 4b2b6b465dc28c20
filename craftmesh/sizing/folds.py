"""Shorter edges along folds of a crack beside a face of the box, where only a sliver parts the two.

Between a fold and a face lies a prism, under both limbs of the fold, or a strip on one of them.
"""

import numpy as np

from craftmesh.cracks.height_parts import MOST_PARTS, between_kinks
from craftmesh.cracks.sheets import sheets
from craftmesh.sizing.length_field import LengthField
from craftmesh.sizing.sizing import Sizing, densify, where_short
from craftmesh.sizing.strips import (
    AT_CORNER,
    PER_WIDTH,
    ROUNDING,
    SHORTEST_IN_SLIVERS,
    STEP,
    Face,
    distance,
    meets_face,
)
from craftmesh.surface.connectivity import edge_sides, unique_edges
from craftmesh.types import BOX_FACES, Crack

# Of l_min: folds farther from a face leave room enough. Along a fold 3.9 l_min from one, edges of 9.7 in
# place of 12 l_min brought 4 flat tetrahedra where there had been none.
NEAR = 1.0


def fold_lengths(crack: Crack, box: np.ndarray, sizing: Sizing) -> LengthField | None:
    """Return the lengths along folds near faces of the box (2, 3); None without such folds.

    A length is PER_WIDTH of the fold's distance from the face, SHORTEST_IN_SLIVERS of l_min at least.
    Folds are the crack's kinks (`height_parts`), but those of a rough crack. A kink of 54 degrees, 0.15
    l_min from a face, among edges of 2 to 6 l_min, had 81 flat tets while only those at which the crack is
    parted counted.
    """
    box = np.asarray(box, float)
    folds = fold_edges(crack)
    if not len(folds):
        return None
    parts = [densify(edge, STEP * sizing.l_min) for edge in folds]
    places = np.concatenate(parts)
    rounding = ROUNDING * np.ptp(box)
    places = places[((places >= box[0] - rounding) & (places <= box[1] + rounding)).all(axis=1)]
    found = [_beside(places, folds, box, face, NEAR * sizing.l_min) for face in BOX_FACES]
    points, widths = (np.concatenate(columns) for columns in zip(*found))
    lengths = np.maximum(PER_WIDTH * widths, SHORTEST_IN_SLIVERS * sizing.l_min)
    return where_short(points, lengths, sizing)


def fold_edges(crack: Crack) -> np.ndarray:
    """Return the edges (k, 2, 3) at which a crack has kinks, none of a sheet that is rough."""
    found = [np.zeros((0, 2, 3))]
    for sheet in sheets(crack):
        part, _ = between_kinks(sheet.points, sheet.triangles)
        if part.max() >= MOST_PARTS:
            continue
        edges, of_corner, count = unique_edges(sheet.triangles)
        f, g = (side // 3 for side in edge_sides(of_corner, count == 2))
        found.append(sheet.points[edges[count == 2][part[f] != part[g]]])
    return np.concatenate(found)


def _beside(
    places: np.ndarray, folds: np.ndarray, box: np.ndarray, face: Face, near: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the places (k, 3) on folds that are near a face, but not in a corner with it, and how near."""
    axis, upper = face
    width = np.abs(places[:, axis] - box[upper, axis])
    off = width > ROUNDING * np.ptp(box)
    out = off & (width < near)
    met = np.concatenate([meets_face(folds[:, 0], folds[:, 1], box, face), places[~off]])
    if len(met):
        out &= width < AT_CORNER * distance(places, met)
    return places[out], width[out]
