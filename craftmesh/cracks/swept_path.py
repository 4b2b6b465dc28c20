"""A crack whose path was measured in one plane, as on a face of a specimen: swept across the box."""

import numpy as np

from craftmesh.cracks.fit_bounds import Numbers
from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.prescription import frame_of, semi_axes, vector
from craftmesh.cracks.series import GivenSurface
from craftmesh.errors import CraftmeshError


def crack_along_path(
    path: np.ndarray, options: CrackOptions, increment: int, box: np.ndarray
) -> tuple[GivenSurface, Numbers]:
    """Return the surface that a measured path (k, 2) sweeps through the box (2, 3), as deep as asked for.

    path: x along the crack, ascending, and y out of its plane, one to options.scale model units. The place
    x = options.start lies at options.centre, x goes along the axis, y along the normal. The surface goes
    from there along the axis to the increment's depth, and the other way out of the box: along the path as
    far as that was measured, then level. It is ruled: its lines stand across the axis, turned about it by
    options.slant degrees, and its front is one of them. Raises CraftmeshError for a path that turns back or
    ends before the crack does.
    """
    along, above = np.asarray(path, float).T * options.scale
    along = along - options.start * options.scale
    back = np.flatnonzero(np.diff(along) <= 0)
    if len(back):
        raise CraftmeshError(
            f"the crack's path turns back after its point {back[0] + 1}, x = {path[back[0], 0]:g}; "
            "expected ascending x: sort the points, or leave out those in which it overhangs"
        )
    sizes = semi_axes(options, increment)
    depth = sizes[0]
    if not along[0] <= 0 < depth <= along[-1]:
        raise CraftmeshError(
            f"the crack's path goes from {along[0]:.4g} to {along[-1]:.4g} along the axis, in model units "
            f"from its start; expected it to hold the crack, 0 to {depth:.4g}: change scale, start or "
            "radius"
        )
    above = above - np.interp(0.0, along, above)
    centre = vector("centre", options.centre)
    reach = float(np.linalg.norm(box[1] - box[0]) + np.linalg.norm(centre - np.mean(box, axis=0)))
    inner = (along > -reach) & (along < depth)
    ends = np.array([min(-reach, along[0]), depth])
    at = np.concatenate([ends[:1], along[inner], ends[1:]])
    profile = np.stack([at, np.interp(at, along, above)], axis=1)
    frame = frame_of(options, sizes)
    sweep = frame[1] + np.tan(np.radians(options.slant)) * frame[2]
    lines = [centre + profile @ frame[[0, 2]] + side * reach * sweep for side in (-1, 1)]
    numbers: Numbers = {"path_points": int(inner.sum())}
    if len(along) > 2 and not ((along > 0) & (along < depth)).any():
        numbers["notes"] = [
            f"none of the path's {len(along)} points, from {along[0]:.4g} to {along[-1]:.4g}, is within "
            f"the crack, 0 to {depth:.4g}: it is straight there; is crack.scale right?"
        ]
    return GivenSurface(np.concatenate(lines), _strip(len(at))), numbers


def _strip(count: int) -> np.ndarray:
    """Return the triangles between two lines of `count` points, the second's after the first's."""
    low = np.arange(count - 1)
    high = low + count
    return np.concatenate(
        [np.column_stack([low, low + 1, high + 1]), np.column_stack([low, high + 1, high])]
    )
