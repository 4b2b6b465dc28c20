"""How far a surface's points are off the crack: what counts as on it, before anything is cut or moved."""

from dataclasses import replace

import numpy as np

from craftmesh.insertion.cut import CutSurface, uncut
from craftmesh.insertion.sheet import Sheet
from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.patches import held_by_box
from craftmesh.types import Surface

NEAR = 3  # longest edges: only points this near the crack get an offset from it
ON = 1e-9  # of the local size: points this near the crack are on it
# Of the least length: a crack passes through edges of the box from this near. A penny 0 to 0.009 l_min from
# one had 21 flat tets beside its mouth, now none; fronts have to be within 0.02.
AT_EDGE = 0.015
ACROSS = 0.05  # cosine of the angles between the crack's normal and the faces at such an edge


def prepared(surface: Surface, sheet: Sheet, least: float) -> CutSurface:
    """Return the surface with psi near the crack, exactly 0 where a point counts as on it."""
    uv = sheet.uv(surface.points)
    size, longest = local_sizes(surface)
    reach = NEAR * longest
    u0, v0, u1, v1 = sheet.rim.domain.bounds
    height = (surface.points - sheet.origin) @ sheet.frame[2]
    lowest, highest = sheet.height.min() - 2 * reach, sheet.height.max() + 2 * reach
    near = (uv >= [u0 - reach, v0 - reach]).all(axis=1) & (uv <= [u1 + reach, v1 + reach]).all(axis=1)
    rows = np.flatnonzero(near & (height >= lowest) & (height <= highest))
    psi = np.full(len(surface.points), np.nan)
    psi[rows] = sheet.offset(surface.points[rows])
    psi[rows[np.abs(psi[rows]) <= ON * size[rows]]] = 0.0
    psi[_on_passed_edges(surface, sheet, rows, AT_EDGE * least)] = 0.0
    return replace(uncut(surface), psi=psi, size=size)


def _on_passed_edges(surface: Surface, sheet: Sheet, rows: np.ndarray, near: float) -> np.ndarray:
    """Return which of the points `rows` (k,) are on edges of the box that the crack passes this near.

    There it comes from the inside of the box; a crack that cuts off the edge has it on one side.
    """
    held = held_by_box(surface)[rows]
    rows, held = rows[held.sum(axis=1) > 1], held[held.sum(axis=1) > 1]
    points = surface.points[rows]
    gradient = sheet.gradient(points)
    steepness = np.linalg.norm(gradient, axis=1)
    outward = (
        np.where(held, gradient * np.sign(points - surface.box.mean(axis=0)), 0.0) / steepness[:, None]
    )
    passed = (outward.max(axis=1) > ACROSS) & (outward.min(axis=1) < -ACROSS)
    return rows[passed & (np.abs(sheet.offset(points)) <= near * steepness)]


def local_sizes(surface: Surface) -> tuple[np.ndarray, float]:
    """Return the mean length (n,) of the edges at each point, and the longest edge's."""
    edges, _, _ = unique_edges(surface.facets)
    length = np.linalg.norm(surface.points[edges[:, 1]] - surface.points[edges[:, 0]], axis=1)
    return _mean_at_points(edges, length, len(surface.points)), float(length.max())


def _mean_at_points(edges: np.ndarray, values: np.ndarray, count: int) -> np.ndarray:
    total, number = (
        np.bincount(edges[:, 0], weights, count) + np.bincount(edges[:, 1], weights, count)
        for weights in (values, None)
    )
    return total / np.maximum(number, 1)
