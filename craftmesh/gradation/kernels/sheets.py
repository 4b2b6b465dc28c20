"""Sheets: stars that lie in one patch and face one way, with nothing near them that faces another way.

Take a line that crosses two facets of one patch from behind to ahead. Between them it crosses a facet of
another patch, or one of this patch from ahead to behind, for different grains lie behind and ahead of a
patch. So in a convex part of space where all facets are of one patch and face one way, no such line crosses
two of them. A star that another one facing that way replaces there meets neither itself nor its patch.
Facets of other patches are left to test. One that does not meet the new star lies outside the space between
the old and the new star if it has a corner beyond that space.
"""

from collections import namedtuple

import numpy as np

from craftmesh.gradation.kernels.star import old_facet
from craftmesh.jit import lean_kernel
from craftmesh.surface.kernels.facet_shape import area_vector

# The patch of a star and its unit normal; patch -1 where the star is no sheet.
Sheet = namedtuple("Sheet", "patch x y z")
# What the facets of a cell have in common, if neither of these: their patch, times WAYS, and the way that
# they face, one of the directions from a cube's middle to its corners, edges and sides.
EMPTY, MIXED = -1, -2
WAYS = 27
# Least part of a normal along an axis that its way has too, squared: the way is then within 30 degrees.
PART2 = 0.33**2
# Squared cosines of the largest turns: of a cell's facets from their way (50 degrees), of this way from a
# sheet (38), of old facets (88) and of new ones (78) from their sheet. Facets of a sheet thus enclose no
# wedge under 12 degrees.
OF_CELL, OF_SHEET, OLD, NEW = np.cos(np.radians([50.0, 38.0, 88.0, 78.0])) ** 2


@lean_kernel
def set_rows(state, star):
    """Set the two corners after the tip of each of the star's new facets, and its unit normal."""
    corners, tip = state.star_corners, star.tip
    for i in range(star.moved):
        k = 0
        while corners[i, k] != tip:
            k += 1
        u = corners[i, (k + 1) % 3]
        v = corners[i, (k + 2) % 3]
        state.star_ends[i, 0] = u
        state.star_ends[i, 1] = v
        x, y, z = area_vector(state.points, tip, u, v)
        size = np.sqrt(x * x + y * y + z * z)
        scale = 1.0 / size if size > 0.0 else 0.0
        state.star_normal[i, 0] = x * scale
        state.star_normal[i, 1] = y * scale
        state.star_normal[i, 2] = z * scale


@lean_kernel
def _sign(x, least2):
    """Return 1 or -1 where the square of `x` is over a bound, else 0."""
    return 0 if x * x <= least2 else (1 if x > 0.0 else -1)


@lean_kernel
def _is_along(way, x, y, z, cosine2):
    """Tell whether a vector is within an angle of a way."""
    i = way // 9 - 1
    j = way // 3 % 3 - 1
    k = way % 3 - 1
    along = i * x + j * y + k * z
    return along > 0.0 and along * along >= cosine2 * (i * i + j * j + k * k) * (x * x + y * y + z * z)


@lean_kernel
def join(common, patch, x, y, z):
    """Return what the facets of a cell have in `common` with one more of a patch and an area vector."""
    if common == EMPTY:
        least2 = PART2 * (x * x + y * y + z * z)
        return WAYS * patch + 9 * _sign(x, least2) + 3 * _sign(y, least2) + _sign(z, least2) + WAYS // 2
    if common // WAYS == patch and _is_along(common % WAYS, x, y, z, OF_CELL):
        return common
    return np.int64(MIXED)


@lean_kernel
def goes_on(common, sheet):
    """Tell whether all facets of a cell are of the sheet's patch and face its way."""
    if sheet.patch < 0 or common // WAYS != sheet.patch:
        return False
    return _is_along(common % WAYS, sheet.x, sheet.y, sheet.z, OF_SHEET)


@lean_kernel
def no_sheet():
    """Return the sheet of a star that is none."""
    return Sheet(np.int64(-1), 0.0, 0.0, 0.0)


@lean_kernel
def sheet_of(state, star):
    """Return the sheet that the star's old facets and its new ones (set_rows) lie in, if they do."""
    patch = state.patch[state.star[0]]
    if state.patch_sides[patch, 0] == state.patch_sides[patch, 1]:
        return no_sheet()
    for i in range(star.moved + star.dying):
        if state.patch[old_facet(state, star, i)] != patch:
            return no_sheet()
    x = y = z = 0.0
    for i in range(star.moved):
        u, v, w = state.star_normal[i]
        x, y, z = x + u, y + v, z + w
    size = np.sqrt(x * x + y * y + z * z)
    if size == 0.0:
        return no_sheet()
    sheet = Sheet(patch, x / size, y / size, z / size)
    for i in range(star.moved):
        if not _faces(
            sheet, state.star_normal[i, 0], state.star_normal[i, 1], state.star_normal[i, 2], NEW
        ):
            return no_sheet()
    for i in range(star.moved + star.dying):
        if not _is_in(state, sheet, old_facet(state, star, i)):
            return no_sheet()
    return sheet


@lean_kernel
def _faces(sheet, x, y, z, cosine2):
    along = sheet.x * x + sheet.y * y + sheet.z * z
    return along > 0.0 and along * along >= cosine2 * (x * x + y * y + z * z)


@lean_kernel
def _is_in(state, sheet, f):
    """Tell whether facet `f` is of the sheet's patch and faces its way."""
    if state.patch[f] != sheet.patch:
        return False
    x, y, z = area_vector(state.points, state.facets[f, 0], state.facets[f, 1], state.facets[f, 2])
    return _faces(sheet, x, y, z, OLD)


@lean_kernel
def _height(points, sheet, v):
    return points[v, 0] * sheet.x + points[v, 1] * sheet.y + points[v, 2] * sheet.z


@lean_kernel
def keep_foreign(state, grid, star, sheet, near):
    """Keep of the grid's `near` candidates those of other patches that may meet the sheet's new facets.

    Returns their number, or -1 where the star is no sheet among them.
    """
    low, high = _heights(state, star, sheet)
    count = 0
    for n in range(near):
        f = grid.candidate[n]
        if _is_in(state, sheet, f):
            continue
        if state.patch[f] == sheet.patch:
            return -1
        below = 0
        above = 0
        for k in range(3):
            h = _height(state.points, sheet, state.facets[f, k])
            below += h < low
            above += h > high
        if below == 3 or above == 3 or low == high:  # in one plane the star fills the same places as before
            continue
        if below + above == 0:
            return -1
        grid.candidate[count] = f
        for k in range(6):
            grid.bounds[k, count] = grid.bounds[k, n]
        count += 1
    return count


@lean_kernel
def _heights(state, star, sheet):
    """Return the least and the largest height of the star's vertices along the sheet's normal."""
    low = high = _height(state.points, sheet, star.vertex)
    for v in (star.tip, star.gone if star.gone >= 0 else star.tip):
        h = _height(state.points, sheet, v)
        low, high = min(low, h), max(high, h)
    for i in range(star.moved):
        for k in range(2):
            h = _height(state.points, sheet, state.star_ends[i, k])
            low, high = min(low, h), max(high, h)
    return low, high
