"""Which way and how far each point of a front goes, and how many load cycles that takes."""

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from craftmesh.cracks.polyline import polyline
from craftmesh.errors import CraftmeshError
from craftmesh.growth.crystal_kink import largest_near_stress
from craftmesh.growth.gate import ARRESTED, Evidence, reasons
from craftmesh.growth.kink_angle import driving_intensity, kink_angles
from craftmesh.growth.options import GrowthOptions
from craftmesh.surface.measure import meets_box
from craftmesh.types import Crack

NEAR_FIELD = "near_field"
# Of itself: how far the crack's radius may be off, and of a front's length: the spacing of places on it.
TOLERANCE = 1e-3


class KinksAndExtensions(NamedTuple):
    """Kink angle (n,) in radians, extension (n,) and driving intensity (n,) of each point of a front.

    stays (n,): why a point does not extend, see `reasons`; the kink angle is 0 where K says none. cycles:
    the load cycles that the extension takes; None without Paris' law, and where nothing extends.
    """

    kink_angle: np.ndarray
    extension: np.ndarray
    driving: np.ndarray
    stays: np.ndarray
    cycles: float | None


def kinks_and_extensions(
    k: np.ndarray,
    radius: float,
    options: GrowthOptions,
    known: Evidence | None = None,
    stiffness: np.ndarray | None = None,
) -> KinksAndExtensions:
    """Return which way and how far points with K_I, K_II, K_III (n, 3) go in a crack of that radius.

    The way is that of the criterion (Erdogan & Sih 1963 by default). Points stay as `reasons` says; without
    what is known of K it counts as exact. stiffness (n, 6, 6): as in `largest_near_stress`, which
    the criterion near_field asks for. Raises CraftmeshError as kink_angles does.
    """
    if options.criterion == NEAR_FIELD:
        angle, driving = _in_crystals(k, stiffness)
    else:
        angle = kink_angles(k, options.criterion, options.poisson)
        driving = driving_intensity(k, angle)
    span = (1 - options.stress_ratio) * np.maximum(driving, 0.0)
    stays = reasons(k, driving, span, options.threshold, known)
    goes = stays == ""
    angle = np.where(goes | (stays == ARRESTED), angle, 0.0)
    size = np.zeros(len(angle))
    if not goes.any():
        return KinksAndExtensions(angle, size, driving, stays, None)
    median = options.extension if options.extension is not None else options.share * radius
    size[goes] = extensions(driving[goes], median, options)
    return KinksAndExtensions(angle, size, driving, stays, load_cycles(span[goes], size[goes], options))


def _in_crystals(k: np.ndarray, stiffness: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """Return kink angles and driving intensities (n,); a closed crack (K_I < 0) counts as K_I = 0."""
    if stiffness is None:
        raise CraftmeshError(
            "grow.criterion is near_field, and the crystals are not known; expected their stiffness"
        )
    return largest_near_stress(np.column_stack([np.maximum(k[:, 0], 0.0), k[:, 1:]]), stiffness)


def extensions(driving: np.ndarray, median: float, options: GrowthOptions) -> np.ndarray:
    """Return the extension (n,) of points that go on, of driving intensity (n,) over 0; median: `median`.

    Uniform, or median (K / K_median)^m, within least and most times the median; a law with a threshold
    has no least.
    """
    if options.law == "uniform":
        return np.full(len(driving), median)
    # as a power of 1 or more it would be capped all the same
    ratio = np.minimum(driving / np.median(driving), options.most)
    least = 0.0 if options.threshold > 0 else options.least
    return median * np.clip(ratio**options.exponent, least, options.most)


def load_cycles(span: np.ndarray, extension: np.ndarray, options: GrowthOptions) -> float | None:
    """Return the load cycles of one extension by Paris' law, their median along the front; None without C.

    da/dN = C (Delta K)^m; span (n,): Delta K, over 0.
    """
    if options.coefficient is None:
        return None
    return float(np.median(extension / (options.coefficient * span**options.exponent)))


def crack_radius(crack: Crack, box: np.ndarray) -> float:
    """Return the crack's radius: the largest distance of a point of it in the box (2, 3) from its fronts.

    That is a penny's radius, a half penny's too, the lesser semi-axis of an ellipse, the depth of an edge
    crack. Triangles that may hold a farther point than the farthest centre known are split, and again.
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
