"""Cracks in, or almost in, a face of the box: what lies between the two could not be meshed."""

from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from craftmesh.cracks.mouths import FLATTEST, LIGAMENT, ON_FACE, refuse_mouths, refuse_ribbons
from craftmesh.cracks.within_box import area_within, clipped, is_in, polygon_area, tilts
from craftmesh.errors import CraftmeshError
from craftmesh.surface.connectivity import edge_sides, unique_edges
from craftmesh.surface.measure import meets_box
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


# Of four random cracks below NEAR or 3 degrees two ended with 4 and 11 % poor tets, two in no mesh.
NEAR = 0.2  # of l_min: a crack nearer than this to a face leaves room for flat tets alone
GENTLE = 15.0  # degrees: steeper parts only end near a face, they do not lie along it
LEAST_AREA = 1.0  # of l_min squared, about two facets: a smaller part near a face is a place, not a run
LIGAMENT_LENGTH = 8.0  # of l_min: a circle of up to 80 l_min that touches a face is near it for less
ROUNDING = 1e-9  # of the box: a corner this near a face of it is on that


class AlongFace(NamedTuple):
    """The part of a crack along a face: its distances from the face, mean tilt in degrees, and area."""

    face: str
    least: float
    most: float
    tilt: float
    area: float


def refuse_along_faces(crack: Crack, box: np.ndarray, l_min: float, fronts_too: bool = True) -> None:
    """Raise CraftmeshError where the crack, its front, or all of it runs along faces of the box (2, 3).

    l_min in model units. fronts_too: also where only a front does.
    """
    box = np.asarray(box, float)
    found = along_faces(crack, box, l_min)
    if not found:
        if fronts_too:
            _refuse_fronts(crack, box, l_min)
        _refuse_slivers(crack, box, l_min)
        refuse_mouths(crack, box, l_min)
        refuse_ribbons(crack, box, l_min)
        refuse_kinks(crack, box, l_min)
        return
    part = max(found, key=lambda one: one.area)
    if part.least <= ON_FACE * l_min:
        wish = (
            f"a crack that meets a face at {FLATTEST:g} degrees or more: turn it, or move it into the box"
        )
    else:
        lack = NEAR * l_min - part.least
        wish = (
            f"0.2 l_min, which is {NEAR * l_min:.3g}: move it inward by {lack:.3g} or give a shorter l_min"
        )
    raise CraftmeshError(
        f"the crack lies {part.least:.3g} to {part.most:.3g} from the box face {part.face}, at "
        f"{part.tilt:.3g} degrees to it, over an area of {part.area:.3g}; expected {wish}"
    )


def _refuse_fronts(crack: Crack, box: np.ndarray, l_min: float) -> None:
    """Raise CraftmeshError where a front leaves a ligament to a face that is too narrow to be meshed."""
    start, end = np.swapaxes(crack.points[crack.front_edges], 0, 1)
    length = np.linalg.norm(end - start, axis=1)
    for axis, upper in BOX_FACES:
        a, b = (np.abs(x[:, axis] - box[upper, axis]) for x in (start, end))
        share = np.clip((LIGAMENT * l_min - np.minimum(a, b)) / np.maximum(np.abs(b - a), 1e-300), 0, 1)
        along = (share * length).sum()
        if along > LIGAMENT_LENGTH * l_min:
            face, least = BOX_PLANES[2 * axis + upper], np.minimum(a, b).min()
            raise CraftmeshError(
                f"the crack's front runs {least:.3g} from the box face {face} over a length of "
                f"{along:.3g}, which leaves a ligament too thin to mesh; expected 0.1 l_min, which is "
                f"{LIGAMENT * l_min:.3g}: move the front inward by {LIGAMENT * l_min - least:.3g}, or "
                "past the face, where the crack then ends"
            )


def _refuse_slivers(crack: Crack, box: np.ndarray, l_min: float) -> None:
    """Raise CraftmeshError where no place of the crack is NEAR l_min from all faces, as along an edge."""
    corners = crack.points[crack.triangles]
    inner = box + NEAR * l_min * np.array([[1.0], [-1.0]])
    if (inner[0] < inner[1]).all() and is_in(corners, box) and not is_in(corners, inner):
        raise CraftmeshError(
            f"the crack cuts only a sliver off the box: all of it in there, an area of "
            f"{area_within(crack, box):.3g}, lies nearer than 0.2 l_min to a face, which is "
            f"{NEAR * l_min:.3g}; expected one that reaches deeper: move it inward or give a shorter l_min"
        )


def along_faces(crack: Crack, box: np.ndarray, l_min: float) -> list[AlongFace]:
    """Return the parts of the crack within the box (2, 3) that are nearer than NEAR l_min to a face.

    A part that reaches the face counts where its tilt to it is under FLATTEST, any other under GENTLE.
    Tilt, distance and area are those of the crack's triangles, cut off at the box: a curved crack is
    measured place by place.
    """
    box = np.asarray(box, float)
    corners = crack.points[crack.triangles]
    found = []
    for axis, tilt in enumerate(tilts(crack).T):
        for upper in (0, 1):
            slab = box.copy()
            slab[1 - upper, axis] = box[upper, axis] + (1 - 2 * upper) * NEAR * l_min
            part = _within(corners, slab, (axis, upper))
            counted = (tilt[part.rows] < FLATTEST) | ~_reaching(crack, part, l_min)
            counted &= tilt[part.rows] < GENTLE
            area = part.area[counted]
            if area.sum() > LEAST_AREA * l_min**2:
                found.append(
                    AlongFace(
                        BOX_PLANES[2 * axis + upper],
                        float(part.least[counted].min()),
                        float(part.most[counted].max()),
                        float(np.average(tilt[part.rows[counted]], weights=area)),
                        float(area.sum()),
                    )
                )
    return found


class _Part(NamedTuple):
    """Triangles (k,) of a crack that reach into a slab: their area there, least and largest distance.

    leaves (k,): whether they are nearest to the slab's face where they leave the box by another.
    """

    rows: np.ndarray
    area: np.ndarray
    least: np.ndarray
    most: np.ndarray
    leaves: np.ndarray


def _within(corners: np.ndarray, slab: np.ndarray, face: tuple[int, int]) -> _Part:
    """Return what of triangles (m, 3, 3) lies in the slab (2, 3), with distances from its face."""
    axis, upper = face
    rows = np.flatnonzero(meets_box(corners, slab))
    kept, area, least, most, leaves = [], [], [], [], []
    sides = np.delete(slab, axis, axis=1)
    near = ROUNDING * float(np.ptp(slab, axis=0).max())
    for row, triangle in zip(rows.tolist(), corners[rows]):
        polygon = clipped(triangle, slab)
        if len(polygon) < 3:
            continue
        distance = np.abs(polygon[:, axis] - slab[upper, axis])
        kept.append(row)
        area.append(polygon_area(polygon))
        least.append(distance.min())
        most.append(distance.max())
        nearest = np.delete(polygon[distance.argmin()], axis)
        leaves.append((np.abs(sides - nearest) <= near).any())
    return _Part(
        np.array(kept, np.int64), np.array(area), np.array(least), np.array(most), np.array(leaves, bool)
    )


def _reaching(crack: Crack, part: _Part, l_min: float) -> np.ndarray:
    """Tell which triangles of the part hang together with one that reaches the face, or leaves by another.

    One that leaves the box LIGAMENT beside an edge makes a wedge as one that reaches the face: 0.1 l_min
    from an edge, at 7, 9 and 12 degrees to the face, cracks had no flat tet, 0.06 from it 15, 12 and none.
    """
    corners = crack.triangles[part.rows].astype(np.int64)
    count = len(crack.points)
    ends = corners.ravel(), np.roll(corners, -1, axis=1).ravel()
    group = connected_components(coo_matrix((np.ones(len(ends[0])), ends), (count, count)), False)[1]
    group = group[corners[:, 0]]
    order = np.lexsort([part.least, group])
    nearest = order[np.unique(group[order], return_index=True)[1]]
    least = part.least[nearest] / l_min
    reach = nearest[(least <= ON_FACE) | (part.leaves[nearest] & (least >= LIGAMENT))]
    return np.isin(group, group[reach])
