"""Points for a patch of a curved crack: where it bends, and where its facets would meet the boundaries."""

from typing import NamedTuple

import numpy as np

from craftmesh.insertion.kernels import planar
from craftmesh.insertion.kernels.planar import Candidates, Planar
from craftmesh.insertion.patch import circumcircles, is_among, refuse_full, smooth_points
from craftmesh.insertion.sheet import Sheet
from craftmesh.surface.kernels.triangle_pairs import intersecting_pairs
from craftmesh.surface.measure import area_vectors

OFF = 0.04  # of the least length: facets farther off the crack get a point; 0.05 is promised
SMALLEST = 0.45  # of the least length: no facet gets a point nearer than this to its corners
TIGHTEST = 0.12  # of the least length: the same where facets would meet a grain boundary
CLEAR = 0.5  # of that distance: how far the point stays off fixed edges
SMALLER = 0.75  # a facet that is too far off gets a point at this share of its circumradius from others
ROUNDS = 12  # of points at most; it ends when a round inserts none


class Bends(NamedTuple):
    """What a patch has to follow: the sheet, the first points' places (n, 3), the least length.

    kept (k, 3): triangles that stay as they are, by their points.
    """

    sheet: Sheet
    known: np.ndarray
    least: float
    kept: np.ndarray


def places(patch: Planar, bends: Bends) -> np.ndarray:
    """Return where the patch's points in use are (n, 3)."""
    added = patch.uv[len(bends.known) : patch.used[0]]
    return np.concatenate([bends.known, bends.sheet.lift(added)])


def follow(patch: Planar, bends: Bends) -> None:
    """Insert points until no facet of the patch is farther than OFF from the crack, if not too small."""
    first = patch.used[0].copy()
    for _ in range(ROUNDS):
        off = distances_off(patch, bends)
        rows = np.flatnonzero(off > OFF * bends.least)
        rows = rows[np.argsort(-off[rows], kind="stable")]
        if not _insert(patch, bends, rows, SMALLEST * bends.least):
            break
    refuse_full(patch)
    smooth_points(patch, np.arange(first, patch.used[0]))
    planar.legalise_all(patch)


def distances_off(patch: Planar, bends: Bends) -> np.ndarray:
    """Return how far the triangles (t,) are off the crack, at centres and the middles of free edges."""
    points = places(patch, bends)
    corners = points[patch.triangles]
    samples = np.stack(
        [corners.mean(axis=1), *((corners[:, i] + corners[:, i - 2]) / 2 for i in range(3))], axis=1
    )
    off = np.abs(bends.sheet.offset(samples.reshape(-1, 3))).reshape(-1, 4)
    off[:, 1:][patch.fixed[: patch.used[1]]] = 0.0
    vectors = area_vectors(points, patch.triangles)
    cosine = vectors @ bends.sheet.frame[2] / np.maximum(np.linalg.norm(vectors, axis=1), 1e-300)
    return off.max(axis=1) * np.abs(cosine)


def part(patch: Planar, bends: Bends, corners: np.ndarray, points_of: np.ndarray) -> int:
    """Insert points in the triangles that meet facets of the surface; return how many there were.

    corners (m, 3, 3): of the surface's facets; points_of (m, 3): the patch's points there, or -1.
    """
    rows = _meeting(patch, bends, corners, points_of)
    if len(rows) and not _insert(patch, bends, rows, TIGHTEST * bends.least):
        return 0
    refuse_full(patch)
    return len(rows)


def _meeting(patch: Planar, bends: Bends, corners: np.ndarray, points_of: np.ndarray) -> np.ndarray:
    """Return the rows of triangles that meet a facet in more than corners and edges they share."""
    points = places(patch, bends)
    own = points[patch.triangles]
    low, high = own.min(axis=(0, 1)), own.max(axis=(0, 1))
    near = np.flatnonzero(((corners.min(axis=1) <= high) & (corners.max(axis=1) >= low)).all(axis=1))
    others = points_of[near]
    new = np.flatnonzero(others.ravel() < 0)
    others = others.ravel().copy()
    others[new] = len(points) + np.arange(len(new))
    points = np.concatenate([points, corners[near].reshape(-1, 3)[new]])
    count = len(patch.triangles)
    pairs = intersecting_pairs(points, np.concatenate([patch.triangles, others.reshape(-1, 3)]))
    pairs = pairs[(pairs[:, 0] < count) & (pairs[:, 1] >= count)]
    rows = np.unique(pairs[:, 0])
    return rows[~is_among(patch, bends.kept)[rows]]


def _insert(patch: Planar, bends: Bends, rows: np.ndarray, least: float) -> int:
    """Insert circumcentres of the triangles `rows` or, where none fits, the middles of their free edges.

    least: the least distance from other points. Returns how many were inserted.
    """
    if not len(rows):
        return 0
    frozen = is_among(patch, bends.kept)
    centre, radius = circumcircles(patch)
    good = rows[np.isfinite(radius[rows])]
    spacing = np.maximum(SMALLER * radius[good], least)
    inserted = planar.insert_spaced(patch, Candidates(centre[good], good, spacing, CLEAR * spacing), frozen)
    if inserted:
        return inserted
    corner = patch.uv[patch.triangles[rows]]
    edge = np.roll(corner, -1, axis=1) - corner
    length = np.where(patch.fixed[rows], -1.0, np.linalg.norm(edge, axis=2))
    side = length.argmax(axis=1)
    row = np.arange(len(rows))
    free = length[row, side] > 0
    middle = (corner + edge / 2)[row, side][free]
    spacing = np.full(len(middle), least)
    return planar.insert_spaced(patch, Candidates(middle, rows[free], spacing, CLEAR * spacing), frozen)
