"""Shorter edges where a crack leaves a narrow strip to a face of the box: its tets would be stretched."""

import numpy as np
from scipy.spatial import cKDTree

from craftmesh.sizing.length_field import LengthField
from craftmesh.sizing.sizing import FREE_GROWTH, Sizing
from craftmesh.surface.measure import meets_box, unit_normals
from craftmesh.types import Crack

# Of a strip's width: its edges. A kinked disc .6 l_min from a face, with edges of 4.5 l_min, had 1.06 %
# of its tets over an aspect ratio of 5; with 3 of the width .12 %, with 2.5 .06 %, for 9 % more tets.
PER_WIDTH = 2.5
# Of the height that its tilt gives a crack at the distance from its mouth on the face: lower places are in
# the wedge at the mouth, whose tets are as flat as it is. Shorter edges would make more of them: 512 in
# place of 205 in a wedge of 8 degrees.
IN_WEDGE = 1.5


def strip_lengths(crack: Crack, box: np.ndarray, sizing: Sizing) -> LengthField | None:
    """Return the lengths in strips between the crack and faces of the box (2, 3); None without strips.

    A length is PER_WIDTH of the strip's width, l_min at least, at places on the crack, and grows away from
    them by sizing.growth, or half the distance. In model units.
    """
    found = [_along_face(crack, box, sizing, axis, upper) for axis in range(3) for upper in (0, 1)]
    points, lengths = (np.concatenate(parts) for parts in zip(*found))
    if not len(points):
        return None
    growth = FREE_GROWTH if sizing.growth is None else sizing.growth
    return LengthField(points, lengths).limited(growth)


def _along_face(
    crack: Crack, box: np.ndarray, sizing: Sizing, axis: int, upper: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return places (k, 3) on the crack in narrow strips to a face, and the lengths (k,) there."""
    plane = box[upper, axis]
    slab = np.array(box, float)
    slab[1 - upper, axis] = plane + (1 - 2 * upper) * sizing.l_max / PER_WIDTH
    corners = _divided(crack.points[crack.triangles], slab, sizing.l_min)
    centres = corners.mean(axis=1)
    within = ((centres >= slab[0]) & (centres <= slab[1])).all(axis=1)
    places, mouth = centres[within], _on_plane(corners, axis, plane)
    width = np.abs(places[:, axis] - plane)
    lengths = np.maximum(PER_WIDTH * width, sizing.l_min)
    narrow = lengths < sizing.at(places)
    if len(mouth):
        facets = np.arange(3 * within.sum()).reshape(-1, 3)
        across = unit_normals(corners[within].reshape(-1, 3), facets)[:, axis]
        steepness = np.sqrt(np.maximum(1 - across**2, 0.0))
        narrow &= width > IN_WEDGE * steepness * cKDTree(mouth).query(places)[0]
    return places[narrow], lengths[narrow]


def _divided(corners: np.ndarray, slab: np.ndarray, longest: float) -> np.ndarray:
    """Return triangles (k, 3, 3) halved until no edge is over `longest`, but those off the slab."""
    done = [np.zeros((0, 3, 3))]
    while True:
        corners = corners[meets_box(corners, slab)]
        length = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
        is_long = length.max(axis=1, initial=0.0) > longest
        done.append(corners[~is_long])
        if not is_long.any():
            return np.concatenate(done)
        turned = (length[is_long].argmax(axis=1)[:, None] + np.arange(3)) % 3
        a, b, c = np.take_along_axis(corners[is_long], turned[:, :, None], axis=1).transpose(1, 0, 2)
        middle = (a + b) / 2
        corners = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])


def _on_plane(corners: np.ndarray, axis: int, plane: float) -> np.ndarray:
    """Return where edges of the triangles (k, 3, 3) meet a plane across an axis."""
    a, b = corners.reshape(-1, 3), np.roll(corners, -1, axis=1).reshape(-1, 3)
    at_a, at_b = a[:, axis] - plane, b[:, axis] - plane
    meets = at_a * at_b <= 0
    a, b, at_a, at_b = a[meets], b[meets], at_a[meets], at_b[meets]
    share = at_a / np.where(at_a == at_b, 1.0, at_a - at_b)
    return a + share[:, None] * (b - a)
