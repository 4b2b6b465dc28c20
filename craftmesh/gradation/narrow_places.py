"""Opening of narrow places: sharp wedges of grains, gaps between the crack or its front and a boundary.

Tetrahedra in them would be as flat as they are.
"""

import numpy as np
from scipy.spatial import cKDTree

from craftmesh.gradation.kernels.codes import ON_FRONT
from craftmesh.gradation.kernels.one_pass import MOVE
from craftmesh.gradation.passes import Gradation, Limits
from craftmesh.surface.measure import area_vectors
from craftmesh.surface.wedges import Wedges, wedges

ROUNDS = 3
# Degrees: wedges under the first are opened towards the second.
SHARP = 25.0
OPENED = 28.0
# In target lengths: vertices over a crack facet and nearer than GAP are moved away; no step is over REACH.
GAP = 0.35
REACH = 0.15
OVER_FACET = 0.7
# The same for facets near a vertex of the crack front.
FRONT_GAP = 0.2
# A vertex is over a facet when its foot is inside or outside by this part of the facet at most.
BESIDE = 0.15
# Crack facets with the nearest centres in which the foot of a vertex is looked for.
CENTRES = 4
TOLERANCES = 1.5
LEAST_MOVE = 1e-3


def open_narrow_places(gradation: Gradation, limits: Limits) -> None:
    """Move vertices off box and crack away from what is too near, as far as the guards allow.

    No vertex goes further than TOLERANCES distance tolerances.
    """
    openings = {
        "wedge_openings": _wedge_moves,
        "gap_openings": _gap_moves,
        "front_openings": _front_moves,
    }
    origin = gradation.mesh.points[: gradation.mesh.used[0]].copy()
    for name, moves in openings.items():
        for _ in range(ROUNDS):
            vertices, places = moves(gradation)
            size = gradation.mesh.size[vertices]
            places = _within(origin[vertices], places, TOLERANCES * limits.distance * size)
            far = np.linalg.norm(places - gradation.mesh.points[vertices], axis=1) > LEAST_MOVE * size
            vertices, places = vertices[far], places[far]
            count = len(vertices)
            if not count or not gradation.repeat(name, MOVE, limits, vertices, places=places):
                break


def _within(origin: np.ndarray, places: np.ndarray, reach: np.ndarray) -> np.ndarray:
    """Return the places (k, 3) drawn back to the distance `reach` (k,) from their origins."""
    way = places - origin
    length = np.linalg.norm(way, axis=1)
    return origin + way * np.minimum(1.0, reach / np.maximum(length, 1e-300))[:, None]


def _is_free(gradation: Gradation, vertices: np.ndarray) -> np.ndarray:
    return gradation.mesh.flags[vertices] == 0


def _unit_normals(gradation: Gradation, facets: np.ndarray) -> np.ndarray:
    normal = area_vectors(gradation.mesh.points, facets)
    return normal / np.linalg.norm(normal, axis=1)[:, None]


def _sharp_wedges(gradation: Gradation) -> Wedges:
    """Return the wedges of grains and voids under SHARP degrees; labels are slots."""
    mesh = gradation.mesh
    living = np.flatnonzero(mesh.alive[: mesh.used[1]])
    edges, feature = gradation.edges()
    slots = mesh.patch_sides[mesh.patch[living]]
    found = wedges(mesh.points, mesh.facets[living], slots, np.sort(edges[feature], axis=1))
    found = found.where((found.label >= 0) & (found.angle < SHARP))
    return found._replace(facets=living[found.facets])


def _wedge_moves(gradation: Gradation) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices (k,) and places (k, 3) that turn the facets beside sharp wedges."""
    mesh, found = gradation.mesh, _sharp_wedges(gradation)
    found = found.where(np.argsort(found.angle, kind="stable"))
    free = _is_free(gradation, found.far)
    turn = np.radians(OPENED - found.angle) / np.maximum(free.sum(axis=1), 1)
    start = mesh.points[found.edge[:, 0]]
    axis = mesh.points[found.edge[:, 1]] - start
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    vertices, places = [], []
    for column in (0, 1):
        facet, far = found.facets[:, column], found.far[:, column]
        normal = _unit_normals(gradation, mesh.facets[facet])
        behind = mesh.patch_sides[mesh.patch[facet], 0] == found.label
        normal[~behind] *= -1
        arm = mesh.points[far] - start
        height = np.linalg.norm(np.cross(arm, axis), axis=1)
        step = np.minimum(height * np.tan(turn), REACH * mesh.size[far])
        place = mesh.points[far] + step[:, None] * normal
        vertices.append(far[free[:, column]])
        places.append(place[free[:, column]])
    return np.concatenate(vertices), np.concatenate(places)


def _gap_moves(gradation: Gradation) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices (k,) over crack facets and places (k, 3) further away, the nearest first."""
    mesh = gradation.mesh
    living = gradation.living(on_crack=True)
    if not len(living):
        return np.zeros(0, np.int64), np.zeros((0, 3))
    corners = mesh.points[mesh.facets[living]]
    normal = _unit_normals(gradation, mesh.facets[living])
    vertices = np.flatnonzero(mesh.first[: mesh.used[0]] >= 0)
    vertices = vertices[_is_free(gradation, vertices)]
    row, nearest = _facets_under(mesh.points[vertices], mesh.size[vertices], corners, normal)
    vertices = vertices[row]
    size = mesh.size[vertices]
    height = np.einsum("ij,ij->i", mesh.points[vertices] - corners[nearest, 0], normal[nearest])
    order = np.flatnonzero(np.abs(height) < GAP * size)
    order = order[np.argsort(np.abs(height)[order] / size[order], kind="stable")]
    step = np.minimum(GAP * size - np.abs(height), REACH * size) * np.where(height < 0, -1.0, 1.0)
    places = mesh.points[vertices] + step[:, None] * normal[nearest]
    return vertices[order], places[order]


def _facets_under(
    places: np.ndarray, size: np.ndarray, corners: np.ndarray, normal: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows of `places` (n, 3) that are close over a facet, and that facet's row in each case.

    Of the facets (m, 3, 3) with unit normals (m, 3) the one with the nearest centre counts. What is beside
    them all, as a boundary that goes on in the crack's plane beyond its front, is over none.
    """
    tree = cKDTree(corners.mean(axis=1))
    reach = np.hypot(OVER_FACET, GAP) * size
    ranks = np.arange(1, min(CENTRES, len(corners)) + 1)
    distance, facet = tree.query(places, ranks, distance_upper_bound=float(reach.max(initial=0)))
    row, rank = np.nonzero(distance < reach[:, None])
    facet = facet[row, rank]
    height = np.einsum("ij,ij->i", places[row] - corners[facet, 0], normal[facet])
    weight = _weights(corners[facet], normal[facet], places[row] - height[:, None] * normal[facet])
    over = weight.min(axis=1, initial=np.inf) > -BESIDE
    row, first = np.unique(row[over], return_index=True)
    return row, facet[over][first]


def _front_moves(gradation: Gradation) -> tuple[np.ndarray, np.ndarray]:
    """Return corners (k,) of facets close to the crack front and places (k, 3) away, the closest first."""
    mesh = gradation.mesh
    vertex, corners = _near_front(gradation)
    normal = _unit_normals(gradation, corners)
    height = np.einsum("ij,ij->i", mesh.points[vertex] - mesh.points[corners[:, 0]], normal)
    weight = _weights(mesh.points[corners], normal, mesh.points[vertex] - height[:, None] * normal)
    missing = FRONT_GAP * mesh.size[vertex] - np.abs(height)
    chosen = np.flatnonzero((missing > 0) & (weight.min(axis=1, initial=np.inf) > -BESIDE))
    chosen = chosen[np.argsort(-missing[chosen] / mesh.size[vertex[chosen]], kind="stable")]
    moved = corners[chosen]
    step = np.minimum(missing[chosen, None], REACH * mesh.size[moved]) * -np.sign(height[chosen, None])
    places = mesh.points[moved] + step[:, :, None] * normal[chosen, None]
    free = _is_free(gradation, moved) & (weight[chosen] > 0)
    return moved[free], places[free]


def _near_front(gradation: Gradation) -> tuple[np.ndarray, np.ndarray]:
    """Return front vertices (k,) and corners (k, 3) of facets, off the crack, that may be close to them."""
    mesh = gradation.mesh
    front = np.flatnonzero((mesh.first >= 0) & (mesh.flags & ON_FRONT > 0))
    living = gradation.living(on_crack=False)
    if not len(front) or not len(living):
        return np.zeros(0, np.int64), np.zeros((0, 3), np.int64)
    corners = mesh.facets[living]
    centre = mesh.points[corners].mean(axis=1)
    reach = np.linalg.norm(mesh.points[corners] - centre[:, None], axis=2).max(axis=1)
    reach += FRONT_GAP * mesh.size[corners].max(axis=1)
    tree = cKDTree(mesh.points[front])
    near = np.flatnonzero(tree.query(centre, distance_upper_bound=float(reach.max()))[0] < reach)
    around = tree.query_ball_point(centre[near], reach[near], return_sorted=True)
    facet = np.repeat(near, [len(found) for found in around])
    vertex = front[np.concatenate([np.asarray(found, np.int64) for found in (*around, [])])]
    apart = (corners[facet] != vertex[:, None]).all(axis=1)
    return vertex[apart], corners[facet[apart]]


def _weights(corners: np.ndarray, normal: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the barycentric coordinates (k, 3) of places in the planes of triangles (k, 3, 3)."""
    arms = corners - places[:, None]
    areas = np.cross(np.roll(arms, -1, axis=1), np.roll(arms, 1, axis=1))
    weight = np.einsum("ijk,ik->ij", areas, normal)
    return weight / weight.sum(axis=1, keepdims=True)
