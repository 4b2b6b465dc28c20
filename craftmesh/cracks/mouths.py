"""Mouths of a crack that no room for tetrahedra is beside: flat to their face, or along another one."""

import numpy as np

from craftmesh.cracks.within_box import clipped, tilts
from craftmesh.errors import CraftmeshError
from craftmesh.surface.measure import meets_box
from craftmesh.types import BOX_FACES, BOX_PLANES, Crack

# Degrees: a crack that ends at a face makes a wedge of this angle at least. A tet is flat under 5 degrees,
# and those of a wedge's second row are flatter than it is: of three random cracks over 2 to 4 l_min^2 of
# which it was 5 to 6 degrees one ended with 6 flat tets, one in no mesh, one with .58 % too much area.
FLATTEST = 6.0
# Of l_min: a front nearer than this to a face leaves a ligament of flat tets alone. It is refused:
# moved onto the face it would be gone, and with all of it the crack parts the body.
LIGAMENT = 0.1
# Of l_min: a mouth under FLATTEST for longer is refused, though the crack soon leaves the face steeper. Of
# 871 random cracks one was so for 1.34 and had 5 flat tets and 0.4 % poor ones, the next for 0.46 and none.
LEAST_MOUTH = 1.0
# Of l_min: a mouth on one face nearer than LIGAMENT to another, for longer than this, leaves a ribbon of
# the face: cracks 0.02 and 0.06 beside an edge of the box, at 20 degrees, had 39 and 3 flat tets, at 30 40
# and 15; 0.1 beside it none. One at AT_EDGE goes through the edge.
RIBBON_LENGTH = 2.0
AT_EDGE = 0.015
ON_FACE = 1e-6  # of l_min: a part this near a face reaches it


def refuse_mouths(crack: Crack, box: np.ndarray, l_min: float) -> None:
    """Raise CraftmeshError where a mouth on a face is at less than FLATTEST over more than LEAST_MOUTH."""
    rows = np.flatnonzero(meets_box(crack.points[crack.triangles], box))
    corners, angles = crack.points[crack.triangles[rows]], tilts(crack)[rows]
    for axis, upper in BOX_FACES:
        flat = _passing(corners, box[upper, axis], axis) & (angles[:, axis] < FLATTEST)
        along = float(_lengths(_mouth(corners[flat], box, (axis, upper), l_min)).sum())
        if along > LEAST_MOUTH * l_min:
            face, least = BOX_PLANES[2 * axis + upper], angles[flat, axis].min()
            raise CraftmeshError(
                f"the crack meets the box face {face} at {least:.3g} degrees and more, over a length of "
                f"{along:.3g} at under {FLATTEST:g}; expected one that meets a face at {FLATTEST:g} "
                "degrees or more: turn it, or move it into the box or farther through it"
            )


def refuse_ribbons(crack: Crack, box: np.ndarray, l_min: float) -> None:
    """Raise CraftmeshError where a mouth on a face leaves a ribbon to another that is too narrow."""
    corners = crack.points[crack.triangles]
    corners = corners[meets_box(corners, box)]
    for axis, upper in BOX_FACES:
        passing = _passing(corners, box[upper, axis], axis)
        mouth = _mouth(corners[passing], box, (axis, upper), l_min)
        for other in (k for k in range(3) if k != axis):
            _refuse_ribbon(mouth, (axis, upper), other, box, l_min)


def _refuse_ribbon(
    mouth: np.ndarray, face: tuple[int, int], other: int, box: np.ndarray, l_min: float
) -> None:
    """Raise CraftmeshError where a mouth (k, 2, 3) on a face runs beside one across another axis.

    One that comes down to the edge between the two ends there, and gradation takes what is near onto it.
    """
    length = _lengths(mouth)
    for upper in (0, 1):
        a, b = np.abs(mouth[:, :, other] - box[upper, other]).T
        low, rise = np.minimum(a, b), np.maximum(np.abs(b - a), 1e-300)
        beside = np.clip((LIGAMENT * l_min - low) / rise, 0, 1) - np.clip(
            (AT_EDGE * l_min - low) / rise, 0, 1
        )
        along = float((beside * length).sum())
        if along > RIBBON_LENGTH * l_min and low.min() > AT_EDGE * l_min:
            least = low.min()
            lack = LIGAMENT * l_min - least
            raise CraftmeshError(
                f"the crack's mouth on the box face {BOX_PLANES[2 * face[0] + face[1]]} runs {least:.3g} "
                f"from {BOX_PLANES[2 * other + upper]} over a length of {along:.3g}, which leaves a ribbon "
                f"too thin to mesh; expected 0.1 l_min, which is {LIGAMENT * l_min:.3g}: move the crack "
                f"inward by {lack:.3g}, or to the edge of the box"
            )


def _passing(corners: np.ndarray, place: float, axis: int) -> np.ndarray:
    """Tell which triangles (m, 3, 3) reach a plane across an axis, or through it."""
    along = corners[:, :, axis]
    return (along.min(axis=1) <= place) & (place <= along.max(axis=1))


def _mouth(corners: np.ndarray, box: np.ndarray, face: tuple[int, int], l_min: float) -> np.ndarray:
    """Return the edges (j, 2, 3) that triangles (m, 3, 3), cut off at the box, have on a face of it."""
    axis, upper = face
    found = [np.zeros((0, 2, 3))]
    for triangle in corners:
        polygon = clipped(triangle, box)
        if len(polygon) > 2:
            on = np.abs(polygon[:, axis] - box[upper, axis]) <= ON_FACE * l_min
            edges = np.stack([polygon, np.roll(polygon, -1, axis=0)], axis=1)
            found.append(edges[on & np.roll(on, -1)])
    return np.concatenate(found)


def _lengths(edges: np.ndarray) -> np.ndarray:
    lengths: np.ndarray = np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1)
    return lengths
