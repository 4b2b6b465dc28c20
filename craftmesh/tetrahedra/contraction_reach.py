"""How far the surface may go where two of its nodes become one."""

from collections.abc import Iterable

import numpy as np

from craftmesh.cracks.promises import FRONT_MOVED
from craftmesh.surface.kernels.facet_shape import facet_distance2
from craftmesh.surface.measure import area_vectors
from craftmesh.tetrahedra.contraction_rules import Cells, merged
from craftmesh.tetrahedra.stars import Corners, Stars
from craftmesh.tetrahedra.surface_freedom import CRACK_REACH

# Of the mean edge at a node: how far the surface may go from where the node was.
REACH = 0.2
# Degrees: no facet turns by more than the first, but those of less height over their longest edge than the
# sine of the second.
TURN, THIN = 60.0, 15.0


def keeps_surface(stars: Stars, kept: int, gone: int) -> bool:
    """Tell whether the surface stays near to what it is if `gone` becomes `kept`, and turns little.

    Patches are within REACH of where the node was, lines too, those of the crack within CRACK_REACH, or
    FRONT_MOVED where the nodes touch.
    """
    classes, points = stars.classes, stars.points
    after = merged(stars.facets, stars.facets_at, kept, gone)
    crack_reach = max(CRACK_REACH, FRONT_MOVED) if stars.touch(kept, gone) else CRACK_REACH
    old = {f: stars.facets[f] for f in sorted(stars.facets_at[gone])}
    reach = REACH * _mean_edge(stars, gone)
    for patch in sorted({int(classes.patch[f]) for f in old}):
        was, new = (
            [three for f, three in cells.items() if classes.patch[f] == patch] for cells in (old, after)
        )
        is_crack = any(classes.crack[f] for f in old if classes.patch[f] == patch)
        samples = _samples(points, was) if is_crack else points[[gone]]
        limit = crack_reach * classes.crack_length if is_crack else reach
        if _farthest(points, samples, new or [(kept,) * 3]) > limit:
            return False
    if classes.rank[gone]:
        lines = [(kept, node, node) for node in _line_ends(stars, after, kept)]
        if _farthest(points, points[[gone]], [*lines, (kept,) * 3]) > reach:
            return False
    return not _turns(points, old, after)


def _mean_edge(stars: Stars, node: int) -> float:
    others = {other for t in stars.tets_at[node] for other in stars.tets[t]} - {node}
    return float(np.linalg.norm(stars.points[sorted(others)] - stars.points[node], axis=1).mean())


def _samples(points: np.ndarray, facets: list[Corners]) -> np.ndarray:
    """Return the corners, the centres and the middles of the edges of facets."""
    corners = points[np.array(facets, np.int64)]
    middles = (corners + np.roll(corners, -1, axis=1)) / 2
    return np.concatenate([corners, middles, corners.mean(axis=1, keepdims=True)], axis=1).reshape(-1, 3)


def _farthest(points: np.ndarray, samples: np.ndarray, facets: Iterable[Corners]) -> float:
    """Return the largest distance of the samples (k, 3) from the facets."""
    squares = np.full(len(samples), np.inf)
    for row in range(len(samples)):
        for a, b, c in facets:
            squares[row] = facet_distance2(points, a, b, c, samples, row, squares[row])
    return float(np.sqrt(squares.max(initial=0.0)))


def _line_ends(stars: Stars, facets: Cells, node: int) -> list[int]:
    """Return the other ends of the feature edges that the facets have at a node."""
    patches: dict[int, list[int]] = {}
    for f, corners in facets.items():
        for other in corners:
            patches.setdefault(other, []).append(int(stars.classes.patch[f]))
    return [other for other, on in patches.items() if other != node and (len(on) != 2 or len(set(on)) > 1)]


def _turns(points: np.ndarray, old: Cells, after: Cells) -> bool:
    """Tell whether a facet that stays, and is not thin, turns by more than TURN."""
    both = [f for f in old if f in after]
    if not both:
        return False
    was, now = (np.array([cells[f] for f in both], np.int64) for cells in (old, after))
    normals = [area_vectors(points, facets) for facets in (was, now)]
    sizes = [np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny) for normal in normals]
    edge = np.roll(points[was], -1, axis=1) - points[was]
    thick = sizes[0] > np.sin(np.radians(THIN)) * np.einsum("ijk,ijk->ij", edge, edge).max(axis=1)
    cosine = np.einsum("ij,ij->i", *normals) / (sizes[0] * sizes[1])
    return bool((cosine[thick] < np.cos(np.radians(TURN))).any())
