"""Where a random crack lies: inside, at faces, edges, corners, along a grain boundary, through a void."""

import numpy as np

from craftmesh.types import Voxels

PLACES = ("inside", "face", "edge", "corner", "near face", "boundary", "void", "outside")
SHARES = (0.22, 0.28, 0.08, 0.06, 0.07, 0.15, 0.12, 0.02)


def draw_place(rng: np.random.Generator, voxels: Voxels, into: bool) -> tuple[str, np.ndarray, np.ndarray]:
    """Return a kind of place, a crack's centre (3,) and its frame (3, 3): rows u, v, normal.

    into: the crack is a strip, whose centre is its mouth on a face and whose u leads into the box.
    """
    kinds, shares = (PLACES[:-1], SHARES[:-1]) if into else (PLACES, SHARES)
    kind = str(rng.choice(kinds, p=np.array(shares) / sum(shares)))
    low, size = voxels.box[0], np.ptp(voxels.box, axis=0)
    centre, normal = low + rng.uniform(0.1, 0.9, 3) * size, _direction(rng)
    axis, upper = int(rng.integers(3)), int(rng.integers(2))
    edge = float(np.cbrt(voxels.spacing.prod()))
    if kind in ("face", "edge", "corner"):
        chosen = rng.permutation(3)[: {"face": 1, "edge": 2, "corner": 3}[kind]]
        centre[chosen] = voxels.box[rng.integers(0, 2, len(chosen)), chosen]
        axis, upper = int(chosen[0]), int(centre[chosen[0]] > low[chosen[0]])
    elif kind == "near face":
        sign = 1 if upper == 0 else -1
        centre[axis] = voxels.box[upper, axis] + sign * edge * rng.choice([0.0, 1e-3, rng.uniform(0, 3)])
        normal = np.eye(3)[axis] + np.tan(np.radians(rng.choice([0, rng.uniform(0, 8)]))) * _direction(rng)
    elif kind == "boundary":
        centre, normal = _grain_boundary(rng, voxels)
    elif kind == "void":
        centre = _void(rng, voxels, centre)
    elif kind == "outside":
        centre[axis] = voxels.box[upper, axis] + (2 * upper - 1) * 2 * size[axis]
    normal /= np.linalg.norm(normal)
    if into:
        return kind, *_mouth(rng, voxels.box, centre, normal, axis, upper)
    return kind, centre, _frame(normal, rng.normal(size=3))


def _direction(rng: np.random.Generator) -> np.ndarray:
    """Return a random unit vector, in a quarter of the cases along an axis."""
    vector = np.eye(3)[rng.integers(3)] if rng.random() < 0.25 else rng.normal(size=3)
    return vector / np.linalg.norm(vector)


def _frame(normal: np.ndarray, along: np.ndarray) -> np.ndarray:
    u = along - (along @ normal) * normal
    u /= np.linalg.norm(u)
    return np.stack([u, np.cross(normal, u), normal])


def _mouth(
    rng: np.random.Generator, box: np.ndarray, centre: np.ndarray, normal: np.ndarray, axis: int, upper: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the mouth's centre on a face and a frame whose u leads in, over 35 degrees to the face."""
    inward = np.eye(3)[axis] * (1 - 2 * upper)
    if abs(normal @ inward) > np.cos(np.radians(35)):
        other = [i for i in range(3) if i != axis]
        axis = int(rng.choice(other))
        inward = np.eye(3)[axis] * (1 - 2 * upper)
        if abs(normal @ inward) > np.cos(np.radians(35)):
            normal = np.eye(3)[next(i for i in range(3) if i != axis)]
    frame = _frame(normal, inward)
    shift = (centre[axis] - box[upper, axis]) / frame[0, axis]
    return centre - shift * frame[0], frame


def _grain_boundary(rng: np.random.Generator, voxels: Voxels) -> tuple[np.ndarray, np.ndarray]:
    """Return a point on a random grain boundary, up to half a voxel off, and the boundary's mean normal."""
    labels, axis = voxels.labels, int(rng.integers(3))
    line = np.moveaxis(labels, axis, 0)
    below, above = line[:-1], line[1:]
    places = np.argwhere((below != above) & (below > 0) & (above > 0))
    if not len(places):
        return voxels.box.mean(axis=0), _direction(rng)
    chosen = tuple(places[rng.integers(len(places))])
    pair_of = np.array([below[chosen], above[chosen]])
    faces = []
    for along in range(3):
        line = np.moveaxis(labels, along, 0)
        low, high = np.minimum(line[:-1], line[1:]), np.maximum(line[:-1], line[1:])
        pair = np.argwhere((low == pair_of.min()) & (high == pair_of.max()))
        order = np.insert(pair[:, 1:], along, pair[:, 0], axis=1) + 0.5 + 0.5 * np.eye(3)[along]
        faces.append(voxels.origin + voxels.spacing * order)
    points = np.concatenate(faces)
    if len(points) < 6:
        return points.mean(axis=0), _direction(rng)
    normal = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][2]
    shift = rng.choice([0.0, rng.uniform(-0.5, 0.5)]) * voxels.spacing.mean()
    return points.mean(axis=0) + shift * normal, normal


def _void(rng: np.random.Generator, voxels: Voxels, centre: np.ndarray) -> np.ndarray:
    """Return a voxel's centre in a random void, or within two voxels of one; `centre` without voids."""
    places = np.argwhere(voxels.labels < 0)
    if not len(places):
        return centre
    place = places[rng.integers(len(places))] + 0.5 + rng.uniform(-2, 2, 3) * (rng.random() < 0.5)
    return voxels.origin + voxels.spacing * place
