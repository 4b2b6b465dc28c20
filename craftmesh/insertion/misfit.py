"""How far an inserted crack is off the given one, and where."""

from typing import NamedTuple

import numpy as np

from craftmesh.cracks.area_off import area_off, segments_of
from craftmesh.cracks.near_sheet import NearSheet
from craftmesh.cracks.within_box import area_within
from craftmesh.insertion.fins import Fronts
from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.front import front_edges, front_of
from craftmesh.surface.measure import total_area
from craftmesh.surface.patches import is_on_box
from craftmesh.types import CRACK, Crack, Surface

# Of the least length, that facets and nodes of the front may be off: the promise of both ways of insertion.
FACETS_OFF, FRONT_OFF = 0.05, 0.02
MARGIN = 0.95  # of FACETS_OFF and FRONT_OFF: what a cut has to keep, for gradation moves points too


class Inserted(NamedTuple):
    """A surface with a crack in it, and the report's numbers.

    own (m,): which facets are this crack's; hidden: the area of what of it lies in voids, on their facets
    or in another crack.
    """

    surface: Surface
    own: np.ndarray
    hidden: float
    numbers: dict[str, int | float]


class Misfit(NamedTuple):
    """Places (k, 3) where a crack is farther off the given one than it may be, and by how many times."""

    places: np.ndarray
    times: float


class Given:
    """A crack in a box (2, 3) as it is given; what is inserted is held to it.

    least: the length of which it may be off in shares; held: as in rim_of.
    """

    def __init__(self, crack: Crack, box: np.ndarray, least: float, held: np.ndarray | None = None) -> None:
        self.crack, self.least, self.held = crack, least, held
        self.look = NearSheet(crack, box)
        self.area = area_within(crack, box)

    def misfit(self, inserted: Inserted) -> Misfit:
        """Return where a crack is off: at the middles of its rim's edges, where its area alone is."""
        surface, own = inserted.surface, inserted.surface.facets[inserted.own].astype(np.int64)
        points = surface.points
        edges, _, count = unique_edges(own)
        middles = points[edges].mean(axis=1)
        places = np.concatenate([points[np.unique(own)], middles, points[own].mean(axis=1)])
        off = np.linalg.norm(self.look.look(places).foot - places, axis=1)
        ends = (surface.sides <= 0).any(axis=1) | ((surface.kind == CRACK) & ~inserted.own)
        free = surface.facets[ends]
        front = front_of(own, free.astype(np.int64))
        nodes = points[np.unique(front)]
        times = np.concatenate([off / FACETS_OFF, self._off_front(nodes) / FRONT_OFF]) / (
            MARGIN * self.least
        )
        bad, most = np.concatenate([places, nodes])[times > 1], float(times.max(initial=0.0))
        if fills_box(surface):
            area = inserted.hidden + total_area(points, own)
            segments = segments_of(points[front], self._off_front(points[front].mean(axis=1)))
            by = area_off(area, self.area, segments, self.least)
            if by > 1 and not len(bad):
                bad = middles[count == 1]
            most = max(most, by)
        return Misfit(bad, most)

    def _off_front(self, places: np.ndarray) -> np.ndarray:
        return np.linalg.norm(self.look.nearest_on_front(places) - places, axis=1)


def misfit_of_fronts(surface: Surface, fronts: Fronts, least: float) -> Misfit:
    """Return where nodes of all fronts in a surface are off the given ones; least as in Given."""
    nodes = surface.points[np.unique(front_edges(surface))]
    times = fronts.off(nodes) / (MARGIN * FRONT_OFF * least)
    return Misfit(nodes[times > 1], float(times.max(initial=0.0)))


def fills_box(surface: Surface) -> bool:
    """Tell whether the body ends at the planes of its box and in voids alone."""
    ends = (surface.sides == 0).any(axis=1)
    return bool(is_on_box(surface.kind[ends]).all())
