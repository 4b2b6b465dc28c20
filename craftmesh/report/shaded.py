"""Shaded pictures of triangles in parallel projection."""

from functools import reduce
from typing import NamedTuple

import numpy as np

from craftmesh.report.kernels.raster import draw
from craftmesh.surface.measure import unit_normals

# Oversampling: a picture is drawn with this many times more pixels along each axis, and then averaged, for
# smooth edges.
FINER = 2
DARKEST = 0.5  # brightness of a facet seen edge-on, relative to one that faces the viewer
MARGIN = 0.02  # margin around the body, relative to the larger of its width and height
AHEAD = 0.8  # cosine of the angle between line of sight and z, above which y is up instead of z
LINE_WIDTH = 0.45  # pixels
# Mean edge length of a triangle, in pixels, above which its edges are drawn; they become gradually wider up
# to twice this length. Lines on smaller triangles would hide the colours.
SHORTEST_LINED = 5.0


class View(NamedTuple):
    """A parallel view. frame (3, 3): rows are the directions right, up, and towards the viewer.

    low, high (2,): the picture's lower left and upper right corner along the first two rows.
    """

    frame: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def flat(self, points: np.ndarray) -> np.ndarray:
        """Return coordinates (n, 2) of points (n, 3) in the picture's plane."""
        return points @ self.frame[:2].T

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """Left, right, bottom and top of the picture, in matplotlib's order."""
        return self.low[0], self.high[0], self.low[1], self.high[1]


def view_from(towards: np.ndarray, points: np.ndarray, below: float = 0.0) -> View:
    """Return the view of points (n, 3) from the direction `towards` (3,), in which z is up.

    If the direction is close to +z or -z (AHEAD), y is up. below: empty space below the points, as a
    fraction of their width.
    """
    towards = np.asarray(towards, float) / np.linalg.norm(towards)
    up = np.eye(3)[1 if abs(towards[2]) > AHEAD else 2]
    right = np.cross(up, towards)
    right /= np.linalg.norm(right)
    frame = np.stack([right, np.cross(towards, right), towards])
    flat = points @ frame[:2].T
    low, high = flat.min(axis=0), flat.max(axis=0)
    rim = MARGIN * max(float((high - low).max()), 1e-300)
    return View(frame, low - rim - [0, below * (high - low)[0]], high + rim)


def shaded(
    points: np.ndarray, triangles: np.ndarray, colours: np.ndarray, view: View, width: int, lined: bool
) -> np.ndarray:
    """Return a picture (h, width, 4), 0 to 1, of triangles (m, 3) on points (n, 3).

    colours (m, 3, 3): of the triangles' corners; facets seen obliquely are darker. Pixels without a
    triangle are transparent. lined: draw the edges of triangles that are large enough (SHORTEST_LINED).
    """
    wide = FINER * width
    size = view.high - view.low
    scale = wide / size[0]
    tall = FINER * max(1, round(scale * size[1] / FINER))
    seen = points @ view.frame.T
    pixels = np.stack(
        [(seen[:, 0] - view.low[0]) * scale, (view.high[1] - seen[:, 1]) * scale, seen[:, 2]], axis=1
    )[triangles]
    picture, depth = np.zeros((tall, wide, 3), np.float32), np.full((tall, wide), -np.inf, np.float32)
    edges = np.linalg.norm(np.diff(pixels[:, [0, 1, 2, 0], :2], axis=1), axis=2).mean(axis=1) / FINER
    lines = lined * LINE_WIDTH * FINER * np.clip(edges / SHORTEST_LINED - 1, 0, 1)
    facing = np.abs(unit_normals(points, triangles) @ view.frame[2])
    lit = colours * (DARKEST + (1 - DARKEST) * facing)[:, None, None]
    draw(pixels, lit, lines, picture, depth)
    covered = np.isfinite(depth)[..., None].astype(np.float32)
    together = np.concatenate([picture, covered], axis=2)
    parts = (together[row::FINER, column::FINER] for row, column in np.ndindex(FINER, FINER))
    mean = reduce(np.add, parts) / FINER**2
    mean[..., :3] /= np.maximum(mean[..., 3:], 1e-9)
    return np.clip(mean, 0, 1)
