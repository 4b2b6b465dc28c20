"""Polylines by arc length: points on them, and nearest points to given places."""

from typing import NamedTuple

import numpy as np

from craftmesh.surface.measure import along_segments

# Most pairs of places and segments, or lattice points, processed at once: about 100 MB.
AT_ONCE = 2_000_000


class Polyline(NamedTuple):
    """A polyline: points (k, d), their arc lengths (k,), and whether it is closed.

    The last point of a closed polyline repeats its first.
    """

    points: np.ndarray
    arc: np.ndarray
    closed: bool

    @property
    def length(self) -> float:
        return float(self.arc[-1])

    def at(self, arc: np.ndarray) -> np.ndarray:
        """Return points (n, d) at arc lengths (n,), which wrap around on a closed polyline."""
        if self.closed:
            arc = np.mod(arc, self.length)
        return np.stack([np.interp(arc, self.arc, column) for column in self.points.T], axis=1)

    def tangents(self) -> np.ndarray:
        """Return unit tangents (k, 3): directions from each point's predecessor to its successor."""
        ahead = np.concatenate([self.points[1:], self.points[1:2] if self.closed else self.points[-1:]])
        behind = np.concatenate([self.points[-2:-1] if self.closed else self.points[:1], self.points[:-1]])
        return (ahead - behind) / np.linalg.norm(ahead - behind, axis=1, keepdims=True)


def polyline(points: np.ndarray) -> Polyline:
    """Return the polyline through points (k, d) in order, without consecutive duplicates."""
    span = np.linalg.norm(np.diff(points, axis=0), axis=1)
    points = points[np.append(True, span > 0)]
    arc = np.append(0.0, np.cumsum(span[span > 0]))
    return Polyline(points, arc, len(points) > 2 and bool((points[0] == points[-1]).all()))


def feet(line: Polyline, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return arc lengths (n,) and distances (n,) of the points of `line` nearest to places (n, 3)."""
    start, step = line.points[:-1], np.diff(line.points, axis=0)
    length = np.diff(line.arc)
    arcs, distances = np.empty(len(places)), np.empty(len(places))
    rows = max(AT_ONCE // len(start), 1)
    for first in range(0, len(places), rows):
        some = places[first : first + rows, None]
        share = along_segments(some, start, step)
        distance = np.linalg.norm(some - start - share[..., None] * step, axis=2)
        nearest = distance.argmin(axis=1)
        row = np.arange(len(some))
        arcs[first : first + rows] = line.arc[nearest] + share[row, nearest] * length[nearest]
        distances[first : first + rows] = distance[row, nearest]
    return arcs, distances
