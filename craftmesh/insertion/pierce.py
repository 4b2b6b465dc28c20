"""The crack front on a cut surface: pierce points on the traces, and front nodes between them."""

from dataclasses import dataclass, replace

import numpy as np
import shapely

from craftmesh.errors import CraftmeshError
from craftmesh.insertion.cut import CutSurface, SizeAt, split_edges, trace_edges, with_phi
from craftmesh.insertion.sheet import Sheet

# Chosen by hand. TOUCHING and END bound how far a node may be off the given front and its end.
ROUNDS = 12  # of splitting, each at the first crossing of every trace edge: no edge may have more
TOUCHING = 1e-3  # of the local size: nearer than this, a trace point, crossing or corner is on the front
AT_END = 1e-9  # of the local size: a crossing this near the end of its edge, off the front, is rounding
SLACK = 1.0001  # an edge shorter than the distances of its ends from the front misses it; and some rounding
ALONG = 0.1  # of its length: a trace edge this near the front replaces it
GRAZING = 0.05  # sine of the angle below which an edge between two front points does not cross the front
SHARPEST = np.radians(60.0)  # a front edge spans at most this much of the front's turning
END = 0.3  # of the size: a pierce point this near the end of a front is its end
CORNER = np.cos(np.radians(20.0))  # front corners sharper than this keep a node
INTERVALS = 256  # even steps in which the target size is summed up between two pierce points
CHORDS = 16  # over those steps, by which the front's turning is measured
ROUND_DOWN = 0.01  # of an edge: a turning just past a multiple of SHARPEST takes no further edge


def pierce(surface: CutSurface, sheet: Sheet) -> CutSurface:
    """Split trace edges where they meet the front; the new points have phi = 0, front number and arc."""
    for _ in range(ROUNDS):
        surface = _touch(with_phi(surface, sheet), sheet)
        edges = trace_edges(surface)
        edges = edges[_may_cross(surface, edges)]
        row, fraction = _first_crossing(surface, sheet, edges)
        if not len(row):
            return surface
        surface = _split_at_front(surface, sheet, edges[row], fraction)
    raise CraftmeshError(
        "a trace crosses the crack front too often; smooth the front or move the crack a little"
    )


def _touch(surface: CutSurface, sheet: Sheet) -> CutSurface:
    """Count trace points that nearly touch the front as on it."""
    with np.errstate(invalid="ignore"):
        rows = np.flatnonzero((surface.front < 0) & (np.abs(surface.phi) <= TOUCHING * surface.size))
    return with_front_points(surface, sheet, rows) if len(rows) else surface


def with_front_points(surface: CutSurface, sheet: Sheet, rows: np.ndarray) -> CutSurface:
    """Return the surface with the points `rows` (k,) counted as on the nearest front; none is moved."""
    _, number, along = sheet.rim.nearest_front(sheet.uv(surface.points[rows]))
    phi, front, arc = surface.phi.copy(), surface.front.copy(), surface.arc.copy()
    phi[rows], front[rows], arc[rows] = 0.0, number, along
    return replace(surface, phi=phi, front=front, arc=arc)


def _lengths(surface: CutSurface, edges: np.ndarray) -> np.ndarray:
    return np.linalg.norm(surface.points[edges[:, 1]] - surface.points[edges[:, 0]], axis=1)


def _may_cross(surface: CutSurface, edges: np.ndarray) -> np.ndarray:
    """Tell which edges are long enough to reach the front from both their ends."""
    phi, length = surface.phi[edges], _lengths(surface, edges)
    return np.abs(phi).sum(axis=1) <= SLACK * length


def _first_crossing(surface: CutSurface, sheet: Sheet, edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows of edges that cross the front and the fraction of the edge of the first crossing."""
    if not len(edges):
        return np.zeros(0, np.int64), np.zeros(0)
    row, fraction, at = _rim_crossings(surface, sheet, edges)
    # on a curved sheet the trace on the box is a chord, so it may pass the end of the front at a distance
    reach = (TOUCHING if sheet.planar else END) * surface.size[edges[row, 0]]
    on_front = np.linalg.norm(sheet.rim.nearest_front(at)[0] - at, axis=1) <= reach
    row, fraction = row[on_front], fraction[on_front]
    order = np.lexsort([fraction, row])
    row, fraction = row[order], fraction[order]
    row, first = np.unique(row, return_index=True)
    return row, fraction[first]


def _rim_crossings(
    surface: CutSurface, sheet: Sheet, edges: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return where edges cross the rim: their rows, the fraction along each, and the place in (u, v).

    Crossings at an end of the edge are left out, and those of edges between two front points that graze it.
    """
    start, end = sheet.uv(surface.points[edges[:, 0]]), sheet.uv(surface.points[edges[:, 1]])
    row, segment = sheet.rim.tree.query(shapely.linestrings(np.stack([start, end], axis=1)), "intersects")
    a, d = start[row], end[row] - start[row]
    b, e = sheet.rim.segments[segment, 0], sheet.rim.segments[segment, 1] - sheet.rim.segments[segment, 0]
    cross = d[:, 0] * e[:, 1] - d[:, 1] * e[:, 0]
    with np.errstate(all="ignore"):
        fraction = ((b - a)[:, 0] * e[:, 1] - (b - a)[:, 1] * e[:, 0]) / cross
    length, is_front = np.linalg.norm(d, axis=1), surface.front[edges[row]] >= 0
    margin = np.where(is_front, TOUCHING, AT_END) * surface.size[edges[row]]
    keep = np.isfinite(fraction) & (fraction * length > margin[:, 0])
    keep &= (1 - fraction) * length > margin[:, 1]
    keep &= ~is_front.all(axis=1) | (np.abs(cross) > GRAZING * length * np.linalg.norm(e, axis=1))
    return row[keep], fraction[keep], a[keep] + fraction[keep, None] * d[keep]


def _split_at_front(
    surface: CutSurface, sheet: Sheet, edges: np.ndarray, fraction: np.ndarray
) -> CutSurface:
    start, end = surface.points[edges[:, 0]], surface.points[edges[:, 1]]
    points = start + fraction[:, None] * (end - start)
    size = surface.size[edges]
    first = len(surface.points)
    surface = split_edges(surface, edges, points, size[:, 0] + fraction * (size[:, 1] - size[:, 0]))
    return with_front_points(surface, sheet, np.arange(first, len(surface.points)))


@dataclass(frozen=True, eq=False)
class FrontChain:
    """Front edges (k, 3): two ids and their interval between pierce points; uv (n, 2) of new ids."""

    edges: np.ndarray
    uv: np.ndarray


def inside_traces(surface: CutSurface) -> tuple[np.ndarray, np.ndarray]:
    """Return trace edges inside the front, and those that join two points of the front."""
    edges = trace_edges(surface)
    phi = surface.phi[edges]
    chords = edges[(phi == 0).all(axis=1)]
    return edges[(phi >= 0).all(axis=1) & (phi > 0).any(axis=1)], chords


def split_chords(surface: CutSurface, sheet: Sheet) -> tuple[CutSurface, np.ndarray]:
    """Split trace edges across the crack between two front points; return those along the front.

    A trace edge between neighbouring front points, close to the front, is taken as the front's edge.
    """
    _, chords = inside_traces(surface)
    if not len(chords):
        return surface, chords
    middle = (surface.points[chords[:, 0]] + surface.points[chords[:, 1]]) / 2
    phi, length = sheet.rim.inside(sheet.uv(middle)), _lengths(surface, chords)
    along = _neighbours(surface, sheet, chords) & (np.abs(phi) <= ALONG * length)
    across = ~along & (phi > 0)
    surface = split_edges(
        surface, chords[across], middle[across], surface.size[chords[across]].mean(axis=1)
    )
    return with_phi(surface, sheet), chords[along]


def _neighbours(surface: CutSurface, sheet: Sheet, chords: np.ndarray) -> np.ndarray:
    """Tell which chords join front points that follow each other along one front."""
    on = np.flatnonzero(surface.front >= 0)
    on = on[np.lexsort([surface.arc[on], surface.front[on]])]
    following = np.roll(on, -1)
    front = surface.front[on]
    last = np.flatnonzero(front != np.roll(front, -1))
    for i in last.tolist():
        following[i] = on[np.flatnonzero(front == front[i])[0]] if sheet.rim.closed[front[i]] else -1
    if len(on) and not len(last) and not sheet.rim.closed[front[0]]:
        following[-1] = -1
    stride = len(surface.points) + 1
    known = np.minimum(on, following) * stride + np.maximum(on, following)
    return np.isin(chords[:, 0] * stride + chords[:, 1], known)


def chain(
    surface: CutSurface, sheet: Sheet, along: np.ndarray, target: SizeAt, crowd: np.ndarray
) -> FrontChain:
    """Return the front's edges: pierce points in order with nodes at the target size between them.

    along (k, 2): trace edges that are front edges. target(points) -> sizes. crowd: extra halvings of
    each interval between pierce points, by position in the order of fronts and arcs.
    """
    taken = set(map(tuple, np.sort(along, axis=1).tolist()))
    edges: list[tuple[int, int, int]] = []
    uv: list[np.ndarray] = []
    interval = 0
    for front, closed in enumerate(sheet.rim.closed):
        nodes = _numbered_nodes(surface, sheet, front, uv)
        if closed:
            nodes.append((nodes[0][0], nodes[0][1] + sheet.rim.curves[front][-1, 2]))
        for (a, start), (b, end) in zip(nodes[:-1], nodes[1:]):
            inner = np.zeros(0)
            if (min(a, b), max(a, b)) not in taken:
                halvings = int(crowd[interval]) if interval < len(crowd) else 0
                inner = _spread(sheet, front, (start, end), target, halvings)
            first = len(surface.points) + len(uv)
            uv.extend(sheet.rim.on_front(front, inner))
            line = [a, *range(first, first + len(inner)), b]
            edges.extend((p, q, interval) for p, q in zip(line[:-1], line[1:]))
            interval += 1
    return FrontChain(np.array(edges, np.int64).reshape(-1, 3), np.array(uv).reshape(-1, 2))


def _numbered_nodes(
    surface: CutSurface, sheet: Sheet, front: int, uv: list[np.ndarray]
) -> list[tuple[int, float]]:
    """Return (id, arc length) of the nodes a front must have; those that are new are added to `uv`."""
    nodes: list[tuple[int, float]] = []
    for node, arc, position in _forced_nodes(surface, sheet, front):
        if node < 0:
            node = len(surface.points) + len(uv)
            uv.append(np.array(position))
        nodes.append((node, arc))
    return nodes


def _forced_nodes(surface: CutSurface, sheet: Sheet, front: int) -> list[tuple[int, float, list[float]]]:
    """Return id (-1: new), arc and uv of the nodes a front must have: pierce points, ends, corners."""
    curve, closed = sheet.rim.curves[front], sheet.rim.closed[front]
    ids = surface.on_front(front)
    known = surface.arc[ids]
    step = np.diff(curve[:, :2], axis=0)
    step /= np.linalg.norm(step, axis=1)[:, None]
    sharp = np.flatnonzero(np.einsum("ij,ij->i", step[1:], step[:-1]) < CORNER) + 1
    size = np.median(surface.size)
    wanted = _apart(curve[sharp, 2], known, TOUCHING * size)
    if not closed:
        wanted += _apart(curve[[0, -1], 2], known, END * size)
    elif not len(wanted) and not len(ids):
        wanted = [0.0]
    uv = sheet.uv(surface.points[ids])
    items = list(zip(ids.tolist(), known.tolist(), uv.tolist()))
    items += [(-1, w, sheet.rim.on_front(front, np.array([w]))[0].tolist()) for w in wanted]
    return sorted(items, key=lambda item: item[1])


def _apart(wanted: np.ndarray, known: np.ndarray, near: float) -> list[float]:
    """Return those of the wanted arc lengths that no known one is near."""
    return [w for w in wanted.tolist() if not len(known) or np.abs(known - w).min() > near]


def _spread(
    sheet: Sheet, front: int, ends: tuple[float, float], target: SizeAt, halvings: int
) -> np.ndarray:
    """Return arc lengths between the ends, evenly in units of the target size.

    Edges turn by at most SHARPEST. Turning is seen between chords; half a chord at each end shows none.
    """
    samples = np.linspace(ends[0], ends[1], INTERVALS + 1)
    uv = sheet.rim.on_front(front, samples)
    density = 1.0 / target(sheet.lift(uv))
    total = np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) / 2 * np.diff(samples))])
    heading = np.unwrap(np.arctan2(*np.diff(uv[:: INTERVALS // CHORDS], axis=0).T[::-1]))
    turning = np.abs(np.diff(heading)).sum() * CHORDS / (CHORDS - 1)
    bends = int(np.ceil(turning / SHARPEST - ROUND_DOWN))
    count = max(1, int(round(total[-1])), bends) * 2**halvings
    return np.interp(np.arange(1, count) * total[-1] / count, total, samples)


def conflicts(edges: np.ndarray, traces: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """Return the intervals whose front edges cross a trace edge in (u, v).

    edges (k, 3) as in FrontChain; traces (j, 2); uv (n, 2) of all points.
    """
    if not len(traces):
        return np.zeros(0, np.int64)
    tree = shapely.STRtree(shapely.linestrings(uv[edges[:, :2]]))
    row, hit = tree.query(shapely.linestrings(uv[traces]), "intersects")
    shared = (edges[hit, :2][:, :, None] == traces[row][:, None, :]).any(axis=(1, 2))
    return np.unique(edges[hit[~shared], 2])
