"""Coarser triangles for a view that is turned by hand: vertices of one cell of a grid become one."""

import numpy as np

COARSER = 1.2  # the grid's cells grow by this until the triangles are few enough


def decimated(
    points: np.ndarray, triangles: np.ndarray, box: np.ndarray, most: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the places (p, 3) of corners, triangles (k, 3) on them, about `most`, and what those were.

    points (n, 3); triangles (m, 3). The last result (k,) has the row of each triangle among those given;
    few enough triangles stay as they are. A corner is the mean of the points that it stands for, which all
    lie on the same planes of the box (2, 3), so faces, edges and corners of the box stay in place, which
    takes some 48 triangles, however few are asked for.
    """
    used, local = np.unique(triangles, return_inverse=True)
    local = local.reshape(-1, 3)
    if len(triangles) <= most:
        return points[used], local, np.arange(len(triangles))
    corners = points[used]
    planes = (corners[:, None] == box).reshape(-1, 6) @ (1 << np.arange(6))
    diagonal = float(np.linalg.norm(np.ptp(box, axis=0)))
    size = diagonal / np.sqrt(most)
    while True:
        cells = np.column_stack([np.floor((corners - box[0]) / size).astype(np.int64), planes])
        _, place, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
        found = place.reshape(-1)[local]
        whole = (found != np.roll(found, 1, axis=1)).all(axis=1)
        _, first = np.unique(np.sort(found[whole], axis=1), axis=0, return_index=True)
        rows = np.sort(np.flatnonzero(whole)[first])
        if len(rows) <= most or size > diagonal:
            break
        size *= COARSER
    sums = [np.bincount(place.reshape(-1), corners[:, k]) for k in range(3)]
    return np.stack(sums, axis=1) / count[:, None], found[rows], rows
