"""A crack in its microstructure, before anything is meshed: what it meets, and a picture of it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from craftmesh.cracks.meetings import Oblique, Traces
from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.front import front_edges
from craftmesh.surface.measure import area_vectors
from craftmesh.surface.patches import is_on_box
from craftmesh.types import BOX_PLANES, CRACK, Crack, Surface


@dataclass(frozen=True, eq=False)
class Preview:
    """What a crack meets.

    crack, and traces on the surface's facets; inserted: the surface with the crack in it, None where that
    was refused, for the reason `refused`; grains: ids that it meets; area, front_length: by grain, empty
    where it was refused; fronts: (closed?, length, faces of its ends); oblique: boundaries met at less
    than a limit.
    """

    crack: Crack
    box: np.ndarray
    traces: Traces
    inserted: Surface | None
    refused: str
    grains: tuple[int, ...]
    area: dict[int, float]
    front_length: dict[int, float]
    fronts: tuple[tuple[bool, float, tuple[str, ...]], ...]
    oblique: tuple[Oblique, ...]


def met_grains(found: Traces, surface: Surface) -> tuple[int, ...]:
    """Return the grains on both sides of the facets that the crack cuts."""
    ids = np.unique(surface.sides[found.facet])
    return tuple(ids[ids > 0].tolist())


def grain_measures(surface: Surface) -> tuple[dict[int, float], dict[int, float]]:
    """Return the area of the crack and the length of its front in each grain that it is in.

    A facet or an edge between two grains counts half for each.
    """
    crack = surface.kind == CRACK
    sides, facets = surface.sides[crack], surface.facets[crack]
    area = np.linalg.norm(area_vectors(surface.points, facets), axis=1)
    edges, of_corner, _ = unique_edges(facets)
    is_front = np.isin(_keys(edges), _keys(front_edges(surface)))
    length = np.linalg.norm(surface.points[edges[:, 1]] - surface.points[edges[:, 0]], axis=1)
    along = np.where(is_front[of_corner], length[of_corner], 0.0).sum(axis=1)
    return tuple(
        {int(g): float((values[:, None] * (sides == g) / 2).sum()) for g in np.unique(sides[sides > 0])}
        for values in (area, along)
    )  # type: ignore[return-value]


def front_lines(surface: Surface) -> tuple[tuple[bool, float, tuple[str, ...]], ...]:
    """Return, for each front of the crack in a surface: closed or not, its length, where its ends lie."""
    edges = front_edges(surface)
    if not len(edges):
        return ()
    nodes, local = np.unique(edges, return_inverse=True)
    local = local.reshape(-1, 2)
    graph = coo_array((np.ones(len(edges)), tuple(local.T)), shape=(len(nodes),) * 2)
    count, piece = connected_components(graph, directed=False)
    degree = np.bincount(local.ravel())
    length = np.linalg.norm(surface.points[edges[:, 1]] - surface.points[edges[:, 0]], axis=1)
    fronts = []
    for number in range(count):
        ends = nodes[(piece == number) & (degree == 1)]
        own = piece[local[:, 0]] == number
        fronts.append((not len(ends), float(length[own].sum()), tuple(map(_face(surface), ends.tolist()))))
    return tuple(fronts)


def _face(surface: Surface) -> Callable[[int], str]:
    """Return what names the free faces that a point lies on: XMIN, XMIN_ZMAX, VOID_3, EXTERIOR."""

    def name(point: int) -> str:
        at = (surface.facets == point).any(axis=1)
        kinds = np.unique(surface.kind[at & is_on_box(surface.kind)])
        names = [BOX_PLANES[kind - 1] for kind in kinds.tolist()]
        open_sides = surface.sides[at & (surface.kind == 0)]
        names += [f"VOID_{-label}" for label in np.unique(open_sides[open_sides < 0]).tolist()]
        names += ["EXTERIOR"] if (open_sides == 0).any() else []
        return "_".join(names) or "inside"

    return name


def _keys(edges: np.ndarray) -> np.ndarray:
    return np.sort(edges, axis=1).astype(np.int64) @ np.array([1 << 32, 1])
