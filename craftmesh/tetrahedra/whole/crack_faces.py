"""The crack found again in a mesh that kept it only to within an envelope."""

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mesh.tet_connectivity import half_face_corners
from craftmesh.surface.front import front_edges
from craftmesh.surface.kernels.distances import nearest_on_edges
from craftmesh.surface.measure import (
    area_vectors,
    edge_lengths,
    nearest_facet,
    point_normals,
    total_area,
)
from craftmesh.types import CRACK, Surface

# Share by which the area may differ from the input's.
AREA_TOLERANCE = 0.03
# A front may lie this part of its median edge off the input's.
OFF_TOLERANCE = 0.5
# Height of the fins along the front, in target lengths.
FIN_HEIGHT = 0.7


def crack_half_faces(
    surface: Surface, points: np.ndarray, tets: np.ndarray, pairs: np.ndarray, reach: float
) -> np.ndarray:
    """Return half faces (c,), those of the tets ahead of the crack, that make up the crack in a mesh.

    pairs (p, 2): half faces that coincide, within the material. A face belongs to the crack when its
    corners and its centroid are within `reach` of the surface's crack facets and its two tets lie on
    different sides of them.
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
    """Return the points and facets of the surface with fins along the crack's front, square to the crack.

    They hold the front in place where a mesher lets open rims of a surface recede. lengths (n,): target
    lengths at the surface's points, about the height of the fins.
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


def recovery_of_crack(before: Surface, after: Surface) -> dict:
    """Return how well the crack was found again; raises CraftmeshError where part of it is missing.

    The area agrees to AREA_TOLERANCE, and the front lies within OFF_TOLERANCE of its edges of the input's.
    """
    areas = [total_area(s.points, s.facets[s.kind == CRACK]) for s in (before, after)]
    given, found = front_edges(before), front_edges(after)
    off, allowed = 0.0, 0.0
    if len(given) and len(found):
        ends = after.points[found]
        places = np.concatenate([ends.reshape(-1, 3), ends.mean(axis=1)])
        nearest = nearest_on_edges(places, before.points, given)
        off = float(np.linalg.norm(places - nearest, axis=1).max())
        allowed = OFF_TOLERANCE * np.median(edge_lengths(before.points, given))
    is_lost = bool(len(given)) > bool(len(found)) or abs(areas[1] - areas[0]) > AREA_TOLERANCE * areas[0]
    if is_lost or off > allowed:
        raise CraftmeshError(
            f"the mesh of the whole model keeps {areas[1]:.6g} of the crack's area {areas[0]:.6g}, and its "
            f"front lies up to {off:.3g} off: no mesh with a damaged crack is written; repair the surface "
            "where grains failed, or take a smaller envelope"
        )
    return {"crack_area_before": areas[0], "crack_area": areas[1], "front_off": off}
