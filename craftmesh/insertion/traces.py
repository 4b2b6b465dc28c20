"""Split trace edges that leave a curved crack or its front, and move the new points onto it."""

import numpy as np

from craftmesh.cracks.crack_tolerances import FRONT_EDGES
from craftmesh.insertion.cut import (
    OFF,
    SHORTEST,
    CutSurface,
    SizeAt,
    flat_facets,
    on_border,
    split_edges,
    trace_edges,
    with_phi,
)
from craftmesh.insertion.front_chain import SHARES, crossing_at, sagitta, stretches
from craftmesh.insertion.guarded_move import settled
from craftmesh.insertion.options import InsertOptions
from craftmesh.insertion.pierce import with_front_points
from craftmesh.insertion.sheet import Sheet
from craftmesh.surface.connectivity import edge_sides, unique_edges
from craftmesh.surface.front import among_edges
from craftmesh.surface.measure import edge_lengths, unit_normals
from craftmesh.surface.patches import is_on_box, patches
from craftmesh.types import Surface

# Largest distance of trace edges on a box face from the crack's mouth, measured in the face, in smallest
# target lengths. OFF would allow much more where the crack meets the face at a small angle.
BESIDE = 0.04
FARTHEST = 0.3  # largest move of an edge's new point onto the crack, in lengths of the edge
FARTHEST_ON_BOX = 1.0  # the same for moves within a box face, where mouths may have sharp kinks
CONTACT = 0.1  # distance, in smallest target lengths, below which a boundary along the crack moves onto it
# Ratio of the straight distance to the distance within a boundary below which crack and boundary graze.
GRAZING = 0.25


def follow_traces(surface: CutSurface, sheet: Sheet, least: float, options: InsertOptions) -> CutSurface:
    """Split trace edges too far from the crack where they are farthest, and move the new points onto it.

    New points move within their boundary. If one cannot move within the bounds, or its trace edges would
    cross others, its edge stays whole. least: smallest target length.
    """
    refused = np.zeros((0, 2), np.int64)
    while True:
        edges, share, targets = _too_far_off(surface, sheet, least)
        stride = np.array([len(surface.points) + 1, 1])
        wanted = ~np.isin(edges @ stride, refused @ stride)
        edges, share, targets = edges[wanted], share[wanted], targets[wanted]
        if not len(edges):
            return surface
        start, end = surface.points[edges].transpose(1, 0, 2)
        places, size = start + share[:, None] * (end - start), surface.size[edges].mean(axis=1)
        rows = len(surface.points) + np.arange(len(edges))
        split, left = settled(split_edges(surface, edges, places, size), rows, targets, options)
        stuck = np.isin(rows, left) | np.isin(rows, crossing_at(split, sheet, rows))
        refused = np.concatenate([refused, edges[stuck]])
        if not stuck.any():
            surface = split


def _too_far_off(
    surface: CutSurface, sheet: Sheet, least: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return trace edges (k, 2) to split, positions (k,) along them, and new points (k, 3) on the crack."""
    edges, normals, held = _edges_in_walls(surface)
    start, step = surface.points[edges[:, 0]], np.diff(surface.points[edges], axis=1)[:, 0]
    length = np.linalg.norm(step, axis=1)
    long = np.flatnonzero(length > 2 * SHORTEST * least)
    edges, normals, start, step, length = (x[long] for x in (edges, normals, start, step, length))
    held = held[long]
    places = (start[:, None] + SHARES[None, :, None] * step[:, None]).reshape(-1, 3)
    normals = np.repeat(normals, len(SHARES), axis=0)
    off, beside = (x.reshape(-1, len(SHARES)) for x in _distances(sheet, places, normals))
    times = np.maximum(off / OFF, np.where(held[:, None], beside / BESIDE, 0.0)) / least
    far = np.flatnonzero(times.max(axis=1) > 1)
    least_share = SHORTEST * least / length[far]
    share = np.clip(SHARES[times[far].argmax(axis=1)], least_share, 1 - least_share)
    place = start[far] + share[:, None] * step[far]
    across = np.cross(normals[:: len(SHARES)][far], step[far])
    reach = np.where(held, FARTHEST_ON_BOX, FARTHEST)[far] * length[far]
    across *= (reach / np.maximum(np.linalg.norm(across, axis=1), 1e-300))[:, None]
    targets = sheet.nearest_crossing(place, across)
    ahead = sheet.gradient(place)
    ahead *= CONTACT * least / np.linalg.norm(ahead, axis=1)[:, None]
    straight = sheet.nearest_crossing(place, ahead)
    way, shorter = (np.linalg.norm(target - place, axis=1) for target in (targets, straight))
    with np.errstate(invalid="ignore"):
        grazing = ~held[far] & np.isfinite(shorter) & ~(GRAZING * way < shorter)
    targets[grazing] = straight[grazing]
    found = np.isfinite(targets).all(axis=1)
    return edges[far[found]], share[found], targets[found]


def _distances(sheet: Sheet, places: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return distances (n,) of places (n, 3) from the crack, to first order: straight, and within a wall.

    normals (n, 3): of the wall (grain boundary or box face) at each place, 0 for none.
    """
    psi, gradient = np.abs(sheet.offset(places)), sheet.gradient(places)
    normals = normals / np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    in_wall = gradient - np.einsum("ij,ij->i", gradient, normals)[:, None] * normals
    return psi / np.linalg.norm(gradient, axis=1), psi / np.maximum(np.linalg.norm(in_wall, axis=1), 1e-300)


def _edges_in_walls(surface: CutSurface) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return trace edges (k, 2) inside the front that lie in one boundary, one box plane or a triple line.

    Also return the boundary's normal (k, 3) there, and a mask (k,) of edges with a facet in a box plane.
    The normal is zero at triple lines, whose points only move straight onto the crack.
    """
    on = surface.psi == 0
    rows = np.flatnonzero(on[surface.facets].sum(axis=1) >= 2)
    near = Surface(surface.points, surface.facets[rows], surface.sides[rows], surface.kind[rows])
    edges, of_corner, count = unique_edges(near.facets)
    patch = patches(near).of_facet
    shared = count > 1
    first, second = (side // 3 for side in edge_sides(of_corner, shared))
    held = np.zeros(len(edges), bool)
    held[of_corner[is_on_box(near.kind)]] = True
    edges, count, held = edges[shared], count[shared], held[shared]
    normal = unit_normals(near.points, near.facets)
    cosine = np.einsum("ij,ij->i", normal[first], normal[second])
    normal = normal[first] + np.sign(cosine)[:, None] * normal[second]
    normal[count > 2] = 0.0
    with np.errstate(invalid="ignore"):
        phi = surface.phi[edges]
        inside = (phi > 0).any(axis=1) | (phi >= 0).all(axis=1)
    chosen = ((count > 2) | (patch[first] == patch[second])) & on[edges].all(axis=1) & inside
    chosen &= ~on_border(surface, edges)
    return edges[chosen], normal[chosen], held[chosen]


ALONG = 0.1  # largest distance, in edge lengths, of a trace edge from the front along which it runs
# As ALONG, for edges of facets that lie in the crack. It is larger, because the front has to bound these.
ALONG_FLAT = 0.5
FRONT_BISECTIONS = (
    10  # most bisections of edges along the front; each reduces their distance from it to a quarter
)
# Smallest distance of a front corner from the ends of an edge's stretch, in lengths of the stretch, for a
# split at that corner. A split at the middle would leave a needle next to the corner.
INNER = 0.1
# Longest edge along the front, in target sizes, that is not split. It is above 1 because new front edges
# have rounded lengths, too.
LONGEST = 1.5


def inside_traces(surface: CutSurface) -> tuple[np.ndarray, np.ndarray]:
    """Return trace edges (k, 2) inside the front, and trace edges (j, 2) between two front points."""
    edges = trace_edges(surface)
    phi = surface.phi[edges]
    chords = edges[(phi == 0).all(axis=1)]
    return edges[(phi >= 0).all(axis=1) & (phi > 0).any(axis=1)], chords


def settle_chords(
    surface: CutSurface, sheet: Sheet, target: SizeAt, options: InsertOptions
) -> tuple[CutSurface, np.ndarray]:
    """Split trace edges between two front points that are not front edges; return those (k, 2) that are.

    A trace edge between neighbouring front points, close to the front, is a front edge. If it is farther
    than FRONT_EDGES from the front or longer than LONGEST, it is split, and its midpoint and the boundary
    move onto the front.
    """
    for _ in range(FRONT_BISECTIONS):
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
    """Return a mask (k,) of edges between neighbouring front points that are too long or too far from it.

    The limits are LONGEST and FRONT_EDGES target sizes.
    """
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
    """Return the largest distance (n,) from each chord of front corners between its ends; 0 without any.

    start, end (n,): arc lengths of the chords' ends on the front.
    """
    most = np.zeros(len(start))
    for corner in sheet.rim.corners_ahead(front).tolist():
        cut = np.flatnonzero((start < corner) & (corner < end))
        arcs = np.concatenate([start[cut], end[cut], [corner]])
        at = sheet.lift(sheet.rim.curves[front].at(arcs))
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
    """Split edges along the front (k, 2), whose midpoints move onto it, and edges across the crack (j, 2).

    A midpoint that cannot move is not a front point, except where the front has to bound facets that lie in
    the crack.
    """
    bent, across = chords
    flat = among_edges(bent, surface.facets[flat_facets(surface)])
    front, start, end = stretches(surface, sheet, bent)
    places = np.empty((len(bent), 3))
    for number in np.unique(front).tolist():
        mine = front == number
        arcs = _inner_arcs(sheet, number, start[mine], end[mine])
        places[mine] = sheet.lift(sheet.rim.curves[number].at(arcs))
    edges = np.concatenate(chords)
    first, size = len(surface.points), surface.size[edges].mean(axis=1)
    middles = surface.points[edges].mean(axis=1)
    surface = with_phi(split_edges(surface, edges, middles, size), sheet)
    halves = np.arange(first, first + len(bent))
    surface, left = settled(surface, halves, places, options)
    return with_front_points(surface, sheet, halves[flat | ~np.isin(halves, left)])


def _inner_arcs(sheet: Sheet, front: int, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return arc lengths (k,) at which to split stretches of a front: inner corners, else the middles."""
    middle, arcs = (start + end) / 2, (start + end) / 2
    reach = (0.5 - INNER) * (end - start)
    for corner in sheet.rim.corners_ahead(front).tolist():
        nearer = np.abs(corner - middle) < reach
        arcs[nearer], reach[nearer] = corner, np.abs(corner - middle)[nearer]
    return arcs


def _neighbours(surface: CutSurface, sheet: Sheet, chords: np.ndarray) -> np.ndarray:
    """Return a mask (k,) of chords that join consecutive points of one front."""
    pairs = [np.zeros((0, 2), np.int64)]
    for front, curve in enumerate(sheet.rim.curves):
        ids = surface.on_front(front)
        pairs.append(np.column_stack([ids, np.roll(ids, -1)])[: len(ids) - (not curve.closed)])
    key = np.array([len(surface.points), 1])
    return np.isin(chords @ key, np.sort(np.concatenate(pairs), axis=1) @ key)
