"""The edges of the crack front on a cut surface, from one pierce point to the next."""

from dataclasses import dataclass, replace

import numpy as np
import shapely

from craftmesh.cracks.crack_tolerances import FRONT_EDGES
from craftmesh.insertion.cut import CutSurface, SizeAt, trace_edges
from craftmesh.insertion.pierce import END, TOUCHING
from craftmesh.insertion.sheet import Sheet
from craftmesh.surface.measure import along_segments

# Largest angle by which the front turns along one edge, so that a circle has at least six edges.
SHARPEST = np.radians(61.0)
INTERVALS = 256  # steps in which the target size is integrated between two pierce points
CHORDS = 16  # chords over those steps, by which the front's turning is measured
# Shortest length, in target sizes, to which edges are reduced so that they lie within FRONT_EDGES of the
# front; it is enough for a bend radius of 0.8 target sizes.
FINEST = 0.35
# Positions along an edge, 0 to 1, at which the edge must be within FRONT_EDGES of the front; between these
# positions, it then is within PROMISED.front.
SHARES = np.arange(1, 8) / 8


@dataclass(frozen=True, eq=False)
class FrontChain:
    """The front's edges in a cut surface, and its new points.

    edges (k, 3): two point ids, and the number of the interval between pierce points that contains the
    edge. uv (n, 2): parameters of the new points; their ids begin after the last point of the
    surface.
    """

    edges: np.ndarray
    uv: np.ndarray


def chain(
    surface: CutSurface, sheet: Sheet, along: np.ndarray, target: SizeAt, crowd: np.ndarray
) -> FrontChain:
    """Return the front's edges: pierce points in order, and nodes at the target size between them.

    along (k, 2): trace edges that are front edges. target(points) returns edge lengths. crowd (i,): number
    of extra bisections in each interval between pierce points, in the order of fronts and arc lengths.
    """
    taken = set(map(tuple, np.sort(along, axis=1).tolist()))
    edges: list[tuple[int, int, int]] = []
    uv: list[np.ndarray] = []
    interval = 0
    for front, curve in enumerate(sheet.rim.curves):
        nodes = _forced_nodes(surface, sheet, front, along, uv)
        if curve.closed:
            nodes.append((nodes[0][0], nodes[0][1] + sheet.rim.period(front)))
        for (a, start), (b, end) in zip(nodes[:-1], nodes[1:]):
            inner = np.zeros(0)
            if (min(a, b), max(a, b)) not in taken:
                halvings = int(crowd[interval]) if interval < len(crowd) else 0
                inner = _spread(sheet, front, (start, end), target, halvings)
            first = len(surface.points) + len(uv)
            uv.extend(sheet.rim.curves[front].at(inner))
            line = [a, *range(first, first + len(inner)), b]
            edges.extend((p, q, interval) for p, q in zip(line[:-1], line[1:]))
            interval += 1
    return FrontChain(np.array(edges, np.int64).reshape(-1, 3), np.array(uv).reshape(-1, 2))


def _forced_nodes(
    surface: CutSurface, sheet: Sheet, front: int, along: np.ndarray, uv: list[np.ndarray]
) -> list[tuple[int, float]]:
    """Return (id, arc length) of the nodes a front must have: pierce points, ends and corners.

    Pierce points are where traces cross the front. New nodes are appended to `uv`. A corner is not needed
    where a front edge, along (k, 2), cuts it off.
    """
    curve = sheet.rim.curves[front]
    ids = surface.on_front(front)
    known = surface.arc[ids]
    size = np.median(surface.size)
    corners = _not_cut_off(sheet, front, stretches(surface, sheet, along))
    wanted = _apart(sheet, front, corners, known, TOUCHING * size)
    if not curve.closed:
        wanted += _apart(sheet, front, curve.arc[[0, -1]], known, END * size)
    elif not len(wanted) and not len(ids):
        wanted = [0.0]
    new = np.sort(np.array(wanted))
    first = len(surface.points) + len(uv)
    uv.extend(curve.at(new))
    nodes = [*zip(ids.tolist(), known.tolist()), *zip(range(first, first + len(new)), new.tolist())]
    return sorted(nodes, key=lambda node: node[1])


def _not_cut_off(sheet: Sheet, front: int, cut: tuple[np.ndarray, np.ndarray, np.ndarray]) -> np.ndarray:
    """Return arc lengths (k,) of a front's corners that lie inside no stretch of `cut` (`stretches`)."""
    number, start, end = cut
    corners, ahead = sheet.rim.corners(front), sheet.rim.corners_ahead(front)[:, None]
    inside = ((start < ahead) & (ahead < end) & (number == front)).any(axis=1)
    return corners[~inside.reshape(1 + sheet.rim.curves[front].closed, -1).any(axis=0)]


def _apart(sheet: Sheet, front: int, wanted: np.ndarray, known: np.ndarray, near: float) -> list[float]:
    """Return those `wanted` arc lengths along a front that are farther than `near` from all known ones."""
    return wanted[sheet.rim.gaps(front, wanted, known).min(axis=1, initial=np.inf) > near].tolist()


def stretches(
    surface: CutSurface, sheet: Sheet, chords: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return front numbers (k,) of chords (k, 2) between neighbouring front points, and their ends' arcs.

    Start and end arcs (k,) are ascending; on a closed front the end may exceed the front's length.
    """
    front = surface.front[chords[:, 0]]
    start, end = np.sort(surface.arc[chords], axis=1).T
    period = np.array([sheet.rim.period(number) for number in range(len(sheet.rim.curves))])[front]
    around = end - start > period / 2
    return front, np.where(around, end, start), np.where(around, start + period, end)


def _spread(
    sheet: Sheet, front: int, ends: tuple[float, float], target: SizeAt, halvings: int
) -> np.ndarray:
    """Return arc lengths between the two of `ends`, at the target size and closer where the front bends.

    Each edge turns by at most about SHARPEST. The front's turning is measured
    between the middles of chords, so it is scaled up for the half chord at each end. Each of the `halvings`
    doubles the number of edges.
    """
    samples = np.linspace(ends[0], ends[1], INTERVALS + 1)
    places = sheet.lift(sheet.rim.curves[front].at(samples))
    size = target(places)
    bend = _bending(sheet, front, samples, size)
    plain, total = (_summed(density, samples) for density in (1 / size, bend / size))
    uv = sheet.uv(places[:: INTERVALS // CHORDS])
    heading = np.unwrap(np.arctan2(*np.diff(uv, axis=0).T[::-1]))
    turning = np.abs(np.diff(heading)).sum() * CHORDS / (CHORDS - 1)
    bends = int(np.ceil(turning / SHARPEST))
    count = max(1, int(round(plain[-1])), bends)
    while True:
        arcs = np.interp(np.linspace(0, total[-1], count * 2**halvings + 1), total, samples)
        if count * FINEST >= plain[-1] or _is_true(sheet, front, arcs, target):
            return arcs[1:-1]
        count += 1


def _summed(density: np.ndarray, samples: np.ndarray) -> np.ndarray:
    """Return the integral (n,) of a density (n,) from the first sample to each sample."""
    return np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) / 2 * np.diff(samples))])


def _bending(sheet: Sheet, front: int, samples: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Return factors (n,) >= 1 by which edges at arc lengths `samples` must be shorter for FRONT_EDGES."""
    low = np.maximum(samples - size / 2, samples[0])
    high = np.minimum(samples + size / 2, samples[-1])
    off = sagitta(sheet, front, low, high)
    return np.clip(np.sqrt(off / (FRONT_EDGES * size)), 1.0, 1 / FINEST)


def _is_true(sheet: Sheet, front: int, arcs: np.ndarray, target: SizeAt) -> bool:
    """Return whether edges between successive `arcs` (k,) stay within FRONT_EDGES of the curved front.

    FRONT_EDGES is in target sizes.
    """
    off = sagitta(sheet, front, arcs[:-1], arcs[1:])
    middle = sheet.lift(sheet.rim.curves[front].at((arcs[:-1] + arcs[1:]) / 2))
    return bool((off <= FRONT_EDGES * target(middle)).all())


def sagitta(sheet: Sheet, front: int, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return the largest distance (n,) of the front from its chords between arc lengths start and end."""
    a, b = (sheet.lift(sheet.rim.curves[front].at(arc)) for arc in (start, end))
    most = np.zeros(len(start))
    for share in SHARES:
        place = sheet.lift(sheet.rim.curves[front].at(start + share * (end - start)))
        along = along_segments(place, a, b - a)
        most = np.maximum(most, np.linalg.norm(a + along[:, None] * (b - a) - place, axis=1))
    return most


def conflicts(edges: np.ndarray, traces: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """Return the sorted numbers of the intervals in which a front edge crosses a trace edge in (u, v).

    edges (k, 3): two point ids and the number of an interval between pierce points; traces (j, 2); uv (n,
    2): parameters of all points. Edges with a common point do not cross.
    """
    if not len(traces):
        return np.zeros(0, np.int64)
    tree = shapely.STRtree(shapely.linestrings(uv[edges[:, :2]]))
    row, hit = tree.query(shapely.linestrings(uv[traces]), "intersects")
    shared = (edges[hit, :2][:, :, None] == traces[row][:, None, :]).any(axis=(1, 2))
    return np.unique(edges[hit[~shared], 2])


def crossing_at(surface: CutSurface, sheet: Sheet, rows: np.ndarray) -> np.ndarray:
    """Return the ids among `rows` (k,) of points whose trace edges cross other trace edges in (u, v)."""
    traces = trace_edges(surface)
    among = np.isin(traces, rows)
    mine = np.column_stack([traces, np.where(among[:, 1], traces[:, 1], traces[:, 0])])[among.any(axis=1)]
    return conflicts(mine, traces, sheet.uv(surface.points)) if len(mine) else np.zeros(0, np.int64)


def without_loose_ends(front: FrontChain, traces: np.ndarray) -> FrontChain:
    """Return the front without the edges before the first and after the last node that is on a trace.

    traces (k, 2): node pairs of the surface's edges on the crack and inside the front. A closed front, and
    an end that is on a trace, do not change.

    An open front ends on the box. If the body does not reach the box, there is no trace at that end: the
    front beyond its last trace lies in no grain and bounds no part of the crack.
    """
    edges = front.edges
    while len(edges):
        nodes = np.concatenate([edges[:, :2].ravel(), traces.ravel()])
        loose = (np.bincount(nodes) == 1)[edges[:, :2]].any(axis=1)
        if not loose.any():
            break
        edges = edges[~loose]
    return replace(front, edges=edges)
