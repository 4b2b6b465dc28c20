"""Room in the working arrays: facets that are gone give up their rows, and there is room for more."""

import numpy as np

from craftmesh.gradation.state import PER_FACET, PER_VERTEX

# The room for more: at least so many vertices and facets, and this part of the living facets.
LEAST_VERTICES, VERTEX_SHARE = 1000, 1 / 4
LEAST_FACETS, FACET_SHARE = 4000, 1 / 2
# Corners renumbered at a time, so that no second copy of them all is needed.
BATCH = 1 << 16


def make_room(arrays: dict[str, np.ndarray]) -> None:
    """Drop the facets that are gone from the `arrays` of Mesh and Guards, by field name, and add room.

    Living facets, corner lists and witnesses keep their order. Each array is copied once at most and let go
    before the next one is, so that the memory of no second state is needed while `arrays` is its only hold.
    """
    vertices, facets = (int(used) for used in arrays["used"])
    living = np.flatnonzero(arrays["alive"][:facets])
    row = np.full(facets, -1, np.int64)
    row[living] = np.arange(len(living))
    vertices += max(LEAST_VERTICES, int(len(living) * VERTEX_SHARE))
    facets = len(living) + max(LEAST_FACETS, int(len(living) * FACET_SHARE))
    for name, fill in PER_VERTEX.items():
        arrays[name] = _lengthened(arrays.pop(name), vertices, fill)
    for name, fill in PER_FACET.items():
        arrays[name] = _picked(arrays.pop(name), living, facets, fill)
    arrays["after"] = _picked(arrays.pop("after").reshape(-1, 3), living, facets, -1).reshape(-1)
    for name in ("first", "after"):
        _renumber(arrays[name], row)
    arrays["used"][1] = len(living)


def _lengthened(array: np.ndarray, length: int, fill: int) -> np.ndarray:
    if len(array) >= length:
        return array
    longer = np.full((length, *array.shape[1:]), fill, array.dtype)
    longer[: len(array)] = array
    return longer


def _picked(array: np.ndarray, rows: np.ndarray, length: int, fill: int) -> np.ndarray:
    """Return the `rows` of `array`, and rows of `fill` up to `length`."""
    picked = np.empty((length, *array.shape[1:]), array.dtype)
    # Without a mode that cannot fail, numpy would collect the rows in a copy first.
    np.take(array, rows, axis=0, out=picked[: len(rows)], mode="clip")
    picked[len(rows) :] = fill
    return picked


def _renumber(corners: np.ndarray, row: np.ndarray) -> None:
    """Set the corners, -1 where there is none, to those of the facets' new rows."""
    for start in range(0, len(corners), BATCH):
        part = corners[start : start + BATCH]
        part[:] = np.where(part < 0, -1, 3 * row[part // 3] + part % 3)
