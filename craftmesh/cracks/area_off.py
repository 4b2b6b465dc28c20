"""By how much a crack's facets cover more or less than the given crack, held to what may be."""

import numpy as np

# Of the given area, and of the least target length squared: what an area may be off. 0.005 and 0.02 are
# promised.
AREA_OFF, LEAST_AREA = 0.004, 0.016


def area_off(area: float, given: float, segments: float, unit: float) -> float:
    """Return how many times farther an area is off the given one than it may be.

    segments: the area between the front and its chords, which counts for nothing; unit: the least target
    length.
    """
    off = min(abs(area - given), abs(area - given + segments))
    return off / max(AREA_OFF * given, LEAST_AREA * unit**2)


def segments_of(chords: np.ndarray, off: np.ndarray) -> float:
    """Return the area between a front and its chords (k, 2, 3) whose middles are off it by (k,)."""
    length = np.linalg.norm(chords[:, 1] - chords[:, 0], axis=1)
    return float((2 / 3 * length * off).sum()) if len(chords) else 0.0
