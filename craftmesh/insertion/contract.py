"""Short edges of crack facets are contracted, others swapped for the other diagonal."""

from dataclasses import replace

import numpy as np

from craftmesh.insertion.cut import CutSurface
from craftmesh.insertion.guarded_move import LEAST_ANGLE, meet_others
from craftmesh.surface.connectivity import facet_edges, unique_edges
from craftmesh.surface.measure import area_vectors, facet_angles
from craftmesh.surface.patches import is_on_box
from craftmesh.types import CRACK

# Degrees: a facet with a larger angle is a cap. One of 177 beside the trace of a boundary, square to the
# facets around, was taken for a fold of the crack and left 2 flat tetrahedra.
CAP = 165.0


def swap_at(facets: np.ndarray, sides: np.ndarray, kind: np.ndarray, a: int, b: int) -> tuple | None:
    """Return the rows (2,) of the facets at edge (a, b) and their corners (2, 3) with the other diagonal.

    None where these are not two, of one kind between the same sides, and where that diagonal is an edge.
    """
    rows = np.flatnonzero((facets == a).any(axis=1) & (facets == b).any(axis=1))
    if len(rows) != 2 or (sides[rows[0]] != sides[rows[1]]).any() or kind[rows[0]] != kind[rows[1]]:
        return None
    c, d = (int(facets[row][~np.isin(facets[row], (a, b))][0]) for row in rows)
    if ((facets == c).any(axis=1) & (facets == d).any(axis=1)).any():
        return None
    after = np.stack([np.where(facets[rows[0]] == a, d, facets[rows[0]]), facets[rows[1]]])
    after[1][after[1] == b] = c
    return rows, after


def is_sound(points: np.ndarray, facets: np.ndarray, rows: np.ndarray, after: np.ndarray) -> bool:
    """Tell whether facets `rows` may become `after` (k, 3): no needles, none through another facet."""
    if (facet_angles(points, after).min(axis=1) < LEAST_ANGLE).any():
        return False
    return not meet_others(points, after, np.delete(facets, rows, axis=0))


def without_caps(surface: CutSurface) -> CutSurface:
    """Return the surface with the longest edges of crack facets over CAP degrees swapped, where sound."""
    crack = np.flatnonzero(surface.kind >= CRACK)
    angles = facet_angles(surface.points, surface.facets[crack])
    caps = np.flatnonzero(angles.max(axis=1) > CAP)
    if not len(caps):
        return surface
    # the edge opposite to corner k runs from corner k + 1 on
    corner = (angles[caps].argmax(axis=1) + 1) % 3
    edges = facet_edges(surface.facets[crack[caps]]).reshape(-1, 3, 2)[np.arange(len(caps)), corner]
    facets = surface.facets.copy()
    for a, b in edges.tolist():
        found = swap_at(facets, surface.sides, surface.kind, a, b)
        if found is not None and is_sound(surface.points, facets, *found):
            facets[found[0]] = found[1]
    return replace(surface, facets=facets)


SHORT = 0.35  # of the local size: edges of crack facets below are contracted
LONG = 0.8  # of the local size: the same at points that are off the crack
SLIVER = 12.0  # degrees: a facet with a smaller angle may turn in any way, for its normal says little
TURN = np.cos(np.radians(60.0))  # other facets turn by less
LEAST_LEFT = 2.0  # degrees: a contraction leaves no facet below this, unless one was worse


def contracted(
    surface: CutSurface, off: np.ndarray, ways: np.ndarray, ahead: float = 0.0, short: float = SHORT
) -> CutSurface:
    """Return the surface without edges of crack facets under `short` sizes, as far as it stays sound.

    off (k,): points that could not be moved onto the crack by ways (k, 3). Their edges of crack facets
    count as short up to LONG, and so do their edges to points that lie in their way, up to `ahead` degrees
    beside it.

    An edge goes to one of its ends: where both boundaries keep to their planes of the box, the one on more
    patches first. Closed grains stay closed.
    """
    on_crack = np.zeros(len(surface.points), bool)
    on_crack[surface.facets[surface.kind >= CRACK]] = True
    edges, _, _ = unique_edges(surface.facets[surface.kind >= CRACK])
    edges = np.concatenate([edges, _in_the_way(surface, on_crack, off, ways, ahead)])
    near = on_crack.copy()
    near[edges] = True
    star = _Stars(surface, near)
    length = np.linalg.norm(np.diff(surface.points[edges], axis=1)[:, 0], axis=1)
    limit = np.where(np.isin(edges, off).any(axis=1), LONG, short)
    is_short = length < limit * surface.size[edges].min(axis=1)
    for v, w in edges[is_short][np.argsort(length[is_short], kind="stable")].tolist():
        ends = sorted(((v, w), (w, v)), key=lambda pair: (star.rank(pair[1]), -pair[1]), reverse=True)
        any(star.contract(gone, kept) for gone, kept in ends)
    alive = star.alive
    return replace(surface, facets=star.facets[alive], sides=surface.sides[alive], kind=surface.kind[alive])


def _in_the_way(
    surface: CutSurface, on_crack: np.ndarray, off: np.ndarray, ways: np.ndarray, ahead: float
) -> np.ndarray:
    """Return the edges (k, 2) from points off the crack to points of no crack in their way."""
    way = np.zeros_like(surface.points)
    way[off] = ways
    is_off = np.any(way != 0, axis=1)
    edges, _, _ = unique_edges(surface.facets[is_off[surface.facets].any(axis=1)])
    edges = np.concatenate([edges, edges[:, ::-1]])
    edges = edges[is_off[edges[:, 0]] & ~on_crack[edges[:, 1]]]
    step, along = surface.points[edges[:, 1]] - surface.points[edges[:, 0]], way[edges[:, 0]]
    length = np.linalg.norm(step, axis=1) * np.linalg.norm(along, axis=1)
    cosine = np.einsum("ij,ij->i", step, along) / length
    return edges[np.degrees(np.arccos(np.clip(cosine, -1, 1))) < ahead]


class _Stars:
    """A surface's facets while edges are contracted, and those around each point that is near (n,)."""

    def __init__(self, surface: CutSurface, near: np.ndarray) -> None:
        self.surface, self.facets = surface, surface.facets.copy()
        self.alive = np.ones(len(self.facets), bool)
        self.around: dict[int, set[int]] = {point: set() for point in np.flatnonzero(near).tolist()}
        for row, corner in zip(*np.nonzero(near[self.facets])):
            self.around[int(self.facets[row, corner])].add(int(row))
        self.band = np.flatnonzero(near[self.facets].any(axis=1))

    def patches(self, point: int) -> set[tuple[int, ...]]:
        """Return the patches at a point: kind and sides of its facets."""
        rows = sorted(self.around[point])
        sides = np.sort(self.surface.sides[rows], axis=1)
        return {(int(k), *map(int, s)) for k, s in zip(self.surface.kind[rows], sides)}

    def rank(self, point: int) -> int:
        return len(self.patches(point))

    def contract(self, gone: int, kept: int) -> bool:
        """Contract an edge to its end `kept` where that is sound; say if it was."""
        both = self.around[gone] & self.around[kept]
        planes = {patch[0] for patch in self.patches(gone) if is_on_box(np.array(patch[0]))} - {
            patch[0] for patch in self.patches(kept)
        }
        alone = self.around[gone] == both  # a corner of the crack, which would get smaller
        if not both or alone or planes or not self._linked(gone, kept, both):
            return False
        rows = np.array(sorted(self.around[gone] - both))
        before = self.facets[rows]
        after = np.where(before == gone, kept, before)
        if not self._sound(before, after, rows, both):
            return False
        self.facets[rows] = after
        self.alive[sorted(both)] = False
        for row in both:
            for point in self.facets[row].tolist():
                if point in self.around:
                    self.around[point].discard(row)
        self.around[kept] |= set(rows.tolist())
        self.around[gone] = set()
        return True

    def _linked(self, gone: int, kept: int, both: set[int]) -> bool:
        """Tell whether the link condition holds: the ends share what the edge's facets share, no more."""
        corners = [set(self.facets[sorted(self.around[end])].ravel().tolist()) for end in (gone, kept)]
        opposite = set(self.facets[sorted(both)].ravel().tolist())
        if corners[0] & corners[1] != opposite:
            return False
        links = [
            {frozenset(row) - {end} for row in self.facets[sorted(self.around[end] - both)].tolist()}
            for end in (gone, kept)
        ]
        return not links[0] & links[1]

    def _sound(self, before: np.ndarray, after: np.ndarray, rows: np.ndarray, both: set[int]) -> bool:
        """Tell whether facets may become `after`: none flat, turned over or through others."""
        points = self.surface.points
        old, new = area_vectors(points, before), area_vectors(points, after)
        was, now = facet_angles(points, before).min(axis=1), facet_angles(points, after).min(axis=1)
        length = np.linalg.norm(old, axis=1) * np.linalg.norm(new, axis=1)
        turned = (np.einsum("ij,ij->i", old, new) < TURN * length) & (was > SLIVER)
        if turned.any() or (now < np.minimum(LEAST_LEFT, was)).any():
            return False
        others = self.band[self.alive[self.band] & ~np.isin(self.band, [*rows.tolist(), *both])]
        return not meet_others(points, after, self.facets[others])
