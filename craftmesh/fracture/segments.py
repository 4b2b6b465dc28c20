"""Segments of a front, each in one crystal, and the fields of their crystals along it."""

from dataclasses import dataclass

import numpy as np

from craftmesh.mechanics.materials import mean_moduli, turned
from craftmesh.mechanics.near_field import MODES, as_tensor, near_field
from craftmesh.mesh.front_curve import FrontCurve
from craftmesh.surface.rounding import EXACT, ROUNDING

# Angle in radians by which the front's axes turn between stations, the points at which fields are computed.
# Fields interpolated between stations err by 0.02 % in copper.
TURN = 0.02
SAMPLES = 16  # samples in each piece of the front's curve, for its axes and nearest points


@dataclass(frozen=True, eq=False)
class Segments:
    """The segments of a front, which is cut where its material changes.

    start, length (k,): in arc length; a closed front in one material is one segment of its whole length.
    stiffness (k, 6, 6) and eigenstrain (k, 3, 3): in sample axes; of_edge (e,): the segment of each edge of
    the front; closed: whether the front is closed; total: the front's length.
    """

    start: np.ndarray
    length: np.ndarray
    stiffness: np.ndarray
    eigenstrain: np.ndarray
    of_edge: np.ndarray
    closed: bool
    total: float

    def at(self, s: np.ndarray) -> np.ndarray:
        """Return the number (k,) of the segment that contains each arc length s (k,)."""
        place = np.searchsorted(self.start, s, side="right") - 1
        return np.where(place < 0, len(self.start) - 1 if self.closed else 0, place)

    @property
    def is_ring(self) -> bool:
        """True if the front is closed and one segment, because all of it is in one material."""
        return self.closed and len(self.start) == 1

    def offset(self, segment: int, s: np.ndarray) -> np.ndarray:
        """Return the offset (k,), in arc length, of s (k,) from the segment's start.

        On a closed front, positions in the first half of the rest behind the segment have offsets over its
        length, positions in the second half negative offsets.
        """
        offset = s - self.start[segment]
        if not self.closed:
            return offset
        rest = 0.5 * (self.total - self.length[segment])
        return np.mod(offset + rest, self.total) - rest

    def within(self, segment: int, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the rows of s (k,) in a segment, ends included, and their offsets from its start.

        Rows are sorted by offset. Positions within rounding of an end are put on it.
        """
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
    """Return the segments of a front with corner nodes at arc lengths s (k,), of length `total`.

    stiffness (e, 6, 6) and eigenstrain (e, 3, 3): of the front's edges. Edges are in one segment if these
    are equal in every bit.
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
    """Fields around the front at stations along its segments, n in all.

    Segment k has stations first[k] to first[k + 1] - 1. start, step (k,): arc length of a segment's first
    station, and the distance between its stations. angles (a,): theta in `near_field`; gradients (n * a *
    2, 3 * m * 3): at each station and angle the displacement gradients of the m fields, then their slopes
    by the angle, in local axes, flattened from components i, m, j. opening (n, 3, 3): L^-1 of `near_field`;
    stiffness (n, 9, 9): in local axes; length: the front's length, 0 if it is open.
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
        """Return the station (k,) at or before s (k,), and the fraction (k,) of the way to the next.

        Third comes the derivative (k,) of the fraction by s. Positions outside the segment get the fields
        of its nearer end, with derivative 0.
        """
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
        """Return L^-1 (k, 3, 3) of `near_field` and the stiffness (k, 9, 9) at s (k,) in a segment.

        Both are in local axes and interpolated linearly between stations.
        """
        station, part, _ = self.places(segment, s)
        part = part[:, None, None]
        tables = self.opening, self.stiffness
        return tuple((1 - part) * table[station] + part * table[station + 1] for table in tables)


def stations_of(segments: Segments, curve: FrontCurve) -> Stations:
    """Return the fields around the front at stations along each segment, in the segment's material.

    Between two stations the front's axes turn by about TURN. Isotropic segments have stations only at both
    ends.
    """
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
    """Return the number of a segment's stations, so that the axes turn by about TURN between them.

    It is at least 2, and 2 in isotropic materials, whose fields do not depend on the axes.
    """
    if is_isotropic(stiffness):
        return 2
    pieces = max(curve.pieces * length / curve.length, 1)
    axes = curve.moving_frames(start + np.linspace(0, length, int(SAMPLES * pieces) + 2)).axes
    steps = np.linalg.norm(np.diff(axes[:, 1:], axis=0), axis=(1, 2))
    return 2 + int(steps.sum() / TURN)


def is_isotropic(stiffness: np.ndarray) -> bool:
    """Return True if a stiffness (6, 6) is isotropic, up to relative differences of about 1e-6.

    The anisotropy index, which is compared, grows with the square of such differences.
    """
    return bool(mean_moduli(stiffness[None]).anisotropy[0] < EXACT)
