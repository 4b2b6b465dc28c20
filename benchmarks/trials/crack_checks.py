"""Checks of a deck's crack against the sheet that was given: front, facets, area."""

from dataclasses import replace

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from craftmesh.types import CRACK, Surface, Voxels
from trials.deck_file import DeckFile
from trials.distances import area_within, to_polylines, to_segments, to_sheet, told
from trials.drawing import Drawn
from trials.sheets import Sheet, samples
from trials.verdict import FRONT, NO_FRONT, OUTSIDE

AT_EDGE = 0.1  # l_min squared of a crack nearer than LIGAMENT to two faces: half of that beside two l_min
FACE_BAND = 0.2  # l_min: a crack this near a face over a part of its area may be refused
FACE_TILT = 3.0  # degrees between crack and face at the mouth, below which it may be refused
FRONT_STEP = 0.25  # l_min: between the points at which the given front is looked at
LIGAMENT = 0.1  # l_min: less than this between front and face leaves room for flat tets alone
LIGAMENT_RUN = 2.0  # l_min: fronts that only end at a face are nearer than LIGAMENT over a shorter length
ALONG_FACE = (
    6.0  # degrees: what is steeper to a face is 2 l_min from its mouth at 0.2 l_min, and only ends there
)
BESIDE_FACE = 15.0  # degrees: the same for what does not come to the face
ALONG_CRACK = 15.0  # degrees between two cracks that run along each other
NEAR_SHARE = 0.01  # of the crack's area in the box that counts as a part of it
NEAR_AREA = 2.0  # of l_min squared, four facets: that much counts too
VOID_ROOM = 1.75  # voxels from voids and the outside within which voxels do not tell where material is


def front_edges(deck: DeckFile) -> np.ndarray:
    """Return the edges (k, 2) where two lips meet: each lip has them once, with the same nodes.

    Where cracks cross, the lips of both meet on edges too, but several of these lie in one place.
    """
    once = []
    for side in "AB":
        rows, count = np.unique(_edges(deck.lip(side)), axis=0, return_counts=True)
        once.append(rows[count == 1])
    both, count = np.unique(np.concatenate(once), axis=0, return_counts=True)
    _, place = np.unique(deck.points, axis=0, return_inverse=True)
    lips = np.unique(np.concatenate([_edges(deck.lip(side)) for side in "AB"]), axis=0)
    places, copies = np.unique(np.sort(place.ravel()[lips], axis=1), axis=0, return_counts=True)
    alone = places[copies == 1] @ (len(deck.points), 1)
    return both[(count == 2) & np.isin(np.sort(place.ravel()[both], axis=1) @ (len(deck.points), 1), alone)]


def _front_inside(case: Drawn, deck: DeckFile, l_min: float) -> float:
    """Return how far in l_min the given front is from the faces of the deck's box within it, at most."""
    front = np.concatenate([_dense(line, FRONT_STEP * l_min) for line in case.sheet.fronts])
    low, high = deck.points.min(axis=0), deck.points.max(axis=0)
    return max(float(np.minimum(front - low, high - front).min(axis=1).max()) / l_min, 0.0)


def check_crack(case: Drawn, deck: DeckFile, l_min: float) -> dict:
    """Return what the deck's crack keeps of the given one; lengths in l_min, areas in percent."""
    edges = front_edges(deck)
    if not len(edges):
        return {"front_edges": 0, "front_inside": _front_inside(case, deck, l_min)}
    nodes = np.unique(edges)
    ends = deck.points[edges]
    at_nodes = to_polylines(deck.points[nodes], case.sheet.fronts) / l_min
    at_middles = to_polylines(ends.mean(axis=1), case.sheet.fronts)
    named = deck.node_sets.get("CRACK_FRONT", np.zeros(0, np.int64))
    worst = deck.points[nodes[at_nodes.argmax()]]
    return {
        "front_edges": len(edges),
        "front_node": float(at_nodes.max()),
        "front_node_at": told(worst),
        "front_node_on_box": bool(_on_box(worst[None], case.voxels.box)[0]),
        "front_middle": float(at_middles.max() / l_min),
        "front_set_off": len(np.setxor1d(nodes, np.intersect1d(named, np.unique(deck.corners)))),
        "front_missing": _missing(case, ends, l_min),
        **facets_off(case.sheet, deck.points, deck.lip("A"), l_min),
        **_area(case, deck, ends, at_middles),
    }


def _on_box(points: np.ndarray, box: np.ndarray) -> np.ndarray:
    near = 1e-9 * np.ptp(box)
    return ((points <= box[0] + near) | (points >= box[1] - near)).any(axis=1)


def _missing(case: Drawn, ends: np.ndarray, l_min: float) -> float:
    """Return the largest distance, in l_min, of the given front inside the material from the deck's.

    Where it is as near to a face of the box as a node of the front may be off, it may end there.
    """
    given = inner_front(case.sheet, case.voxels)
    gaps = np.abs(given[:, None] - case.voxels.box).min(axis=(1, 2))
    given = given[gaps > FRONT * l_min]
    if not len(given):
        return 0.0
    return float(to_segments(given, ends[:, 0], ends[:, 1]).max() / l_min)


def inner_front(sheet: Sheet, voxels: Voxels) -> np.ndarray:
    """Return points of the given front that lie in the material and clear of voids."""
    points = np.concatenate([_dense(line, 0.5 * voxels.spacing.min()) for line in sheet.fronts])
    return points[material_depth(voxels, points) > VOID_ROOM]


def _dense(line: np.ndarray, step: float) -> np.ndarray:
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    places = np.linspace(0, length[-1], int(length[-1] / step) + 2)
    return np.stack([np.interp(places, length, column) for column in line.T], axis=1)


def material_depth(voxels: Voxels, points: np.ndarray) -> np.ndarray:
    """Return distances (in voxels) from empty voxels; 0 outside the box, infinite without empty voxels."""
    solid = voxels.labels > 0
    depth = np.full(solid.shape, np.inf) if solid.all() else ndimage.distance_transform_edt(solid)
    place = np.floor((points - voxels.origin) / voxels.spacing).astype(int)
    inside = ((points >= voxels.box[0]) & (points <= voxels.box[1])).all(axis=1)
    place = np.clip(place, 0, np.array(solid.shape) - 1)
    return np.where(inside, depth[tuple(place.T)], 0.0)


def check_inserted(case: Drawn, inserted: Surface, l_min: float) -> dict:
    """Return how far crack facets and front are from the given ones before gradation, in l_min."""
    facets = inserted.facets[inserted.kind == CRACK]
    off = facets_off(case.sheet, inserted.points, facets, l_min)
    edges, count = np.unique(_edges(facets), axis=0, return_counts=True)
    free = _edges(inserted.facets[(inserted.sides <= 0).any(axis=1)])
    width = len(inserted.points)
    inner = ~np.isin(edges @ (width, 1), free @ (width, 1))
    front = inserted.points[np.unique(edges[(count == 1) & inner])]
    at_nodes = to_polylines(front, case.sheet.fronts) / l_min
    return {f"inserted_{key}": value for key, value in off.items()} | {
        "inserted_front_node": float(at_nodes.max(initial=0.0))
    }


def _edges(triangles: np.ndarray) -> np.ndarray:
    """Return the edges (3m, 2) of triangles (m, 3), the lower node first."""
    pairs = [triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]
    return np.sort(np.concatenate(pairs).astype(np.int64), axis=1)


def facets_off(sheet: Sheet, points: np.ndarray, triangles: np.ndarray, l_min: float) -> dict:
    """Return how far corners, and middles and centres, of facets are from the given sheet, in l_min."""
    corners = points[triangles]
    middles = (corners + np.roll(corners, -1, axis=1)) / 2
    nodes = points[np.unique(triangles)]
    off = {"facet_node": nodes, "facet": np.concatenate([middles.reshape(-1, 3), corners.mean(axis=1)])}
    given = sheet.points[sheet.triangles]
    result = {}
    for name, places in off.items():
        if sheet.flat:
            normal = samples(sheet, 1)[1][0]
            distance = np.abs((places - sheet.points[0]) @ normal)
        else:
            distance = to_sheet(places, given, 0.02 * l_min)
        result[name] = float(distance.max() / l_min)
        result[f"{name}_at"] = told(places[distance.argmax()])
    return result


def _area(case: Drawn, deck: DeckFile, ends: np.ndarray, at_middles: np.ndarray) -> dict:
    """Return the area over the given one inside the box in percent, where no void is near the crack.

    The segments between the front and its chords are taken off the given area.
    """
    triangles = deck.lip("A")
    if material_depth(case.voxels, deck.points[np.unique(triangles)]).min() < VOID_ROOM:
        return {"area_off_pct": None}
    corners = deck.points[triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    found = float(np.linalg.norm(cross, axis=1).sum() / 2)
    given = area_within(case.sheet.points[case.sheet.triangles], case.voxels.box)
    segments = float((2 / 3 * np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) * at_middles).sum())
    off = found - given
    left = min(abs(off), abs(off + segments))
    return {"area": found, "area_given": given, "area_off_pct": 100 * left / max(given, 1e-300)}


def may_be_refused(case: Drawn, l_min: float) -> str | None:
    """Return why a crack of the case may be refused: outside the material, along a face or another one."""
    parts = [replace(case, sheet=part) for part in case.parts or (case.sheet,)]
    found = next((why for why in (_may_be_refused(part, l_min) for part in parts) if why), None)
    if found is None and _along_each_other(case, l_min):
        return "cracks along each other"
    return found


def _along_each_other(case: Drawn, l_min: float) -> bool:
    """Tell whether the second of two cracks runs along the first over more than two facets' area."""
    if len(case.parts) < 2:
        return False
    first, second = case.parts
    given, its_normals = samples(first)
    points, normals = samples(second)
    box = case.voxels.box
    near = np.flatnonzero(((points > box[0]) & (points < box[1])).all(axis=1))
    near = near[to_sheet(points[near], first.points[first.triangles], 0.02 * l_min) < FACE_BAND * l_min]
    beside = cKDTree(given).query(points[near])[1]
    cosine = np.abs((normals[near] * its_normals[beside]).sum(axis=1))
    along = (cosine > np.cos(np.radians(ALONG_CRACK))).sum()
    return bool(along * _sheet_area(second) / len(points) > l_min**2)


def _sheet_area(sheet: Sheet) -> float:
    return area_within(sheet.points[sheet.triangles], np.array([[-np.inf] * 3, [np.inf] * 3]))


def _may_be_refused(case: Drawn, l_min: float) -> str | None:
    points, normals = samples(case.sheet)
    box, reach = case.voxels.box, FACE_BAND * l_min
    if not (material_depth(case.voxels, points) > 0).any():
        return OUTSIDE
    front = np.concatenate([_dense(line, FRONT_STEP * l_min) for line in case.sheet.fronts])
    if not (material_depth(case.voxels, front) > 0).any():
        return NO_FRONT
    inside = front[((front >= box[0]) & (front <= box[1])).all(axis=1)]
    to_faces = np.minimum(inside - box[0], box[1] - inside)
    if (to_faces < LIGAMENT * l_min).sum(axis=0).max() > LIGAMENT_RUN / FRONT_STEP:
        return "the front runs along a face"
    near_box = ((points >= box[0] - reach) & (points <= box[1] + reach)).all(axis=1)
    enough = min(NEAR_SHARE * near_box.sum(), NEAR_AREA * l_min**2 / _sheet_area(case.sheet) * len(points))
    for axis in range(3):
        tilt = np.degrees(np.arccos(np.clip(np.abs(normals[:, axis]), 0, 1)))
        for bound in box[:, axis]:
            distance = np.abs(points[:, axis] - bound)
            beyond = (points[:, axis] < box[0, axis]) | (points[:, axis] > box[1, axis])
            steepest = ALONG_FACE if (near_box & (distance < reach) & beyond).any() else BESIDE_FACE
            in_face = near_box & (distance < reach) & (tilt < steepest)
            if in_face.sum() > enough:
                return "in a face"
            if (near_box & (distance < l_min) & (tilt < FACE_TILT)).any():
                return "tilted to a face by under 3 degrees"
    within = points[((points >= box[0]) & (points <= box[1])).all(axis=1)]
    to_planes = np.minimum(within - box[0], box[1] - within)
    if (to_planes.min(axis=1) < reach).all():
        return "a sliver at an edge"
    at_edge = ((to_planes < LIGAMENT * l_min).sum(axis=1) > 1).sum()
    beside = at_edge * _sheet_area(case.sheet) / len(points) > AT_EDGE * l_min**2
    return "along an edge of the box" if beside else None
