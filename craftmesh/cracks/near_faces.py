"""Reject cracks so near to a box face that only flat tetrahedra fit in between."""

from typing import NamedTuple

import numpy as np

from craftmesh.cracks.crack_tolerances import PREPARATION
from craftmesh.cracks.height_parts import MOST_PARTS, kinks_of
from craftmesh.cracks.sheets import sheets
from craftmesh.cracks.within_box import area_within, clipped, is_in, polygon_area, tilts
from craftmesh.errors import CraftmeshError
from craftmesh.surface.measure import meets_box
from craftmesh.surface.rounding import SAME_PLACE
from craftmesh.types import BOX_FACES, BOX_PLANES, Crack

NEAR = 0.2  # smallest distance, in l_min, between a face and a crack part at less than FLATTEST to it
# Smallest angle, in degrees, between a crack and a nearby box face. A tet is flat under 5 degrees, and tets
# in the second row of a wedge are flatter than the wedge.
FLATTEST = 6.0
ALONG = np.sin(np.radians(FLATTEST))  # sine of the angle to a face below which a crack lies along the face
LEAST_AREA = 1.0  # smallest area along a face that is rejected, in l_min squared: about two facets
# Smallest distance, in l_min, of fronts, kinks and mouths from a face; nearer ones leave flat tets.
LIGAMENT = 0.1
# Largest length, in l_min, of fronts, kinks and mouths nearer than LIGAMENT to a face; circles of radius 80
# l_min are so near over less.
LENGTH = 8.0


Face = tuple[int, int]  # a box face: the axis perpendicular to it, and 0 for the lower, 1 for the upper one


class AlongFace(NamedTuple):
    """The part of a crack along a face: least and most distance from it, mean tilt in degrees, and area."""

    face: str
    least: float
    most: float
    tilt: float
    area: float


def refuse_near_faces(crack: Crack, box: np.ndarray, l_min: float, lines_too: bool = True) -> None:
    """Raise CraftmeshError if a crack runs along a face of the box (2, 3), or cuts only a sliver off it.

    l_min in model units. lines_too: also reject fronts, kinks and mouths that run close to a face (0.0175
    to 0.1 l_min) over more than LENGTH; nearer ones count as on the face.
    """
    box = np.asarray(box, float)
    found = along_faces(crack, box, l_min)
    if found:
        _refuse_part(max(found, key=lambda one: one.area), l_min)
    inner = box + NEAR * l_min * np.array([[1.0], [-1.0]])
    corners = crack.points[crack.triangles]
    if (inner[0] < inner[1]).all() and is_in(corners, box) and not is_in(corners, inner):
        raise CraftmeshError(
            f"the crack cuts only a sliver off the box: its whole area in the box, "
            f"{area_within(crack, box):.3g}, lies nearer than 0.2 l_min ({NEAR * l_min:.3g}) to the faces; "
            "move it inward or give a shorter l_min"
        )
    if lines_too:
        _refuse_lines(crack, box, l_min)


def _refuse_part(part: AlongFace, l_min: float) -> None:
    if part.least <= SAME_PLACE * l_min:
        wish = f"an angle of {FLATTEST:g} degrees or more where it meets a face: turn it, or move it inward"
    else:
        lack = NEAR * l_min - part.least
        wish = (
            f"at least 0.2 l_min ({NEAR * l_min:.3g}): move it inward by {lack:.3g} or give a shorter l_min"
        )
    away = " to ".join(dict.fromkeys(f"{distance:.3g}" for distance in (part.least, part.most)))
    raise CraftmeshError(
        f"the crack lies {away} from the box face {part.face}, at "
        f"{part.tilt:.3g} degrees to it, over an area of {part.area:.3g}; expected {wish}"
    )


def along_faces(crack: Crack, box: np.ndarray, l_min: float) -> list[AlongFace]:
    """Return the crack's parts in the box (2, 3) that lie along a face, at most one for each face.

    A part is nearer than NEAR l_min to the face, at less than FLATTEST degrees to it, over more than
    LEAST_AREA. Tilt, distance and area are measured on the crack's triangles, cut off at the box, so a
    curved crack is measured locally.
    """
    corners = crack.points[crack.triangles]
    found = []
    for axis, upper in BOX_FACES:
        slab = np.array(box, float)
        slab[1 - upper, axis] = slab[upper, axis] + (1 - 2 * upper) * NEAR * l_min
        tilt = tilts(crack)[:, axis]
        rows = np.flatnonzero((tilt < FLATTEST) & meets_box(corners, slab))
        parts = [clipped(corners[row], slab) for row in rows]
        area = np.array([polygon_area(part) if len(part) > 2 else 0.0 for part in parts])
        if area.sum() > LEAST_AREA * l_min**2:
            away = np.abs(np.concatenate(parts)[:, axis] - slab[upper, axis])
            mean = float(np.average(tilt[rows], weights=area))
            face = BOX_PLANES[2 * axis + upper]
            found.append(AlongFace(face, float(away.min()), float(away.max()), mean, float(area.sum())))
    return found


def _refuse_lines(crack: Crack, box: np.ndarray, l_min: float) -> None:
    """Raise CraftmeshError if a front, a kink or a mouth leaves too thin a ligament to a face."""
    corners = crack.points[crack.triangles]
    lines = {"front": crack.points[crack.front_edges], "kink": kink_edges(crack)}
    mouths = {face: cuts(corners, box, face) for face in BOX_FACES}
    for axis, upper in BOX_FACES:
        slab = box.copy()
        inward = (1 - 2 * upper) * l_min
        slab[[upper, 1 - upper], axis] = box[upper, axis] + inward * np.array([PREPARATION.front, LIGAMENT])
        on_others = [mouth for face, mouth in mouths.items() if face[0] != axis]
        for name, ends in (lines | {"mouth": np.concatenate(on_others)}).items():
            share = _shares(ends, slab)
            along = float((share * np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)).sum())
            if along > LENGTH * l_min:
                away = np.abs(ends[share > 0, :, axis] - box[upper, axis]).min()
                raise CraftmeshError(
                    f"the crack's {name} runs {away:.3g} from the box face {BOX_PLANES[2 * axis + upper]} "
                    f"over a length of {along:.3g}, which leaves a ligament too thin to mesh; expected at "
                    f"least 0.1 l_min ({LIGAMENT * l_min:.3g}): move it inward by "
                    f"{max(LIGAMENT * l_min - away, 0):.3g}, or onto or past the face"
                )


def _shares(ends: np.ndarray, slab: np.ndarray) -> np.ndarray:
    """Return the fraction (k,) of each segment (k, 2, 3) that lies in a box (2, 3)."""
    start, way = ends[:, 0], ends[:, 1] - ends[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        at = (slab[:, None] - start) / way
    inside = (slab[0] <= start) & (start <= slab[1])
    flat = way == 0
    enter = np.where(flat, np.where(inside, 0.0, 1.0), at.min(axis=0)).max(axis=1)
    leave = np.where(flat, 1.0, at.max(axis=0)).min(axis=1)
    shares: np.ndarray = np.clip(np.minimum(leave, 1.0) - np.maximum(enter, 0.0), 0.0, 1.0)
    return shares


def kink_edges(crack: Crack) -> np.ndarray:
    """Return the edges (k, 2, 3) of a crack's kinks: edges at which it turns by KINK degrees or more.

    A surface with over MOST_PARTS parts between kinks counts as rough, without kinks.
    """
    found = [np.zeros((0, 2, 3))]
    for sheet in sheets(crack):
        part, edges, _ = kinks_of(sheet.points, sheet.triangles)
        if part.max() < MOST_PARTS:
            found.append(sheet.points[edges])
    return np.concatenate(found)


def cuts(corners: np.ndarray, box: np.ndarray, face: Face) -> np.ndarray:
    """Return segments (k, 2, 3) in which triangles (n, 3, 3) cut a box face: the crack's mouth there."""
    places = in_plane(corners, np.roll(corners, -1, axis=1), box, face)
    ends = np.stack([places, np.roll(places, -1, axis=1)], axis=2)
    length = np.nan_to_num(np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2), nan=-1.0)
    cut = np.flatnonzero(length.max(axis=1, initial=-1.0) >= 0)
    segments = ends[cut, length[cut].argmax(axis=1)]
    return segments[meets_box(segments, box)]


def in_plane(a: np.ndarray, b: np.ndarray, box: np.ndarray, face: Face) -> np.ndarray:
    """Return points (..., 3) at which edges from a to b (..., 3) cross the plane of a box face.

    Edges that do not cross the plane have NaN.
    """
    axis, upper = face
    at_a, at_b = a[..., axis] - box[upper, axis], b[..., axis] - box[upper, axis]
    share = at_a / np.where(at_a == at_b, 1.0, at_a - at_b)
    return np.where((at_a * at_b <= 0)[..., None], a + share[..., None] * (b - a), np.nan)
