"""Trace edges between two front points: the front's own where they run along it, else split."""

import numpy as np

from craftmesh.cracks.promises import FRONT_EDGES
from craftmesh.insertion.cut import (
    CutSurface,
    SizeAt,
    flat_facets,
    split_edges,
    trace_edges,
    with_phi,
)
from craftmesh.insertion.front_chain import sagitta, stretches
from craftmesh.insertion.guarded_move import settled
from craftmesh.insertion.options import InsertOptions
from craftmesh.insertion.pierce import with_front_points
from craftmesh.insertion.sheet import Sheet
from craftmesh.surface.front import among_edges
from craftmesh.surface.measure import edge_lengths

ALONG = 0.1  # of its length: a trace edge this near the front runs along it
ALONG_FLAT = 0.5  # the same for an edge of facets that lie in the crack: the front has to bound them
ROUNDS = 10  # of halving edges along the front; each takes three quarters of what they are off it
# Of such an edge's stretch of the front: it is split at a corner of the front this far off its ends, and
# not at its middle, which would leave a needle beside the corner.
INNER = 0.1
# Of the target size: such an edge that is longer is split, too, as those that are made are rounded.
LONGEST = 1.5


def inside_traces(surface: CutSurface) -> tuple[np.ndarray, np.ndarray]:
    """Return trace edges inside the front, and those that join two points of the front."""
    edges = trace_edges(surface)
    phi = surface.phi[edges]
    chords = edges[(phi == 0).all(axis=1)]
    return edges[(phi >= 0).all(axis=1) & (phi > 0).any(axis=1)], chords


def settle_chords(
    surface: CutSurface, sheet: Sheet, target: SizeAt, options: InsertOptions
) -> tuple[CutSurface, np.ndarray]:
    """Split trace edges that join two front points but are not the front's; return those that are (k, 2).

    A trace edge between neighbouring front points, close to the front, is the front's edge. Where it leaves
    that by more than FRONT_EDGES, or is longer than LONGEST, it is split, its middle moved onto the front,
    and the boundary with it.
    """
    for _ in range(ROUNDS):
        _, chords = inside_traces(surface)
        if not len(chords):
            return surface, chords
        middle = (surface.points[chords[:, 0]] + surface.points[chords[:, 1]]) / 2
        phi, length = sheet.rim.inside(sheet.uv(middle)), edge_lengths(surface.points, chords)
        near = (
            np.where(among_edges(chords, surface.facets[flat_facets(surface)]), ALONG_FLAT, ALONG) * length
        )
        along = _neighbours(surface, sheet, chords) & (np.abs(phi) <= near)
        bent = along.copy()
        bent[along] = _is_coarse(surface, sheet, chords[along], target)
        across = ~along & (phi > 0)
        if not (bent | across).any():
            return surface, chords[along]
        surface = _split(surface, sheet, (chords[bent], chords[across]), options)
    return surface, chords[along & ~bent]


def _is_coarse(surface: CutSurface, sheet: Sheet, chords: np.ndarray, target: SizeAt) -> np.ndarray:
    """Tell which edges between neighbouring front points are too long, leave the front, or cut a corner."""
    off = np.zeros(len(chords), bool)
    front, start, end = stretches(surface, sheet, chords)
    for number in np.unique(front).tolist():
        mine = np.flatnonzero(front == number)
        size = target(surface.points[chords[mine]].mean(axis=1))
        stretch = start[mine], end[mine]
        most = np.maximum(sagitta(sheet, number, *stretch), _corners_off(sheet, number, *stretch))
        off[mine] = (most > FRONT_EDGES * size) | (
            edge_lengths(surface.points, chords[mine]) > LONGEST * size
        )
    return off


def _corners_off(sheet: Sheet, front: int, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return how far (n,) corners of a front are from the chords that cut them off, 0 without one."""
    most = np.zeros(len(start))
    for corner in sheet.rim.corners_ahead(front).tolist():
        cut = np.flatnonzero((start < corner) & (corner < end))
        arcs = np.concatenate([start[cut], end[cut], [corner]])
        at = sheet.lift(sheet.rim.on_front(front, arcs))
        a, b, place = at[: len(cut)], at[len(cut) : -1], at[-1]
        step = (b - a) / np.linalg.norm(b - a, axis=1, keepdims=True)
        most[cut] = np.maximum(most[cut], np.linalg.norm(np.cross(step, place - a), axis=1))
    return most


def _split(
    surface: CutSurface,
    sheet: Sheet,
    chords: tuple[np.ndarray, np.ndarray],
    options: InsertOptions,
) -> CutSurface:
    """Split edges along the front (k, 2), whose middles move onto it, and edges across the crack (j, 2).

    A middle that may not move is no front point, but where the front has to bound flat facets.
    """
    bent, across = chords
    flat = among_edges(bent, surface.facets[flat_facets(surface)])
    front, start, end = stretches(surface, sheet, bent)
    places = np.empty((len(bent), 3))
    for number in np.unique(front).tolist():
        mine = front == number
        arcs = _inner_arcs(sheet, number, start[mine], end[mine])
        places[mine] = sheet.lift(sheet.rim.on_front(number, arcs))
    edges = np.concatenate(chords)
    first, size = len(surface.points), surface.size[edges].mean(axis=1)
    middles = surface.points[edges].mean(axis=1)
    surface = with_phi(split_edges(surface, edges, middles, size), sheet)
    halves = np.arange(first, first + len(bent))
    surface, left = settled(surface, halves, places, options)
    return with_front_points(surface, sheet, halves[flat | ~np.isin(halves, left)])


def _inner_arcs(sheet: Sheet, front: int, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return arc lengths (k,) to split stretches of a front at: corners well inside, else the middles."""
    middle, arcs = (start + end) / 2, (start + end) / 2
    reach = (0.5 - INNER) * (end - start)
    for corner in sheet.rim.corners_ahead(front).tolist():
        nearer = np.abs(corner - middle) < reach
        arcs[nearer], reach[nearer] = corner, np.abs(corner - middle)[nearer]
    return arcs


def _neighbours(surface: CutSurface, sheet: Sheet, chords: np.ndarray) -> np.ndarray:
    """Tell which chords join front points that follow each other along one front."""
    on = np.flatnonzero(surface.front >= 0)
    on = on[np.lexsort([surface.arc[on], surface.front[on]])]
    following = np.roll(on, -1)
    front = surface.front[on]
    last = np.flatnonzero(front != np.roll(front, -1))
    for i in last.tolist():
        following[i] = on[np.flatnonzero(front == front[i])[0]] if sheet.rim.curves[front[i]].closed else -1
    if len(on) and not len(last) and not sheet.rim.curves[front[0]].closed:
        following[-1] = -1
    stride = len(surface.points) + 1
    known = np.minimum(on, following) * stride + np.maximum(on, following)
    return np.isin(chords[:, 0] * stride + chords[:, 1], known)
