"""Move points near the crack onto it before the cut; points already on it get the offset 0."""

from dataclasses import replace

import numpy as np

from craftmesh.cracks.crack_tolerances import LATER_CRACKS, PROMISED
from craftmesh.cracks.near_faces import ALONG
from craftmesh.insertion.cut import OFF, CutSurface, feet_on_edges, uncut
from craftmesh.insertion.guarded_move import move_onto
from craftmesh.insertion.options import InsertOptions
from craftmesh.insertion.sheet import Sheet
from craftmesh.surface.classification import Classification
from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.front import front_edges
from craftmesh.surface.kernels.ranks import AT_JUNCTION, IN_PATCH, ON_LINE
from craftmesh.surface.measure import area_vectors, edge_lengths, mean_edges, point_normals
from craftmesh.surface.rounding import ROUNDING, SAME_PLACE
from craftmesh.types import CRACK, Surface

OFFSET_DISTANCE = 3  # largest distance, in longest edges, at which points get an offset from the crack


def prepared(
    surface: Surface, sheet: Sheet, known: np.ndarray | None = None, least: float = 0.0
) -> CutSurface:
    """Return the surface with signed distances psi from the crack, and with local edge lengths.

    psi is exactly 0 at points on the crack, and NaN beyond about OFFSET_DISTANCE longest edges. known (k,
    3): positions of points on the crack of an older mesh; such points within PROMISED.facets times `least`
    of the crack count as on it. least: smallest target edge length, in the surface's unit of length; with
    0, `known` has no effect.
    """
    uv = sheet.uv(surface.points)
    size, longest = local_sizes(surface)
    reach = OFFSET_DISTANCE * longest
    u0, v0, u1, v1 = sheet.rim.domain.bounds
    height = (surface.points - sheet.origin) @ sheet.frame[2]
    lowest, highest = sheet.height.min() - 2 * reach, sheet.height.max() + 2 * reach
    near = (uv >= [u0 - reach, v0 - reach]).all(axis=1) & (uv <= [u1 + reach, v1 + reach]).all(axis=1)
    rows = np.flatnonzero(near & (height >= lowest) & (height <= highest))
    psi = np.full(len(surface.points), np.nan)
    psi[rows] = sheet.offset(surface.points[rows])
    psi[rows[np.abs(psi[rows]) <= ROUNDING * size[rows]]] = 0.0
    if known is not None:
        on_old = rows[_are_among(surface.points[rows], known)]
        psi[on_old[np.abs(psi[on_old]) <= PROMISED.facets * least]] = 0.0
    return replace(uncut(surface), psi=psi, size=size)


def _are_among(points: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return a mask (n,) of the points (n, 3) that have the coordinates of one of the places (k, 3)."""
    known = set(map(tuple, places.tolist()))
    return np.array([tuple(point) in known for point in points.tolist()], bool)


def local_sizes(surface: Surface) -> tuple[np.ndarray, float]:
    """Return the mean length (n,) of the edges at each point, and the length of the longest edge."""
    edges, _, _ = unique_edges(surface.facets)
    return mean_edges(surface.points, edges), float(edge_lengths(surface.points, edges).max())


FARTHEST = 0.5  # largest move of a point onto the crack, in local sizes
# Fraction of the snap distance within which a point on a line moves onto the front, or straight onto the
# crack instead of along its line.
LINE_SHARE = 0.5
# Fraction of the snap distance within which a point where lines end or meet moves straight onto the crack;
# a crack close to such a point leaves needle facets.
KNOTS = 0.1
# Smallest squared sine of the crack's angle to a box plane for moves in that plane: 6 degrees.
STEEP = ALONG**2


def snap_to_crack(surface: CutSurface, sheet: Sheet, options: InsertOptions) -> CutSurface:
    """Move points near the crack onto it, within the patches, box planes and lines that hold them.

    Points of an earlier crack move along that crack. A point on a line moves along it to where the line
    crosses the crack. If that is too far away, or a neighbour moves there, the point moves straight onto
    the crack, provided that it is within LINE_SHARE of the snap distance and not on an earlier crack.
    Points where lines meet or end move straight within KNOTS of the snap distance; box corners stay. A move
    that turns or flattens a facet beyond the bounds, or makes facets intersect, is not made.
    """
    distance = _distances(surface, sheet)
    with np.errstate(invalid="ignore"):
        rows = np.flatnonzero((distance < options.snap * surface.size) & (surface.psi != 0))
    if len(rows):
        rows = rows[sheet.rim.inside(sheet.uv(surface.points[rows])) > -surface.size[rows]]
    if not len(rows):
        return surface
    reach = FARTHEST * surface.size
    classes = classified(surface)
    rank, planes = classes.rank, classes.held
    targets = np.full((len(surface.points), 3), np.nan)
    normals = _crack_normals(surface)
    free = rows[rank[rows] == IN_PATCH]
    targets[free] = onto_crack(surface.points[free], planes[free], sheet, reach[free], normals[free])
    on_line = np.zeros(len(surface.points), bool)
    on_line[rows[rank[rows] == ON_LINE]] = True
    _along_lines(surface, sheet, classes.features.lines, on_line, targets)
    movable = np.isin(np.arange(len(distance)), rows) & ~normals.any(axis=1) & ~planes.all(axis=1)
    with np.errstate(invalid="ignore"):
        grazes = on_line & movable & (distance < LINE_SHARE * options.snap * surface.size)
        straight = grazes & ~(np.linalg.norm(targets - surface.points, axis=1) < reach)
        straight |= (rank == AT_JUNCTION) & movable & (distance < KNOTS * options.snap * surface.size)
    targets[straight] = onto_crack(surface.points[straight], planes[straight], sheet, reach[straight])
    surface = _moved(surface, targets, reach, options)
    # One of two neighbours on a line can move to the crossing between them; the other moves straight.
    left = np.flatnonzero(grazes & (surface.psi != 0))
    targets[:] = np.nan
    targets[left] = onto_crack(surface.points[left], planes[left], sheet, reach[left])
    return _moved(surface, targets, reach, options) if len(left) else surface


def taken_at_box_edges(surface: CutSurface, sheet: Sheet, least: float) -> CutSurface:
    """Return the surface with points of box edges within OFF of the crack marked as on it.

    Such a point has no crossing of the crack on its box edge to move to, and the narrow strip of face
    between it and the crack would lead to flat tetrahedra. least: smallest target length.
    """
    planes = classified(surface).held
    with np.errstate(invalid="ignore"):
        near = (_distances(surface, sheet) <= OFF * least) & (surface.psi != 0)
    rows = np.flatnonzero(near & (planes.sum(axis=1) == 2))
    psi = surface.psi.copy()
    psi[rows[sheet.rim.inside(sheet.uv(surface.points[rows])) > 0]] = 0.0
    return replace(surface, psi=psi)


def _moved(
    surface: CutSurface, targets: np.ndarray, reach: np.ndarray, options: InsertOptions
) -> CutSurface:
    """Return the surface with points moved onto the crack at targets (n, 3) nearer than reach (n,)."""
    with np.errstate(invalid="ignore"):
        rows = np.flatnonzero(np.linalg.norm(targets - surface.points, axis=1) < reach)
    surface, moved = move_onto(surface, rows, targets[rows], options.bounds)
    psi = surface.psi.copy()
    psi[moved] = 0.0
    return replace(surface, psi=psi)


def _distances(surface: CutSurface, sheet: Sheet) -> np.ndarray:
    """Return distances (n,) >= 0 from the crack, |psi| over the length of its gradient; NaN far from it."""
    distance = np.abs(surface.psi)
    rows = np.flatnonzero(np.isfinite(distance))
    distance[rows] /= np.linalg.norm(sheet.gradient(surface.points[rows]), axis=1)
    return distance


def classified(surface: CutSurface) -> Classification:
    """Return the classification (ranks, and box planes that hold points) from facets near the crack."""
    rows = np.flatnonzero(np.isfinite(surface.psi[surface.facets]).any(axis=1))
    return Classification(
        Surface(surface.points, surface.facets[rows], surface.sides[rows], surface.kind[rows])
    )


def _crack_normals(surface: CutSurface) -> np.ndarray:
    """Return unit normals (n, 3) of an earlier crack at its points, zero elsewhere."""
    facets = surface.facets[surface.kind == CRACK]
    return point_normals(area_vectors(surface.points, facets), facets, len(surface.points))


def leaves_crack(surface: CutSurface, rows: np.ndarray, targets: np.ndarray) -> np.ndarray:
    """Return a mask (k,) of points `rows` whose targets (k, 3) lie too far off an earlier crack or front.

    The allowed distances are LATER_CRACKS times the local size.
    """
    step = targets - surface.points[rows]
    off = np.abs(np.einsum("ij,ij->i", step, _crack_normals(surface)[rows])) / LATER_CRACKS.facets
    times = np.maximum(off, _off_front(surface, rows, targets) / LATER_CRACKS.front)
    return times > surface.size[rows]


def _off_front(surface: CutSurface, rows: np.ndarray, targets: np.ndarray) -> np.ndarray:
    """Return distances (k,) of targets (k, 3) from an earlier crack's front; 0 for points not on a front.

    rows (k,): ids of the points that move to the targets.
    """
    front = front_edges(Surface(surface.points, surface.facets, surface.sides, surface.kind))
    at = np.full(len(surface.points), -1)
    at[rows] = np.arange(len(rows))
    edges = np.concatenate([front, front[:, ::-1]])
    edges = edges[at[edges[:, 0]] >= 0]
    moved = at[edges[:, 0]]
    off = np.full(len(rows), np.inf)
    np.minimum.at(off, moved, feet_on_edges(surface, edges, targets[moved])[0])
    return np.where(np.isfinite(off), off, 0.0)


def onto_crack(
    points: np.ndarray,
    planes: np.ndarray,
    sheet: Sheet,
    reach: np.ndarray,
    normals: np.ndarray | None = None,
) -> np.ndarray:
    """Return the points (n, 3) moved onto the crack within their box planes (n, 3), by at most reach (n,).

    The direction is the crack's normal, projected onto the box planes and onto an earlier crack with
    `normals` (n, 3). NaN where the crack is nearly parallel to these, or where no point on it is found.
    """
    gradient = sheet.gradient(points)
    direction = np.where(planes, 0.0, gradient)
    if normals is not None:
        direction -= np.einsum("ij,ij->i", direction, normals)[:, None] * normals
    square = np.einsum("ij,ij->i", direction, direction)
    result = np.full(points.shape, np.nan)
    rows = np.flatnonzero(square > STEEP * np.einsum("ij,ij->i", gradient, gradient))
    points, square, direction = points[rows], square[rows], direction[rows]
    if sheet.planar:
        result[rows] = points - (sheet.offset(points) / square)[:, None] * direction
        return result
    direction = direction * (reach[rows] / np.sqrt(square))[:, None]
    result[rows] = sheet.nearest_crossing(points, direction)
    return result


def _along_lines(
    surface: CutSurface, sheet: Sheet, edges: np.ndarray, on_line: np.ndarray, targets: np.ndarray
) -> None:
    """Fill in `targets` (n, 3) in place at the points in `on_line` (n,).

    A target is the crossing of the crack and a line edge (k, 2) at the point.
    """
    psi = surface.psi[edges]
    crossing = np.sign(psi[:, 0]) * np.sign(psi[:, 1]) < 0
    for start, end in ((0, 1), (1, 0)):
        a, b = edges[crossing, start], edges[crossing, end]
        chosen = on_line[a]
        a, b = a[chosen], b[chosen]
        fraction, off = sheet.crossings(surface.points[a], surface.points[b])
        on = np.abs(off) <= SAME_PLACE * surface.size[a]
        a, b, fraction = a[on], b[on], fraction[on]
        targets[a] = surface.points[a] + fraction[:, None] * (surface.points[b] - surface.points[a])
