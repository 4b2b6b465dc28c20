"""Volume-preserving curvature flow of grain boundaries in the voxels, and the roughness of boundaries.

Each iteration blurs the grains with a Gaussian and gives every voxel to the grain with the largest weight
there (Merriman, Bence and Osher 1994). A price per grain is added to the weight to keep the grain's volume
(Jacobs, Merkurjev and Esedoglu, J. Comput. Phys. 354, 2018). Voxels are exchanged one by one. No exchange
may split a grain, remove its last voxel, or connect grains that touch nowhere else.
"""

from dataclasses import dataclass

import numpy as np
import scipy

from craftmesh.voxels.kernels.exchange import CONNECTION_DISTANCE, contact_key, exchange
from craftmesh.voxels.kernels.votes import MOST_GRAINS, choices, votes

# Radius of the Gaussian, in standard deviations; on cubic voxels 6 % of its weight is beyond.
CUT_OFF = 2.5
# Distance from a boundary, in standard deviations, within which voxels are exchanged; none are farther.
BAND = 1.5
# Largest relative error of a grain's number of voxels after an iteration; one voxel is always allowed.
VOLUME_TOLERANCE = 0.005
# The same during the first half of an iteration's passes.
MOST_DRIFT = 0.1
# Largest number of exchange passes in an iteration. A grain's price is added to its weight at each voxel;
# after each pass the price is raised if the grain has too few voxels, and lowered if it has too many.
SWEEPS = 20
# Fraction of the price change that a grain's missing voxels require; less than 1, because the prices of its
# neighbours change too.
DAMPING = 0.5
# Difference of weights below which a small price change exchanges a voxel; also the largest price change.
WIDTH = 0.1


def smooth_boundaries(labels: np.ndarray, spacing: np.ndarray, rounds: int) -> tuple[np.ndarray, dict]:
    """Return labels (nx, ny, nz) with smoother grain boundaries after `rounds` iterations, and a report.

    spacing (3,): of the voxels. Voids and the outside do not change. No grain disappears or splits, and no
    two grains, voids or box faces touch that did not touch before. The report has `roughness`, the fraction
    of the grain boundaries' area (of voxel faces) that the first iteration removes, also measured if
    `rounds` is 0; `smoothed_voxels`, their number; `smoothed_by_grain`, the sum of voxels lost and gained
    per changed grain; and `smoothing_volume_change`, the largest relative change of a grain's volume.
    """
    grid = _Grid.of(labels, spacing)
    flow = _Flow(grid)
    before = grid.boundary_area(spacing)
    flow.round()
    area = grid.boundary_area(spacing)
    for _ in range(rounds - 1):
        flow.round()
    smoothed = grid.labels(labels) if rounds else labels
    changed = smoothed != labels
    change = float(np.abs(flow.voxels / flow.wanted - 1).max(initial=0.0))
    ids, count = np.unique(np.concatenate([smoothed[changed], labels[changed]]), return_counts=True)
    report = {
        "roughness": float(1 - area / before) if before else 0.0,
        "smoothed_voxels": int(changed.sum()),
        "smoothed_by_grain": dict(zip(map(str, ids.tolist()), count.tolist())),
        "smoothing_volume_change": change if rounds else 0.0,
    }
    return smoothed, report


@dataclass(frozen=True)
class _Grid:
    """A flat padded array of grain indices 0, 1, ...

    Each void, the outside and each box face has a code < -1 of its own.
    """

    padded: np.ndarray  # (n,) int32: each voxel's grain index or code; the rim has the box faces' codes
    shape: tuple[int, int, int]  # shape of the padded array
    rim: list[int]  # voxels padded on each side along x, y, z
    ids: np.ndarray  # (g,) label of each grain
    steps: np.ndarray  # (s,) flat offsets of the voxels in the Gaussian's neighbourhood
    weights: np.ndarray  # (s,) of the Gaussian
    band: tuple[int, ...]  # window along x, y, z in which a second label makes a voxel exchangeable

    @classmethod
    def of(cls, labels: np.ndarray, spacing: np.ndarray) -> "_Grid":
        offsets, weights = _gaussian(spacing)
        rim = np.maximum(CONNECTION_DISTANCE, np.abs(offsets).max(axis=0)).tolist()
        ids = np.unique(labels)
        grains = ids[ids > 0]
        code = np.where(ids > 0, np.cumsum(ids > 0) - 1, -8 - np.cumsum(ids <= 0))
        padded = np.pad(code.astype(np.int32)[np.searchsorted(ids, labels)], [(r, r) for r in rim])
        for axis in range(3):
            ends = np.moveaxis(padded, axis, 0)
            ends[: rim[axis]], ends[-rim[axis] :] = -2 - 2 * axis, -3 - 2 * axis
        strides = np.array(padded.strides) // padded.itemsize
        band = tuple(2 * int(r) + 1 for r in BAND * _deviation(spacing) / spacing)
        return cls(padded.ravel(), padded.shape, rim, grains, offsets @ strides, weights, band)

    @property
    def strides(self) -> np.ndarray:
        return np.array([self.shape[1] * self.shape[2], self.shape[2], 1], np.int64)

    def _core(self, axis: int, low: int, high: int) -> np.ndarray:
        """Return the unpadded voxels, with the window's ends on `axis` moved by `low` and `high` voxels."""
        window = [slice(r, -r) for r in self.rim]
        window[axis] = slice(self.rim[axis] + low, self.shape[axis] - self.rim[axis] + high)
        return self.padded.reshape(self.shape)[tuple(window)]

    def labels(self, before: np.ndarray) -> np.ndarray:
        code = self._core(0, 0, 0)
        return np.where(code >= 0, self.ids[np.maximum(code, 0)], before).astype(np.int32)

    def boundary_area(self, spacing: np.ndarray) -> float:
        """Return the total area of voxel faces between grains, without voids, outside and box faces."""
        area = 0.0
        for axis in range(3):
            a, b = self._core(axis, 0, -1), self._core(axis, 1, 0)
            faces = np.count_nonzero((a != b) & (a >= 0) & (b >= 0))
            area += faces * float(spacing.prod() / spacing[axis])
        return area

    def contacts(self) -> tuple[np.ndarray, int]:
        """Return sorted keys of pairs of codes (grains, voids, ...) that share voxel faces, and `count`.

        count, more than the largest code, is needed to make such keys (`contact_key`). Both go to
        `exchange`.
        """
        count = int(np.abs(self.padded).max()) + 1
        keys = []
        for axis in range(3):
            a, b = self._core(axis, -1, 0).ravel(), self._core(axis, 0, 1).ravel()
            a, b = a[a != b].astype(np.int64), b[a != b].astype(np.int64)
            keys.append(contact_key(np.minimum(a, b), np.maximum(a, b), count))
        return np.unique(np.concatenate(keys)), count


def _deviation(spacing: np.ndarray) -> float:
    """Return the Gaussian's standard deviation: the edge of a cube of the voxel's volume.

    It is larger if the cut-off would not reach the next voxel along the longest edge. On clean grains with
    voxels of 1 x 1 x 3, smoothing with this deviation relabels 0.4% of the voxels; with the longest edge as
    deviation it would relabel 4%.
    """
    reaching = np.nextafter(spacing.max() / CUT_OFF, np.inf)
    return float(max(np.cbrt(spacing.prod()), reaching))


def _gaussian(spacing: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return offsets (s, 3) of the voxels in the Gaussian's neighbourhood, 0 first, and weights (s,)."""
    sigma = _deviation(spacing)
    reach = np.floor(CUT_OFF * sigma / spacing).astype(int)
    axes = [np.arange(-r, r + 1) for r in reach]
    offsets = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    square = ((offsets * spacing) ** 2).sum(axis=1)
    order = np.argsort(square, kind="stable")
    order = order[square[order] <= (CUT_OFF * sigma) ** 2]
    return offsets[order], np.exp(-square[order] / (2 * sigma**2))


def _rows(grid: _Grid) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return flat indices (k,) of voxels near boundaries, grains around each (k, m), and weights (k, m).

    A weight is the fraction of the Gaussian around the voxel that the grain fills; m is MOST_GRAINS.
    """
    code = grid.padded.reshape(grid.shape)
    mixed = scipy.ndimage.maximum_filter(code, grid.band) != scipy.ndimage.minimum_filter(code, grid.band)
    near = np.flatnonzero(mixed.ravel() & (grid.padded >= 0))
    place = np.empty(len(near) + 1, np.int64)
    grain = np.empty((len(near) + 1, MOST_GRAINS), np.int32)
    share = np.empty((len(near) + 1, MOST_GRAINS), np.float32)
    count = votes(grid.padded, near, grid.steps, grid.weights, place, grain, share)
    return place[:count], grain[:count], share[:count]


class _Flow:
    """The curvature flow on a grid: its state (volumes, prices, contacts); it changes the grid's voxels."""

    def __init__(self, grid: _Grid):
        self.grid = grid
        self.voxels = np.bincount(grid.padded[grid.padded >= 0], minlength=len(grid.ids))
        self.wanted = self.voxels.copy()
        self.contacts, self.count = grid.contacts()
        self.price = np.zeros(len(grid.ids))
        self.mark = np.zeros(len(grid.padded), np.int32)

    def round(self) -> None:
        """Run one iteration: blur, and exchange voxels until each grain's volume is near its start value.

        Near means within VOLUME_TOLERANCE; after SWEEPS passes, volumes may be farther off.
        """
        rows = _rows(self.grid)
        for n in range(SWEEPS):
            near = self._sweep(rows, MOST_DRIFT if n < SWEEPS // 2 else VOLUME_TOLERANCE)
            missing = self.wanted - self.voxels
            if (np.abs(missing) <= self._room(VOLUME_TOLERANCE)).all():
                break
            change = DAMPING * missing * 2 * WIDTH / np.maximum(near, 1)
            self.price += np.clip(change, -WIDTH, WIDTH)

    def _room(self, drift: float) -> np.ndarray:
        """Return the number of voxels (g,) that each grain may differ from its volume at the start."""
        return np.maximum(1, (drift * self.wanted).astype(np.int64))

    def _sweep(self, rows: tuple[np.ndarray, np.ndarray, np.ndarray], drift: float) -> np.ndarray:
        """Give voxels near boundaries to the grain with the largest weight plus price there.

        The voxels with the largest gain come first, and passes over them follow until nothing changes. No
        grain leaves the range of the fraction `drift` around its volume at the start; a grain outside the
        range may only come closer. rows: from `_rows`. Return for each grain the number (g,) of voxels in
        which it is one of the best two and these differ by less than WIDTH: a small change of price would
        exchange them.
        """
        best, lead = np.empty(len(rows[0]), np.int64), np.empty(len(rows[0]))
        near = np.zeros(len(self.price), np.int64)
        choices(self.grid.padded, *rows, self.price, best, lead, near, WIDTH)
        chosen = np.flatnonzero(lead > 0)
        chosen = chosen[np.argsort(-lead[chosen], kind="stable")]
        place, wanted = rows[0][chosen], best[chosen]
        room = self._room(drift)
        bounds = np.stack([np.maximum(self.wanted - room, 1), self.wanted + room], axis=1)
        arguments = place, wanted, self.voxels, bounds, self.contacts, self.count, self.mark
        while exchange(self.grid.padded, self.grid.strides, *arguments):
            pass
        return near
