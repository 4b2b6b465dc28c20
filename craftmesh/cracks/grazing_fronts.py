"""Fronts that graze a box face are made to end on it; otherwise flat tets would fill the thin ligament."""

from typing import NamedTuple

import numpy as np

from craftmesh.cracks.crack_tolerances import PREPARATION
from craftmesh.cracks.near_faces import ALONG
from craftmesh.cracks.triangulated import boundary_loops, split_boundary_edge, with_fronts
from craftmesh.surface.measure import unit_normals
from craftmesh.types import BOX_FACES, Crack

# Smallest length, in l_min, of a front stretch that grazes a face. The stretch lies within 2
# PREPARATION.front l_min of the face, so its angle to the face is below 7 degrees. Shorter stretches cross
# or touch the face.
GRAZING = 0.3
STEP = 0.1  # length of edges along a moved stretch, in l_min


class _Face(NamedTuple):
    """A box face: its outward normal (3,), and `out`, its coordinate along that normal."""

    outward: np.ndarray
    out: float


def ending_on_faces(sheet: Crack, box: np.ndarray, l_min: float) -> Crack:
    """Return a surface whose fronts end on the box faces (2, 3) that they graze; l_min in model units.

    A grazing front point at distance d from the face, along the crack, moves towards it by r - d, where r =
    2 PREPARATION.front l_min. Points with d < r / 2 thereby pass the face, and the front meets the face
    twice as steeply. A front stays where the crack lies between it and the face.
    """
    for axis, upper in BOX_FACES:
        outward = (2.0 * upper - 1.0) * np.eye(3)[axis]
        face = _Face(outward, float(outward @ box[upper]))
        sheet = _ending_on_face(sheet, face, box, l_min)
    return sheet


def _ending_on_face(sheet: Crack, face: _Face, box: np.ndarray, l_min: float) -> Crack:
    reach = 2 * PREPARATION.front * l_min
    near = [face.out - sheet.points[front] @ face.outward < reach for front in sheet.fronts]
    if not any(one.any() for one in near):
        return sheet
    points, triangles = sheet.points, sheet.triangles.astype(np.int64)
    fronts, steps = [], []
    for front in sheet.fronts:
        ways = _ways(points, triangles, front, face)
        grazing = _grazing(points[front], ways, face, l_min)
        points, triangles, front, edge = _refined(points, triangles, front, grazing, STEP * l_min)
        fronts.append(front)
        steps.append(_steps(points[front], ways[edge], grazing[edge], face, reach))
    if not any(step.any() for step in steps):
        return sheet
    lines = []
    for front, step in zip(fronts, steps):
        points, triangles, front = _widened(points, triangles, front, step)
        lines.append(front)
    return with_fronts(points, triangles, boundary_loops(triangles), [points[line] for line in lines], box)


def _ways(points: np.ndarray, triangles: np.ndarray, front: np.ndarray, face: _Face) -> np.ndarray:
    """Return vectors (k - 1, 3) along the crack at a front's edges that advance by 1 towards the face.

    A vector is 0 where the crack lies along the face, or between the face and the front. front (k,): ids.
    """
    edges = np.sort(np.stack([front[:-1], front[1:]], axis=1), axis=1)
    sides = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2), axis=2)
    count = len(points)
    keys = sides[..., 0] * count + sides[..., 1]
    order = np.argsort(keys.ravel(), kind="stable")
    of_edge = order[np.searchsorted(keys.ravel()[order], edges[:, 0] * count + edges[:, 1])]
    row, side = np.divmod(of_edge, 3)
    normal = unit_normals(points, triangles[row])
    way = face.outward - (normal @ face.outward)[:, None] * normal
    sine = np.linalg.norm(way, axis=1)
    along = points[triangles[row, (side + 1) % 3]] - points[triangles[row, side]]
    way[(sine < ALONG) | (np.einsum("ij,ij->i", np.cross(normal, along), way) > 0)] = 0.0
    return way / np.maximum(sine, ALONG)[:, None] ** 2


def _grazing(line: np.ndarray, ways: np.ndarray, face: _Face, l_min: float) -> np.ndarray:
    """Return a mask (k - 1,) of the edges of a front line (k, 3) in stretches that graze the face.

    Such a stretch is longer than GRAZING l_min and within 2 PREPARATION.front l_min of the face, measured
    along the crack. ways (k - 1, 3): from `_ways`.
    """
    length = np.linalg.norm(np.diff(line, axis=0), axis=1)
    times = np.maximum(np.ceil(length / (STEP * l_min)), 1).astype(np.int64)
    edge = np.repeat(np.arange(len(length)), times)
    share = (np.arange(len(edge)) - (np.cumsum(times) - times)[edge] + 0.5) / times[edge]
    middle = line[edge] + share[:, None] * (line[edge + 1] - line[edge])
    far = (face.out - middle @ face.outward) * np.linalg.norm(ways, axis=1)[edge]
    near = (far < 2 * PREPARATION.front * l_min) & (ways != 0).any(axis=1)[edge]
    run = np.concatenate([[0], np.cumsum(near[1:] != near[:-1])])
    if (line[0] == line[-1]).all() and near[0] and near[-1]:
        run[run == run[-1]] = 0
    long = np.bincount(run, (length / times)[edge])[run] > GRAZING * l_min
    return np.bincount(edge, near & long, len(length)) > 0


def _refined(
    points: np.ndarray, triangles: np.ndarray, front: np.ndarray, parted: np.ndarray, step: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Subdivide the front edges in the mask `parted` (k - 1,) until none is longer than `step`.

    Returns points, triangles, the front's ids, and the number of the old edge that starts at or contains
    each front point.
    """
    places, line, edge = list(points), [], []
    for number, (a, b) in enumerate(zip(front[:-1].tolist(), front[1:].tolist())):
        line.append(a)
        edge.append(number)
        start, way = points[a], points[b] - points[a]
        count = int(np.ceil(np.linalg.norm(way) / step)) if parted[number] else 1
        for k in range(1, count):
            triangles = split_boundary_edge(triangles, line[-1], b, len(places))
            line.append(len(places))
            edge.append(number)
            places.append(start + k / count * way)
    return np.array(places), triangles, np.array([*line, front[-1]]), np.array([*edge, edge[-1]])


def _widened(
    points: np.ndarray, triangles: np.ndarray, front: np.ndarray, step: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points, triangles and the new front after moving a front (k,) by step (k, 3).

    A strip of triangles joins old and new front. Moving the points themselves would invert triangles with
    three corners on the front.
    """
    moved = np.abs(step).max(axis=1) > 0
    closed = bool(front[0] == front[-1])
    rows = np.flatnonzero(moved[:-1] if closed else moved)
    new = front.copy()
    new[rows] = len(points) + np.arange(len(rows))
    if closed:
        new[-1] = new[0]
    a, b, c, d = front[:-1], front[1:], new[1:], new[:-1]
    strip = np.concatenate([np.stack([b, a, d], axis=1)[d != a], np.stack([b, d, c], axis=1)[c != b]])
    return (
        np.concatenate([points, points[front[rows]] + step[rows]]),
        np.concatenate([triangles, strip]),
        new,
    )


def _steps(
    line: np.ndarray, ways: np.ndarray, grazing: np.ndarray, face: _Face, reach: float
) -> np.ndarray:
    """Return displacements (k, 3) of front points `line` (k, 3) towards the face, along `ways` (k, 3).

    grazing (k,): mask of points that move; reach: distance from the face within which they move.
    """
    size = np.linalg.norm(ways, axis=1)
    far = (face.out - line @ face.outward) * size
    part = np.where(grazing, np.clip(reach - np.abs(far), 0, None), 0.0)
    return part[:, None] * ways / np.maximum(size, 1e-300)[:, None]
