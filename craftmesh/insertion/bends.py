"""Points for a patch of a curved crack: where it bends, and where its facets would meet the boundaries."""

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from craftmesh.insertion.cut import OFF
from craftmesh.insertion.kernels import planar
from craftmesh.insertion.kernels.planar import Candidates, Planar
from craftmesh.insertion.patch import circumcircles, is_among, refuse_full
from craftmesh.insertion.sheet import Sheet
from craftmesh.surface.kernels.triangle_pairs import intersecting_pairs
from craftmesh.surface.measure import area_vectors, meets_box

# No new point is nearer to those around it than the first share of the least length and the second of its
# facet's longest edge.
SPACING, APART = 0.25, 0.2
TIGHTEST = 0.12  # of the least length: the same where facets would meet a grain boundary
CLEAR = 0.5  # of that distance: how far the point stays off fixed edges
SMALLER = 0.75  # a facet that meets a boundary gets a point at this share of its circumradius from others
# Of a facet's longest edge: a corner of the given crack nearer to its new point gets the point, which saves
# rough cracks a third of their facets.
NEAR_CORNER = 0.35
# Where a facet's distance from the crack is looked at, by shares of its corners: along each edge, inside
SAMPLES = np.array(
    [(1 - s, s, 0.0) for s in (0.25, 0.5, 0.75)]
    + [(0.0, 1 - s, s) for s in (0.25, 0.5, 0.75)]
    + [(s, 0.0, 1 - s) for s in (0.25, 0.5, 0.75)]
    + [(0.6, 0.2, 0.2), (0.2, 0.6, 0.2), (0.2, 0.2, 0.6), (1 / 3, 1 / 3, 1 / 3)]
)


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


class _Survey:
    """How far the triangles of a patch are off the crack; only what has changed is looked at again."""

    def __init__(self, patch: Planar, bends: Bends) -> None:
        self.patch, self.bends = patch, bends
        self.corners = np.zeros((0, 3), np.int64)
        self.off, self.at = np.zeros(0), np.zeros((0, 2))

    def look(self) -> tuple[np.ndarray, np.ndarray]:
        """Return how far the triangles (t,) are off, fixed edges apart, and where in (u, v) they are so."""
        triangles, known = self.patch.triangles, len(self.corners)
        changed = np.ones(len(triangles), bool)
        changed[:known] = (triangles[:known] != self.corners).any(axis=1)
        rows = np.flatnonzero(changed)
        off = _off(triangles[rows], self.patch, self.bends)
        off[:, :9][np.repeat(self.patch.fixed[rows], 3, axis=1)] = 0.0
        room = len(triangles) - known
        self.off = np.concatenate([self.off, np.zeros(room)])
        self.at = np.concatenate([self.at, np.zeros((room, 2))])
        self.off[rows] = off.max(axis=1)
        self.at[rows] = np.einsum("tk,tkd->td", SAMPLES[off.argmax(axis=1)], self.patch.uv[triangles[rows]])
        self.corners = triangles.copy()
        return self.off, self.at


def follow(patch: Planar, bends: Bends) -> None:
    """Insert points until no facet of the patch is farther than OFF from the crack, if not too small.

    A point goes where its facet is farthest off, or onto a corner of the given crack next to that.
    """
    corners = cKDTree(bends.sheet.nodes)
    survey = _Survey(patch, bends)
    while True:
        off, at = survey.look()
        rows = np.flatnonzero(off > OFF * bends.least)
        if not len(rows):
            return
        rows = rows[np.argsort(-off[rows], kind="stable")]
        triangles = patch.uv[patch.triangles[rows]]
        longest = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2).max(axis=1)
        away, corner = corners.query(at[rows])
        to_corner = (away < NEAR_CORNER * longest)[:, None]
        places = np.where(to_corner, corners.data[corner], at[rows])
        room = np.maximum(SPACING * bends.least, APART * longest)
        wanted = Candidates(places, rows, room, CLEAR * room)
        if not planar.insert_spaced(patch, wanted, is_among(patch, bends.kept)) and not _insert(
            patch, bends, rows, SPACING * bends.least
        ):
            return
        refuse_full(patch)


def _off(triangles: np.ndarray, patch: Planar, bends: Bends) -> np.ndarray:
    """Return how far the triangles (k, 3) are off the crack at the SAMPLES (k, s), along their normals."""
    points = places(patch, bends)
    samples = np.einsum("sk,tkd->tsd", SAMPLES, points[triangles])
    off = np.abs(bends.sheet.offset(samples.reshape(-1, 3))).reshape(-1, len(SAMPLES))
    vectors = area_vectors(points, triangles)
    cosine = vectors @ bends.sheet.frame[2] / np.maximum(np.linalg.norm(vectors, axis=1), 1e-300)
    return off * np.abs(cosine)[:, None]


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
    near = np.flatnonzero(meets_box(corners, np.stack([own.min(axis=(0, 1)), own.max(axis=(0, 1))])))
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
