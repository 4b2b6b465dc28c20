"""Shorter edges in narrow strips beside the faces of the box, where long ones would make stretched tets.

Such strips lie between a crack and a face, and on a crack that cuts off an edge of the box, between its two
mouths. Slivers, narrow in two directions, lie between a mouth and an edge of the box, and between a front
and a face.
"""

from itertools import combinations, permutations

import numpy as np
from scipy.spatial import cKDTree

from craftmesh.sizing.length_field import LengthField
from craftmesh.sizing.sizing import Sizing, densify, where_short
from craftmesh.surface.measure import meets_box, unit_normals
from craftmesh.types import BOX_FACES, Crack

# Of a strip's width: its edges. A kinked disc .6 l_min from a face, with edges of 4.5 l_min, had 1.06 %
# of its tets over an aspect ratio of 5; with 3 of the width .12 %, with 2.5 .06 %, for 9 % more tets.
PER_WIDTH = 2.5
# Of the height that its tilt gives a crack at the distance from its mouth on the face: places between are
# in the wedge at the mouth, whose tets are as flat as it is. Shorter edges would make more of them: 512 in
# place of 205 in a wedge of 8 degrees.
IN_WEDGE = (0.5, 1.5)
# Of l_min: no edge is shorter for a strip; those narrower than 0.2 l_min are not meshed. Within 0.7 l_min
# of a face, over 34 x 34 l_min^2, 1.7 % of 140,000 tets had an aspect ratio over 5 with edges of l_min, now
# 0.2 % of 155,000, in three quarters of the time.
SHORTEST = 0.5
# The same for slivers, which are few edges. A front that comes within 0.07 l_min of a face and a mouth that
# runs 0.2 l_min beside an edge over 9 l_min had 26 and 24 tets over an aspect ratio of 5, now none and 11;
# with 0.25 three times as many.
SHORTEST_IN_SLIVERS = 0.12
# Of a sliver's width, where the crack goes on along a face beside it, which makes a wedge: its edges. Tets
# in it are as flat as it is, whatever the edges, but with edges of over 11 widths they have dihedral angles
# under 5 degrees. Mouths 0.07 and 0.13 l_min beside an edge of the box, in wedges of 10 and 13 degrees, had
# edges of 1.2 to 2.3 l_min and a flat tet each; with 6 widths, and strips parted by gradation, none.
PER_WIDTH_IN_WEDGE = 6.0
# The sine of the angle between a crack and the face beside a sliver: flatter ones make a wedge or a strip
# there. At 18 degrees edges of PER_WIDTH made 60 such tets of 16, at 21 and 23 degrees 11 of 24 and of 15.
# So it is within l_min of a mouth: a disc that was steep there, and beyond a kink 10 degrees to the face,
# had points of its facets out of the box.
STEEP = 0.34
# Of the height that its tilt gives a crack at the distance from its mouth: at a corner that a mouth or a
# front makes with a face only what is narrower is a sliver, as in corners of under 15 degrees.
AT_CORNER = 0.25
# Of the box's extent: a place this near a face is on it.
ROUNDING = 1e-9
# Places along mouths and fronts are so far apart, in l_min.
STEP = 0.2

Face = tuple[int, int]


def strip_lengths(crack: Crack, box: np.ndarray, sizing: Sizing) -> LengthField | None:
    """Return the lengths in narrow strips beside faces of the box (2, 3); None without strips.

    A length is PER_WIDTH of the strip's width, SHORTEST of l_min at least, at places on the crack; in a
    sliver SHORTEST_IN_SLIVERS.
    """
    box = np.asarray(box, float)
    near = {face: _near_face(crack, box, sizing, face) for face in BOX_FACES}
    cuts = {face: _cuts(near[face], box, face) for face in BOX_FACES}
    mouths = {face: cuts[face][0] for face in BOX_FACES}
    beside = {face: _beside(near[face], cuts[face][1], sizing.l_min) for face in BOX_FACES}
    fronts = [densify(crack.points[front], STEP * sizing.l_min) for front in crack.fronts]
    found = [_over_face(near[face], mouths[face], box, face, sizing.l_min) for face in BOX_FACES]
    found += [
        _between_mouths(near[one], (mouths[one], mouths[other]), box, (one, other))
        for one, other in combinations(BOX_FACES, 2)
        if one[0] != other[0]
    ]
    slivers = [
        _between_mouth_and_edge(
            near[one], beside[one], (mouths[one], mouths[other]), box, (one, other), sizing.l_min
        )
        for one, other in permutations(BOX_FACES, 2)
        if one[0] != other[0]
    ]
    slivers += [_under_front(near[face], mouths[face], fronts, box, face) for face in BOX_FACES]
    parts = []
    for places, shortest in ((found, SHORTEST), (slivers, SHORTEST_IN_SLIVERS)):
        points, widths = (np.concatenate(columns) for columns in zip(*places))
        parts.append((points, np.maximum(PER_WIDTH * widths, shortest * sizing.l_min)))
    points, lengths = (np.concatenate(columns) for columns in zip(*parts))
    return where_short(points, lengths, sizing)


def _near_face(crack: Crack, box: np.ndarray, sizing: Sizing, face: Face) -> np.ndarray:
    """Return the crack as triangles (k, 3, 3) of edges up to l_min, where strips may be narrow."""
    axis, upper = face
    slab = box.copy()
    slab[1 - upper, axis] = box[upper, axis] + (1 - 2 * upper) * sizing.l_max / PER_WIDTH
    return _divided(crack.points[crack.triangles], slab, sizing.l_min)


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


def _cuts(corners: np.ndarray, box: np.ndarray, face: Face) -> tuple[np.ndarray, np.ndarray]:
    """Return the segments (k, 2, 3) in which triangles (n, 3, 3) cut a face of the box, and whose rows."""
    axis, upper = face
    a, b = corners, np.roll(corners, -1, axis=1)
    share, meets = _crossing(a[..., axis] - box[upper, axis], b[..., axis] - box[upper, axis])
    places = np.where(meets[..., None], a + share[..., None] * (b - a), np.nan)
    ends = np.stack([places, np.roll(places, -1, axis=1)], axis=2)
    length = np.nan_to_num(np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2), nan=-1.0)
    cut = np.flatnonzero(length.max(axis=1, initial=-1.0) >= 0)
    segments = ends[cut, length[cut].argmax(axis=1)]
    inside = meets_box(segments, box)
    return segments[inside], cut[inside]


def _crossing(at_a: np.ndarray, at_b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the shares of the way from a to b at which signed distances vanish, and where they do."""
    return at_a / np.where(at_a == at_b, 1.0, at_a - at_b), at_a * at_b <= 0


def _over_face(
    corners: np.ndarray, mouth: np.ndarray, box: np.ndarray, face: Face, least: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return places (k, 3) on the crack over a face, but those in a wedge at its mouth, and widths (k,).

    least: l_min.
    """
    axis, upper = face
    places, steepness = _places(corners, box, axis)
    width = np.abs(places[:, axis] - box[upper, axis])
    if not len(mouth):
        return places, width
    straight = steepness * distance(places, mouth)
    # distances are from points up to l_min apart
    out = (width + least < IN_WEDGE[0] * straight) | (width > IN_WEDGE[1] * straight)
    return places[out], width[out]


def _between_mouths(
    corners: np.ndarray,
    mouths: tuple[np.ndarray, np.ndarray],
    box: np.ndarray,
    pair: tuple[Face, Face],
) -> tuple[np.ndarray, np.ndarray]:
    """Return places (k, 3) on the crack between its mouths on two faces, and how close these are (k,).

    Where the mouths meet, at an edge of the box, they make a corner of the crack, which is no strip.
    """
    first, second = mouths
    if not len(first) or not len(second):
        return np.zeros((0, 3)), np.zeros(0)
    places, _ = _places(corners, box, pair[0][0])
    width = distance(places, first) + distance(places, second)
    met = meets_face(first[:, 0], first[:, 1], box, pair[1])
    if len(met):
        out = PER_WIDTH * width < distance(places, met)
        places, width = places[out], width[out]
    return places, width


def _beside(corners: np.ndarray, rows: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the triangles (n,) within reach of those in rows (k,) one by one, and where each begins."""
    if not len(rows):
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    centres = corners.mean(axis=1)
    near = cKDTree(centres).query_ball_point(centres[rows], reach)
    counts = np.array([len(some) for some in near])
    return np.concatenate(near).astype(np.int64), np.cumsum(counts) - counts


def _between_mouth_and_edge(
    corners: np.ndarray,
    beside: tuple[np.ndarray, np.ndarray],
    mouths: tuple[np.ndarray, np.ndarray],
    box: np.ndarray,
    pair: tuple[Face, Face],
    l_min: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Return places (k, 3) on a mouth on the first face, near its edge with the second, and widths (k,).

    Where the crack goes on along a face the widths are larger, for edges of PER_WIDTH_IN_WEDGE of them.
    corners: the crack near the first face, and what is `_beside` each segment of its mouth there.
    """
    segments, other = mouths[0], pair[1]
    if not len(segments):
        return np.zeros((0, 3)), np.zeros(0)
    parts = [densify(segment, STEP * l_min) for segment in segments]
    near, begin = beside
    steepness = np.minimum(*(_steepness(corners, axis) for axis, _ in pair))
    steepness = np.repeat(np.minimum.reduceat(steepness[near], begin), [len(part) for part in parts])
    met = meets_face(segments[:, 0], segments[:, 1], box, other)
    mouth = np.concatenate([mouths[1].reshape(-1, 3), met])
    places = np.concatenate(parts)
    flat = steepness <= STEEP
    steep, widths = _slivers(places, steepness, mouth, box, other)
    beside_wedge, gaps = _beside_wedge(places[flat], mouth, box, other)
    return (
        np.concatenate([steep, beside_wedge]),
        np.concatenate([widths, PER_WIDTH_IN_WEDGE / PER_WIDTH * gaps]),
    )


def _beside_wedge(
    places: np.ndarray, mouth: np.ndarray, box: np.ndarray, face: Face
) -> tuple[np.ndarray, np.ndarray]:
    """Return the places (k, 3) on a mouth that runs along a face, but for its corners, and widths (k,).

    mouth (k, 3): points of the crack's mouth on that face.
    """
    upright = np.ones(len(places))
    places, widths = _slivers(places, upright, mouth, box, face)
    if not len(mouth):
        return places, widths
    # beyond a mouth on that face, too, the crack may lie nearer to it than it stands off
    along = widths < AT_CORNER * distance(places, mouth)
    return places[along], widths[along]


def _under_front(
    corners: np.ndarray, mouth: np.ndarray, fronts: list[np.ndarray], box: np.ndarray, face: Face
) -> tuple[np.ndarray, np.ndarray]:
    """Return places (k, 3) on fronts near a face, and how near they are (k,); the mouth is that on it.

    fronts: their points (n, 3), close together.
    """
    centres, steepness = _places(corners, box, face[0])
    if not len(centres):
        return np.zeros((0, 3)), np.zeros(0)
    met = [meets_face(line[:-1], line[1:], box, face) for line in fronts]
    mouth = np.concatenate([mouth.reshape(-1, 3), *met])
    places = np.concatenate([np.zeros((0, 3)), *fronts])
    return _slivers(places, steepness[cKDTree(centres).query(places)[1]], mouth, box, face)


def meets_face(a: np.ndarray, b: np.ndarray, box: np.ndarray, face: Face) -> np.ndarray:
    """Return the points (k, 3) in which segments from a to b (n, 3) meet the plane of a face."""
    axis, upper = face
    share, meets = _crossing(a[:, axis] - box[upper, axis], b[:, axis] - box[upper, axis])
    return (a + share[:, None] * (b - a))[meets]


def _slivers(
    places: np.ndarray, steepness: np.ndarray, mouth: np.ndarray, box: np.ndarray, face: Face
) -> tuple[np.ndarray, np.ndarray]:
    """Return the places (k, 3) that only a sliver parts from a face, and how near they are (k,).

    steepness: sines of the crack's angles to the face; where it is flat the narrow place goes on along it.
    mouth (k, 3): points of that on the face; where the crack leads to it they make a wedge or a corner.
    """
    axis, upper = face
    width = np.abs(places[:, axis] - box[upper, axis])
    rounding = ROUNDING * np.ptp(box)
    out = (steepness > STEEP) & ((places >= box[0] - rounding) & (places <= box[1] + rounding)).all(axis=1)
    out &= width > rounding
    mouth = np.concatenate([mouth, places[width <= rounding]])
    if len(mouth):
        straight = steepness * distance(places, mouth)
        out &= (width < AT_CORNER * straight) | (width > IN_WEDGE[1] * straight)
    return places[out], width[out]


def _places(corners: np.ndarray, box: np.ndarray, axis: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the triangles' centres (k, 3) in the box, and the sines (k,) of their tilts to a face."""
    centres = corners.mean(axis=1)
    within = ((centres >= box[0]) & (centres <= box[1])).all(axis=1)
    return centres[within], _steepness(corners[within], axis)


def _steepness(corners: np.ndarray, axis: int) -> np.ndarray:
    """Return the sines (k,) of the angles between triangles (k, 3, 3) and the faces across an axis."""
    across = unit_normals(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
    return np.sqrt(np.maximum(1 - across[:, axis] ** 2, 0.0))


def distance(places: np.ndarray, parts: np.ndarray) -> np.ndarray:
    """Return the distances (k,) from places to the nearest of points, or ends of segments (..., 3)."""
    return cKDTree(np.unique(parts.reshape(-1, 3), axis=0)).query(places)[0]
