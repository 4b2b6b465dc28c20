"""The surfaces (sheets) that a crack consists of: each has its own fronts and its own plane."""

from collections.abc import Sequence

import numpy as np

from craftmesh.cracks.height_parts import height_parts
from craftmesh.cracks.one_sheet import clean_triangles
from craftmesh.cracks.triangulated import boundary_loops, crack_from_triangles, with_fronts
from craftmesh.cracks.within_box import is_in
from craftmesh.errors import CraftmeshError
from craftmesh.surface.connectivity import compact, joined, pieces, unique_edges
from craftmesh.surface.measure import meets_box, nearest_facet, total_area
from craftmesh.types import Crack


def sheets(crack: Crack) -> list[Crack]:
    """Return the edge-connected surfaces of a crack as separate cracks, in the order of their triangles."""
    piece = pieces(crack.triangles)
    if piece.max(initial=0) == 0:
        return [crack]
    found = []
    for number in range(piece.max() + 1):
        points, triangles, kept = compact(crack.points, crack.triangles[piece == number])
        new = np.full(len(crack.points), -1)
        new[kept] = np.arange(len(kept))
        fronts = [new[front] for front in crack.fronts if (new[front] >= 0).all()]
        found.append(Crack(points, triangles, tuple(fronts)))
    return found


def by_place(crack: Crack) -> list[Crack]:
    """Return the surfaces of a crack, sorted by their lowest point (by x, then y, then z).

    Points, triangles and fronts of each are sorted by position too, so that the order in the input makes no
    difference; triangles keep their orientation.
    """
    return sorted(map(_by_place, sheets(crack)), key=lambda sheet: sheet.points[0].tolist())


def _by_place(sheet: Crack) -> Crack:
    order = np.lexsort(sheet.points.T[::-1])
    new = np.argsort(order)
    triangles = new[sheet.triangles]
    turn = np.argmin(triangles, axis=1)[:, None] + np.arange(3)
    triangles = np.take_along_axis(triangles, turn % 3, axis=1)
    fronts = sorted(_from_least(new[front]) for front in sheet.fronts)
    return Crack(
        sheet.points[order], triangles[np.lexsort(triangles.T[::-1])], tuple(map(np.array, fronts))
    )


def _from_least(front: np.ndarray) -> list[int]:
    """Return a front's ids in an order independent of its direction and start.

    An open front begins at its lower end id, a closed front at its lowest id, towards the lower neighbour.
    """
    if front[0] != front[-1]:
        return min(front.tolist(), front[::-1].tolist())
    start = int(np.argmin(front))
    ring = np.roll(front[:-1], -start).tolist()
    ring.append(ring[0])
    return min(ring, ring[::-1])


def heights_of(sheet: Crack, box: np.ndarray) -> list[Crack]:
    """Return a surface as parts that are single-valued over their planes, or itself if it is; box (2, 3).

    The largest part comes first, so that a kink across an edge of the box is cut from the plane of that
    part. Fronts of a part are the fronts of the surface and the seams to other parts. Parts outside the box
    are dropped. Raise CraftmeshError if the surface cannot be split into such parts.
    """
    parts, fault = height_parts(sheet.points, sheet.triangles)
    if fault:
        raise CraftmeshError(fault)
    if len(parts) == 1:
        return [sheet]
    return [
        with_fronts(points, triangles, boundary_loops(triangles), None, box)
        for points, triangles in sorted(parts, key=lambda part: -total_area(*part))
        if is_in(points[triangles], box)
    ]


def seam_ends(parts: list[Crack]) -> np.ndarray:
    """Return ends (k, 3) of the seams between parts: boundary points of the surface in several parts."""
    if len(parts) == 1:
        return np.zeros((0, 3))
    points, every = np.unique(np.concatenate([part.points for part in parts]), axis=0, return_inverse=True)
    of_part = np.split(every.ravel(), np.cumsum([len(part.points) for part in parts])[:-1])
    edges, _, count = unique_edges(
        np.concatenate([own[part.triangles] for own, part in zip(of_part, parts)])
    )
    times = np.bincount(every.ravel())
    rim = np.unique(edges[count == 1])
    ends: np.ndarray = points[rim[times[rim] > 1]]
    return ends


def one_crack(cracks: Sequence[Crack]) -> Crack:
    """Return all cracks as one, in order; points are not merged, so each surface stays separate."""
    if len(cracks) == 1:
        return cracks[0]
    shifts = np.cumsum([0, *(len(crack.points) for crack in cracks)])
    return Crack(
        np.concatenate([crack.points for crack in cracks]),
        np.concatenate([crack.triangles + shift for crack, shift in zip(cracks, shifts)]),
        tuple(front + shift for crack, shift in zip(cracks, shifts) for front in crack.fronts),
    )


def cracks_from_triangles(
    points: np.ndarray,
    triangles: np.ndarray,
    fronts: Sequence[np.ndarray] | None,
    box: np.ndarray,
) -> Crack:
    """Return the crack of a triangulated surface of one or several pieces, without pieces outside the box.

    Each piece becomes a crack as in crack_from_triangles. A front whose points all belong to a piece is
    used for that piece only. If any piece has such a front, the front of a piece without one is its
    boundary in the box; if none has, every piece gets all fronts.
    """
    points, triangles = clean_triangles(points, triangles)
    piece = pieces(triangles)
    if piece.max() == 0:
        return crack_from_triangles(points, triangles, fronts, box)
    meets = meets_box(points[triangles], box)
    found = np.unique(piece[meets]) if meets.any() else np.unique(piece)
    parts = [compact(points, triangles[piece == k])[:2] for k in found]
    own = [[front for front in fronts or () if _is_of(front, part[0])] for part in parts]
    named = [mine or None for mine in own] if any(own) else [fronts] * len(parts)
    return one_crack([crack_from_triangles(*part, mine, box) for part, mine in zip(parts, named)])


def _is_of(front: np.ndarray, points: np.ndarray) -> bool:
    """Return whether all points of a front (k, 3) are among the points (n, 3)."""
    known = {tuple(point) for point in points.tolist()}
    return all(tuple(point) in known for point in np.asarray(front, float).tolist())


def crack_numbers(points: np.ndarray, facets: np.ndarray, crack: Crack | None = None) -> np.ndarray:
    """Return numbers (m,), from 0, of the crack that each crack facet (m, 3) belongs to.

    If `crack` is None, each edge-connected piece has a number, in the order of first facets. Otherwise a
    piece gets the number of the nearest surface of `crack`: pieces of one surface that the box or a void
    separates share a number, as do surfaces that have grown together. The numbers follow the order of the
    surfaces.
    """
    piece = pieces(facets)
    if crack is None or not len(facets):
        return piece
    sheet = _nearest_sheet(points[facets].mean(axis=1), crack)
    width = int(piece.max()) + 1
    size = width + int(sheet.max()) + 1
    found = joined(size, piece, width + sheet)
    first = np.full(size, size)
    np.minimum.at(first, found[width + sheet], sheet)
    return np.unique(first[found[piece]], return_inverse=True)[1].ravel()


def _nearest_sheet(places: np.ndarray, crack: Crack) -> np.ndarray:
    """Return the number (n,) of the crack's surface nearest to each place (n, 3)."""
    sheet = pieces(crack.triangles)
    if sheet.max() == 0:
        return np.zeros(len(places), np.int64)
    nearest = nearest_facet(places, crack.points, crack.triangles.astype(np.int64))[0]
    of_place: np.ndarray = sheet[nearest]
    return of_place
