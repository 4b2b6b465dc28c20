"""Heights over a plane that fit measured points with as little bending as these allow."""

import numpy as np
import scipy
import shapely

from craftmesh.cracks.in_plane import doubled_areas
from craftmesh.cracks.near_sheet import weights_in_triangles
from craftmesh.surface.connectivity import edge_sides, unique_edges

# Length, in spacings, that sets the bending stiffness. The fit halves the amplitude of waves that are 2 pi
# 3^(1/4) times as long, 2.1 spacings, because the hinge energy is three times that of a thin plate.
STIFFNESS = 0.25


def fitted_heights(
    points: np.ndarray, triangles: np.ndarray, fixed: np.ndarray, measured: np.ndarray, spacing: float
) -> np.ndarray:
    """Return heights (n,) at points (n, 2) of a triangulation (m, 3) whose edges are about `spacing` long.

    fixed (n,): prescribed heights, NaN where free. measured (k, 3): u, v and height of points to fit;
    points off the triangles are ignored. The heights minimise the squared deviations plus the bending
    across edges (the hinge energy of a flat sheet), without measured points only the bending. Not checked:
    at least three points, not on a line, must be fixed or measured; otherwise heights may be NaN.
    """
    bends, twice = _bends(points, triangles)
    matrix, values = bends.T @ bends, np.zeros(len(points))
    row, _, at = interpolation(points, triangles, measured[:, :2])
    if len(row):
        density = len(row) / (twice.sum() / 2)
        matrix = at.T @ at + density * (STIFFNESS * spacing) ** 4 * matrix
        values = at.T @ measured[row, 2]
    known = np.flatnonzero(np.isfinite(fixed))
    free = np.flatnonzero(~np.isfinite(fixed))
    heights = fixed.copy()
    if len(free):
        matrix = scipy.sparse.csr_array(matrix)
        right = values[free] - matrix[free][:, known] @ fixed[known]
        heights[free] = scipy.sparse.linalg.spsolve(matrix[free][:, free].tocsc(), right)
    return heights


def interpolation(
    points: np.ndarray, triangles: np.ndarray, places: np.ndarray, within: float = 0.0
) -> tuple[np.ndarray, np.ndarray, "scipy.sparse.csr_array"]:
    """Return rows (r,) of places (k, 2) on triangles (m, 3), their triangles (r,), sparse weights (r, n).

    weights @ values gives the values at these places that linear interpolation of `values` (n,), given at
    the points (n, 2), has. within: largest distance of a place from its triangle.
    """
    tree = shapely.STRtree(shapely.polygons(points[triangles]))
    row, triangle = tree.query(shapely.points(places), predicate="dwithin", distance=within)
    row, first = np.unique(row, return_index=True)
    triangle = triangle[first]
    corners = triangles[triangle]
    weights = weights_in_triangles(places[row], points[corners])
    ends = np.repeat(np.arange(len(row)), 3), corners.ravel()
    return (
        row,
        triangle,
        scipy.sparse.coo_array((weights.ravel(), ends), shape=(len(row), len(points))).tocsr(),
    )


def _bends(points: np.ndarray, triangles: np.ndarray) -> tuple["scipy.sparse.csr_array", np.ndarray]:
    """Return a sparse matrix (e, n) and doubled areas (m,); |matrix @ heights|^2 is the bending energy.

    Each row belongs to an inner edge: the edge's length times the jump of the slope across it, divided by
    the square root of a third of the area of both triangles.
    """
    twice = doubled_areas(points, triangles)
    edges, of_corner, count = unique_edges(triangles)
    sides = edge_sides(of_corner, count == 2)
    start, end = (points[edges[count == 2, i]] for i in range(2))
    along = end - start
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1)  # times the edge's length
    scale = np.sqrt(6 / (twice[sides[0] // 3] + twice[sides[1] // 3]))
    rows, columns, values = [], [], []
    for sign, side in zip((1.0, -1.0), sides):
        t = side // 3
        for k in range(3):
            p, q = (points[triangles[t, (k + i) % 3]] for i in (1, 2))
            slope = np.stack([p[:, 1] - q[:, 1], q[:, 0] - p[:, 0]], axis=1) / twice[t, None]
            rows.append(np.arange(len(t)))
            columns.append(triangles[t, k])
            values.append(sign * scale * (slope * normal).sum(axis=1))
    shape = (len(sides[0]), len(points))
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return scipy.sparse.coo_array(entries, shape=shape).tocsr(), twice
