"""Split edges of facets at new points, conformally with the neighbouring facets."""

from typing import NamedTuple

import numpy as np

from craftmesh.surface.measure import meets_box

# Fraction of an edge: a crossing nearer to an end counts as at that end, because shorter edges leave facets
# without an angle.
AT_END = 0.1


class Divided(NamedTuple):
    """Facets split where a dividing surface, such as a sphere or a plane, crosses them.

    points (n, 3), new ones last; side (n,): < 0 or > 0 for points on either side of it, 0 at crossings;
    facets (m, 3); parent (m,): row of the original facet; ends (k, 2): end points of the split edges.
    """

    points: np.ndarray
    side: np.ndarray
    facets: np.ndarray
    parent: np.ndarray
    ends: np.ndarray


def divided_at(
    points: np.ndarray,
    facets: np.ndarray,
    side: np.ndarray,
    edges: np.ndarray,
    share: np.ndarray,
) -> Divided:
    """Return facets (m, 3) with edges (k, 2) split where a dividing surface crosses them.

    side (n,): < 0 or > 0 for points on either side of it; share (k,): position of the crossing on the edge,
    from 0 to 1, NaN without one. A crossing within AT_END of an end of the edge is moved to that end and
    splits nothing.
    """
    side = side.copy()
    side[edges[share < AT_END, 0]] = 0
    side[edges[share > 1 - AT_END, 1]] = 0
    crossed = side[edges].prod(axis=1) < 0
    ends, share = edges[crossed], share[crossed, None]
    start = points[ends[:, 0]]
    every = np.concatenate([points, start + share * (points[ends[:, 1]] - start)])
    facets, parent = divided(every, facets, ends, len(points))
    return Divided(every, np.pad(side, (0, len(ends))), facets.astype(np.int64), parent, ends)


def divided(
    points: np.ndarray, facets: np.ndarray, edges: np.ndarray, first_new: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return facets (m, 3) with edges (k, 2) split at points from id `first_new` on; and old rows (m,).

    edges: lower point first. points: positions of at least all points before first_new. If two edges of a
    facet are split, the shorter diagonal divides the rest. The facets keep their order.
    """
    if not len(edges):
        return facets, np.arange(len(facets))
    stride = np.int64(len(points) + 1)
    keys = edges[:, 0] * stride + edges[:, 1]
    order = np.argsort(keys)
    touched = np.zeros(len(points), bool)
    touched[edges] = True
    rows = np.flatnonzero(touched[facets].sum(axis=1) >= 2)
    corners = facets[rows].astype(np.int64)
    following = np.roll(corners, -1, axis=1)
    wanted = np.minimum(corners, following) * stride + np.maximum(corners, following)
    slot = np.minimum(np.searchsorted(keys, wanted, sorter=order), len(keys) - 1)
    middle = np.where(keys[order[slot]] == wanted, first_new + order[slot], -1)
    split = (middle >= 0).sum(axis=1)
    kept = np.ones(len(facets), bool)
    kept[rows[split > 0]] = False
    pieces, parents = [facets[kept]], [np.flatnonzero(kept)]
    for number, divide in ((1, _in_two), (2, _in_three), (3, _in_four)):
        chosen = split == number
        for piece in divide(corners[chosen], middle[chosen], points):
            pieces.append(piece)
            parents.append(rows[chosen])
    parent = np.concatenate(parents)
    stable = np.argsort(parent, kind="stable")
    return np.concatenate(pieces)[stable].astype(np.int32), parent[stable]


def bisected(corners: np.ndarray, slab: np.ndarray, longest: float) -> np.ndarray:
    """Bisect triangles (k, 3, 3) until no edge exceeds `longest`; drop those that miss the box `slab`."""
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


def _turn(corners: np.ndarray, middle: np.ndarray, first: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rotate each facet so that its edge `first` becomes edge 0 (corner 0 to corner 1)."""
    index = (first[:, None] + np.arange(3)) % 3
    return np.take_along_axis(corners, index, 1), np.take_along_axis(middle, index, 1)


def _in_two(corners: np.ndarray, middle: np.ndarray, _points: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return two arrays (m, 3): the parts of facets `corners` (m, 3) that have one split edge.

    middle (m, 3): id of the new point on each edge, -1 if not split.
    """
    corners, middle = _turn(corners, middle, np.argmax(middle >= 0, axis=1))
    (a, b, c), m = corners.T, middle[:, 0]
    return np.stack([a, m, c], axis=1), np.stack([m, b, c], axis=1)


def _in_three(corners: np.ndarray, middle: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return three arrays (m, 3): the parts of facets with two split edges, by the shorter diagonal."""
    corners, middle = _turn(corners, middle, np.argmax(middle < 0, axis=1))
    (a, b, c), (_, bc, ca) = corners.T, middle.T
    to_a = np.linalg.norm(points[a] - points[bc], axis=1) <= np.linalg.norm(points[b] - points[ca], axis=1)
    third = np.where(to_a, bc, ca)
    return (
        np.stack([bc, c, ca], axis=1),
        np.stack([a, b, third], axis=1),
        np.stack([np.where(to_a, a, b), bc, ca], axis=1),
    )


def _in_four(corners: np.ndarray, middle: np.ndarray, _points: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return the four parts of each facet with three split edges."""
    (a, b, c), (ab, bc, ca) = corners.T, middle.T
    return (
        np.stack([a, ab, ca], axis=1),
        np.stack([ab, b, bc], axis=1),
        np.stack([bc, c, ca], axis=1),
        np.stack([ab, bc, ca], axis=1),
    )
