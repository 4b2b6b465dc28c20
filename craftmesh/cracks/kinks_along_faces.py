"""Kinks of a crack along a face of the box: what lies between the two could not be meshed."""

import numpy as np

from craftmesh.cracks.within_box import tilts
from craftmesh.errors import CraftmeshError
from craftmesh.surface.connectivity import edge_sides, unique_edges
from craftmesh.types import BOX_FACES, BOX_PLANES, Crack

# Of l_min: a kink nearer than this to a face, on the inner side of it, leaves a ligament of flat tets: two
# along a face had 10 and 16 of them 0.1 from it, 81 and more 0.017 to 0.03 from it, none from 0.15 on.
WITHIN = 0.15
# Of l_min, beyond a face: the crack leaves it there by two mouths with a ribbon between. The same two had
# 24 flat tets 0.03 beyond it, none and one 0.1, none farther.
BEYOND = 0.1
# Of l_min: one that passes a face at 1 in 33 is in there for 8.3, without a flat tet in five; at 1 in 100
# for 25, with 4 to 30 in eight.
LENGTH = 10.0
# Degrees: where a side of the kink is nearer to the face, it is that side that lies along it.
STEEP = 15.0


def refuse_kinks(crack: Crack, box: np.ndarray, l_min: float) -> None:
    """Raise CraftmeshError where a kink, both its sides inward, runs along a face of the box (2, 3).

    l_min in model units.
    """
    edges, sides, of_corner = _hinges(crack.triangles)
    steep = tilts(crack)[sides // 3].min(axis=1)
    for axis, upper in BOX_FACES:
        inward = 1 - 2 * upper
        depth = inward * (crack.points[:, axis] - box[upper, axis])
        kinks = (depth[of_corner].min(axis=1) > depth[edges].max(axis=1)) & (steep[:, axis] >= STEEP)
        slab = box.copy()
        slab[upper, axis] = box[upper, axis] - inward * BEYOND * l_min
        slab[1 - upper, axis] = box[upper, axis] + inward * WITHIN * l_min
        ends = crack.points[edges[kinks]]
        along = float((_shares(ends, slab) * np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)).sum())
        if along > LENGTH * l_min:
            face = BOX_PLANES[2 * axis + upper]
            raise CraftmeshError(
                f"a kink of the crack runs along the box face {face} over a length of {along:.3g}, which "
                "leaves a ligament too thin to mesh; expected it 0.15 l_min inside the face, which is "
                f"{WITHIN * l_min:.3g}, or {BEYOND * l_min:.3g} beyond it: move the crack"
            )


def _hinges(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return edges (k, 2) of two triangles, which sides 3 t + i of these they are, and the corners across.

    The last two (k, 2) each.
    """
    edges, of_corner, count = unique_edges(triangles)
    sides = np.stack(edge_sides(of_corner, count == 2), axis=1)
    return edges[count == 2], sides, triangles[sides // 3, (sides % 3 + 2) % 3]


def _shares(ends: np.ndarray, slab: np.ndarray) -> np.ndarray:
    """Return which share of each segment (k, 2, 3) lies in a box (2, 3)."""
    start, way = ends[:, 0], ends[:, 1] - ends[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        at = (slab[:, None] - start) / way
    inside = (slab[0] <= start) & (start <= slab[1])
    flat = way == 0
    enter = np.where(flat, np.where(inside, 0.0, 1.0), at.min(axis=0)).max(axis=1)
    leave = np.where(flat, 1.0, at.max(axis=0)).min(axis=1)
    shares: np.ndarray = np.clip(np.minimum(leave, 1.0) - np.maximum(enter, 0.0), 0.0, 1.0)
    return shares
