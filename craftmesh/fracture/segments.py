"""Segments of a front, each in one crystal, and the fields of their crystals along it."""

from dataclasses import dataclass

import numpy as np

from craftmesh.mechanics.materials import mean_moduli, turned
from craftmesh.mechanics.near_field import MODES, as_tensor, near_field
from craftmesh.mesh.front_curve import FrontCurve
from craftmesh.surface.rounding import EXACT, ROUNDING

# Angle in radians by which the axes turn between stations; fields interpolated between them err by 0.02 %
# in copper.
TURN = 0.02
SAMPLES = 16  # samples in each piece of the curve, for its axes and nearest points


@dataclass(frozen=True, eq=False)
class Segments:
    """A front cut where its material changes.

    start, length (k,): in arc length; a closed front in one material is one segment of its whole length.
    stiffness (k, 6, 6) and eigenstrain (k, 3, 3): in sample axes. of_edge (e,): the segment of each edge;
    closed, total: of the front, total its length.
    """

    start: np.ndarray
    length: np.ndarray
    stiffness: np.ndarray
    eigenstrain: np.ndarray
    of_edge: np.ndarray
    closed: bool
    total: float

    def at(self, s: np.ndarray) -> np.ndarray:
        """Return the segment (k,) that holds arc length s (k,)."""
        place = np.searchsorted(self.start, s, side="right") - 1
        return np.where(place < 0, len(self.start) - 1 if self.closed else 0, place)

    @property
    def is_ring(self) -> bool:
        """Whether the whole front is closed and of one material."""
        return self.closed and len(self.start) == 1

    def offset(self, segment: int, s: np.ndarray) -> np.ndarray:
        """Return the offset (k,) of s (k,) from the segment's start, the shorter way around if closed."""
        offset = s - self.start[segment]
        if not self.closed:
            return offset
        rest = 0.5 * (self.total - self.length[segment])
        return np.mod(offset + rest, self.total) - rest

    def within(self, segment: int, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the rows of s (k,) in a segment, ends included, and their offsets in it, ascending."""
        length, rounding = self.length[segment], ROUNDING * self.total
        offset = s - self.start[segment]
        if self.closed:
            offset = np.mod(offset + rounding, self.total) - rounding
        offset = np.where(np.abs(offset) < rounding, 0.0, offset)
        offset = np.where(np.abs(offset - length) < rounding, length, offset)
        rows = np.flatnonzero((offset >= 0) & (offset <= length))
        rows = rows[np.argsort(offset[rows], kind="stable")]
        return rows, offset[rows]


def segments_of(
    s: np.ndarray, total: float, closed: bool, stiffness: np.ndarray, eigenstrain: np.ndarray
) -> Segments:
    """Return the segments of a front with corner nodes at s (k,).

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
    """Return a number (k,) for each row of constants (k, ...), the same for equal rows."""
    return np.unique(constants.reshape(len(constants), -1), axis=0, return_inverse=True)[1].ravel()


@dataclass(frozen=True, eq=False)
class Stations:
    """Fields at stations along a front's segments; segment k has stations first[k] to first[k + 1] - 1.

    start, step (k,): s of a segment's first station, and the distance between its stations. gradients (n *
    a * 2, 3 * m * 3), in local axes, components i, m, j: at each station and angle (a,) of `near_field` the
    value and its slope by the angle. opening (n, 3, 3): L^-1; stiffness (n, 9, 9); length: of the front, 0
    if it is open.
    """

    first: np.ndarray
    start: np.ndarray
    step: np.ndarray
    angles: np.ndarray
    gradients: np.ndarray
    opening: np.ndarray
    stiffness: np.ndarray
    length: float

    def places(self, segment: int, s: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the station (k,) at or before s (k,), the fraction to the next, and its slope in s."""
        first, last = self.first[segment], self.first[segment + 1] - 1
        reach = self.step[segment] * (last - first)
        offset = s - self.start[segment]
        if self.length:  # closed front: half of its part outside the segment counts as before the segment
            rest = 0.5 * (self.length - reach)
            offset = np.mod(offset + rest, self.length) - rest
        place = offset.clip(0, reach) / self.step[segment]
        station = np.minimum(place.astype(np.int64), last - first - 1)
        inside = (offset > 0) & (offset < reach)
        return first + station, place - station, np.where(inside, 1 / self.step[segment], 0.0)

    def at(self, segment: int, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return L^-1 (k, 3, 3) and the stiffness (k, 9, 9) in local axes at s (k,) in a segment."""
        station, part, _ = self.places(segment, s)
        part = part[:, None, None]
        tables = self.opening, self.stiffness
        return tuple((1 - part) * table[station] + part * table[station + 1] for table in tables)


def stations_of(segments: Segments, curve: FrontCurve) -> Stations:
    """Return the fields of the segments' crystals at stations, dense enough for the turning of the axes."""
    local, counts = [], []
    for start, length, stiffness in zip(segments.start, segments.length, segments.stiffness):
        count = _station_count(curve, start, length, stiffness)
        axes = curve.moving_frames(start + np.linspace(0, length, count)).axes
        local.append(turned(stiffness, axes))
        counts.append(count)
    stiffness = np.concatenate(local)
    field = near_field(stiffness)
    gradients = np.stack([field.value, field.slope], axis=2).swapaxes(3, 4)
    gradients = np.concatenate([gradients, np.zeros_like(gradients[..., :1])], axis=5)
    return Stations(
        first=np.concatenate([[0], np.cumsum(counts)]),
        start=segments.start.astype(float),
        step=segments.length / (np.array(counts) - 1),
        angles=field.angles,
        gradients=gradients.reshape(-1, 9 * MODES),
        opening=field.opening,
        stiffness=as_tensor(stiffness).reshape(-1, 9, 9),
        length=segments.total if segments.closed else 0.0,
    )


def _station_count(curve: FrontCurve, start: float, length: float, stiffness: np.ndarray) -> int:
    """Return the number of stations, at least two; isotropic materials need only two."""
    if is_isotropic(stiffness):
        return 2
    pieces = max(curve.pieces * length / curve.length, 1)
    axes = curve.moving_frames(start + np.linspace(0, length, int(SAMPLES * pieces) + 2)).axes
    steps = np.linalg.norm(np.diff(axes[:, 1:], axis=0), axis=(1, 2))
    return 2 + int(steps.sum() / TURN)


def is_isotropic(stiffness: np.ndarray) -> bool:
    """Return whether a stiffness (6, 6) is isotropic, to about 1e-6: the index is the square of that."""
    return bool(mean_moduli(stiffness[None]).anisotropy[0] < EXACT)
