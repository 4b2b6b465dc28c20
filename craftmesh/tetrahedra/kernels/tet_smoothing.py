"""Moves of one interior point: to raise its worst tet, or to lower its mean aspect ratio."""

import numpy as np
from numba import njit

from craftmesh.tetrahedra.kernels.tet_cavity import MAX_FACES, find_star, star_faces, worst_of
from craftmesh.tetrahedra.kernels.tet_quality import INVERTED, aspect_ratio_at, quality_at, quality_of

# Of a tet's two worst, the second counts for the direction when it is this close to the worst.
CLOSE = 0.03
# A centroid may lower a sound worst quality by this factor when the mean rises.
LOSS = 0.95


@njit(cache=True)
def worst_at(points, faces, count, x, y, z, measure, floor):
    """Worst quality of the cone from (x, y, z) over the faces; ends at the first one not over `floor`."""
    worst = 1e300
    for i in range(count):
        worst = min(worst, quality_at(points, faces[i, 0], faces[i, 1], faces[i, 2], x, y, z, measure))
        if worst <= floor:
            return worst
    return worst


@njit(cache=True)
def _mean_at(points, faces, count, x, y, z, measure):
    total = 0.0
    for i in range(count):
        total += quality_at(points, faces[i, 0], faces[i, 1], faces[i, 2], x, y, z, measure)
    return total / count


@njit(cache=True)
def _aspect_sum(points, faces, count, x, y, z, limit):
    """Sum of the cone's aspect ratios; INVERTED as soon as it passes `limit`."""
    total = 0.0
    for i in range(count):
        total += aspect_ratio_at(points, faces[i, 0], faces[i, 1], faces[i, 2], x, y, z)
        if total >= limit:
            return INVERTED
    return total


@njit(cache=True)
def _ascent(points, face, x, y, z, value, h, measure):
    """Unit direction in which the quality of one tet of the cone rises fastest (finite differences)."""
    a, b, c = face[0], face[1], face[2]
    dx = quality_at(points, a, b, c, x + h, y, z, measure) - value
    dy = quality_at(points, a, b, c, x, y + h, z, measure) - value
    dz = quality_at(points, a, b, c, x, y, z + h, measure) - value
    length = np.sqrt(dx * dx + dy * dy + dz * dz) + 1e-300
    return dx / length, dy / length, dz / length


@njit(cache=True)
def _climb_direction(points, faces, count, x, y, z, size, measure):
    """Direction in which the worst tet of the cone (and the second, if close) improves; not normed."""
    first, second, i_first, i_second = 1e300, 1e300, -1, -1
    for i in range(count):
        value = quality_at(points, faces[i, 0], faces[i, 1], faces[i, 2], x, y, z, measure)
        if value < first:
            second, i_second = first, i_first
            first, i_first = value, i
        elif value < second:
            second, i_second = value, i
    h = 1e-4 * size
    gx, gy, gz = _ascent(points, faces[i_first], x, y, z, first, h, measure)
    if i_second >= 0 and second <= first + CLOSE:
        dx, dy, dz = _ascent(points, faces[i_second], x, y, z, second, h, measure)
        gx, gy, gz = gx + dx, gy + dy, gz + dz
    return gx, gy, gz


@njit(cache=True)
def climb(points, faces, count, x, y, z, size, measure, steps, best):
    """Hill climb for the cone's apex with the best worst quality; return x, y, z and that quality."""
    step = 0.15 * size
    for _ in range(steps):
        gx, gy, gz = _climb_direction(points, faces, count, x, y, z, size, measure)
        length = np.sqrt(gx * gx + gy * gy + gz * gz)
        if length < 1e-6:
            break
        gain = 0.0
        for _ in range(5):
            px, py, pz = x + step * gx / length, y + step * gy / length, z + step * gz / length
            value = worst_at(points, faces, count, px, py, pz, measure, best)
            if value > best:
                x, y, z, gain, best = px, py, pz, value - best, value
                step *= 1.3
                break
            step *= 0.4
        if gain < 1e-3:
            break
    return x, y, z, best


@njit(cache=True)
def _place(state, v, x, y, z, star, count, measure):
    """Move point v and renew the qualities of its star."""
    state.points[v, 0], state.points[v, 1], state.points[v, 2] = x, y, z
    tets = state.tets
    for i in range(count):
        t = star[i]
        state.quality[t] = quality_of(state.points, tets[t, 0], tets[t, 1], tets[t, 2], tets[t, 3], measure)


@njit(cache=True)
def _weighted_centroid(state, faces, count):
    """Centroid of the star's outer faces, weighted by area over target length cubed."""
    points, size = state.points, state.size
    cx, cy, cz, total = 0.0, 0.0, 0.0, 0.0
    for i in range(count):
        a, b, c = faces[i, 0], faces[i, 1], faces[i, 2]
        ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
        vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        weight = np.sqrt(nx * nx + ny * ny + nz * nz) / (size[a] + size[b] + size[c]) ** 3
        cx += weight * (points[a, 0] + points[b, 0] + points[c, 0]) / 3.0
        cy += weight * (points[a, 1] + points[b, 1] + points[c, 1]) / 3.0
        cz += weight * (points[a, 2] + points[b, 2] + points[c, 2]) / 3.0
        total += weight
    return cx / total, cy / total, cz / total


@njit(cache=True)
def smooth_worst(state, v, measure, threshold, steps, work):
    """Move interior point v to raise its worst quality where that is under `threshold`; return whether.

    Elsewhere v goes towards the centroid of its star if the mean rises and the worst stays over both
    the threshold and .95 of itself.
    """
    points, faces = state.points, work.faces
    count = find_star(state, v, work.star)
    if count < 4 or count > MAX_FACES:
        return False
    star_faces(state.tets, work.star, count, v, faces)
    worst = worst_of(state.quality, work.star, count)
    x0, y0, z0 = points[v, 0], points[v, 1], points[v, 2]
    cx, cy, cz = _weighted_centroid(state, faces, count)
    x, y, z, best, moved = x0, y0, z0, worst, False
    floor = worst if worst < threshold else max(threshold, LOSS * worst)
    share = 1.0
    for _ in range(3):
        px, py, pz = x0 + share * (cx - x0), y0 + share * (cy - y0), z0 + share * (cz - z0)
        value = worst_at(points, faces, count, px, py, pz, measure, floor)
        if value > floor and (
            worst < threshold
            or _mean_at(points, faces, count, px, py, pz, measure)
            > _mean_at(points, faces, count, x0, y0, z0, measure) + 1e-4
        ):
            x, y, z, best, moved = px, py, pz, value, True
            break
        share *= 0.5
    if best < threshold:
        px, py, pz, value = climb(points, faces, count, x, y, z, state.size[v], measure, steps, best)
        if value > best + 1e-6:
            x, y, z, moved = px, py, pz, True
    if moved:
        _place(state, v, x, y, z, work.star, count, measure)
    return moved


@njit(cache=True)
def smooth_aspect(state, v, measure, floor, work):
    """Lower the mean aspect ratio round interior point v by pattern search; return whether it moved.

    The worst quality stays over the lesser of itself and `floor`.
    """
    points, faces = state.points, work.faces
    count = find_star(state, v, work.star)
    if count < 4 or count > MAX_FACES:
        return False
    star_faces(state.tets, work.star, count, v, faces)
    limit = min(worst_of(state.quality, work.star, count), floor) - 1e-9
    x, y, z = points[v, 0], points[v, 1], points[v, 2]
    first = _aspect_sum(points, faces, count, x, y, z, INVERTED)
    if first >= INVERTED:
        return False
    best = first
    px, py, pz = 0.0, 0.0, 0.0
    for i in range(count):
        for k in range(3):
            px += points[faces[i, k], 0] / (3 * count)
            py += points[faces[i, k], 1] / (3 * count)
            pz += points[faces[i, k], 2] / (3 * count)
    value = _aspect_sum(points, faces, count, px, py, pz, best)
    if value < best and worst_at(points, faces, count, px, py, pz, measure, limit) > limit:
        x, y, z, best = px, py, pz, value
    step = 0.12 * state.size[v]
    for _ in range(4):
        found = False
        for way in range(6):
            d = step if way % 2 else -step
            px = x + d if way < 2 else x
            py = y + d if 2 <= way < 4 else y
            pz = z + d if way >= 4 else z
            value = _aspect_sum(points, faces, count, px, py, pz, best)
            if value < best - 1e-6 and worst_at(points, faces, count, px, py, pz, measure, limit) > limit:
                x, y, z, best, found = px, py, pz, value, True
        if not found:
            step *= 0.4
    if best > first - 1e-4:
        return False
    _place(state, v, x, y, z, work.star, count, measure)
    return True
