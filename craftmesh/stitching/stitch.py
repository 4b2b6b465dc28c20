"""Stitch the closed surfaces of grains to one conformal surface."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from craftmesh.arguments import as_array, check_indices, typed
from craftmesh.errors import CraftmeshError
from craftmesh.mesh.tet_connectivity import RowGroups, group_triples
from craftmesh.options import Options, option
from craftmesh.stitching.misfits import refuse_lost, refuse_misfits
from craftmesh.stitching.outer_shells import grain_names, in_pieces, refuse_gaps, starts_of, with_voids
from craftmesh.surface.connectivity import compact, joined, lowest_equal_point, open_edges, same_turn
from craftmesh.surface.kernels.boundaries import close_pairs
from craftmesh.surface.measure import swept_volumes, unit_normals
from craftmesh.surface.rounding import ROUNDING
from craftmesh.types import INTERFACE, Surface


@dataclass(frozen=True)
class StitchOptions(Options):
    """Options of the stage `stitch`: the distance below which points are merged."""

    tolerance: float = option(
        1e-6, "points closer than this fraction of the model's diagonal become one", at_least=0, below=1
    )


Grain = tuple[int, np.ndarray, np.ndarray]  # id, points (n, 3), triangles (m, 3)
FACING_OUT = 0.9  # smallest cosine between an axis and the normal of a facet on the box


@dataclass(frozen=True, eq=False)
class _Soup:
    """All grains' facets on shared points, with outward normals, rows sorted by grain id.

    A facet between two grains is there twice, once for each; groups: groups of facets with equal corners.
    """

    points: np.ndarray
    facets: np.ndarray
    grain: np.ndarray
    groups: RowGroups


@typed
def stitch_grains(grains: Sequence[Grain], options: StitchOptions | None = None) -> tuple[Surface, dict]:
    """Return the conformal surface of grains given as (id, points (n, 3), triangles (m, 3)), and a report.

    Points closer than options.tolerance times the diagonal are merged. A facet that two grains share
    becomes one facet between them. A facet without a partner lies on a box plane, on a void -k (a closed
    shell off the box, numbered by its lowest point) or on the exterior 0. Box planes are exact.
    Raises CraftmeshError if a grain is open or loses much area, if neighbours do not match, and if surfaces
    intersect or touch no others; it names grains and places. The report's notes list guesses: inverted
    grains that were turned, voids, grains of several components.
    """
    options = options or StitchOptions()
    soup, figures = _joined(grains, options)
    facets, sides = _paired(soup)
    ids, pieces = np.unique(soup.grain), in_pieces(soup.points, soup.facets, soup.grain)
    points = soup.points
    del soup  # frees memory: it has two facets for each facet between grains
    points, kind = _on_box(points, facets, sides, options)
    alone = np.flatnonzero((sides[:, 1] == 0) & (kind == INTERFACE))
    refuse_gaps(points, facets, sides, alone)
    sides, voids = with_voids(points, facets, sides, kind, alone)
    refuse_misfits(points, facets, sides)
    points, facets, _ = compact(points, facets)
    exterior = int(((sides == 0).any(axis=1) & (kind == INTERFACE)).sum())
    report = {"grains": len(grains), "points": len(points), "facets": len(facets)} | figures
    report |= {
        "box_facets": int((kind != INTERFACE).sum()),
        "voids": voids,
        "exterior_facets": exterior,
        "notes": _notes(ids, pieces, voids, exterior, figures["grains_turned"]),
    }
    return Surface(points, facets, sides, kind), report


def _joined(grains: Sequence[Grain], options: StitchOptions) -> tuple[_Soup, dict]:
    """Merge points of all grains within the tolerance, drop collapsed facets, turn inverted grains.

    Return the soup and the report's numbers of merged points, dropped facets and turned grains. Raise
    CraftmeshError if a grain loses much of its area.
    """
    ids, parts = np.array(sorted(_ids(grains)), np.int32), list(_distinct(grains))
    shift = np.cumsum([0, *(len(points) for points, _ in parts)])
    points = np.concatenate([points for points, _ in parts])
    facets = np.concatenate([triangles + s for (_, triangles), s in zip(parts, shift)])
    grain = np.repeat(ids, [len(triangles) for _, triangles in parts])
    del parts
    first, inverse = _first_equal(points)
    inverse = _cluster(points[first], options.tolerance)[inverse]
    merged = inverse[facets]
    a, b, c = merged.T
    distinct = (a != b) & (b != c) & (c != a)
    kept = distinct.copy()
    groups = group_triples(merged[distinct])
    kept[distinct] = ~_folded(merged[distinct], grain[distinct], groups.pairs)
    if not kept.all():
        refuse_lost(points, facets, grain, kept)
        merged, grain = merged[kept], grain[kept]
        groups = group_triples(merged)
    del facets
    soup, turned = _outward(points[first], merged, grain, groups)
    used = np.zeros(len(soup.points), bool)
    used[soup.facets] = True
    return soup, {
        "points_joined": sum(len(points) for _, points, _ in grains) - int(used.sum()),
        "degenerate_facets_dropped": int((~distinct).sum()),
        "folded_facets_dropped": int((distinct & ~kept).sum()),
        "grains_turned": turned,
    }


def _ids(grains: Sequence[Grain]) -> list[int]:
    """Return the grains' ids; raise CraftmeshError if there are none, or ids are <= 0 or duplicate."""
    if not grains:
        raise CraftmeshError("no grains to stitch; expected one closed surface per grain")
    ids = [int(as_array("grain id", given, np.int32, ())) for given, _, _ in grains]
    for grain, times in Counter(ids).items():
        if grain <= 0 or times > 1:
            raise CraftmeshError(f"grain id {grain} is <= 0 or duplicate; expected distinct ids > 0")
    return ids


def _distinct(grains: Sequence[Grain]) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield distinct points and the triangles of each grain, by id; raise CraftmeshError for bad arrays."""
    for grain, points, triangles in sorted(grains, key=lambda given: int(given[0])):
        points = as_array(f"grain {grain}: points", points, float, (None, 3))
        triangles = as_array(f"grain {grain}: triangles", triangles, np.int64, (None, 3))
        if not len(triangles):
            raise CraftmeshError(f"grain {grain}: no triangles; expected a closed surface")
        check_indices(f"grain {grain}: triangles", triangles, len(points))
        first, inverse = _first_equal(points)
        yield points[first] + 0.0, inverse[triangles]  # turns -0.0 into 0.0, for any order of grains


def _first_equal(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the indices of the first point at each place, and for each point (n,) its row among these."""
    lowest = lowest_equal_point(points)
    is_first = lowest == np.arange(len(points))
    return np.flatnonzero(is_first), (np.cumsum(is_first) - 1)[lowest]


def _outward(
    points: np.ndarray, facets: np.ndarray, grain: np.ndarray, groups: RowGroups
) -> tuple[_Soup, list[int]]:
    """Return the soup with all grains' facets turned outward, and the ids of grains that were inverted."""
    start = starts_of(grain)
    swept = np.add.reduceat(swept_volumes(points, facets), start[:-1])
    for n in np.flatnonzero(swept < 0):
        facets[start[n] : start[n + 1]] = facets[start[n] : start[n + 1], ::-1]
    return _Soup(points, facets, grain, groups), grain[start[:-1][swept < 0]].tolist()


def _notes(ids: np.ndarray, pieces: np.ndarray, voids: int, exterior: int, turned: list[int]) -> list[str]:
    """Return sentences on guesses: turned grains, voids and exterior, grains of several components."""
    notes = []
    if turned:
        notes.append(f"the facets of grains {grain_names(turned)} looked inwards and were turned")
    if voids or exterior:
        absent = np.setdiff1d(np.arange(1, min(ids[-1], 2 * len(ids))), ids)
        notes.append(
            f"{voids} voids within grains and {exterior} facets to the outside off the box: no grain is "
            "there; if one is missing, add its file"
            + (f" (ids without one: {grain_names(absent)})" if len(absent) else "")
        )
    if len(pieces):
        notes.append(f"grains {grain_names(pieces)} consist of pieces that do not touch")
    return notes


def _cluster(points: np.ndarray, tolerance: float) -> np.ndarray:
    """Return for each point (n,) the index of the first point of its cluster.

    A cluster consists of points that are linked, directly or through others. tolerance: largest distance
    between linked points, as a fraction of the diagonal of all points.
    """
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    lowest = np.arange(len(points))
    pairs = close_pairs(points - points[0], tolerance * size, max(4 * tolerance, ROUNDING) * size or 1.0)
    if len(pairs):
        _, first, of = np.unique(joined(len(points), *pairs.T), return_index=True, return_inverse=True)
        lowest = first[of]
    return lowest


def _folded(facets: np.ndarray, grain: np.ndarray, pairs: np.ndarray) -> np.ndarray:
    """Return a mask (m,) of facets that coincide with an opposite facet of the same grain.

    A thin part of a grain collapsed there. pairs (k, 2): facets with the same corners.
    """
    own = pairs[grain[pairs[:, 0]] == grain[pairs[:, 1]]]
    is_folded = np.zeros(len(facets), bool)
    is_folded[own[~same_turn(*facets[own.T])]] = True
    return is_folded


def _paired(soup: _Soup) -> tuple[np.ndarray, np.ndarray]:
    """Return facets (m, 3), each once with the orientation of its grain of lower id, and sides (m, 2).

    Side 0 is the outside. Raises CraftmeshError if a grain is open, or if facets belong to more than two
    grains or to grains on the same side.
    """
    _refuse_open(soup)
    groups = soup.groups
    lead, pairs, crowded = groups.lead, groups.pairs, np.flatnonzero(groups.count > 2)
    if len(crowded):
        rows = groups.order[slice(*groups.first[crowded[0] : crowded[0] + 2])]
        raise CraftmeshError(
            f"grains {grain_names(soup.grain[rows])} share one facet near {_place(soup, rows[0])}; "
            "expected at most two: leave out the overlapping grains"
        )
    same_way = pairs[same_turn(*soup.facets[pairs.T])]
    if len(same_way):
        raise CraftmeshError(
            f"grains {grain_names(soup.grain[same_way[0]])} overlap near {_place(soup, same_way[0, 0])}: "
            f"{len(same_way)} facets have both grains on the same side; expected grains that only touch"
        )
    sides = np.stack([soup.grain, np.zeros_like(soup.grain)], axis=1)
    sides[pairs[:, 0], 1] = soup.grain[pairs[:, 1]]
    lead.sort()
    return soup.facets[lead], sides[lead]


def _refuse_open(soup: _Soup) -> None:
    """Raise CraftmeshError with grains and a place if the facets of a grain have open edges."""
    sides = np.stack([soup.grain, np.zeros_like(soup.grain)], axis=1)
    found = open_edges(soup.facets, sides, len(soup.points))
    if len(found):
        middle = soup.points[found[0, 1:]].mean(axis=0)
        raise CraftmeshError(
            f"grains {grain_names(found[:, 0])} are not closed: {len(found)} open edges, the first near "
            f"{np.round(middle, 4).tolist()}; expected closed surfaces: repair the files or raise tolerance"
        )


def _place(soup: _Soup, row: int) -> list[float]:
    return np.round(soup.points[soup.facets[row]].mean(axis=0), 4).tolist()


def _on_box(
    points: np.ndarray, facets: np.ndarray, sides: np.ndarray, options: StitchOptions
) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, 3) with exact box planes, and the kind (m,) of each facet: 0, or box plane 1..6.

    A facet without a partner is on a box plane if its corners are within the tolerance of the extreme
    coordinate and its normal points out of the box.
    """
    points, kind = points.copy(), np.zeros(len(facets), np.uint8)
    alone = np.flatnonzero(sides[:, 1] == 0)
    reach = options.tolerance * np.linalg.norm(np.ptp(points, axis=0))
    normals = unit_normals(points, facets[alone])
    for axis in range(3):
        for end, extreme in enumerate((points[:, axis].min(), points[:, axis].max())):
            near = np.abs(points[facets[alone], axis] - extreme).max(axis=1) <= reach
            rows = alone[near & (normals[:, axis] * (2 * end - 1) > FACING_OUT)]
            if not len(rows):
                continue
            plane = np.median(points[np.unique(facets[rows]), axis])
            points[np.abs(points[:, axis] - plane) <= 2 * reach, axis] = plane
            kind[rows] = 1 + 2 * axis + end
    return points, kind
