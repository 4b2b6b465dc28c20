"""Volumes of cones between a star of facets and a point, by grain.

The star is the set of facets that an operation changes. A cone is the tetrahedron between a facet and the
point. The sum of a grain's cones over the old facets is the volume that the grain loses if all new facets
have the point as a corner. The sums give the position that keeps the volumes, and the drift, the change of
a grain's volume since the start.
"""

import numpy as np

from craftmesh.gradation.kernels.result_codes import is_held
from craftmesh.gradation.kernels.star import old_facet, star_patch
from craftmesh.jit import kernel, lean_kernel
from craftmesh.surface.kernels.facet_shape import area_vector

# Fraction of the matrix's trace that is added to its diagonal in the 3 x 3 system for a shift. The system
# then has a solution for facets in one plane too; there the shift is one percent too short.
DAMPING = 0.01


@lean_kernel
def _slot_row(slots, slot, count):
    for i in range(count):
        if slots[i] == slot:
            return i
    return count if count < len(slots) else -1


@lean_kernel
def _cone(points, facets, f, place):
    """Return the components of facet `f`'s area vector and the volume of its cone from `place` (3,)."""
    a = facets[f, 0]
    x, y, z = area_vector(points, a, facets[f, 1], facets[f, 2])
    height = x * (points[a, 0] - place[0]) + y * (points[a, 1] - place[1]) + z * (points[a, 2] - place[2])
    return 0.5 * x, 0.5 * y, 0.5 * z, height / 6.0


@lean_kernel
def _add_cone(points, facets, patch, sides, slots, areas, volumes, f, place, count):
    x, y, z, volume = _cone(points, facets, f, place)
    for k in range(2):
        slot = sides[patch, k]
        row = _slot_row(slots, slot, count) if slot >= 0 else -1
        if row < 0:
            continue
        turn = 1.0 if k == 0 else -1.0
        if row == count:
            slots[row] = slot
            volumes[row] = 0.0
            areas[row, 0] = 0.0
            areas[row, 1] = 0.0
            areas[row, 2] = 0.0
            count += 1
        volumes[row] += turn * volume
        areas[row, 0] += turn * x
        areas[row, 1] += turn * y
        areas[row, 2] += turn * z
    return count


@lean_kernel
def _cones_of_patch(state, star, place, patch):
    """Fill state.near_slot, near_area and near_volume like `grain_cones`, for a star within one patch."""
    x = y = z = volume = 0.0
    for i in range(star.moved + star.dying):
        u, v, w, more = _cone(state.points, state.facets, old_facet(state, star, i), place)
        x, y, z, volume = x + u, y + v, z + w, volume + more
    count = np.int64(0)
    for k in range(2):
        slot = state.patch_sides[patch, k]
        if slot >= 0:
            turn = 1.0 - 2.0 * k
            state.near_slot[count] = slot
            state.near_volume[count] = turn * volume
            state.near_area[count, 0] = turn * x
            state.near_area[count, 1] = turn * y
            state.near_area[count, 2] = turn * z
            count += 1
    return count


@lean_kernel
def grain_cones(state, star, place):
    """Fill state.near_slot, near_area and near_volume; return the number of rows.

    Each row has the sums, for one grain or void at the star, of the area vectors of the old facets (out of
    the grain) and of the volumes of their cones from `place`. Further grains are left out when the arrays
    are full.
    """
    points, facets, patch, sides = state.points, state.facets, state.patch, state.patch_sides
    slots, areas, volumes = state.near_slot, state.near_area, state.near_volume
    count = np.int64(0)
    one = star_patch(state, star)
    if one >= 0:
        return _cones_of_patch(state, star, place, one)
    for i in range(star.moved + star.dying):
        f = old_facet(state, star, i)
        count = _add_cone(points, facets, patch[f], sides, slots, areas, volumes, f, place, count)
    return count


@lean_kernel
def _solve(m, right, x):
    """Set `x` (3,) to the solution of the symmetric, definite 3 x 3 system."""
    c00 = m[1, 1] * m[2, 2] - m[1, 2] * m[2, 1]
    c01 = m[1, 2] * m[2, 0] - m[1, 0] * m[2, 2]
    c02 = m[1, 0] * m[2, 1] - m[1, 1] * m[2, 0]
    c11 = m[0, 0] * m[2, 2] - m[0, 2] * m[2, 0]
    c12 = m[0, 1] * m[2, 0] - m[0, 0] * m[2, 1]
    c22 = m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0]
    determinant = m[0, 0] * c00 + m[0, 1] * c01 + m[0, 2] * c02
    x[0] = (c00 * right[0] + c01 * right[1] + c02 * right[2]) / determinant
    x[1] = (c01 * right[0] + c11 * right[1] + c12 * right[2]) / determinant
    x[2] = (c02 * right[0] + c12 * right[1] + c22 * right[2]) / determinant


@kernel
def volume_shift(state, count, planes, shift):
    """Set `shift` (3,) to the smallest move of the cones' apex that keeps the grains' volumes best.

    count: number of rows from `grain_cones`. Coordinates that the bits of the box `planes` fix do not move;
    the rows' areas become 0 along them. On a line of three grains, the volumes determine the move across
    the line; inside a patch they determine only the part along the normal.
    """
    matrix = np.zeros((3, 3))
    right = np.zeros(3)
    for n in range(count):
        for i in range(3):
            if is_held(planes, i):
                state.near_area[n, i] = 0.0
        for i in range(3):
            right[i] += 3.0 * state.near_volume[n] * state.near_area[n, i]
            for j in range(3):
                matrix[i, j] += state.near_area[n, i] * state.near_area[n, j]
    trace = matrix[0, 0] + matrix[1, 1] + matrix[2, 2]
    shift[:] = 0.0
    if trace <= 0.0:
        return
    for i in range(3):
        matrix[i, i] += DAMPING * trace
    _solve(matrix, right, shift)


@kernel
def keep_volumes(state, star, planes, reach):
    """Move the star's tip, its new corner, by at most `reach`, so that grains keep their volumes.

    planes: bits of the box planes that the tip does not leave.
    """
    place = state.points[star.tip]
    shift = np.empty(3)
    volume_shift(state, grain_cones(state, star, place), planes, shift)
    length = np.sqrt(shift[0] ** 2 + shift[1] ** 2 + shift[2] ** 2)
    if length > reach:
        shift *= reach / length
    for k in range(3):
        place[k] += shift[k]


@lean_kernel
def drift_allows(state, count, cap):
    """Return whether the change in the first `count` rows keeps each grain's drift within its limit.

    Drift is the change of a grain's volume since the start; its limit is `cap` times the initial volume. A
    grain beyond the limit may still move back.
    """
    for n in range(count):
        slot = state.near_slot[n]
        after = abs(state.drift[slot] - state.near_volume[n])
        if after > cap * state.volume[slot] and after > abs(state.drift[slot]):
            return False
    return True


@lean_kernel
def book_drift(state, count):
    """Subtract the volumes in the first `count` rows from their grains' drifts, changes since the start."""
    for n in range(count):
        state.drift[state.near_slot[n]] -= state.near_volume[n]
