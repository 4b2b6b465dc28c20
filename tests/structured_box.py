"""Small structured models for tests: cubes cut into six tetrahedra each, with grains, voids and cracks."""

import numpy as np

from craftmesh.types import CRACK, GrainTets, Surface

# The six tetrahedra of a cube along its diagonal; neighbouring cubes match face by face.
_KUHN = [(0, 1, 3, 7), (0, 3, 2, 7), (0, 2, 6, 7), (0, 6, 4, 7), (0, 4, 5, 7), (0, 5, 1, 7)]


def structured_box(shape, label_of, crack_at=None, spacing=(1.0, 1.0, 1.0), origin=(0.0, 0.0, 0.0)):
    """Return (surface, grain_tets) of a box of `shape` cells.

    label_of(cell centres (n, 3) in cells) -> labels (n,), <= 0 empty. crack_at(face centres, unit
    normals) -> bool (k,): faces between tetrahedra that belong to the crack; normals have a positive first
    component that is not zero.
    """
    nodes = np.stack(np.meshgrid(*(np.arange(n + 1) for n in shape), indexing="ij"), -1).reshape(-1, 3)
    tets, label = _kuhn_tets(shape, label_of)
    faces, sides = _faces(nodes, tets, label)
    corners = nodes[faces].astype(float)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    crack = np.zeros(len(faces), bool)
    if crack_at is not None:
        crack = crack_at(corners.mean(1), normals) & (sides > 0).all(1)
    kind = np.where(crack, CRACK, _plane(corners, sides, shape))
    kept = ((sides[:, 0] != sides[:, 1]) | crack) & (sides > 0).any(1)
    points = nodes * np.asarray(spacing) + origin
    return _model(points, faces[kept], sides[kept], kind[kept], tets, label)


def _kuhn_tets(shape, label_of):
    cells = np.stack(np.meshgrid(*(np.arange(n) for n in shape), indexing="ij"), -1).reshape(-1, 3)
    corner = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)])
    strides = np.array([(shape[1] + 1) * (shape[2] + 1), shape[2] + 1, 1])
    ids = (cells[:, None, :] + corner) @ strides
    return ids[:, _KUHN].reshape(-1, 4), np.repeat(np.asarray(label_of(cells + 0.5)), 6)


def _faces(nodes, tets, label):
    """Return all faces once, normals towards positive axes, with the labels behind and ahead."""
    halves = tets[:, [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]]].reshape(-1, 3)  # normals point outwards
    _, first, which = np.unique(np.sort(halves, 1), axis=0, return_index=True, return_inverse=True)
    which, owner = which.ravel(), np.repeat(label, 4)
    second = np.full(len(first), -1)
    rows = np.setdiff1d(np.arange(len(halves)), first)
    second[which[rows]] = rows
    faces = halves[first]
    sides = np.stack([owner[first], np.where(second >= 0, owner[second], 0)], 1)
    p = nodes[faces]
    normal = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    leading = normal[np.arange(len(normal)), (normal != 0).argmax(1)]
    backward = leading < 0
    faces[backward] = faces[backward][:, ::-1]
    sides[backward] = sides[backward][:, ::-1]
    return faces, sides


def _plane(corners, sides, shape):
    kind = np.zeros(len(corners), int)
    outer = (sides == 0).any(1)
    for axis in range(3):
        for end, value in enumerate((0, shape[axis])):
            kind[outer & (corners[:, :, axis] == value).all(1)] = 1 + 2 * axis + end
    return kind


def _model(points, facets, sides, kind, tets, label):
    on_surface = np.unique(facets)
    new = np.full(len(points), -1)
    new[on_surface] = np.arange(len(on_surface))
    surface = Surface(points[on_surface], new[facets], sides, kind)
    grains = []
    for grain in np.unique(label[label > 0]):
        own = tets[label == grain]
        used = np.unique(own)
        shared, inner = used[new[used] >= 0], used[new[used] < 0]
        local = np.full(len(points), -1)
        local[np.concatenate([shared, inner])] = np.arange(len(used))
        grains.append(GrainTets(grain, new[shared], points[inner], local[own]))
    return surface, grains


def hexagon(centre, radius):
    """Return an `inside` for `plane_crack` in a plane of z: a hexagon along the grid's own diagonals.

    None of its facets has all three corners on the rim.
    """

    def inside(centres):
        dx, dy = centres[:, 0] - centre[0], centres[:, 1] - centre[1]
        return np.maximum(np.maximum(np.abs(dx), np.abs(dy)), np.abs(dx - dy)) < radius

    return inside


def plane_crack(axis, at, inside):
    """Return a `crack_at` for the faces in the plane `axis` = `at` whose centres satisfy `inside`."""

    def crack_at(centres, normals):
        return (np.abs(normals[:, axis]) > 0.9) & (np.abs(centres[:, axis] - at) < 1e-9) & inside(centres)

    return crack_at
