"""Segments of a front in one crystal each, and the fields of their crystals along it."""

from dataclasses import dataclass

import numpy as np

from craftmesh.fracture.kernels.fields import Fields
from craftmesh.mechanics.near_field import NearField, in_axes, near_field
from craftmesh.mesh.front_curve import FrontCurve

# The axes turn by so much, in radians, from one station to the next; in copper fields between them, which
# are interpolated, err by 0.02 %.
TURN = 0.02
_SAMPLES = 16  # of the axes in each piece of the curve, to find how much they turn


@dataclass(frozen=True, eq=False)
class Segments:
    """A front cut where its material changes.

    start, length (k,): in arc length; a closed front in one material is one segment of its whole length.
    stiffness (k, 6, 6) and eigenstrain (k, 3, 3) in the sample's axes. closed: of the front; of_edge (e,):
    the segment of each edge.
    """

    start: np.ndarray
    length: np.ndarray
    stiffness: np.ndarray
    eigenstrain: np.ndarray
    of_edge: np.ndarray
    closed: bool
    total: float

    def at(self, s: np.ndarray) -> np.ndarray:
        """Return the segment (k,) at s (k,)."""
        place = np.searchsorted(self.start, s, side="right") - 1
        return np.where(place < 0, len(self.start) - 1 if self.closed else 0, place)

    @property
    def is_ring(self) -> bool:
        """Whether the whole front is closed and of one material."""
        return self.closed and len(self.start) == 1

    def offset(self, segment: int, s: np.ndarray) -> np.ndarray:
        """Return how far s (k,) is past the segment's start, on a closed front the nearer way round."""
        offset = s - self.start[segment]
        if not self.closed:
            return offset
        rest = 0.5 * (self.total - self.length[segment])
        return np.mod(offset + rest, self.total) - rest


def segments_of(
    s: np.ndarray, total: float, closed: bool, stiffness: np.ndarray, eigenstrain: np.ndarray
) -> Segments:
    """Return the segments of a front with nodes at s (k,).

    stiffness (e, 6, 6) and eigenstrain (e, 3, 3): along its edges.
    """
    count = len(stiffness)
    material = material_numbers(np.hstack([stiffness.reshape(count, 36), eigenstrain.reshape(count, 9)]))
    before = np.roll(material, 1)
    changes = np.flatnonzero(material != before)
    if not closed:
        changes = np.union1d([0], changes[changes > 0])
    if not len(changes):
        changes = np.array([0])
    start = s[changes]
    end = np.append(start[1:], total + start[0] if closed else total)
    of_edge = (np.searchsorted(changes, np.arange(len(material)), side="right") - 1) % len(changes)
    return Segments(start, end - start, stiffness[changes], eigenstrain[changes], of_edge, closed, total)


def material_numbers(constants: np.ndarray) -> np.ndarray:
    """Return a number (k,) for the constants (k, ...) of each material, the same for equal ones."""
    return np.unique(constants.reshape(len(constants), -1), axis=0, return_inverse=True)[1].ravel()


@dataclass(frozen=True, eq=False)
class Stations:
    """The fields along a front for kernels, and at each station its L^-1 (n, 3, 3)."""

    fields: Fields
    opening: np.ndarray

    def at(self, segment: int, offset: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return L^-1 (k, 3, 3) and the stiffness (k, 6, 6), local axes, at offsets (k,) in a segment."""
        fields = self.fields
        first, last = fields.first[segment], fields.first[segment + 1] - 1
        place = np.clip(offset / fields.step[segment], 0, last - first)
        station = np.minimum(place.astype(np.int64), last - first - 1)
        part = (place - station)[:, None, None]
        station += first
        return tuple(
            (1 - part) * table[station] + part * table[station + 1]
            for table in (self.opening, fields.stiffness)
        )


def stations_of(segments: Segments, curve: FrontCurve) -> Stations:
    """Return the fields of the crystals of all segments, dense enough for their turns."""
    local, counts = [], []
    for start, length, stiffness in zip(segments.start, segments.length, segments.stiffness):
        count = _station_count(curve, start, length, stiffness)
        s = start + np.linspace(0, length, count)
        _, tangent, normal, binormal = curve.frames(s)
        local.append(in_axes(stiffness, np.stack([binormal, normal, tangent], axis=1)))
        counts.append(count)
    found: NearField = near_field(np.concatenate(local))
    fields = Fields(
        first=np.concatenate([[0], np.cumsum(counts)]),
        start=segments.start.astype(float),
        step=segments.length / (np.array(counts) - 1),
        value=found.value,
        slope=found.slope,
        stiffness=np.concatenate(local),
        angle=float(found.angles[0]),
        cell=float(found.angles[1] - found.angles[0]),
        length=segments.total if segments.closed else 0.0,
    )
    return Stations(fields, found.opening)


def _station_count(curve: FrontCurve, start: float, length: float, stiffness: np.ndarray) -> int:
    """Return the number of stations, at least two; isotropic materials need no more."""
    if is_isotropic(stiffness):
        return 2
    pieces = max(len(curve.breaks) * length / curve.length, 1)
    _, tangent, normal, _ = curve.frames(start + np.linspace(0, length, int(_SAMPLES * pieces) + 2))
    steps = np.hypot(*(np.linalg.norm(np.diff(axis, axis=0), axis=1) for axis in (tangent, normal)))
    return 2 + int(steps.sum() / TURN)


def is_isotropic(stiffness: np.ndarray) -> bool:
    """Return whether a stiffness (6, 6) is the same in all axes, to 1e-9."""
    turn = np.array([[2.0, -1, 2], [2, 2, -1], [-1, 2, 2]]) / 3
    other = np.array([[0.0, 0.6, 0.8], [1, 0, 0], [0, 0.8, -0.6]])
    turned = in_axes(stiffness, np.stack([turn, other, turn @ other]))
    return bool(np.abs(turned - stiffness).max() < 1e-9 * np.abs(stiffness).max())
