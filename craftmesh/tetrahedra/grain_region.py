"""The tetrahedra inside a grain, by flood fill from its facets, and seeds of regions to leave empty."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from craftmesh.surface.connectivity import same_turn
from craftmesh.surface.rounding import ROUNDING
from craftmesh.tetrahedra.grain_surface import GrainSurface
from craftmesh.tetrahedra.kernels.tet_cavity import FACES, link_tets
from craftmesh.tetrahedra.kernels.tet_regions import find_facets, part_regions, sum_volumes

# Shift of given seeds along x, y and z, as fractions of the grain's extents. It takes a seed off the faces,
# edges and diagonals of a regular grid.
OFF_FACES = np.array([1.0, 0.7, 0.4]) * 1e-7


class WrongMesh(Exception):
    """A mesh that does not fill its grain exactly; `where`: rows of the faulty facets of the grain."""

    def __init__(self, reason: str, where: Sequence[int] | np.ndarray = ()):
        super().__init__(reason)
        self.where = np.asarray(where, np.int64)


@dataclass(frozen=True)
class Regions:
    """Regions of a mesh, which the grain's facets separate from each other.

    region (t,): number of each tet's region; is_grain (r,): mask of the regions inside the grain.
    """

    region: np.ndarray
    is_grain: np.ndarray

    @property
    def kept(self) -> np.ndarray:
        """Mask (t,) of tets inside the grain."""
        return self.is_grain[self.region]


def find_regions(surface: GrainSurface, tets: np.ndarray) -> Regions:
    """Return the regions into which the grain's facets divide the tets (t, 4), inside and outside.

    A region is inside the grain if it lies behind the boundary facets that it touches. Raises WrongMesh if
    facets are missing from the mesh or duplicate, or if a region lies behind one facet and ahead of
    another, because the surface is open or inconsistently oriented.
    """
    triples = np.sort(surface.facets, axis=1)
    order = np.lexsort(triples.T[::-1])
    triples = triples[order]
    twice = np.sort(order[1:][(triples[1:] == triples[:-1]).all(axis=1)])
    if len(twice):
        raise WrongMesh(f"{len(twice)} of its facets are duplicates, with the same corners", twice)

    on_surface = len(surface.points)
    points = max(int(tets.max(initial=-1)) + 1, on_surface)
    neighbours, found = np.empty((2, len(tets), 4), np.int64)
    region, work = np.empty((2, len(tets)), np.int64)
    link_tets(tets, len(tets), points, neighbours, np.empty(points, np.int64))
    find_facets(tets, triples, on_surface, found)
    count = part_regions(neighbours, found, region, work)

    tet, corner = np.nonzero(found >= 0)
    facet, of = order[found[tet, corner]], region[tet]
    behind = ~same_turn(tets[tet[:, None], FACES[corner]], surface.facets[facet])
    boundary = ~surface.internal[facet]
    votes_in = np.bincount(of, behind & boundary, count) > 0
    votes_out = np.bincount(of, ~behind & boundary, count) > 0
    kept_faces = np.bincount(facet, votes_in[of], len(surface.facets))
    leaks = votes_in & votes_out
    if leaks.any():
        suspect = np.unique(facet[leaks[of]])
        raise WrongMesh("its facets are not closed, or some of their normals point inward", suspect)
    wrong = np.flatnonzero(kept_faces != np.where(surface.internal, 2, 1))
    if len(wrong):
        raise WrongMesh(f"{len(wrong)} of its {len(surface.facets)} facets are no faces of its mesh", wrong)
    return Regions(region, votes_in)


def check_filled(surface: GrainSurface, points: np.ndarray, tets: np.ndarray) -> None:
    """Raise WrongMesh unless the tets (t, 4) on points (n, 3) fill the grain.

    The first points must be the surface's points bit for bit. No tet may be flat or inverted, and the total
    volume may differ from the volume in the surface by the fraction ROUNDING.
    """
    count = len(surface.points)
    if not np.array_equal(points[:count], surface.points):
        raise WrongMesh("the mesher moved nodes of its surface")
    volume, wrong = sum_volumes(points, tets)
    if wrong:
        raise WrongMesh(f"{wrong} of its {len(tets)} tetrahedra are flat or inverted")
    if abs(volume - surface.volume) > ROUNDING * surface.volume:
        raise WrongMesh(
            f"its tetrahedra fill a volume of {volume:.12g}, but its facets enclose {surface.volume:.12g}"
        )


def hole_seeds(points: np.ndarray, tets: np.ndarray, regions: Regions) -> np.ndarray:
    """Return a seed (h, 3), a point inside, for each region outside the grain, in the order of regions.

    The point is the centroid of the region's tet with the largest inscribed sphere.
    """
    outside = np.flatnonzero(~regions.kept)
    if not len(outside):
        return np.zeros((0, 3))
    corners = points[tets[outside]]
    a, b, c, d = (corners[:, i] for i in range(4))
    area = sum(
        np.linalg.norm(np.cross(q - p, r - p), axis=1)
        for p, q, r in ((a, b, c), (a, b, d), (a, c, d), (b, c, d))
    )
    radius = np.abs(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a)) / np.maximum(area, 1e-300)
    order = np.lexsort((-radius, regions.region[outside]))
    _, first = np.unique(regions.region[outside][order], return_index=True)
    return corners[order[first]].mean(1)


def replace_by_given(
    seeds: np.ndarray, given: np.ndarray, points: np.ndarray, tets: np.ndarray, regions: Regions
) -> tuple[np.ndarray, int]:
    """Return seeds (h, 3), replaced by given ones where possible, and the number of given seeds not used.

    seeds: from `hole_seeds`, one for each region outside the grain; given (k, 3): a given seed replaces the
    seed of the region that it lies in. Given seeds in no such region are counted.
    """
    outside = np.flatnonzero(~regions.kept)
    holes = np.unique(regions.region[outside])
    result, off = seeds.copy(), 0
    # a seed may lie on a face between two tets, as voxel centres do; shifted off the face, it lies in one
    for seed in given + OFF_FACES * np.ptp(points, axis=0):
        inside = outside[_holds(points[tets[outside]], seed)]
        if len(inside):
            result[np.searchsorted(holes, regions.region[inside[0]])] = seed
        else:
            off += 1
    return result, off


def _holds(corners: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Return a mask (t,) of tets with `corners` (t, 4, 3) that contain the point strictly inside."""
    a, b, c, d = (corners[:, i] - point for i in range(4))
    faces = ((a, b, c), (a, c, d), (a, d, b), (b, d, c))
    turn = np.stack([np.einsum("ij,ij->i", np.cross(p, q), r) for p, q, r in faces], axis=1)
    return np.all(turn > 0, axis=1) | np.all(turn < 0, axis=1)
