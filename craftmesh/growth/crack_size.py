"""How large a crack is, and how far a step of its front may go."""

import numpy as np
from scipy.spatial import cKDTree

from craftmesh.cracks.polyline import polyline
from craftmesh.growth.cycles import ROOT
from craftmesh.growth.options import GrowthOptions
from craftmesh.surface.measure import meets_box
from craftmesh.types import Crack

# Of itself: how far the crack's size may be off, and of a front's length: the spacing of places on it.
TOLERANCE = 1e-3
# Of a front's length: in a step of it K along the front, by Paris' law with m = 3, loses the longest
# difference that a front can have, half a wave, but for 1 / e: 2 / (pi m) (see `relaxation`).
OF_FRONT = 0.2
# Of the front's edges: a shorter step is a kink within one element of the next mesh, and K there says
# little. Steps of 0.8 edges kinked by 53 degrees, and by 58 the same way again, where one kink was due.
LEAST_STEP = 1.0


def crack_size(crack: Crack, box: np.ndarray) -> float:
    """Return the crack's size: the largest distance of a point of it in the box (2, 3) from its fronts.

    That is the radius of a penny and a half penny, the lesser semi-axis of an ellipse, the depth of an edge
    crack, the half width of a through crack. Triangles that may hold a farther point than the farthest
    centre known are split, and again.
    """
    fronts = [polyline(crack.points[front]) for front in crack.fronts]
    step = TOLERANCE * max(line.length for line in fronts)
    places = [line.at(np.linspace(0, line.length, int(line.length / step) + 2)) for line in fronts]
    front = cKDTree(np.concatenate(places))
    farthest = 0.0
    corners = crack.points[crack.triangles]
    while len(corners):
        centre = corners.mean(axis=1)
        off, _ = front.query(centre)
        within = ((centre >= box[0]) & (centre <= box[1])).all(axis=1)
        farthest = max(farthest, off[within].max(initial=0.0))
        reach = np.linalg.norm(corners - centre[:, None], axis=2).max(axis=1)
        further = (off + reach > farthest * (1 + TOLERANCE)) & (reach > TOLERANCE * step)
        corners = _split(corners[meets_box(corners, box) & further])
    return farthest


def _split(corners: np.ndarray) -> np.ndarray:
    """Return the triangles (4 m, 3, 3) into which the middles of their edges part triangles (m, 3, 3)."""
    middles = (corners + np.roll(corners, -1, axis=1)) / 2
    at_corners = [np.stack([corners[:, k], middles[:, k], middles[:, k - 1]], axis=1) for k in range(3)]
    return np.concatenate([*at_corners, middles])


def share_of_size(change: float, growth: float = ROOT) -> float:
    """Return the step, over the crack's size, in which K changes by a share: it goes with size^growth.

    Where K changes less than with the root of the size it counts as that.
    """
    return float((1 + change) ** (1 / max(abs(growth), ROOT)) - 1)


def step_length(options: GrowthOptions, size: float, front: float, edge: float, growth: float) -> float:
    """Return how far the front of a crack goes in one step: as the options say, else as K lets it.

    front: length of the shortest front; edge: of its mesh; growth: d ln(K) / d ln(size). A step of its own
    is no longer than OF_FRONT, and no shorter than LEAST_STEP.
    """
    if options.extension is not None:
        return options.extension
    if options.share is not None:
        return options.share * size
    return max(min(share_of_size(options.change, growth) * size, OF_FRONT * front), LEAST_STEP * edge)
