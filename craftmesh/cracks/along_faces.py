"""Cracks in, or almost in, a face of the box: what lies between the two could not be meshed."""

from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from craftmesh.errors import CraftmeshError
from craftmesh.surface.measure import area_vectors, meets_box, total_area
from craftmesh.types import BOX_PLANES, Crack

# Of four random cracks below NEAR or 3 degrees two ended with 4 and 11 % poor tets, two in no mesh.
NEAR = 0.2  # of l_min: a crack nearer than this to a face leaves room for flat tets alone
# Degrees: a crack that ends at a face makes a wedge of this angle at least. A tet is flat under 5 degrees,
# and those of a wedge's second row are flatter than it is: of three random cracks over 2 to 4 l_min^2 of
# which it was 5 to 6 degrees one ended with 6 flat tets, one in no mesh, one with .58 % too much area.
FLATTEST = 6.0
GENTLE = 15.0  # degrees: steeper parts only end near a face, they do not lie along it
LEAST_AREA = 1.0  # of l_min squared, about two facets: a smaller part near a face is a place, not a run
# Of l_min: a front nearer than this to a face leaves a ligament of flat tets alone. It is refused:
# moved onto the face it would be gone, and with all of it the crack parts the body.
LIGAMENT = 0.1
LIGAMENT_LENGTH = 8.0  # of l_min: a circle of up to 80 l_min that touches a face is near it for less
# Of l_min: a mouth under FLATTEST for longer is refused, though the crack soon leaves the face steeper. Of
# 871 random cracks one was so for 1.34 and had 5 flat tets and 0.4 % poor ones, the next for 0.46 and none.
LEAST_MOUTH = 1.0
ON_FACE = 1e-6  # of l_min: a part this near a face reaches it
TOUCHING = 1e-12  # of the box's diagonal squared: less area of a crack only touches it


class AlongFace(NamedTuple):
    """The part of a crack along a face: its distances from the face, mean tilt in degrees, and area."""

    face: str
    least: float
    most: float
    tilt: float
    area: float


def refuse_along_faces(crack: Crack, box: np.ndarray, l_min: float) -> None:
    """Raise CraftmeshError where the crack, its front, or all of it runs along faces of the box (2, 3).

    l_min in model units.
    """
    box = np.asarray(box, float)
    found = along_faces(crack, box, l_min)
    if not found:
        _refuse_fronts(crack, box, l_min)
        _refuse_slivers(crack, box, l_min)
        _refuse_mouths(crack, box, l_min)
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
    start, end = (
        np.concatenate([crack.points[front[part]] for front in crack.fronts] or [np.zeros((0, 3))])
        for part in (slice(None, -1), slice(1, None))
    )
    length = np.linalg.norm(end - start, axis=1)
    for axis in range(3):
        for upper in (0, 1):
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


def _refuse_mouths(crack: Crack, box: np.ndarray, l_min: float) -> None:
    """Raise CraftmeshError where a mouth on a face is at less than FLATTEST over more than LEAST_MOUTH."""
    rows = np.flatnonzero(meets_box(crack.points[crack.triangles], box))
    corners, tilts = crack.points[crack.triangles[rows]], _tilts(crack)[rows]
    for axis, tilt in enumerate(tilts.T):
        for upper in (0, 1):
            place = box[upper, axis]
            low, high = corners[:, :, axis].min(axis=1), corners[:, :, axis].max(axis=1)
            flat = np.flatnonzero((low <= place) & (place <= high) & (tilt < FLATTEST))
            along = sum(_on_plane(clipped(corners[row], box), axis, place, l_min) for row in flat.tolist())
            if along > LEAST_MOUTH * l_min:
                face = BOX_PLANES[2 * axis + upper]
                raise CraftmeshError(
                    f"the crack meets the box face {face} at {tilt[flat].min():.3g} degrees and more, over "
                    f"a length of {along:.3g} at under {FLATTEST:g}; expected one that meets a face at "
                    f"{FLATTEST:g} degrees or more: turn it, or move it into the box or farther through it"
                )


def _on_plane(polygon: np.ndarray, axis: int, place: float, l_min: float) -> float:
    """Return the length of what of a polygon's (k, 3) rim lies on a plane of the box, 0 without area."""
    if len(polygon) < 3:
        return 0.0
    on = np.abs(polygon[:, axis] - place) <= ON_FACE * l_min
    step = np.roll(polygon, -1, axis=0) - polygon
    return float(np.linalg.norm(step[on & np.roll(on, -1)], axis=1).sum())


def along_faces(crack: Crack, box: np.ndarray, l_min: float) -> list[AlongFace]:
    """Return the parts of the crack within the box (2, 3) that are nearer than NEAR l_min to a face.

    A part that reaches the face counts where its tilt to it is under FLATTEST, any other under GENTLE.
    Tilt, distance and area are those of the crack's triangles, cut off at the box: a curved crack is
    measured place by place.
    """
    box = np.asarray(box, float)
    corners = crack.points[crack.triangles]
    found = []
    for axis, tilt in enumerate(_tilts(crack).T):
        for upper in (0, 1):
            slab = box.copy()
            slab[1 - upper, axis] = box[upper, axis] + (1 - 2 * upper) * NEAR * l_min
            part = _within(corners, slab, (axis, upper))
            counted = (tilt[part.rows] < FLATTEST) | ~_reaching(crack, part, ON_FACE * l_min)
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


def _tilts(crack: Crack) -> np.ndarray:
    """Return the angles (m, 3) of a crack's triangles to faces of the box across x, y and z, in degrees."""
    vectors = area_vectors(crack.points, crack.triangles)
    size = np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), np.finfo(float).tiny)
    return np.degrees(np.arccos(np.minimum(np.abs(vectors) / size, 1.0)))


class _Part(NamedTuple):
    """Triangles (k,) of a crack that reach into a slab: their area there, least and largest distance."""

    rows: np.ndarray
    area: np.ndarray
    least: np.ndarray
    most: np.ndarray


def _within(corners: np.ndarray, slab: np.ndarray, face: tuple[int, int]) -> _Part:
    """Return what of triangles (m, 3, 3) lies in the slab (2, 3), with distances from its face."""
    axis, upper = face
    rows = np.flatnonzero(meets_box(corners, slab))
    kept, area, least, most = [], [], [], []
    for row, triangle in zip(rows.tolist(), corners[rows]):
        polygon = clipped(triangle, slab)
        if len(polygon) < 3:
            continue
        distance = np.abs(polygon[:, axis] - slab[upper, axis])
        kept.append(row)
        area.append(_area(polygon))
        least.append(distance.min())
        most.append(distance.max())
    return _Part(np.array(kept, np.int64), np.array(area), np.array(least), np.array(most))


def area_within(crack: Crack, box: np.ndarray) -> float:
    """Return the area of what of a crack lies in the box (2, 3)."""
    corners = crack.points[crack.triangles]
    whole = ((corners >= box[0]) & (corners <= box[1])).all(axis=(1, 2))
    across = ~whole & meets_box(corners, box)
    inside = total_area(crack.points, crack.triangles[whole])
    parts = (clipped(triangle, box) for triangle in corners[across])
    return float(inside + sum(_area(part) for part in parts if len(part) > 2))


def clipped(polygon: np.ndarray, slab: np.ndarray) -> np.ndarray:
    """Return the convex polygon (k, 3) cut off at the six planes of the slab (2, 3)."""
    for axis in range(3):
        for inward, plane in ((1.0, slab[0, axis]), (-1.0, slab[1, axis])):
            depth = inward * (polygon[:, axis] - plane)
            if (depth >= 0).all():
                continue
            after, depth_after = np.roll(polygon, -1, axis=0), np.roll(depth, -1)
            pieces = []
            for a, b, at_a, at_b in zip(polygon, after, depth, depth_after):
                if at_a >= 0:
                    pieces.append(a)
                if at_a * at_b < 0:
                    pieces.append(a + at_a / (at_a - at_b) * (b - a))
            polygon = np.array(pieces).reshape(-1, 3)
    return polygon


def is_in(corners: np.ndarray, box: np.ndarray) -> bool:
    """Tell whether any part of the triangles (m, 3, 3) lies in the box (2, 3), not only touches it."""
    least = TOUCHING * float(((box[1] - box[0]) ** 2).sum())
    parts = (clipped(triangle, box) for triangle in corners[meets_box(corners, box)])
    return any(len(part) > 2 and _area(part) > least for part in parts)


def _area(polygon: np.ndarray) -> float:
    """Return the area of a convex polygon (k, 3)."""
    spokes = polygon[1:] - polygon[0]
    return float(np.linalg.norm(np.cross(spokes[:-1], spokes[1:]).sum(axis=0)) / 2)


def _reaching(crack: Crack, part: _Part, on_face: float) -> np.ndarray:
    """Tell which triangles of the part hang together with one that reaches the face."""
    corners = crack.triangles[part.rows].astype(np.int64)
    count = len(crack.points)
    ends = corners.ravel(), np.roll(corners, -1, axis=1).ravel()
    group = connected_components(coo_matrix((np.ones(len(ends[0])), ends), (count, count)), False)[1]
    group = group[corners[:, 0]]
    return np.isin(group, group[part.least <= on_face])
