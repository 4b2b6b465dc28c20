"""Points for a patch of a curved crack: where it bends, and where its facets would meet the boundaries."""

from typing import NamedTuple

import numpy as np

from craftmesh.insertion.creases import Creases, creases_of
from craftmesh.insertion.kernels import planar
from craftmesh.insertion.kernels.planar import Candidates, Planar
from craftmesh.insertion.kernels.planar_smoothing import move_in_plane
from craftmesh.insertion.patch import circumcircles, is_among, refuse_full, smooth_points, triangles_around
from craftmesh.insertion.sheet import Sheet
from craftmesh.surface.kernels.triangle_pairs import intersecting_pairs
from craftmesh.surface.measure import area_vectors

OFF = 0.04  # of the least length: facets farther off the crack get a point; 0.05 is promised
SMALLEST = 0.35  # of the least length: no facet gets a point nearer than this to its corners
TIGHTEST = 0.12  # of the least length: the same where facets would meet a grain boundary
CLEAR = 0.5  # of that distance: how far the point stays off fixed edges
SMALLER = 0.75  # a facet that is too far off gets a point at this share of its circumradius from others
NEAR_CREASE = 0.6  # of a facet's circumradius: a crease nearer to its centre gets the point
TO_CREASE = 0.4  # of the edges around it: a point nearer to a crease moves onto it
GOOD = 0.4  # the least shape of a facet that such moves and flips may leave: 20 degrees
FLIPS = 8  # rounds of flips at most
LEAST_GAIN = 0.005  # of the least length: a flip has to bring its facets nearer to the crack by this much
LAPS = 3  # of points, moves onto creases and flips
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
    """Insert points until no facet of the patch is farther than OFF from the crack, if not too small.

    Then points near a crease move onto it, and edges are flipped where that brings facets nearer.
    """
    creases = creases_of(bends.sheet)
    for lap in range(LAPS):
        first = patch.used[0].copy()
        for _ in range(ROUNDS):
            off = distances_off(patch, bends)
            rows = np.flatnonzero(off > OFF * bends.least)
            rows = rows[np.argsort(-off[rows], kind="stable")]
            on_crease = _insert_on(patch, bends, rows, creases)
            if not on_crease and not _insert(patch, bends, rows, SMALLEST * bends.least):
                break
        refuse_full(patch)
        if lap == 0:
            smooth_points(patch, np.arange(first, patch.used[0]))
            planar.legalise_all(patch)
        _onto_creases(patch, bends, creases)
        _flip_nearer(patch, bends)


def _insert_on(patch: Planar, bends: Bends, rows: np.ndarray, creases: Creases) -> int:
    """Insert the places of creases next to the centres of the triangles `rows`; return how many."""
    centre = patch.uv[patch.triangles[rows]].mean(axis=1)
    feet = creases.feet(centre)
    _, radius = circumcircles(patch)
    near = np.linalg.norm(feet - centre, axis=1) < NEAR_CREASE * radius[rows]
    rows, feet = rows[near], feet[near]
    spacing = np.maximum(NEAR_CREASE * radius[rows], SMALLEST * bends.least)
    candidates = Candidates(feet, rows, spacing, CLEAR * spacing)
    return planar.insert_spaced(patch, candidates, is_among(patch, bends.kept))


def _onto_creases(patch: Planar, bends: Bends, creases: Creases) -> None:
    """Move inner points of facets that are off the crack onto creases near by, where shapes stay good."""
    bad = np.unique(patch.triangles[distances_off(patch, bends) > OFF * bends.least])
    movable = bad[bad >= len(bends.known)]
    targets = creases.feet(patch.uv[movable])
    corner = patch.uv[patch.triangles]
    length = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2).mean(axis=1)
    start, owner = triangles_around(patch)
    reach = np.full(len(patch.uv), np.inf)
    np.minimum.at(reach, patch.triangles, length[:, None])
    near = np.linalg.norm(targets - patch.uv[movable], axis=1) < TO_CREASE * reach[movable]
    move_in_plane(patch.uv, patch.corners, start, owner, movable[near], targets[near], GOOD)


def _flip_nearer(patch: Planar, bends: Bends) -> None:
    """Flip free edges of facets that are off the crack where the other diagonal is nearer to it."""
    for _ in range(FLIPS):
        off = distances_off(patch, bends)
        t, i = np.nonzero((off > OFF * bends.least)[:, None] & ~patch.fixed[: patch.used[1]])
        u = patch.across[t, i]
        once = (off[u] < off[t]) | ((off[u] == off[t]) & (t < u))
        t, i, u = t[once], i[once], u[once]
        a, b, c = (patch.corners[t, (i + k) % 3] for k in range(3))
        d = patch.triangles[u].sum(axis=1) - a - b
        pairs = np.stack([np.stack([a, d, c], axis=1), np.stack([d, b, c], axis=1)], axis=1)
        good = _shapes(patch.uv[pairs]).min(axis=1) > GOOD
        t, i, u, pairs = t[good], i[good], u[good], pairs[good]
        gain = np.maximum(off[t], off[u]) - _off(pairs.reshape(-1, 3), patch, bends).reshape(-1, 2).max(
            axis=1
        )
        taken = np.zeros(patch.used[1], bool)
        flipped = 0
        for k in np.argsort(-gain, kind="stable").tolist():
            if gain[k] > LEAST_GAIN * bends.least and not taken[t[k]] and not taken[u[k]]:
                planar.flip(patch, t[k], i[k])
                taken[[t[k], u[k]]] = True
                flipped += 1
        if not flipped:
            return


def _shapes(corners: np.ndarray) -> np.ndarray:
    """Return 4 sqrt(3) area over the sum of the squared edges of triangles (..., 3, 2); 1 for even ones."""
    edge = np.roll(corners, -1, axis=-2) - corners
    area = edge[..., 0, 0] * edge[..., 1, 1] - edge[..., 0, 1] * edge[..., 1, 0]
    return 2 * np.sqrt(3) * area / (edge**2).sum(axis=(-1, -2))


def distances_off(patch: Planar, bends: Bends) -> np.ndarray:
    """Return how far the triangles (t,) are off the crack, at centres and the middles of free edges."""
    return _off(patch.triangles, patch, bends, patch.fixed[: patch.used[1]])


def _off(triangles: np.ndarray, patch: Planar, bends: Bends, fixed: np.ndarray | None = None) -> np.ndarray:
    """Return how far triangles (k, 3) are off the crack; fixed (k, 3): edges that are left out."""
    points = places(patch, bends)
    corners = points[triangles]
    middles = ((corners[:, i] + corners[:, i - 2]) / 2 for i in range(3))
    samples = np.stack([corners.mean(axis=1), *middles], axis=1)
    off = np.abs(bends.sheet.offset(samples.reshape(-1, 3))).reshape(-1, 4)
    if fixed is not None:
        off[:, 1:][fixed] = 0.0
    vectors = area_vectors(points, triangles)
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
