"""The place of a first crack in a body of voxels: the root of its deepest notch, else on a face."""

from typing import NamedTuple

import numpy as np

# Axes of the crack's normal and of the direction into the body, in order of preference.
_AXES = ((2, 1), (2, 0), (1, 0), (1, 2), (0, 1), (0, 2))


class Mouth(NamedTuple):
    """The mouth of a first crack: `place` (3,), a point of the body's surface in voxels.

    face: face of the body's bounding box from which the crack enters, such as "y = min"; normal: axis of
    the crack's normal, 0 to 2; radius: of the crack; notch: depth of the notch, 0 if none. Radius and notch
    are in model units.
    """

    place: np.ndarray
    face: str
    normal: int
    radius: float
    notch: float


def find_mouth(body: np.ndarray, spacing: np.ndarray, radius: float, least: float) -> Mouth:
    """Return the mouth, the place where a crack enters, of a crack of at most `radius` in a body.

    body: mask (nx, ny, nz) of its voxels in its bounding box; least: smallest depth of a notch. On each
    line of voxels into the box, the body begins at some depth. The excess of this depth over the smallest
    depths on either side, along the crack's normal, is the notch; below `least` it is roughness and counts
    as 0. A crack's radius is at most half the material ahead, and the distance to the box faces at the
    line's sides. The line with the largest (crack radius) x (notch + `radius`) is chosen, the middle one of
    equals.
    """
    best, found = 0.0, None
    for normal, inward in _AXES:
        across = 3 - normal - inward
        for upper in (False, True):
            lines = body.transpose(inward, across, normal)[:: -1 if upper else 1]
            away = np.where(lines.any(axis=0), lines.argmax(axis=0), len(lines))
            is_past = ~lines & (np.arange(len(lines))[:, None, None] > away)
            end = np.where(is_past.any(axis=0), is_past.argmax(axis=0), len(lines))
            sides = [np.minimum.accumulate(away[:, ::way], axis=1)[:, ::way] for way in (1, -1)]
            notch = (away - np.maximum(*sides)) * spacing[inward]
            notch[notch < least] = 0.0
            beside = [_to_ends(away.shape[k], spacing[axis]) for k, axis in enumerate((across, normal))]
            room = np.minimum(beside[0][:, None], beside[1])
            fits = np.minimum(np.minimum(radius, room), (end - away) * spacing[inward] / 2)
            score = fits * (radius + notch)
            if score.max() <= best:
                continue
            best = score.max()
            at, middle = _middle(score == best)
            place = np.empty(3)
            place[[across, normal]] = middle
            place[inward] = len(lines) - away[at] if upper else away[at]
            face = f"{'xyz'[inward]} = {'max' if upper else 'min'}"
            found = Mouth(place, face, normal, float(fits[at]), float(notch[at]))
    assert found is not None  # a body has at least one voxel
    return found


def _to_ends(count: int, edge: float) -> np.ndarray:
    """Return distances (count,) of voxel centres, `edge` apart, from the nearer end of their row."""
    at = np.arange(count) + 0.5
    return np.minimum(at, count - at) * edge


def _middle(chosen: np.ndarray) -> tuple[tuple[int, int], np.ndarray]:
    """Return a chosen cell (i, j) and a point in it, from a mask `chosen` (n, m) of cells.

    The point is the mean of the chosen cells' centres, if it lies in a chosen cell; else the chosen centre
    nearest to the mean.
    """
    middles = np.argwhere(chosen) + 0.5
    mean = middles.mean(axis=0)
    at = mean.astype(int)
    if not chosen[tuple(at)]:
        mean = middles[((middles - mean) ** 2).sum(axis=1).argmin()]
        at = mean.astype(int)
    return (int(at[0]), int(at[1])), mean
