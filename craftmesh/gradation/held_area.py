"""The area of the crack, to which a gradation is held: the given one, else the one that came in."""

import numpy as np

from craftmesh.cracks.within_box import area_off, area_within, segments_of
from craftmesh.surface.front import front_edges
from craftmesh.surface.kernels.distances import nearest_on_edges
from craftmesh.surface.measure import total_area
from craftmesh.types import CRACK, Crack, Surface


class HeldArea:
    """The area that the crack of a surface is to keep; l_min in model units.

    It is the given crack's within the surface's bounds, unless the surface comes with another one, as
    where parts of the crack lie in voids.
    """

    def __init__(self, surface: Surface, given: Crack | None, l_min: float) -> None:
        self.l_min = l_min
        front = front_edges(surface)
        self.points, self.fronts = np.array(surface.points, float, order="C"), front
        self.area = _area(surface)
        if given is None or not len(surface.points):
            return
        lines = [np.column_stack([line[:-1], line[1:]]) for line in given.fronts]
        self.points = np.array(given.points, float, order="C")
        self.fronts = np.concatenate([np.zeros((0, 2)), *lines]).astype(np.int64)
        box = np.stack([surface.points.min(axis=0), surface.points.max(axis=0)])
        whole = area_within(given, box)
        if area_off(self.area, whole, self._segments(surface, front), l_min) <= 1:
            self.area = whole

    def times_off(self, surface: Surface) -> float:
        """Return how many times farther off the area of the crack is than it may be."""
        if not self.area:
            return 0.0
        return area_off(
            _area(surface), self.area, self._segments(surface, front_edges(surface)), self.l_min
        )

    def _segments(self, surface: Surface, front: np.ndarray) -> float:
        if not len(front) or not len(self.fronts):
            return 0.0
        chords = surface.points[front]
        middles = np.ascontiguousarray(chords.mean(axis=1))
        foot = nearest_on_edges(middles, self.points, self.fronts)
        return segments_of(chords, np.linalg.norm(foot - middles, axis=1))


def _area(surface: Surface) -> float:
    return total_area(surface.points, surface.facets[surface.kind == CRACK])
