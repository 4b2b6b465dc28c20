"""The fields of a front's crystals at a point, with their derivatives along the local axes."""

from typing import NamedTuple

import numpy as np

from craftmesh.fracture.kernels.curve import AXES, POINT, SPEED, TURNS
from craftmesh.jit import kernel

# Powers of 1 / r of the gradients: three fields of unit K, two of unit forces.
POWERS = np.array([0.5, 0.5, 0.5, 1.0, 1.0])
MODES = len(POWERS)
# The least stretch of the tube round a bent front, outside its centre of curvature.
LEAST_STRETCH = 0.05


class Fields(NamedTuple):
    """Fields at stations along the front's segments: those of segment k are first[k] .. first[k + 1] - 1.

    start, step (k,): s of its first station, and from one to the next; value, slope (n, c + 1, MODES, 3,
    2) as in NearField; stiffness (n, 6, 6) in the local axes; angle, cell: the first theta and the step in
    it; length of the curve, 0 where it is open.
    """

    first: np.ndarray
    start: np.ndarray
    step: np.ndarray
    value: np.ndarray
    slope: np.ndarray
    stiffness: np.ndarray
    angle: float
    cell: float
    length: float


@kernel
def fill_fields(fields, segment, s, frame, x, side, h, dh, stress, dstress):
    """Fill gradients h (MODES, 3, 3), stresses, and the derivatives dh, dstress (3, MODES, 3, 3) of both.

    frame: that of the nearest point on the front to x (3,), at s; side: 1 where theta is within pi of
    pi / 2, else -1. All in the local axes; the derivatives are along them, and hold those of the axes.
    """
    x1, x2 = 0.0, 0.0
    for i in range(3):
        offset = x[i] - frame[POINT, i]
        x1 += offset * frame[AXES, i]
        x2 += offset * frame[AXES + 1, i]
    r = np.hypot(x1, x2)
    cos, sin = x1 / r, x2 / r
    middle = 0.5 * np.pi * side
    theta = middle + (np.arctan2(x2, x1) - middle + np.pi) % (2.0 * np.pi) - np.pi
    b_n, b_t, n_t = 0.0, 0.0, 0.0
    for i in range(3):
        b_n += frame[TURNS, i] * frame[AXES + 1, i]
        b_t += frame[TURNS, i] * frame[AXES + 2, i]
        n_t += frame[TURNS + 1, i] * frame[AXES + 2, i]
    stretch = max(frame[SPEED, 0] + x1 * b_t + x2 * n_t, LEAST_STRETCH)
    station, part, per_s = _station(fields, segment, s)
    by_theta, by_s = dh[1], dh[2]
    _interpolated(fields, station, part, per_s, theta, h, by_theta, by_s)
    for m in range(MODES):
        scale = r ** -POWERS[m]
        for i in range(3):
            for j in range(2):
                h[m, i, j] *= scale
                dr, dt, ds = -POWERS[m] / r * h[m, i, j], scale * by_theta[m, i, j], scale * by_s[m, i, j]
                dh[0, m, i, j] = cos * dr - sin * dt / r
                dh[1, m, i, j] = sin * dr + cos * dt / r
                dh[2, m, i, j] = ds - b_n * dt
            h[m, i, 2] = 0.0
            for k in range(3):
                dh[k, m, i, 2] = 0.0
        _turned(h[m], dh[2, m], b_n, b_t, n_t)
        for i in range(3):
            for j in range(3):
                dh[2, m, i, j] /= stretch
    here, there = fields.stiffness[station], fields.stiffness[station + 1]
    c = here + part * (there - here)
    for m in range(MODES):
        contract(c, h[m], stress[m])
        for k in range(3):
            contract(c, dh[k, m], dstress[k, m])


@kernel
def _station(fields, segment, s):
    """Return the station at or before s, the part of the way to the next, and how it grows with s."""
    first, last = fields.first[segment], fields.first[segment + 1] - 1
    offset = s - fields.start[segment]
    reach = fields.step[segment] * (last - first)
    if fields.length > 0.0:  # a closed front: from half the rest before the segment to half of it behind
        rest = 0.5 * (fields.length - reach)
        offset = (offset + rest) % fields.length - rest
    if offset <= 0.0:
        return first, 0.0, 0.0
    if offset >= reach:
        return last - 1, 1.0, 0.0
    place = offset / fields.step[segment]
    station = min(int(place), last - first - 1)
    return first + station, place - station, 1.0 / fields.step[segment]


@kernel
def _interpolated(fields, station, part, per_s, theta, value, by_theta, by_s):
    """Fill the gradients' parts in theta and s and their derivatives, cubic in theta, linear in s."""
    place = (theta - fields.angle) / fields.cell
    k = min(max(int(place), 0), fields.value.shape[1] - 2)
    y = place - k
    w = 1.0 - y
    a, b, c, d = (
        (1.0 + 2.0 * y) * w * w,
        y * w * w * fields.cell,
        y * y * (3.0 - 2.0 * y),
        -y * y * w * fields.cell,
    )
    da = -6.0 * y * w / fields.cell
    db, dd = w * (1.0 - 3.0 * y), y * (3.0 * y - 2.0)
    for m in range(MODES):
        for i in range(3):
            for j in range(2):
                v0, v1 = fields.value[station, k, m, i, j], fields.value[station, k + 1, m, i, j]
                g0, g1 = fields.slope[station, k, m, i, j], fields.slope[station, k + 1, m, i, j]
                u0, u1 = fields.value[station + 1, k, m, i, j], fields.value[station + 1, k + 1, m, i, j]
                q0, q1 = fields.slope[station + 1, k, m, i, j], fields.slope[station + 1, k + 1, m, i, j]
                here = a * v0 + b * g0 + c * v1 + d * g1
                there = a * u0 + b * q0 + c * u1 + d * q1
                value[m, i, j] = here + part * (there - here)
                by_s[m, i, j] = per_s * (there - here)
                here = da * (v0 - v1) + db * g0 + dd * g1
                there = da * (u0 - u1) + db * q0 + dd * q1
                by_theta[m, i, j] = here + part * (there - here)


@kernel
def _turned(tensor, by_s, b_n, b_t, n_t):
    """Add to `by_s` (3, 3) what the turn of the axes makes of a tensor (3, 3) along s."""
    turn = ((0.0, b_n, b_t), (-b_n, 0.0, n_t), (-b_t, -n_t, 0.0))
    for i in range(3):
        for j in range(3):
            for k in range(3):
                by_s[i, j] += turn[k][i] * tensor[k, j] + tensor[i, k] * turn[k][j]


@kernel
def contract(c, gradient, stress):
    """Fill `stress` (3, 3) of a displacement gradient; c (6, 6): stiffness over 11, 22, 33, 12, 13, 23."""
    e0, e1, e2 = gradient[0, 0], gradient[1, 1], gradient[2, 2]
    e3 = gradient[0, 1] + gradient[1, 0]
    e4 = gradient[0, 2] + gradient[2, 0]
    e5 = gradient[1, 2] + gradient[2, 1]
    for k in range(6):
        v = c[k, 0] * e0 + c[k, 1] * e1 + c[k, 2] * e2 + c[k, 3] * e3 + c[k, 4] * e4 + c[k, 5] * e5
        if k < 3:
            stress[k, k] = v
        elif k == 3:
            stress[0, 1] = stress[1, 0] = v
        elif k == 4:
            stress[0, 2] = stress[2, 0] = v
        else:
            stress[1, 2] = stress[2, 1] = v
