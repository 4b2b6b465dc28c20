"""Clean a given triangulated surface: remove slivers, orient it, and keep its part near the box."""

import numpy as np

from craftmesh.arguments import as_array, check_indices
from craftmesh.errors import CraftmeshError, rounded_values
from craftmesh.surface.connectivity import compact, edge_sides, facet_edges, joined, unique_edges
from craftmesh.surface.measure import area_vectors, meets_box
from craftmesh.surface.rounding import ROUNDING, SAME_PLACE

# Height of a triangle relative to its longest edge, below which its normal is not reliable (float32 files).
SLIVER = 1e-4
SLIVER_PASSES = 20  # most passes of sliver removal; chosen by hand, more than a row of points should need
# Distance between a surface's two sides, relative to its smaller width, below which it is a thin shell.
# Measured: 0.37 in ten voxels by three, 0.53 in an ellipsoid 2.5 times as wide as thick, 1.2 in a cube.
THIN = 0.4
# Number of lines through a surface that test for a thin shell; a fraction of 0.5 of them is then known to
# within 0.04.
LINES = 200
BOX_DISTANCE = 0.25  # triangles farther than this from the box, in its diagonals, may be dropped


def clean_triangles(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Merge coincident points, drop degenerate triangles and unused points, orient triangles consistently.

    Raise CraftmeshError if points (n, 3) or ids (m, 3) are invalid, if no triangle is left, if more than
    two triangles share an edge, or if the surface has only one side.
    """
    points = as_array("the crack's points", points, float, (None, 3))
    triangles = as_array("the crack's triangles", triangles, np.int64, (None, 3))
    check_indices("the crack's triangles", triangles, len(points))
    if not len(triangles):
        raise CraftmeshError("the crack surface has no triangles; give a triangulated surface")
    points, triangles = merged_points(points, triangles)
    refuse_shared_edges(triangles)
    return points, turned_alike(points, triangles)


def merged_points(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return points and triangles (m, 3) without coincident or unused points and degenerate triangles.

    Raise CraftmeshError if no triangle is left.
    """
    step = max(np.ptp(points, axis=0).max(), 1e-300) * ROUNDING
    _, first, inverse = np.unique(np.round(points / step), axis=0, return_index=True, return_inverse=True)
    triangles = first[inverse.ravel()[triangles]]
    distinct = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    if not distinct.any():
        raise CraftmeshError(
            "the crack surface has no triangle of three distinct points; give a triangulated surface"
        )
    points, triangles, _ = compact(points, triangles[distinct])
    return points, triangles


def refuse_shared_edges(triangles: np.ndarray) -> None:
    """Raise CraftmeshError if more than two triangles share an edge."""
    edges, _, count = unique_edges(triangles)
    if (count > 2).any():
        a, b = edges[np.flatnonzero(count > 2)[0]]
        raise CraftmeshError(
            f"the crack surface is not a manifold: {count.max()} triangles share the edge {a}-{b}; "
            "expected at most 2: give one surface without branches"
        )


def turned_alike(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return triangles (m, 3) oriented consistently; each piece keeps the orientation of most of its area.

    Raise CraftmeshError if that is impossible, as on a Moebius strip.
    """
    count = len(triangles)
    f, g = _neighbours(triangles)
    directed = facet_edges(triangles)
    against = directed[f, 0] != directed[g, 0]  # True if both triangles are oriented consistently
    f, g = f // 3, g // 3
    # Node t is triangle t as it is, node t + count is t reversed; nodes that imply each other are joined.
    ends = np.concatenate([f, f + count]), np.concatenate([g, g + count])
    other = np.where(against, g + count, g), np.where(against, g, g + count)
    ends = ends[0], np.concatenate([other[1], other[0]])
    piece = joined(2 * count, *ends)
    one_sided = np.flatnonzero(piece[:count] == piece[count:])
    if len(one_sided):
        place = rounded_values(points[triangles[one_sided[0]]].mean(axis=0))
        raise CraftmeshError(
            f"the crack surface near {place} has only one side, as a Moebius strip has; give a surface "
            "with two sides"
        )
    area = np.linalg.norm(area_vectors(points, triangles), axis=1)
    total = np.bincount(piece, np.concatenate([area, np.zeros(count)]), piece.max() + 1)
    other = total[piece[count:]]
    even = np.isclose(other, total[piece[:count]], rtol=SAME_PLACE, atol=0)
    # If both orientations have the same area, the piece's first triangle decides.
    turned = np.where(even, piece[count:] < piece[:count], other > total[piece[:count]])
    return np.where(turned[:, None], triangles[:, ::-1], triangles)


def sides_apart(points: np.ndarray, triangles: np.ndarray, box: np.ndarray) -> float | None:
    """Return the median distance between the two sides of a thin shell; None for any other surface.

    points (n, 3), all distinct; triangles (m, 3), any orientation. A thin shell is a surface where most
    lines across it meet the other side close by. It is closed, or open only outside or next to faces of the
    box (2, 3): a single surface that folds back on itself has its boundary inside the box.
    """
    apart = lines_across(points, triangles, LINES)[1]
    if len(apart) <= LINES / 2:
        return None
    edges, _, count = unique_edges(triangles)
    rim = points[edges[count == 1]].reshape(-1, 3)
    depth = np.minimum(rim - box[0], box[1] - rim).min(axis=1)
    return float(np.median(apart)) if (depth <= np.median(apart)).all() else None


def lines_across(points: np.ndarray, triangles: np.ndarray, lines: int) -> tuple[np.ndarray, np.ndarray]:
    """Return middles (k, 3) and lengths (k,) of normal lines that meet the other side of a surface nearby.

    The `lines` lines start at centres of triangles (m, 3), spread evenly over the area. Nearby means within
    THIN of the smaller width of the set of middles, which is small in balls and tubes.
    """
    corner, vectors = points[triangles], area_vectors(points, triangles)
    area, middle = np.linalg.norm(vectors, axis=1), corner.mean(axis=1)
    reach = np.linalg.norm(corner - middle[:, None], axis=2).max(axis=1) * (1 + SAME_PLACE)
    total = np.cumsum(area)
    chosen = np.searchsorted(total, (np.arange(lines) + 0.5) / lines * total[-1])
    found = []
    for own in chosen.tolist():
        way, off = vectors[own] / area[own], middle - middle[own]
        # triangles whose bounding sphere the line passes through
        some = np.flatnonzero((off**2).sum(axis=1) - (off @ way) ** 2 <= reach**2)
        lean = vectors[some] @ way
        some, lean = (part[(some != own) & (lean != 0)] for part in (some, lean))
        far = ((corner[some, 0] - middle[own]) * vectors[some]).sum(axis=1) / lean
        spokes = corner[some] - (middle[own] + far[:, None] * way)[:, None]
        parts = (np.cross(spokes, np.roll(spokes, -1, axis=1)) @ way) * np.sign(lean)[:, None]
        far = far[(parts >= -ROUNDING * area[some, None]).all(axis=1)]
        if len(far):
            nearest = far[np.abs(far).argmin()]
            found.append((*(middle[own] + nearest / 2 * way), abs(nearest)))
    rows = np.array(found).reshape(-1, 4)
    if len(rows) < 3:
        return np.zeros((0, 3)), np.zeros(0)
    spread = np.linalg.svd(rows[:, :3] - rows[:, :3].mean(axis=0), compute_uv=False)
    # In a disc, the diameter is four times the standard deviation of the points along one axis.
    near = rows[rows[:, 3] < THIN * 4 * spread[1] / np.sqrt(len(rows))]
    return near[:, :3], near[:, 3]


def lip_a_ahead(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return consistently oriented triangles (m, 3) with lip A on the side that their normals point to.

    In each surface the mean normal's largest component becomes positive; of equal ones z, then y, decides,
    so lip A of a level crack is on top. Without a mean normal, as on a closed surface, lip A is outside.
    """
    f, g = (rows // 3 for rows in _neighbours(triangles))
    sheet = joined(len(triangles), f, g)
    vectors = area_vectors(points, triangles)
    turned = np.zeros(len(triangles), bool)
    for number in range(sheet.max() + 1):
        own = sheet == number
        mean, area = vectors[own].sum(axis=0), np.linalg.norm(vectors[own], axis=1).sum()
        centres = points[triangles[own]].mean(axis=1)
        nearest = np.flatnonzero(np.abs(mean) >= (1 - SAME_PLACE) * np.abs(mean).max())[-1]
        outward = np.sum((centres - centres.mean(axis=0)) * vectors[own])
        turned[own] = (outward if np.linalg.norm(mean) < SAME_PLACE * area else mean[nearest]) < 0
    return np.where(turned[:, None], triangles[:, ::-1], triangles)


def _neighbours(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return two arrays of directed edges (3 * triangle + side): both sides of edges with two triangles."""
    _, of_corner, count = unique_edges(triangles)
    return edge_sides(of_corner, count == 2)


def without_slivers(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Remove flat caps: flip inner ones at their long edge and drop outer ones; return the triangles.

    The flattest caps go first; a cap whose neighbour has changed waits for the next pass. After
    SLIVER_PASSES passes, caps may be left. Changes the array `triangles` in place.
    """
    for _ in range(SLIVER_PASSES):
        height, side = _heights(points, triangles)
        caps = np.flatnonzero(height < SLIVER)
        if not len(caps):
            break
        f, g = _neighbours(triangles)
        across = np.full(3 * len(triangles), -1)
        across[f], across[g] = g, f
        touched = np.zeros(len(triangles), bool)
        dropped = np.zeros(len(triangles), bool)
        for t in caps[np.argsort(height[caps], kind="stable")].tolist():
            edge = across[3 * t + side[t]]
            if touched[t] or (edge >= 0 and touched[edge // 3]):
                continue
            touched[t] = True
            if edge < 0:
                dropped[t] = True
                continue
            u = edge // 3
            touched[u] = True
            a, b, c = np.roll(triangles[t], -side[t]).tolist()
            d = int(triangles[u, (edge % 3 + 2) % 3])
            triangles[t], triangles[u] = (a, d, c), (d, b, c)
        triangles = triangles[~dropped]
    return triangles


def _heights(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return heights (m,) on the longest edge, relative to its length, and the number (m,) of that edge.

    The height of a needle, a triangle with one short edge, is set to inf, because it is not a cap.
    """
    corner = points[triangles]
    length = np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2)
    longest = length.max(axis=1)
    height = 2 * np.linalg.norm(area_vectors(points, triangles), axis=1) / longest**2
    height[length.min(axis=1) < 10 * SLIVER * longest] = np.inf
    return height, length.argmax(axis=1)


def near_box(points: np.ndarray, triangles: np.ndarray, box: np.ndarray) -> np.ndarray:
    """Return ids of the triangles (m, 3) within BOX_DISTANCE of the box (2, 3).

    Further triangles are added where the boundary would touch itself, so that it forms simple loops.
    """
    margin = BOX_DISTANCE * np.linalg.norm(box[1] - box[0])
    near = meets_box(points[triangles], box + np.array([[-margin], [margin]]))
    while near.any():
        # points through which the boundary passes more than once
        edges, _, number = unique_edges(triangles[near])
        pinched = np.bincount(edges[number == 1].ravel(), minlength=len(points)) > 2
        more = pinched[triangles].any(axis=1) & ~near
        if not more.any():
            break
        near |= more
    return np.flatnonzero(near)
