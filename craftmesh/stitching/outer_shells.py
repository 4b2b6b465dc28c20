"""Facets of only one grain: gaps between grains, voids and the exterior; grains of several components."""

import numpy as np
import scipy

from craftmesh.errors import CraftmeshError
from craftmesh.surface.connectivity import facet_edges, pieces
from craftmesh.surface.front import among_edges
from craftmesh.surface.kernels.boundaries import outer_shells
from craftmesh.surface.measure import area_vectors, swept_volumes, unit_normals
from craftmesh.types import INTERFACE

GAP = 0.15  # edge lengths: facets of two grains that face each other at a smaller distance should match
FACING = -0.7  # largest cosine between the normals of facets that face each other
NEIGHBOURS = 8  # nearest facets by centre that are compared with a facet, itself included
CROWD = 0.5  # fraction of neighbours that must be faulty too: sharp edges of voids flag single facets
# Volume of a closed shell, relative to its area times the root of its mean facet area, below which the
# shell is not a void but two triangulations of one boundary.
FLAT_SHELL = 0.01


def refuse_gaps(points: np.ndarray, facets: np.ndarray, sides: np.ndarray, alone: np.ndarray) -> None:
    """Raise CraftmeshError if facets of two grains face each other closely but do not match.

    points (n, 3), facets (m, 3), sides (m, 2); alone (k,): indices of facets that no other grain shares.
    Compared are NEIGHBOURS nearest facets; single facets without a crowd of faulty neighbours are accepted.
    """
    if not len(alone):
        return
    corner = points[facets[alone]]
    centre = corner.mean(axis=1)
    edge = np.sqrt(((corner - np.roll(corner, 1, axis=1)) ** 2).sum(axis=2)).mean(axis=1)
    normal = unit_normals(points, facets[alone])
    distance, near = scipy.spatial.cKDTree(centre).query(centre, k=min(NEIGHBOURS, len(alone)))
    near = near.reshape(len(alone), -1)
    facing = np.einsum("ij,ikj->ik", normal, normal[near]) < FACING
    height = np.abs(np.einsum("ij,ikj->ik", normal, centre[near] - centre[:, None]))
    other = sides[alone][:, :1] != sides[alone][near, 0]
    shared = (facets[alone][:, None, :, None] == facets[alone][near][:, :, None, :]).any(axis=(2, 3))
    bad = (
        facing
        & other
        & ~shared
        & (height < GAP * edge[:, None])
        & (distance.reshape(near.shape) < edge[:, None])
    )
    crowded = bad.any(axis=1)[near].mean(axis=1) > CROWD
    rows = np.flatnonzero(bad.any(axis=1) & crowded)
    if len(rows):
        partners = sides[alone][near[rows], 0][bad[rows]]
        place = np.round(centre[rows[0]], 4).tolist()
        raise CraftmeshError(
            f"grains {grain_names(np.concatenate([sides[alone[rows], 0], partners]))} do not match: "
            f"{len(rows)} facets have no partner, the first near {place}; "
            "expected the same triangles on both sides: export the grains from one conformal mesh"
        )


def with_voids(
    points: np.ndarray, facets: np.ndarray, sides: np.ndarray, kind: np.ndarray, alone: np.ndarray
) -> tuple[np.ndarray, int]:
    """Return a copy of sides (m, 2) with -k as the label ahead of void k's facets, and the number of voids.

    A void is the space inside a closed shell off the box, with the shell's grains outside. Voids are in the
    order of their shells' lowest points (smallest x, then y, then z). points (n, 3), facets (m, 3), kind
    (m,): the surface; alone (k,): facets that no other grain shares. Raise CraftmeshError if a closed shell
    encloses almost no volume.
    """
    if not len(alone):
        return sides, 0
    shell = pieces(facets[alone])
    at_box = among_edges(facet_edges(facets[alone]), facets[kind != INTERFACE]).reshape(-1, 3)
    open_shell = np.unique(shell[at_box.any(axis=1)])
    swept = swept_volumes(points, facets[alone])
    closed = [n for n in np.unique(shell).tolist() if n not in open_shell]
    members = {n: alone[shell == n] for n in closed}
    for name in closed:
        _refuse_flat(points, facets[members[name]], sides[members[name], 0], swept[shell == name].sum())
    names = [n for n in closed if swept[shell == n].sum() < 0]
    lowest = {n: tuple(min(points[facets[members[n]]].reshape(-1, 3).tolist())) for n in names}
    sides = sides.copy()
    for k, name in enumerate(sorted(names, key=lambda n: lowest[n]), start=1):
        sides[members[name], 1] = -k
    return sides, len(names)


def _refuse_flat(points: np.ndarray, facets: np.ndarray, grains: np.ndarray, volume: float) -> None:
    """Raise CraftmeshError if a closed shell has almost no volume: two triangulations of one boundary."""
    area = np.linalg.norm(area_vectors(points, facets), axis=1)
    if abs(volume) < FLAT_SHELL * area.sum() * np.sqrt(area.mean()):
        place = np.round(points[facets].mean(axis=(0, 1)), 4).tolist()
        raise CraftmeshError(
            f"grains {grain_names(grains)} do not match near {place}: "
            f"{len(facets)} facets enclose no volume; "
            "expected the same triangles on both sides: export the grains from one conformal mesh"
        )


def starts_of(grain: np.ndarray) -> np.ndarray:
    """Return the first row of each grain, then the number of rows; rows (m,) are sorted by grain."""
    return np.append(np.flatnonzero(np.diff(grain, prepend=0)), len(grain))


def in_pieces(points: np.ndarray, facets: np.ndarray, grain: np.ndarray) -> np.ndarray:
    """Return the ids of grains with several outer closed surfaces.

    points (n, 3), facets (m, 3) with outward normals, grain (m,): the facets' grain ids, ascending.
    """
    start = starts_of(grain)
    shells = outer_shells(facets, start, swept_volumes(points, facets), len(points))
    return grain[start[:-1][shells > 1]]


def grain_names(grains: np.ndarray | list[int]) -> str:
    """Return the distinct grain ids as text: the first eight ids, then the number of further ids."""
    names = [str(int(g)) for g in np.unique(grains)]
    return ", ".join(names[:8]) + (f" and {len(names) - 8} more" if len(names) > 8 else "")
