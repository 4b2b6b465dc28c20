"""From a labelled mesh of the whole model back to a surface and the tetrahedra of each grain."""

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mesh.tet_connectivity import (
    RowGroups,
    group_triples,
    half_face_corners,
    half_faces,
    tet_volumes,
)
from craftmesh.surface.connectivity import compact
from craftmesh.surface.front import ears, front_of
from craftmesh.surface.patches import PLANES
from craftmesh.tetrahedra.whole.crack_faces import crack_half_faces, move_front_onto
from craftmesh.types import CRACK, INTERFACE, GrainTets, Surface

# Most rounds of splits. After each round the crack is found again and may have other facets, with new ears
# (inner crack edges between two front points).
MAX_SPLITS = 5


def move_onto_planes(
    surface: Surface, points: np.ndarray, tets: np.ndarray, labels: np.ndarray, reach: float
) -> tuple[np.ndarray, np.ndarray, dict]:
    """Return points with outer faces exactly on box planes, labels (t,), and a report.

    Points of faces between material and outside move onto box planes within `reach` of them, along the
    planes' normals. Tets that become flat on a plane get the label 0. The report has the number of points
    moved and their largest move. Raises CraftmeshError if another tet of a grain becomes flat or inverted.
    """
    groups = group_triples(half_faces(tets))
    outside = _sides_of(groups, labels)
    outer = groups.lead[(outside > 0).any(axis=1) & (outside == 0).any(axis=1)]
    is_outer = np.zeros(len(points), bool)
    is_outer[half_face_corners(tets, outer)] = True
    moved = points.copy()
    for axis, level in box_levels(surface).values():
        near = is_outer & (np.abs(points[:, axis] - level) <= reach)
        moved[near, axis] = level
    labels = labels.copy()
    for axis, level in box_levels(surface).values():
        labels[(moved[tets][:, :, axis] == level).all(axis=1)] = 0
    turned = (tet_volumes(moved, tets) <= 0) & (labels > 0)
    if turned.any():
        raise CraftmeshError(
            f"{turned.sum()} tetrahedra (the first in grain {labels[turned][0]}) turn over when the mesh "
            "of the whole model is put on the planes of the box; use a smaller envelope"
        )
    off = np.abs(moved - points).max(axis=1)
    report = {"points_put_on_planes": int((off > 0).sum()), "largest_move": float(off.max(initial=0.0))}
    return moved, labels, report


def settle_crack(
    surface: Surface, points: np.ndarray, tets: np.ndarray, labels: np.ndarray, reach: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points, tets and labels with the crack's ears split and its front moved onto the given front.

    An ear is an inner crack edge between two front points; without ears, all facets of the crack can open.
    After MAX_SPLITS rounds ears may remain. reach: largest distance of crack faces from the given crack.
    """
    for _ in range(MAX_SPLITS):
        crack, free = _crack_facets(surface, points, tets, labels, reach)
        on_front = np.zeros(len(points), bool)
        on_front[front_of(crack, free)] = True
        edges = ears(crack, on_front)
        if not len(edges):
            break
        for edge in edges:
            points, tets, labels = _split(points, tets, labels, edge)
    crack, free = _crack_facets(surface, points, tets, labels, reach)
    return move_front_onto(surface, points, tets, crack, free), tets, labels


def _crack_facets(
    surface: Surface, points: np.ndarray, tets: np.ndarray, labels: np.ndarray, reach: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the crack facets (c, 3) of the mesh and the facets (f, 3) of its free surfaces."""
    groups = group_triples(half_faces(tets))
    pairs = groups.pairs[(labels[groups.pairs // 4] > 0).all(axis=1)]
    crack = half_face_corners(tets, crack_half_faces(surface, points, tets, pairs, reach))
    sides = _sides_of(groups, labels)
    free = groups.lead[(sides > 0).any(axis=1) & (sides <= 0).any(axis=1)]
    return crack, half_face_corners(tets, free)


def _split(
    points: np.ndarray, tets: np.ndarray, labels: np.ndarray, edge: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the mesh with the edge bisected; its tets keep their labels and orientations."""
    around = (tets == edge[0]).any(axis=1) & (tets == edge[1]).any(axis=1)
    halves = [np.where(tets[around] == end, len(points), tets[around]) for end in edge]
    tets = np.concatenate([tets[~around], *halves])
    labels = np.concatenate([labels[~around], labels[around], labels[around]])
    return np.concatenate([points, points[edge].mean(axis=0)[None]]), tets, labels


def model_of(
    surface: Surface, points: np.ndarray, tets: np.ndarray, labels: np.ndarray, reach: float
) -> tuple[Surface, list[GrainTets]]:
    """Return the surface of a mesh with labels (t,), its crack included, and the tets of each grain.

    Facets are the faces between two labels, also between a grain and the outside, and the crack's faces,
    which lie within `reach` of the crack facets of the input `surface`.
    """
    groups = group_triples(half_faces(tets))
    pairs = groups.pairs
    inside = (labels[pairs // 4] > 0).all(axis=1)
    crack = crack_half_faces(surface, points, tets, pairs[inside], reach)
    is_crack = np.zeros(4 * len(tets), bool)
    is_crack[crack] = True
    partner = np.full(4 * len(tets), -1, np.int64)
    partner[pairs[:, 0]], partner[pairs[:, 1]] = pairs[:, 1], pairs[:, 0]
    lead = groups.lead
    is_crack[pairs[is_crack[pairs].any(axis=1)]] = True
    lead = lead[~is_crack[lead]]
    across = np.where(partner[lead] >= 0, labels[partner[lead] // 4], 0)
    bounds = (labels[lead // 4] != across) & ((labels[lead // 4] > 0) | (across > 0))
    # the normal of a half face points into its own tet, so this tet is ahead
    rows = np.concatenate([lead[bounds], crack])
    behind = np.where(partner[rows] >= 0, labels[partner[rows] // 4], 0)
    facets, sides = half_face_corners(tets, rows), np.stack([behind, labels[rows // 4]], axis=1)
    kind = _kinds(surface, points, facets, sides)
    kind[len(rows) - len(crack) :] = CRACK
    points_kept, facets, nodes = compact(points, facets)
    found = Surface(points_kept, facets, sides, kind)
    return found, _grain_tets(points, tets, labels, nodes)


def box_levels(surface: Surface) -> dict[int, tuple[int, float]]:
    """Return a dict of box plane (kind 1 to 6) to its axis and coordinate, for planes that have facets."""
    levels = {}
    for plane, axis, _ in PLANES:
        facets = surface.facets[surface.kind == plane]
        if len(facets):
            levels[plane] = axis, float(surface.points[facets[0, 0], axis])
    return levels


def _sides_of(groups: RowGroups, labels: np.ndarray) -> np.ndarray:
    """Return the labels (g, 2) on both sides of each face, 0 if there is no tet."""
    first = labels[groups.lead // 4]
    second = np.zeros(len(first), labels.dtype)
    second[groups.count == 2] = labels[groups.pairs[:, 1] // 4]
    return np.stack([first, second], axis=1)


def _kinds(surface: Surface, points: np.ndarray, facets: np.ndarray, sides: np.ndarray) -> np.ndarray:
    kind = np.full(len(facets), INTERFACE, np.uint8)
    is_open = (sides == 0).any(axis=1)
    for plane, (axis, level) in box_levels(surface).items():
        kind[is_open & (points[facets][:, :, axis] == level).all(axis=1)] = plane
    return kind


def _grain_tets(
    points: np.ndarray, tets: np.ndarray, labels: np.ndarray, nodes: np.ndarray
) -> list[GrainTets]:
    """Return each grain's tets, by ascending grain id.

    nodes (s,): ids in the mesh of the surface's points, in their order.
    """
    on_surface = np.full(len(points), -1, np.int64)
    on_surface[nodes] = np.arange(len(nodes))
    result = []
    for grain in np.unique(labels[labels > 0]).tolist():
        mine = tets[labels == grain]
        used = np.unique(mine)
        is_node = on_surface[used] >= 0
        order = np.concatenate([used[is_node], used[~is_node]])
        local = np.empty(len(points), np.int64)
        local[order] = np.arange(len(order))
        result.append(GrainTets(grain, on_surface[used[is_node]], points[used[~is_node]], local[mine]))
    return result
