"""Cracks so near to a face of the box that only flat tetrahedra fit in between: refused in one line."""

from typing import NamedTuple

import numpy as np

from craftmesh.cracks.height_parts import MOST_PARTS, kinks_of
from craftmesh.cracks.promises import PREPARATION
from craftmesh.cracks.sheets import sheets
from craftmesh.cracks.within_box import area_within, clipped, is_in, polygon_area, tilts
from craftmesh.errors import CraftmeshError
from craftmesh.surface.measure import meets_box
from craftmesh.surface.rounding import SAME_PLACE
from craftmesh.types import BOX_FACES, BOX_PLANES, Crack

NEAR = 0.2  # of l_min: a part along a face, at less than FLATTEST to it, has to be this far from it
# Degrees between a crack and a face that it meets or runs beside, at least. A tet is flat under 5 degrees,
# and those of a wedge's second row are flatter than it is.
FLATTEST = 6.0
ALONG = np.sin(np.radians(FLATTEST))  # of that angle: under it a crack lies along a face
LEAST_AREA = 1.0  # of l_min squared, about two facets: a smaller part near a face is a place, not a run
# Of l_min: fronts, kinks and mouths nearer than this to a face leave a ligament of flat tets.
LIGAMENT = 0.1
LENGTH = 8.0  # of l_min, over which they do: a circle of up to 80 l_min that touches a face does for less


Face = tuple[int, int]  # of the box: the axis across it, and 1 for the upper one


class AlongFace(NamedTuple):
    """The part of a crack along a face: its distances from the face, mean tilt in degrees, and area."""

    face: str
    least: float
    most: float
    tilt: float
    area: float


def refuse_near_faces(crack: Crack, box: np.ndarray, l_min: float, lines_too: bool = True) -> None:
    """Raise CraftmeshError where a crack runs along a face of the box (2, 3), or cuts off a sliver of it.

    l_min in model units. lines_too: also where only its front, a kink or a mouth on another face does.
    """
    box = np.asarray(box, float)
    found = along_faces(crack, box, l_min)
    if found:
        _refuse_part(max(found, key=lambda one: one.area), l_min)
    inner = box + NEAR * l_min * np.array([[1.0], [-1.0]])
    corners = crack.points[crack.triangles]
    if (inner[0] < inner[1]).all() and is_in(corners, box) and not is_in(corners, inner):
        raise CraftmeshError(
            f"the crack cuts only a sliver off the box: all of it in there, an area of "
            f"{area_within(crack, box):.3g}, lies nearer than 0.2 l_min to a face, which is "
            f"{NEAR * l_min:.3g}; expected one that reaches deeper: move it inward or give a shorter l_min"
        )
    if lines_too:
        _refuse_lines(crack, box, l_min)


def _refuse_part(part: AlongFace, l_min: float) -> None:
    if part.least <= SAME_PLACE * l_min:
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


def along_faces(crack: Crack, box: np.ndarray, l_min: float) -> list[AlongFace]:
    """Return the parts of the crack within the box (2, 3) that run along a face nearer than NEAR l_min.

    They are at less than FLATTEST to it. Tilt, distance and area are those of the crack's triangles, cut
    off at the box: a curved crack is measured place by place.
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
    """Raise CraftmeshError where a front, a kink or a mouth leaves too thin a ligament to a face."""
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
                    f"over a length of {along:.3g}, which leaves a ligament too thin to mesh; expected 0.1 "
                    f"l_min, which is {LIGAMENT * l_min:.3g}: move it inward by "
                    f"{max(LIGAMENT * l_min - away, 0):.3g}, or onto the face or past it"
                )


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


def kink_edges(crack: Crack) -> np.ndarray:
    """Return the edges (k, 2, 3) at which a crack has kinks (`height_parts`), none of a rough sheet."""
    found = [np.zeros((0, 2, 3))]
    for sheet in sheets(crack):
        part, edges, _ = kinks_of(sheet.points, sheet.triangles)
        if part.max() < MOST_PARTS:
            found.append(sheet.points[edges])
    return np.concatenate(found)


def cuts(corners: np.ndarray, box: np.ndarray, face: Face) -> np.ndarray:
    """Return the segments (k, 2, 3) in which triangles (n, 3, 3) cut a face of the box: its mouth there."""
    places = in_plane(corners, np.roll(corners, -1, axis=1), box, face)
    ends = np.stack([places, np.roll(places, -1, axis=1)], axis=2)
    length = np.nan_to_num(np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2), nan=-1.0)
    cut = np.flatnonzero(length.max(axis=1, initial=-1.0) >= 0)
    segments = ends[cut, length[cut].argmax(axis=1)]
    return segments[meets_box(segments, box)]


def in_plane(a: np.ndarray, b: np.ndarray, box: np.ndarray, face: Face) -> np.ndarray:
    """Return the points (..., 3) at which edges from a to b (..., 3) cross the plane of a face of the box.

    Edges that do not cross the plane have NaN.
    """
    axis, upper = face
    at_a, at_b = a[..., axis] - box[upper, axis], b[..., axis] - box[upper, axis]
    share = at_a / np.where(at_a == at_b, 1.0, at_a - at_b)
    return np.where((at_a * at_b <= 0)[..., None], a + share[..., None] * (b - a), np.nan)
