"""Cut the facets of a surface along a crack: split edges that cross it, and all facets at these edges."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from craftmesh.insertion.sheet import Sheet
from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.facet_subdivision import divided
from craftmesh.surface.front import among_edges
from craftmesh.surface.measure import along_segments, edge_lengths
from craftmesh.types import BORDER, Surface

SizeAt = Callable[[np.ndarray], np.ndarray]  # target edge lengths (n,) at points (n, 3)

# Facets are cut too where the crack, extended past its front, would cross them less than this distance plus
# half their longest edge beyond the front; in local sizes.
BEYOND = 0.4
# OFF: largest distance of trace edges and crack facets from the crack; a larger one would cost 0.5 % of the
# crack's area, all that is promised. SHORTEST: shortest edge that a split may leave. Both in smallest
# target lengths.
OFF, SHORTEST = 0.03, 0.15


@dataclass(frozen=True, eq=False)
class CutSurface:
    """A surface while a crack is being cut into it.

    points (n, 3), facets (m, 3), sides (m, 2), kind (m,) as in Surface. psi (n,): signed distance from the
    crack, exactly 0 on it, NaN far from it. phi (n,): of points with psi = 0, distance from the front, > 0
    inside, exactly 0 on it, NaN elsewhere. size (n,): mean edge length around each point before the cut.
    front, arc (n,): front number and arc length of points with phi = 0.
    """

    points: np.ndarray
    facets: np.ndarray
    sides: np.ndarray
    kind: np.ndarray
    psi: np.ndarray
    phi: np.ndarray
    size: np.ndarray
    front: np.ndarray
    arc: np.ndarray

    def on_front(self, number: int) -> np.ndarray:
        """Return the ids of the points on front `number`, sorted by arc length."""
        ids = np.flatnonzero(self.front == number)
        return ids[np.argsort(self.arc[ids], kind="stable")]


def uncut(surface: Surface) -> CutSurface:
    """Return a surface as a CutSurface, with psi and phi NaN (no distance known) and sizes unset."""
    count = len(surface.points)
    psi, phi, size, arc = (np.full(count, np.nan) for _ in range(4))
    return CutSurface(
        surface.points, surface.facets, surface.sides, surface.kind, psi, phi, size, np.full(count, -1), arc
    )


def split_edges(
    surface: CutSurface, edges: np.ndarray, new_points: np.ndarray, size: np.ndarray
) -> CutSurface:
    """Split each edge (k, 2), lower id first, at its row of new_points (k, 3); new ids follow the old ones.

    Every facet at a split edge is subdivided. The new points lie on the crack (psi = 0), at an unknown
    distance from its front (phi), and have the local sizes `size` (k,).
    """
    count = len(surface.points)
    points = np.concatenate([surface.points, new_points])
    facets, parent = divided(points, surface.facets, np.asarray(edges, np.int64), count)
    return _with_points(surface, points, facets, parent, size)


def _with_points(
    surface: CutSurface, points: np.ndarray, facets: np.ndarray, parent: np.ndarray, size: np.ndarray
) -> CutSurface:
    """Return the surface with new facets and further points, which lie on the crack.

    parent (m,): the old facet that each facet is a part of; size (k,): local sizes of the new points.
    """
    extra = len(points) - len(surface.points)
    unknown = np.full(extra, np.nan)
    return CutSurface(
        points=points,
        facets=facets,
        sides=surface.sides[parent],
        kind=surface.kind[parent],
        psi=np.concatenate([surface.psi, np.zeros(extra)]),
        phi=np.concatenate([surface.phi, unknown]),
        size=np.concatenate([surface.size, size]),
        front=np.concatenate([surface.front, np.full(extra, -1)]),
        arc=np.concatenate([surface.arc, unknown]),
    )


def split_facet(surface: CutSurface, row: int, place: np.ndarray) -> CutSurface:
    """Split facet `row` into three at a new point on the crack, `place` (1, 3), whose phi is unknown."""
    new, (a, b, c) = len(surface.points), surface.facets[row]
    facets = surface.facets.copy()
    facets[row] = a, b, new
    facets = np.concatenate([facets, np.array([[b, c, new], [c, a, new]], facets.dtype)])
    parent = np.append(np.arange(len(surface.facets)), [row, row])
    points = np.concatenate([surface.points, place])
    return _with_points(surface, points, facets, parent, surface.size[[a, b, c]].mean(keepdims=True))


def flat_facets(cut: CutSurface) -> np.ndarray:
    """Return the ids of facets with all corners on the crack."""
    return np.flatnonzero((cut.psi[cut.facets] == 0).all(axis=1))


def cut_along(surface: CutSurface, sheet: Sheet) -> CutSurface:
    """Split edges whose ends lie on opposite sides of the crack, in facets that the crack reaches."""
    near = np.flatnonzero(np.isfinite(surface.psi[surface.facets]).all(axis=1))
    edges, of_corner, _ = unique_edges(surface.facets[near])
    psi = surface.psi[edges]
    crossing = np.flatnonzero(np.sign(psi[:, 0]) * np.sign(psi[:, 1]) < 0)
    if not len(crossing):
        return surface
    start, end = surface.points[edges[crossing, 0]], surface.points[edges[crossing, 1]]
    fraction, _ = sheet.crossings(start, end)
    points = start + fraction[:, None] * (end - start)
    phi = np.full(len(edges), -np.inf)
    phi[crossing] = sheet.rim.inside(sheet.uv(points))
    length = edge_lengths(surface.points, edges)
    margin = 0.5 * length[of_corner].max(axis=1) + BEYOND * surface.size[surface.facets[near]].max(axis=1)
    on = np.unique(surface.facets[near])
    on = on[surface.psi[on] == 0]
    at = np.full(len(surface.points), -np.inf)
    at[on] = sheet.rim.inside(sheet.uv(surface.points[on]))
    reached = (phi[of_corner].max(axis=1) > -margin) | (at[surface.facets[near]].max(axis=1) > 0)
    wanted = np.zeros(len(edges), bool)
    wanted[of_corner[reached]] = True
    chosen = wanted[crossing] & ~on_border(surface, edges[crossing])
    size = surface.size[edges[crossing]]
    size = size[:, 0] + fraction * (size[:, 1] - size[:, 0])
    return split_edges(surface, edges[crossing[chosen]], points[chosen], size[chosen])


def on_border(surface: CutSurface, edges: np.ndarray) -> np.ndarray:
    """Return a mask (k,) of edges (k, 2) of border facets, where a part was cut out of a mesh.

    The crack does not split these.
    """
    return among_edges(edges, surface.facets[surface.kind == BORDER])


def trace_edges(surface: CutSurface) -> np.ndarray:
    """Return the edges (k, 2) of facets with both ends on the crack (psi = 0)."""
    on = surface.psi == 0
    rows = np.flatnonzero(on[surface.facets].sum(axis=1) >= 2)
    edges, _, _ = unique_edges(surface.facets[rows])
    return edges[on[edges].all(axis=1)]


def with_phi(surface: CutSurface, sheet: Sheet) -> CutSurface:
    """Return the surface with phi (the distance inside the front) filled in at points on the crack."""
    rows = np.flatnonzero((surface.psi == 0) & np.isnan(surface.phi))
    phi = surface.phi.copy()
    phi[rows] = sheet.rim.inside(sheet.uv(surface.points[rows]))
    return replace(surface, phi=phi)


def feet_on_edges(
    surface: CutSurface, edges: np.ndarray, places: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return distances (k,) of edges (k, 2) from places (k or 1, 3), and their nearest points (k, 3)."""
    start, step = surface.points[edges[:, 0]], surface.points[edges[:, 1]] - surface.points[edges[:, 0]]
    feet = start + along_segments(places, start, step)[:, None] * step
    return np.linalg.norm(places - feet, axis=1), feet
