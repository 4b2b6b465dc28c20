"""Fronts of which a part stays where it is: which of their points, and how far those beside them may go."""

import numpy as np
from scipy.spatial import cKDTree

from craftmesh.cracks.polyline import Polyline


def points_at_rest(line: Polyline, s: np.ndarray, goes: np.ndarray) -> np.ndarray:
    """Tell which points (k,) of a front stay, whose rows at arc lengths s (n,) go on where `goes` (n,).

    A point does as the row next to it, and the point next to a row that stays does so too.
    """
    rows, arc = _places(line, s), _places(line, line.arc)
    rest = ~goes[_tree(line, rows).query(arc)[1]]
    rest[_tree(line, arc).query(rows[~goes])[1]] = True
    if line.closed:
        rest[[0, -1]] = rest[0] | rest[-1]
    return rest


def beside_rest(line: Polyline, rest: np.ndarray, moves: np.ndarray) -> np.ndarray:
    """Return moves (k, 3) no longer than the way along the front to the next point at rest (k,) bool.

    So the new front leaves the old one at 45 degrees at most: K has no jump along a front, nor has its
    extension, and elements beside a sharper corner would be flat.
    """
    if not rest.any():
        return moves
    arc = _places(line, line.arc)
    room, _ = _tree(line, arc[rest]).query(arc)
    size = np.linalg.norm(moves, axis=1)
    share = np.minimum(1.0, room / np.maximum(size, np.finfo(float).tiny))
    return np.where(rest[:, None], 0.0, share[:, None] * moves)


def _places(line: Polyline, s: np.ndarray) -> np.ndarray:
    return np.mod(s, line.length)[:, None] if line.closed else s[:, None]


def _tree(line: Polyline, places: np.ndarray) -> cKDTree:
    return cKDTree(places, boxsize=line.length if line.closed else None)
