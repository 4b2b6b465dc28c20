"""Fields given by values at points: values at other places."""

from dataclasses import dataclass

import numpy as np
import scipy

from craftmesh.errors import CraftmeshError, rounded_values
from craftmesh.mesh.integration import AT_ONCE
from craftmesh.surface.side_data import covered, notes_on_place


@dataclass(frozen=True, eq=False)
class PointField:
    """Values (k, c) at points (k, d), c components each.

    axes (d,): the axes (0, 1, 2) of the points' coordinates; the field is the same along all others.
    """

    points: np.ndarray
    axes: tuple[int, ...]
    values: np.ndarray

    def at(self, places: np.ndarray, key: str, box: np.ndarray, needed: str) -> np.ndarray:
        """Return values (n, c) at places (n, 3), `interpolated` between the points around each.

        key: the option that names the field; box (2, 3): of the body; needed: where values are needed, both
        for errors. Raises CraftmeshError for a field off the body, and for a place farther from the points
        than these from their neighbours.
        """
        if len(self.points) == 1:
            return np.broadcast_to(self.values[0], (len(places), self.values.shape[1]))
        notes_on_place(key, self.points, box[:, self.axes])
        along, count = places[:, self.axes], 3 ** len(self.axes)  # a point of a grid and its neighbours
        is_covered, where = covered(along, self.points, count)
        if not is_covered.all():
            raise CraftmeshError(
                f"{key}: has no value at {rounded_values(places[~is_covered][0])}, {where}; give values "
                f"{needed}"
            )
        return interpolated(self.points, self.values, along, count)


def interpolated(points: np.ndarray, values: np.ndarray, places: np.ndarray, count: int) -> np.ndarray:
    """Return values (n, c) at places (n, d) from values (k, c) at points (k, d).

    The value is on the least-squares plane through the values of the `count` nearest points, weighted by
    inverse squared distance, and is clipped to their range. Within that range, values linear in position
    are reproduced.
    """
    tree = scipy.spatial.KDTree(points)
    rows = range(0, len(places), AT_ONCE)
    parts = [_on_planes(tree, values, places[row : row + AT_ONCE], count) for row in rows]
    return np.concatenate([values[:0], *parts])


def _on_planes(
    tree: "scipy.spatial.KDTree", values: np.ndarray, places: np.ndarray, count: int
) -> np.ndarray:
    """Return `interpolated` values; tree: of the points."""
    far, near = tree.query(places, k=range(1, min(count, tree.n) + 1))
    weight = 1 / np.maximum(far / np.maximum(far[:, -1:], np.finfo(float).tiny), 1e-6) ** 2
    weight /= weight.sum(axis=1, keepdims=True)
    off, own = tree.data[near] - places[:, None], values[near]
    middle, mean = ((weight[:, None] @ part)[:, 0] for part in (off, own))
    off, change = off - middle[:, None], own - mean[:, None]
    turned = (weight[:, :, None] * off).swapaxes(1, 2)
    slope = np.linalg.pinv(turned @ off, rcond=1e-12, hermitian=True) @ (turned @ change)
    found = mean - (middle[:, None] @ slope)[:, 0]
    return np.clip(found, own.min(axis=1), own.max(axis=1))
