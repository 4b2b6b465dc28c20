"""Recovery of the crack in a mesh that keeps it only within an envelope, a largest distance.

A half face is a face of one tet: number 4 * tet + k for the face opposite its corner k.
"""

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mesh.tet_connectivity import half_face_corners, tet_volumes
from craftmesh.surface.front import front_edges, front_of
from craftmesh.surface.kernels.distances import nearest_on_edges
from craftmesh.surface.measure import (
    area_vectors,
    edge_lengths,
    nearest_facet,
    point_normals,
    total_area,
)
from craftmesh.types import CRACK, Surface

# Largest relative differences of crack area and front length from the input.
AREA_TOLERANCE = 0.03
FRONT_TOLERANCE = 0.1
# Largest distance of the front from the input's front, in median front edges.
OFF_TOLERANCE = 0.5
# Fractions of the move to the given front that are tried in turn at a point of the new front, and smallest
# fraction of its volume that a tet keeps in the move.
STEPS = (1.0, 0.75, 0.5, 0.25)
LEAST_VOLUME = 0.1
# Height, in target lengths, of the fins: auxiliary facets along the front, perpendicular to the crack.
FIN_HEIGHT = 0.7


def crack_half_faces(
    surface: Surface, points: np.ndarray, tets: np.ndarray, pairs: np.ndarray, reach: float
) -> np.ndarray:
    """Return the half faces (c,) that form the crack in a mesh, of the tets ahead of it.

    pairs (p, 2): coincident half faces between tets of the material. A face belongs to the crack if its
    corners and centroid are within `reach` of the crack facets of the input `surface`, and the centroids of
    its two tets lie on different sides of these facets.
    """
    crack = surface.facets[surface.kind == CRACK].astype(np.int64)
    if not len(crack) or not len(pairs):
        return np.zeros(0, np.int64)
    low, high = (f(surface.points[crack], axis=(0, 1)) for f in (np.min, np.max))
    corners = half_face_corners(tets, pairs[:, 0])
    near = ((points > low - reach) & (points < high + reach)).all(axis=1)
    candidates = np.flatnonzero(near)
    near[candidates] = nearest_facet(points[candidates], surface.points, crack)[1] <= reach
    chosen = near[corners].all(axis=1)
    pairs, corners = pairs[chosen], corners[chosen]
    chosen = nearest_facet(points[corners].mean(axis=1), surface.points, crack)[1] <= reach
    pairs = pairs[chosen]
    centres = points[tets[pairs // 4]].mean(axis=2)
    sides = [nearest_facet(centres[:, i], surface.points, crack)[2] for i in range(2)]
    return np.where(sides[0] > 0, pairs[:, 0], pairs[:, 1])[sides[0] != sides[1]]


def with_fins(surface: Surface, lengths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the surface's points and facets, and fins along the front: facets perpendicular to the crack.

    Fins keep the front in place, because the mesher lets the free border of a surface recede. lengths (n,):
    target lengths at the surface's points; a fin is FIN_HEIGHT times as high on both sides of the crack.
    """
    points, facets = surface.points, surface.facets.astype(np.int64)
    front = front_edges(surface)
    if not len(front):
        return points, facets
    crack = facets[surface.kind == CRACK]
    normal = point_normals(area_vectors(points, crack), crack, len(points))
    nodes = np.unique(front)
    rise = FIN_HEIGHT * lengths[nodes, None] * normal[nodes]
    up = np.full(len(points), -1, np.int64)
    up[nodes] = len(points) + np.arange(len(nodes))
    a, b = front.T
    above = np.concatenate([np.stack([a, b, up[b]], axis=1), np.stack([a, up[b], up[a]], axis=1)])
    below = np.where(above >= len(points), above + len(nodes), above)
    points = np.concatenate([points, points[nodes] + rise, points[nodes] - rise])
    return points, np.concatenate([facets, above, below])


def move_front_onto(
    surface: Surface, points: np.ndarray, tets: np.ndarray, crack: np.ndarray, free: np.ndarray
) -> np.ndarray:
    """Return points with the front of the crack facets (c, 3) moved onto the front of the input surface.

    free (f, 3): facets on free surfaces, whose points stay. A point moves by the largest of four fractions
    of its way (STEPS) at which each of its tets keeps more than a tenth of its volume, or stays.
    """
    front = front_edges(surface)
    rim = np.setdiff1d(front_of(crack, free), free)
    if not len(front) or not len(rim):
        return points
    targets = nearest_on_edges(points[rim], surface.points, front)
    at_rim = np.flatnonzero(np.isin(tets, rim).any(axis=1))
    moved = points.copy()
    for point, target in zip(rim.tolist(), targets):
        star = tets[at_rim[(tets[at_rim] == point).any(axis=1)]]
        least = LEAST_VOLUME * tet_volumes(points, star)
        for part in STEPS:
            moved[point] = (1 - part) * points[point] + part * target
            if (tet_volumes(moved, star) > least).all():
                break
        else:
            moved[point] = points[point]
    return moved


def recovery_of_crack(before: Surface, after: Surface) -> dict:
    """Return areas and front lengths of the crack before and after, and how far the new front is off.

    Raises CraftmeshError if a part is missing: the area must agree to 3 %, the front length to 10 %, and
    the new front must lie within half the median front edge of the input's front.
    """
    areas, fronts = zip(*(_area_and_front(surface) for surface in (before, after)))
    lengths = [edge_lengths(s.points, edges) for s, edges in zip((before, after), fronts)]
    off = 0.0
    if len(fronts[0]) and len(fronts[1]):
        ends = after.points[fronts[1]]
        places = np.concatenate([ends.reshape(-1, 3), ends.mean(axis=1)])
        nearest = nearest_on_edges(places, before.points, fronts[0])
        off = float(np.linalg.norm(places - nearest, axis=1).max())
    report = {
        "crack_area_before": areas[0],
        "crack_area": areas[1],
        "front_length_before": float(lengths[0].sum()),
        "front_length": float(lengths[1].sum()),
        "front_off": off,
    }
    lost = abs(areas[1] - areas[0]) > AREA_TOLERANCE * areas[0]
    lost |= abs(lengths[1].sum() - lengths[0].sum()) > FRONT_TOLERANCE * lengths[0].sum()
    if lost or off > OFF_TOLERANCE * np.median(lengths[0] if len(lengths[0]) else 0.0):
        raise CraftmeshError(
            f"the mesh of the whole model keeps {areas[1]:.6g} of the crack's area {areas[0]:.6g} and "
            f"{lengths[1].sum():.6g} of the front's length {lengths[0].sum():.6g}, and its front is up to "
            f"{off:.3g} away from the given front; no mesh with a damaged crack is written: repair the "
            "surface where grains failed, or use a smaller envelope"
        )
    return report


def _area_and_front(surface: Surface) -> tuple[float, np.ndarray]:
    """Return the crack's area and its front edges (e, 2)."""
    crack = surface.facets[surface.kind == CRACK]
    return total_area(surface.points, crack), front_edges(surface)
