"""Where a crack meets the facets of a surface: traces, and the angles between crack and facets."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from craftmesh.surface.kernels.triangle_pairs import intersecting_pairs
from craftmesh.surface.measure import meets_box, unit_normals
from craftmesh.surface.rounding import ROUNDING
from craftmesh.types import Crack, Surface


class Traces(NamedTuple):
    """Segments where crack triangles cut facets: facet (k,), ends (k, 2, 3), angle (k,).

    angle: between triangle and facet, 0 to 90 degrees.
    """

    facet: np.ndarray
    ends: np.ndarray
    angle: np.ndarray

    @property
    def length(self) -> np.ndarray:
        """Lengths (k,) of the traces."""
        return np.linalg.norm(self.ends[:, 1] - self.ends[:, 0], axis=1)


class Oblique(NamedTuple):
    """A boundary that the crack meets at a small angle.

    sides, kind: of the boundary's facets; angle: the smallest, in degrees; length: of the trace at small
    angles; place (3,): where the angle is smallest.
    """

    sides: tuple[int, int]
    kind: int
    angle: float
    length: float
    place: tuple[float, float, float]


def traces(crack: Crack, surface: Surface) -> Traces:
    """Return the traces of the crack's triangles on the facets of a surface.

    Not checked: the surface must not contain this crack.
    """
    reach = np.stack([f(crack.points[crack.triangles], axis=(0, 1)) for f in (np.min, np.max)])
    rows = np.flatnonzero(meets_box(surface.points[surface.facets], reach))
    points = np.concatenate([crack.points, surface.points])
    count = len(crack.triangles)
    facets = np.concatenate([crack.triangles, surface.facets[rows] + len(crack.points)]).astype(np.int64)
    pairs = intersecting_pairs(points, facets)
    pairs = np.sort(pairs, axis=1)[((pairs < count).sum(axis=1) == 1)]
    a, b = (points[facets[pairs[:, k]]] for k in range(2))
    normals = [unit_normals(points, facets[pairs[:, k]]) for k in range(2)]
    line = np.cross(normals[0], normals[1])
    sine = np.linalg.norm(line, axis=1)
    angle = np.degrees(np.arctan2(sine, np.abs((normals[0] * normals[1]).sum(axis=1))))
    line = line / np.maximum(sine, ROUNDING)[:, None]
    low_a, high_a, first = _span(a, b, normals[1], line)
    low_b, high_b, _ = _span(b, a, normals[0], line)
    start, end = np.maximum(low_a, low_b), np.minimum(high_a, high_b)
    ends = first[:, None] + (np.stack([start, end], axis=1) - low_a[:, None])[..., None] * line[:, None]
    good = (sine > ROUNDING) & (end > start)
    return Traces(rows[pairs[good, 1] - count], ends[good], angle[good])


def oblique(found: Traces, surface: Surface, limit: float) -> list[Oblique]:
    """Return the boundaries that the crack meets at less than `limit` degrees, smallest angle first."""
    return sorted(_oblique(found, surface, limit), key=lambda one: one.angle)


def _oblique(found: Traces, surface: Surface, limit: float) -> Iterator[Oblique]:
    small = np.flatnonzero(found.angle < limit)
    key = np.column_stack(
        [np.sort(surface.sides[found.facet[small]], axis=1), surface.kind[found.facet[small]]]
    )
    groups, which = np.unique(key, axis=0, return_inverse=True)
    for number, (low, high, kind) in enumerate(groups.tolist()):
        own = small[which.ravel() == number]
        least = own[np.argmin(found.angle[own])]
        place = found.ends[least].mean(axis=0)
        yield Oblique(
            (low, high),
            kind,
            float(found.angle[least]),
            float(found.length[own].sum()),
            tuple(place.tolist()),
        )


def _span(
    corners: np.ndarray, others: np.ndarray, normal: np.ndarray, line: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the segment in which each triangle (k, 3, 3) cuts the plane of its partner in `others`.

    normal (k, 3): of these planes; line (k, 3): unit vectors along the segments. Returns start and end (k,)
    as coordinates along `line`, and the start's position (k, 3); start = inf if nothing is cut.
    """
    off = ((corners - others[:, :1]) * normal[:, None]).sum(axis=2)
    low, high = np.full(len(corners), np.inf), np.full(len(corners), -np.inf)
    first = np.zeros((len(corners), 3))
    for i in range(3):
        j = (i + 1) % 3
        crosses = (off[:, i] * off[:, j] <= 0) & (off[:, i] != off[:, j])
        share = off[:, i] / np.where(crosses, off[:, i] - off[:, j], 1.0)
        at = corners[:, i] + share[:, None] * (corners[:, j] - corners[:, i])
        along = (at * line).sum(axis=1)
        first = np.where((crosses & (along < low))[:, None], at, first)
        low = np.where(crosses, np.minimum(low, along), low)
        high = np.where(crosses, np.maximum(high, along), high)
    return low, high, first
