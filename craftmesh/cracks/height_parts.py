"""The plane over which a surface is single-valued; folded or kinked surfaces are split into such parts."""

from typing import NamedTuple

import numpy as np
import scipy
import shapely

from craftmesh.errors import rounded_values
from craftmesh.surface.connectivity import compact, edge_sides, joined, unique_edges
from craftmesh.surface.facet_subdivision import divided_at
from craftmesh.surface.measure import area_vectors, total_area, unit_normals
from craftmesh.surface.rounding import EXACT, ROUNDING

# Cosine of the steepest slope for which the area-weighted mean normal is used. Lengths on a triangle are
# then at most 1.4 times as long as on the plane. With steeper triangles, the normal to which the steepest
# one is least steep is better.
STEEP = np.cos(np.radians(45.0))


def best_fit_frame(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return rows u, v, normal (3, 3) of the best-fit plane of triangles (m, 3).

    They may still fold over it, which `fold_of` tests. points (n, 3). The normal is the area-weighted mean
    of the triangle normals. If a triangle is steeper than 45 degrees to it, the normal to which the
    steepest triangle is least steep is used, if all face it. The triangles must be oriented consistently. u
    is the direction in which the crack is longest.
    """
    vectors = area_vectors(points, triangles)
    weight = np.linalg.norm(vectors, axis=1)
    proper = weight > ROUNDING * weight.sum() / len(weight)
    normals = vectors[proper] / weight[proper, None]
    mean = vectors.sum(axis=0)
    normal = mean / np.linalg.norm(mean) if np.linalg.norm(mean) > ROUNDING * weight.sum() else normals[0]
    if (normals @ normal).min() < STEEP:
        direction = least_steep(normals)
        normal = direction if (normals @ direction).min() > 0 else normal
    corners = points[triangles].reshape(-1, 3)
    corner_weight = np.repeat(weight, 3)
    centred = corners - np.average(corners, axis=0, weights=corner_weight)
    across = centred - (centred @ normal)[:, None] * normal
    _, axes = np.linalg.eigh((across * corner_weight[:, None]).T @ across)
    return np.stack([axes[:, 2], np.cross(normal, axes[:, 2]), normal])


def least_steep(normals: np.ndarray) -> np.ndarray:
    """Return the unit vector d (3,) that maximises the smallest cosine n_i . d over unit normals (m, 3).

    It points to the point of the normals' convex hull nearest to the origin, found by least squares with
    weights >= 0 (Lawson & Hanson 1974, chapter 23) over the few normals that decide. If the hull contains
    the origin, no direction has only positive cosines.
    """
    direction = normals[0]
    chosen = [int(np.argmin(normals @ normals.mean(axis=0)))]
    for _ in normals:  # each iteration adds the steepest normal
        system = np.vstack([normals[chosen].T, np.ones(len(chosen))])
        weights, _ = scipy.optimize.nnls(system, np.array([0, 0, 0, 1.0]))
        nearest = weights @ normals[chosen]
        if np.linalg.norm(nearest) <= ROUNDING:
            break
        direction = nearest / np.linalg.norm(nearest)
        cosine = normals @ direction
        steepest = int(np.argmin(cosine))
        if cosine[steepest] >= cosine[chosen].min() - ROUNDING:
            break
        chosen.append(steepest)
    return direction


STEEPEST = 0.15  # smallest cosine of a triangle's normal to the plane's: lengths are at most 7 times longer
COVERED = 1e-6  # fraction of the projected area that may be covered twice by rounding; more is a fold


def fold_of(points: np.ndarray, triangles: np.ndarray) -> str:
    """Return a message on where a surface (m, 3) is not single-valued over its best-fit plane, else ''."""
    frame = best_fit_frame(points, triangles)
    vectors = area_vectors(points, triangles)
    true = np.linalg.norm(vectors, axis=1)
    seen = vectors @ frame[2]
    proper = are_proper(true)
    cosine = np.where(proper, seen / np.maximum(true, 1e-300), 1.0)
    steep = cosine < STEEPEST
    if steep.any():
        worst = int(np.argmin(cosine))
        place = rounded_values(points[triangles[worst]].mean(axis=0))
        angle, most = np.degrees(np.arccos(np.clip([cosine[worst], STEEPEST], -1, 1)))
        return (
            f"the crack surface is folded near {place}: a triangle there stands at {angle:.0f} degrees to "
            f"the best-fit plane ({int(steep.sum())} of {len(triangles)} triangles at over {most:.0f}); "
            "expected a surface that is single-valued over some plane: smooth it or cut it off there"
        )
    uv = points @ frame[:2].T
    polygons = shapely.polygons(uv[triangles[proper]])
    missing = 1 - _united_area(polygons, ROUNDING * float(np.ptp(uv))) / seen[proper].sum()
    if missing <= COVERED:
        return ""
    place = rounded_values(_overlap(points, triangles[proper], polygons))
    return (
        f"the crack surface is folded near {place}: seen along its mean normal, {100 * missing:.2g} % of "
        "it overlaps other parts; expected a surface that is single-valued over a plane: cut it off there"
    )


def _united_area(polygons: np.ndarray, rounding: float) -> float:
    """Return the area of the union of polygons, on a grid of `rounding` if exact corners are too close."""
    try:
        return float(shapely.union_all(polygons).area)
    except shapely.GEOSException:  # a union on a grid always exists, and takes five times as long
        return float(shapely.union_all(polygons, grid_size=rounding).area)


def are_proper(areas: np.ndarray) -> np.ndarray:
    """Return a mask (m,) of triangles with a normal: of an area over EXACT times the sum of all areas."""
    return areas > EXACT * areas.sum()


def _overlap(points: np.ndarray, triangles: np.ndarray, polygons: np.ndarray) -> np.ndarray:
    """Return the centre (3,) of the triangle that overlaps another one most, seen along the normal."""
    tree = shapely.STRtree(polygons)
    a, b = tree.query(polygons, predicate="intersects")
    apart = a < b
    a, b = a[apart], b[apart]
    over = int(np.argmax(shapely.area(shapely.intersection(polygons[a], polygons[b]))))
    return points[triangles[a[over]]].mean(axis=0)


# Angle in degrees between neighbouring triangles from which on a folded surface is split between them; the
# parts represent the kink exactly.
KINK = 30.0
# Degrees: a kink this sharp splits a single-valued surface too; a single part would cut the kink off.
SHARP = 65.0
LEAST_PART = 1e-3  # smallest area fraction of a part of a single-valued surface; smaller ones are slivers
SHARPEST = 150.0  # largest kink in degrees; a sharper one leaves a wedge under 30 between its two sides
MOST_PARTS = 50  # most parts, chosen by hand: a surface with more is rough, not kinked

Part = tuple[np.ndarray, np.ndarray]  # points (n, 3) and triangles (m, 3)


def height_parts(points: np.ndarray, triangles: np.ndarray) -> tuple[list[Part], str]:
    """Return a surface split into parts that are single-valued over their planes, and a message or ''.

    A single-valued surface without a kink of SHARP degrees stays one part. Any other is split along kinks
    of KINK degrees or more. Parts that fold smoothly, as a bowl or a roll does, are bisected until they are
    single-valued. A surface with a kink over SHARPEST, or that would need over MOST_PARTS parts, stays
    whole, with a message on where it folds if it does. A single-valued one also stays whole if a part would
    fold or be a sliver (under LEAST_PART of the area).
    """
    whole = [(points, triangles)]
    fault = fold_of(points, triangles)
    piece, _, sharpest = kinks_of(points, triangles)
    if sharpest > SHARPEST or (not fault and (sharpest < SHARP or not 0 < piece.max() < MOST_PARTS)):
        return whole, fault
    if piece.max() >= MOST_PARTS:
        piece = np.zeros(len(triangles), np.int64)
    if not fault:
        parts = _parts(points, triangles, piece)
        least = min(total_area(*part) for part in parts) < LEAST_PART * total_area(points, triangles)
        return whole if least or any(fold_of(*part) for part in parts) else parts, ""
    while True:
        parts = _parts(points, triangles, piece)
        folded = [number for number, part in enumerate(parts) if fold_of(*part)]
        if not folded:
            return parts, ""
        if len(parts) + len(folded) > MOST_PARTS or min(len(parts[k][1]) for k in folded) < 2:
            return whole, fault
        for number in folded:
            points, triangles, piece = _halved(points, triangles, piece, number)


def _parts(points: np.ndarray, triangles: np.ndarray, piece: np.ndarray) -> list[Part]:
    """Return the parts of a surface by part numbers `piece` (m,), each with only its own points."""
    return [compact(points, triangles[piece == number])[:2] for number in range(piece.max() + 1)]


def _halved(
    points: np.ndarray, triangles: np.ndarray, piece: np.ndarray, number: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Bisect part `number` of a surface across the direction in which its normals turn most.

    Returns points, triangles and part numbers (m,). The cutting plane adds points; neighbouring parts get
    them too, so that their own seams can end there.
    """
    own = triangles[piece == number]
    vectors = area_vectors(points, own)
    area = np.linalg.norm(vectors, axis=1)
    weight, centres = area / area.sum(), points[own].mean(axis=1)
    turn = vectors / np.maximum(area, 1e-300)[:, None]
    turn, middle = turn - weight @ turn, weight @ centres
    _, axes = np.linalg.eigh((turn * weight[:, None]).T @ turn)
    offset = (points - middle) @ ((weight * (turn @ axes[:, 2])) @ (centres - middle))
    edges = unique_edges(own)[0]
    start, end = offset[edges].T
    share = np.where(start * end < 0, start / np.where(start == end, 1.0, start - end), np.nan)
    split = divided_at(points, triangles, offset, edges, share)
    points, triangles, piece = split.points, split.facets, piece[split.parent]
    piece[(piece == number) & (split.side[triangles].sum(axis=1) < 0)] = piece.max() + 1
    _, of_corner, count = unique_edges(triangles)
    f, g = (side // 3 for side in edge_sides(of_corner, count == 2))
    same = piece[f] == piece[g]
    return points, triangles, joined(len(triangles), f[same], g[same])


class Kinks(NamedTuple):
    """The kinks of a surface: edges at which it turns by KINK degrees or more.

    part (m,): number of each triangle's part between kinks, in the order of first triangles; edges (k, 2):
    edges between two parts; sharpest: the largest turn across any edge, in degrees.
    """

    part: np.ndarray
    edges: np.ndarray
    sharpest: float


def kinks_of(points: np.ndarray, triangles: np.ndarray) -> Kinks:
    """Return the kinks of triangles (m, 3), and the parts between them; flat triangles make no kinks."""
    edges, of_corner, count = unique_edges(triangles)
    f, g = (side // 3 for side in edge_sides(of_corner, count == 2))
    normal = unit_normals(points, triangles)
    proper = are_proper(np.linalg.norm(area_vectors(points, triangles), axis=1))
    turn = np.degrees(np.arccos(np.clip((normal[f] * normal[g]).sum(axis=1), -1, 1)))
    turn[~(proper[f] & proper[g])] = 0.0
    smooth = turn < KINK
    part = joined(len(triangles), f[smooth], g[smooth])
    return Kinks(part, edges[count == 2][part[f] != part[g]], float(turn.max(initial=0.0)))
