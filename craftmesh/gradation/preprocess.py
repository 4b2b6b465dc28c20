"""Preprocessing of the input surface (paper, section 2.2): unnecessary nodes and sawtooth junctions."""

from dataclasses import replace

import numpy as np

from craftmesh.surface.classification import Classification
from craftmesh.surface.connectivity import compact
from craftmesh.surface.guarded_move import MoveBounds, guarded_move
from craftmesh.surface.kernels.corner_lists import corner_lists
from craftmesh.surface.kernels.hinges import SHARP_COSINE, sharpest_cosines
from craftmesh.surface.kernels.ranks import ON_LINE
from craftmesh.surface.measure import area_vectors
from craftmesh.surface.patches import oriented, patches
from craftmesh.surface.rounding import ROUNDING
from craftmesh.types import CRACK, Surface

# Cosine of the largest angle at which crack facets count as in one plane. A lid is the facet that replaces
# the three facets of a removed node. On a curved crack the lid would be off the crack by the node's height
# over the lid. The guards would not see this, because the surface with lids is their input.
IN_PLANE = 1.0 - ROUNDING


def remove_unnecessary_nodes(surface: Surface, normal_tolerance: float = 40.0) -> tuple[Surface, int]:
    """Return the surface without unnecessary nodes, and their number.

    An unnecessary node has exactly three facets, all of one patch; one facet replaces them. The normals may
    turn by at most `normal_tolerance` degrees (on the crack by none). The new facet must not exist already,
    and its edges must not get a sharp dihedral angle that is sharper than before.
    """
    candidates = np.flatnonzero(np.bincount(surface.facets.ravel(), minlength=len(surface.points)) == 3)
    if not len(candidates):
        return surface, 0
    cosine = np.where(surface.kind == CRACK, IN_PLANE, np.cos(np.radians(normal_tolerance)))
    facets, sides = oriented(surface)
    facets = facets.astype(np.int64)
    patch = patches(surface).of_facet
    while True:
        lidded, alive, rows = _with_lids(surface.points, facets, patch, candidates, cosine)
        sharp = _sharpened(surface.points, facets, lidded, alive, rows)
        if not len(sharp):
            break
        candidates = np.setdiff1d(candidates, sharp)
    points, lidded, _ = compact(surface.points, lidded[alive])
    return Surface(points, lidded, sides[alive], surface.kind[alive]), len(rows)


def _with_lids(
    points: np.ndarray, facets: np.ndarray, patch: np.ndarray, candidates: np.ndarray, cosine: np.ndarray
) -> tuple[np.ndarray, np.ndarray, dict[int, np.ndarray]]:
    """Return facets (m, 3) with lids, a mask (m,) of remaining facets, and a dict of rows.

    The dict maps each removed vertex to the rows (3,) of its facets; the first of these rows now has the
    lid. candidates (c,): vertices with three facets each. cosine (m,): cosine of each facet's largest turn.
    """
    at = _facets_at(facets, candidates, len(points))
    present = {tuple(f) for f in np.sort(facets[_facets_at(facets, facets[at], len(points))], axis=1)}
    corners = facets[at].ravel()
    order = np.argsort(corners, kind="stable")
    start = np.searchsorted(corners[order], candidates)
    facets, alive, rows = facets.copy(), np.ones(len(facets), bool), {}
    for v, first in zip(candidates.tolist(), start.tolist()):
        three = at[order[first : first + 3] // 3]
        new = _lid(points, facets, patch, alive, three, v, present, cosine)
        if new is not None:
            facets[three[0]] = new
            alive[three[1:]] = False
            rows[v] = three
    return facets, alive, rows


def _facets_at(facets: np.ndarray, vertices: np.ndarray, count: int) -> np.ndarray:
    """Return the rows of facets (m, 3) with a corner in `vertices`; count: number of all vertices."""
    chosen = np.zeros(count, bool)
    chosen[vertices] = True
    a, b, c = facets.T
    return np.flatnonzero(chosen[a] | chosen[b] | chosen[c])


def _sharpened(
    points: np.ndarray,
    before: np.ndarray,
    facets: np.ndarray,
    alive: np.ndarray,
    rows: dict[int, np.ndarray],
) -> np.ndarray:
    """Return ids of vertices whose lid makes a dihedral angle sharper than SHARP_WEDGE and than before.

    before, facets (m, 3): without and with lids; alive, rows: from `_with_lids`.
    """
    if not rows:
        return np.zeros(0, np.int64)
    old, new = _sharpest(points, before, np.ones(len(before), bool)), _sharpest(points, facets, alive)
    sharp = [new[three[0]] > max(SHARP_COSINE, old[three].max()) for three in rows.values()]
    return np.array(list(rows))[sharp]


def _sharpest(points: np.ndarray, facets: np.ndarray, alive: np.ndarray) -> np.ndarray:
    """Return the cosine (m,) of the sharpest dihedral angle at each living facet's edges; -1 if dead."""
    cosines = np.full(len(facets), -1.0)
    living = facets[alive]
    cosines[alive] = sharpest_cosines(points, living, *corner_lists(living, len(points)))
    return cosines


def _lid(
    points: np.ndarray,
    facets: np.ndarray,
    patch: np.ndarray,
    alive: np.ndarray,
    three: np.ndarray,
    v: int,
    present: set[tuple],
    cosine: np.ndarray,
) -> np.ndarray | None:
    """Return the corners (3,) of the facet that can replace the facets `three` around `v`, or None.

    Adds the new facet to `present`, the sorted corners of facets that exist already.
    """
    if not alive[three].all() or len(set(patch[three])) > 1 or (facets[three] == v).sum() != 3:
        return None
    turned = [np.roll(facets[f], -int(np.flatnonzero(facets[f] == v)[0])) for f in three]
    following = {int(t[1]): int(t[2]) for t in turned}
    a = int(turned[0][1])
    b = following.get(a, -1)
    c = following.get(b, -1)
    if len(following) != 3 or following.get(c, -1) != a:
        return None
    new = np.array([a, b, c])
    if tuple(np.sort(new)) in present:
        return None
    normal = area_vectors(points, new[None])[0]
    old = area_vectors(points, facets[three])
    least = cosine[three] * np.linalg.norm(normal) * np.linalg.norm(old, axis=1)
    if (old @ normal <= 0).any() or (old @ normal < least).any():
        return None
    present.add(tuple(np.sort(new)))
    return new


def smooth_junctions(surface: Surface, iterations: int) -> tuple[Surface, int]:
    """Return the surface with smoothed junction lines, and the number of moved nodes.

    In each of the `iterations` a node moves to half its own position plus a quarter of the position of each
    of its two neighbours on the line (Eq. 1 of the paper). Nodes on a box face move within the face. Nodes
    on the crack, on box edges and at junction points stay. Moves that break `MoveBounds` are undone and not
    counted.
    """
    if not iterations:
        return surface, 0
    nodes, before, after = _line_neighbours(surface)
    targets = surface.points.copy()
    for _ in range(int(iterations)):
        targets[nodes] = 0.25 * (targets[before] + targets[after]) + 0.5 * targets[nodes]
    points, _ = guarded_move(surface, targets, MoveBounds())
    return replace(surface, points=points), int((points != surface.points).any(axis=1).sum())


def _line_neighbours(surface: Surface) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return ids (k,) of movable junction-line vertices, and ids (k,) of each of their two neighbours."""
    classes = Classification(surface)
    lines, planes = classes.features.lines, classes.planes
    both = np.concatenate([lines, lines[:, ::-1]])
    both = both[np.lexsort((both[:, 1], both[:, 0]))]
    free = (classes.rank == ON_LINE) & ~classes.on_crack & (classes.held.sum(axis=1) < 2)
    rows = both[free[both[:, 0]]].reshape(-1, 2, 2)
    node, ends = rows[:, 0, 0], rows[:, :, 1]
    same_plane = ((planes[ends] & planes[node][:, None]) == planes[node][:, None]).all(1)
    return node[same_plane], ends[same_plane, 0], ends[same_plane, 1]
