"""Intergranular cracks: the boundaries between chosen grains of a surface, cut off at a sphere."""

import numpy as np

from craftmesh.cracks.one_sheet import turned_alike
from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.prescription import boundary_pairs, is_sized, semi_axes, vector
from craftmesh.errors import CraftmeshError
from craftmesh.surface.connectivity import compact, unique_edges
from craftmesh.surface.facet_subdivision import divided_at
from craftmesh.surface.front import among_edges
from craftmesh.types import INTERFACE, Crack, Surface


def crack_in_boundaries(surface: Surface, options: CrackOptions, increment: int) -> Crack:
    """Return the crack along options.boundaries of the surface, within the sphere of an increment.

    Without a radius, whole boundaries crack. Where the sphere crosses a facet's edge, the crack gets a
    point exactly there; nearer than a tenth of the edge to an end, the crack ends at that end instead. The
    crack may branch at triple lines. Its facets are oriented consistently if possible, else from the lower
    to the higher grain id. Fronts consist of edges with one crack facet, within the material; they are
    split at points without exactly two such edges. Raise CraftmeshError if grains do not touch or the
    sphere misses their boundaries.
    """
    facets, sides = _chosen(surface, boundary_pairs(options))
    turned = sides[:, 0] > sides[:, 1]
    facets = np.where(turned[:, None], facets[:, ::-1], facets)
    points, ends = surface.points, np.zeros((0, 2), np.int64)
    if is_sized(options):
        centre = vector("centre", options.centre)
        points, facets, ends = _within(points, facets, centre, semi_axes(options, increment)[0])
    if not len(facets):
        raise CraftmeshError(
            f"crack.centre {list(options.centre or ())}: its sphere contains no part of the boundaries "
            f"{' '.join(options.boundaries or ())}; move it or enlarge the radius"
        )
    try:
        facets = turned_alike(points, facets)
    except CraftmeshError:  # the boundaries form a one-sided ring, a Moebius strip
        pass
    fronts = _fronts(facets, surface, ends)
    points, triangles, kept = compact(points, facets)
    return Crack(points, triangles, tuple(np.searchsorted(kept, front) for front in fronts))


def _chosen(surface: Surface, pairs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the facets (m, 3) between the pairs of grains (k, 2), and their sides (m, 2)."""
    known = np.sort(surface.sides, axis=1)
    inner = (surface.kind == INTERFACE) & (known[:, 0] > 0)
    chosen = np.zeros(len(known), bool)
    for low, high in pairs.tolist():
        own = inner & (known == [low, high]).all(axis=1)
        if not own.any():
            others = np.unique(known[inner & (known == low).any(axis=1)])
            told = ", ".join(map(str, others[others != low].tolist())) or "no other"
            raise CraftmeshError(
                f"crack.boundaries has {low}-{high}, grains that do not touch; grain {low} touches {told}"
            )
        chosen |= own
    return surface.facets[chosen].astype(np.int64), surface.sides[chosen]


def _within(
    points: np.ndarray, facets: np.ndarray, centre: np.ndarray, radius: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points (n, 3), new ones last, facets (m, 3) in a sphere, and ends (k, 2) of split edges.

    An edge that the sphere crosses close to an end is not split: the crack ends at that end (`divided_at`).
    A facet with two corners inside leaves a quadrangle, which its shorter diagonal splits.
    """
    side = np.sign(radius - np.linalg.norm(points - centre, axis=1))
    edges, _, _ = unique_edges(facets)
    share = _shares(points[edges], side[edges], centre, radius)
    split = divided_at(points, facets, side, edges, share)
    side = split.side[split.facets]
    kept = (side >= 0).all(axis=1) & (side > 0).any(axis=1)
    return split.points, split.facets[kept], split.ends


def _shares(ends: np.ndarray, side: np.ndarray, centre: np.ndarray, radius: float) -> np.ndarray:
    """Return positions (k,), from 0 to 1, where edges (k, 2, 3) cross a sphere; NaN without a crossing."""
    share = np.full(len(ends), np.nan)
    rows = np.flatnonzero(side[:, 0] != side[:, 1])
    share[rows] = _crossing(ends[rows, 0] - centre, ends[rows, 1] - ends[rows, 0], radius)
    return share


def _crossing(start: np.ndarray, step: np.ndarray, radius: float) -> np.ndarray:
    """Return positions (k,), from 0 to 1, where segments with one end in a sphere about 0 leave it."""
    a, b = (step**2).sum(axis=1), (start * step).sum(axis=1)
    c = (start**2).sum(axis=1) - radius**2
    root = np.sqrt(np.maximum(b**2 - a * c, 0))
    return np.clip(np.where(c < 0, root - b, -root - b) / a, 0, 1)


def _fronts(triangles: np.ndarray, surface: Surface, ends: np.ndarray) -> list[np.ndarray]:
    """Return the fronts as polylines of ids: edges of one triangle that are not edges of free facets.

    ends (k, 2): end points of the surface edges that the points after the surface's own ones split.
    """
    edges, _, count = unique_edges(triangles)
    rim = edges[count == 1]
    known = len(surface.points)
    whole = rim.copy()  # a part of a split surface edge is replaced by the whole edge
    parted = np.flatnonzero((rim[:, 1] >= known) & (rim[:, 0] < known))
    of_edge = ends[rim[parted, 1] - known]
    along = (of_edge == rim[parted, :1]).any(axis=1)
    whole[parted[along]] = of_edge[along]
    free = surface.facets[(surface.sides <= 0).any(axis=1)]
    return _chains(rim[~among_edges(whole, free)])


def _chains(edges: np.ndarray) -> list[np.ndarray]:
    """Return edges (k, 2) as polylines of ids, split at points that have not exactly two edges.

    A closed line repeats its first id.
    """
    beside: dict[int, list[int]] = {}
    for a, b in edges.tolist():
        beside.setdefault(a, []).append(b)
        beside.setdefault(b, []).append(a)
    joints = [node for node in sorted(beside) if len(beside[node]) != 2]
    lines = []
    for start in [*joints, *sorted(set(beside) - set(joints))]:
        while beside[start]:
            line = [start]
            while len(line) == 1 or (line[-1] not in joints and line[-1] != start):
                following = beside[line[-1]].pop(0)
                beside[following].remove(line[-1])
                line.append(following)
            lines.append(np.array(line))
    return lines
