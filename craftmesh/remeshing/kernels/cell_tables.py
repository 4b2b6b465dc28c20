"""Corners, edges, faces and local points of one cell of the dual grid (corners = eight voxel centres).

Corner c lies at (c >> 2 & 1, c >> 1 & 1, c & 1). Local points 0..11 lie on the edges, 12..17 on the
faces, and from 18 on inside the cell.
"""

import numpy as np

FIRST_FACE_POINT = 12
FIRST_CELL_POINT = 18
MAX_POINTS = 64

CORNER_AT = np.array([[c >> 2 & 1, c >> 1 & 1, c & 1] for c in range(8)])
EDGE_CORNERS = np.array(
    [[c, c + (4 >> axis)] for axis in range(3) for c in range(8) if not CORNER_AT[c][axis]]
)
EDGE_AXIS = np.repeat(np.arange(3), 4)


def _face_corners() -> np.ndarray:
    """Return corners (6, 4) of face 2 * axis + side, counter-clockwise seen from outside the cell."""
    faces = []
    for axis in range(3):
        u, v = 4 >> (axis + 1) % 3, 4 >> (axis + 2) % 3
        faces.append([0, v, u + v, u])
        faces.append([(4 >> axis) + c for c in (0, u, u + v, v)])
    return np.array(faces)


def _face_edges() -> np.ndarray:
    """Return edges (6, 4): column i is the edge between corners i and i + 1 of each face."""
    edge_of = {tuple(pair): e for e, pair in enumerate(EDGE_CORNERS.tolist())}
    return np.array(
        [[edge_of[tuple(sorted((f[i], f[(i + 1) % 4])))] for i in range(4)] for f in FACE_CORNERS]
    )


def _point_positions() -> np.ndarray:
    """Return positions (MAX_POINTS, 3) in the unit cell; cell points are at its centre."""
    at = np.full((MAX_POINTS, 3), 0.5)
    at[:FIRST_FACE_POINT] = CORNER_AT[EDGE_CORNERS].mean(axis=1)
    at[FIRST_FACE_POINT:FIRST_CELL_POINT] = CORNER_AT[FACE_CORNERS].mean(axis=1)
    return at


def _point_faces() -> np.ndarray:
    """Return bit masks (MAX_POINTS,) of the cell's faces that contain each local point."""
    mask = np.zeros(MAX_POINTS, np.int64)
    for face in range(6):
        mask[FACE_EDGES[face]] |= 1 << face
        mask[FIRST_FACE_POINT + face] |= 1 << face
    return mask


def _point_slots() -> np.ndarray:
    """Return rows (18, 4): where the id of a point shared by cells is kept, by layer, slot, steps in y, z.

    Layers 0 and 1 are the planes below and above the slab of cells, layer 2 lies between them. The slot
    tells the points of a layer at one cell apart: in layers 0 and 1 the edge along y, the edge along z and
    the face; in layer 2 the edge along x and the faces perpendicular to y and z. The steps count cells.
    """
    slots = np.zeros((FIRST_CELL_POINT, 4), np.int64)
    for p in range(FIRST_FACE_POINT):
        x, y, z = CORNER_AT[EDGE_CORNERS[p, 0]]
        axis = EDGE_AXIS[p]
        slots[p] = (2, 0, y, z) if axis == 0 else (x, axis - 1, y, z)
    for face in range(6):
        axis, side = divmod(face, 2)
        step = (side if axis == 1 else 0, side if axis == 2 else 0)
        slots[FIRST_FACE_POINT + face] = (side, 2, 0, 0) if axis == 0 else (2, axis, *step)
    return slots


FACE_CORNERS = _face_corners()
FACE_EDGES = _face_edges()
POINT_AT = _point_positions()
POINT_FACES = _point_faces()
POINT_SLOT = _point_slots()
