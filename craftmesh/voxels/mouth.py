"""Where a first crack can begin in a body of voxels: at the root of its deepest notch, else on a face."""

from typing import NamedTuple

import numpy as np

# Axes of the crack's normal and of the way into the body: of equal places the first is taken.
_AXES = ((2, 1), (2, 0), (1, 0), (1, 2), (0, 1), (0, 2))


class Mouth(NamedTuple):
    """A place (3,) on the body, in voxels, and what fits there.

    face: of the body's bounding box, through which the crack comes, as "y = min"; normal: axis of the
    crack's normal; radius: of the crack; notch: depth of the notch, 0 for none. Lengths are in model units.
    """

    place: np.ndarray
    face: str
    normal: int
    radius: float
    notch: float


def find_mouth(body: np.ndarray, spacing: np.ndarray, radius: float, least: float) -> Mouth:
    """Return where a crack up to `radius` begins in a body (nx, ny, nz) that fills its bounding box.

    Lines of voxels go in from each face. A line's notch is how much farther the body is there than on both
    sides, along the crack's normal; less than `least` is roughness. The radius is at most half the
    material ahead, and the distance to the faces beside. The largest product of this radius and of notch
    plus `radius` is taken, in the middle of equal ones.
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
    assert found is not None  # a body has voxels
    return found


def _to_ends(count: int, edge: float) -> np.ndarray:
    """Return the distances (count,) of voxels' centres from the nearer end of their row."""
    at = np.arange(count) + 0.5
    return np.minimum(at, count - at) * edge


def _middle(chosen: np.ndarray) -> tuple[tuple[int, int], np.ndarray]:
    """Return the chosen cell (i, j) at the mean of all, and that mean, else the nearest and its middle."""
    middles = np.argwhere(chosen) + 0.5
    mean = middles.mean(axis=0)
    at = mean.astype(int)
    if not chosen[tuple(at)]:
        mean = middles[((middles - mean) ** 2).sum(axis=1).argmin()]
        at = mean.astype(int)
    return (int(at[0]), int(at[1])), mean
