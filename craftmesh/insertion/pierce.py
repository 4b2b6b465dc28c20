"""The crack front on a cut surface: pierce points on the traces, and front nodes between them."""

from dataclasses import dataclass, replace

import numpy as np
import shapely

from craftmesh.errors import CraftmeshError
from craftmesh.insertion.cut import CutSurface, SizeAt, edge_lengths, split_edges, trace_edges, with_phi
from craftmesh.insertion.sheet import Sheet

# Chosen by hand. TOUCHING and END bound how far a node may be off the given front and its end.
ROUNDS = 12  # of splitting, each at the first crossing of every trace edge: no edge may have more
TOUCHING = 1e-3  # of the local size: nearer than this, a trace point, crossing or corner is on the front
AT_END = 1e-9  # of the local size: a crossing this near the end of its edge, off the front, is rounding
SLACK = 1.0001  # an edge shorter than the distances of its ends from the front misses it; and some rounding
GRAZING = 0.05  # sine of the angle below which an edge between two front points does not cross the front
SHARPEST = np.radians(60.0)  # a front edge spans at most this much of the front's turning
END = 0.3  # of the size: a pierce point this near the end of a front is its end
INTERVALS = 256  # even steps in which the target size is summed up between two pierce points
CHORDS = 16  # over those steps, by which the front's turning is measured
# Of the target size: front edges, and so what slides along them, stay this near the front at the SHARES.
# 0.02 is promised; with 0.02 here up to 0.0203 was measured between the SHARES.
FIDELITY = 0.0196
# Of the target size: front edges are not made shorter for that; enough for 0.8 of it as radius.
FINEST = 0.35
# Of an edge, at which its distance from the front is measured.
SHARES = (0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875)
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
    at = sheet.uv(surface.points[rows])  # the rim there may be the crack's mouth
    foot, _, _ = sheet.rim.nearest_front(at)
    rows = rows[np.linalg.norm(foot - at, axis=1) <= TOUCHING * surface.size[rows]]
    return with_front_points(surface, sheet, rows) if len(rows) else surface


def with_front_points(surface: CutSurface, sheet: Sheet, rows: np.ndarray) -> CutSurface:
    """Return the surface with the points `rows` (k,) counted as on the nearest front; none is moved."""
    _, number, along = sheet.rim.nearest_front(sheet.uv(surface.points[rows]))
    phi, front, arc = surface.phi.copy(), surface.front.copy(), surface.arc.copy()
    phi[rows], front[rows], arc[rows] = 0.0, number, along
    return replace(surface, phi=phi, front=front, arc=arc)


def _may_cross(surface: CutSurface, edges: np.ndarray) -> np.ndarray:
    """Tell which edges are long enough to reach the front from both their ends."""
    phi, length = surface.phi[edges], edge_lengths(surface, edges)
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
    beside, at_end = _past_front_ends(surface, sheet, edges, row)
    row, fraction = np.concatenate([row, beside]), np.concatenate([fraction, at_end])
    order = np.lexsort([fraction, row])
    row, fraction = row[order], fraction[order]
    row, first = np.unique(row, return_index=True)
    return row, fraction[first]


def _past_front_ends(
    surface: CutSurface, sheet: Sheet, edges: np.ndarray, crossed: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows of edges that leave the crack past an end of its front, and the fractions there.

    Such an edge on the box is a chord of the mouth: past the end of the front it leaves through what was
    pushed out of the box.
    """
    ends = [curve[[0, -1], :2] for curve, closed in zip(sheet.rim.curves, sheet.rim.closed) if not closed]
    leaving = np.prod(np.sign(surface.phi[edges]), axis=1) < 0
    leaving[crossed] = False
    rows = np.flatnonzero(leaving)
    if not ends or not len(rows):
        return np.zeros(0, np.int64), np.zeros(0)
    lines = shapely.linestrings(sheet.uv(surface.points[edges[rows].ravel()]).reshape(-1, 2, 2))
    tree = shapely.STRtree(shapely.points(np.concatenate(ends)))
    end = tree.geometries[tree.query_nearest(lines, all_matches=False)[1]]
    near = shapely.distance(lines, end) <= END * surface.size[edges[rows, 0]]
    fraction = shapely.line_locate_point(lines, end, normalized=True)
    near &= (fraction > 0) & (fraction < 1)
    return rows[near], fraction[near]


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
    size = np.median(surface.size)
    wanted = _apart(sheet.rim.corners(front), known, TOUCHING * size)
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
    """Return arc lengths between the ends, even in units of the target size, closer where the front bends.

    Edges turn by at most SHARPEST. Turning is seen between chords; half a chord at each end shows none.
    """
    samples = np.linspace(ends[0], ends[1], INTERVALS + 1)
    places = sheet.lift(sheet.rim.on_front(front, samples))
    size = target(places)
    bend = _bending(sheet, front, samples, size)
    plain, total = (_summed(density, samples) for density in (1 / size, bend / size))
    uv = sheet.uv(places[:: INTERVALS // CHORDS])
    heading = np.unwrap(np.arctan2(*np.diff(uv, axis=0).T[::-1]))
    turning = np.abs(np.diff(heading)).sum() * CHORDS / (CHORDS - 1)
    bends = int(np.ceil(turning / SHARPEST - ROUND_DOWN))
    count = max(1, int(round(plain[-1])), bends)
    while True:
        arcs = np.interp(np.linspace(0, total[-1], count * 2**halvings + 1), total, samples)
        if count * FINEST >= plain[-1] or _is_true(sheet, front, arcs, target):
            return arcs[1:-1]
        count += 1


def _summed(density: np.ndarray, samples: np.ndarray) -> np.ndarray:
    """Return the integral (n,) of the density (n,) from the first sample to each."""
    return np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) / 2 * np.diff(samples))])


def _bending(sheet: Sheet, front: int, samples: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Return by what factor (n,) edges around the arc lengths are to be shorter to stay at the front."""
    low = np.maximum(samples - size / 2, samples[0])
    high = np.minimum(samples + size / 2, samples[-1])
    off = sagitta(sheet, front, low, high)
    return np.clip(np.sqrt(off / (FIDELITY * size)), 1.0, 1 / FINEST)


def _is_true(sheet: Sheet, front: int, arcs: np.ndarray, target: SizeAt) -> bool:
    """Tell whether the edges between the arc lengths stay within FIDELITY of the front."""
    off = sagitta(sheet, front, arcs[:-1], arcs[1:])
    middle = sheet.lift(sheet.rim.on_front(front, (arcs[:-1] + arcs[1:]) / 2))
    return bool((off <= FIDELITY * target(middle)).all())


def sagitta(sheet: Sheet, front: int, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return how far (n,) the front is from its chords between the arc lengths start and end (n,)."""
    a, b = (sheet.lift(sheet.rim.on_front(front, arc)) for arc in (start, end))
    chord = b - a
    square = np.maximum(np.einsum("ij,ij->i", chord, chord), np.finfo(float).tiny)
    most = np.zeros(len(start))
    for share in SHARES:
        place = sheet.lift(sheet.rim.on_front(front, start + share * (end - start)))
        along = np.clip(np.einsum("ij,ij->i", place - a, chord) / square, 0, 1)
        most = np.maximum(most, np.linalg.norm(a + along[:, None] * chord - place, axis=1))
    return most


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


def crossing_at(surface: CutSurface, sheet: Sheet, rows: np.ndarray) -> np.ndarray:
    """Return which of the points `rows` (k,) have trace edges that cross others in (u, v)."""
    traces = trace_edges(surface)
    among = np.isin(traces, rows)
    mine = np.column_stack([traces, np.where(among[:, 1], traces[:, 1], traces[:, 0])])[among.any(axis=1)]
    return conflicts(mine, traces, sheet.uv(surface.points)) if len(mine) else np.zeros(0, np.int64)
