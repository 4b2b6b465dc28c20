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

from craftmesh.gradation.kernels.star import old_facet, star_patch
from craftmesh.jit import lean_kernel
from craftmesh.surface.kernels.facet_shape import area_vector
from craftmesh.surface.kernels.hinges import SHARP_WEDGE

# The patch of a star and its unit normal; patch -1 where the star is no sheet.
Sheet = namedtuple("Sheet", "patch x y z")
# What the facets of a cell have in common, if neither of these: their patch, times the number of ways, and
# the way that they face.
EMPTY, MIXED = range(-2, 0)
# Ways (26, 3): unit vectors from the middle of a cube to its corners, edges and sides.
WAYS = np.array([way for way in np.ndindex(3, 3, 3) if way != (1, 1, 1)]) - 1.0
WAYS /= np.linalg.norm(WAYS, axis=1, keepdims=True)
# Degrees: largest turns of a cell's facets from their way, and of this way from a sheet, chosen by hand.
OF_CELL, OF_SHEET = 50.0, 38.0
# Squared cosines of the largest turns: of a cell's facets from its way, of this way from a sheet, and of
# old and new facets from their sheet. With the last one no two facets of a sheet enclose a sharp wedge.
CELL2, SHEET2, OLD2, NEW2 = (
    np.cos(np.radians([OF_CELL, OF_SHEET, OF_CELL + OF_SHEET, 180 - SHARP_WEDGE - OF_CELL - OF_SHEET])) ** 2
)


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
def _faces(x, y, z, u, v, w, cosine2):
    """Tell whether a vector (u, v, w) is within an angle of the unit vector (x, y, z)."""
    along = x * u + y * v + z * w
    return along > 0.0 and along * along >= cosine2 * (u * u + v * v + w * w)


@lean_kernel
def join(common, patch, x, y, z):
    """Return the code that a cell's facets have in common after one more facet is entered.

    common: the code before; patch and (x, y, z): patch and area vector of the new facet.
    """
    if common == EMPTY:
        way = 0
        for n in range(len(WAYS)):
            along = x * (WAYS[n, 0] - WAYS[way, 0]) + y * (WAYS[n, 1] - WAYS[way, 1])
            if along + z * (WAYS[n, 2] - WAYS[way, 2]) > 0.0:
                way = n
        return len(WAYS) * patch + way
    if common == MIXED or common // len(WAYS) != patch:
        return np.int64(MIXED)
    way = common % len(WAYS)
    alike = _faces(WAYS[way, 0], WAYS[way, 1], WAYS[way, 2], x, y, z, CELL2)
    return np.int64(common if alike else MIXED)


@lean_kernel
def goes_on(common, sheet):
    """Tell whether all facets of a cell are of the sheet's patch and face its way."""
    if common < 0 or common // len(WAYS) != sheet.patch:
        return False
    way = common % len(WAYS)
    return _faces(sheet.x, sheet.y, sheet.z, WAYS[way, 0], WAYS[way, 1], WAYS[way, 2], SHEET2)


@lean_kernel
def no_sheet():
    """Return the sheet of a star that is none."""
    return Sheet(np.int64(-1), 0.0, 0.0, 0.0)


@lean_kernel
def sheet_of(state, star):
    """Return the sheet that the star's old facets and its new ones (set_rows) lie in, if they do."""
    patch = star_patch(state, star)
    if patch < 0:
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
        u, v, w = state.star_normal[i]
        if not _faces(sheet.x, sheet.y, sheet.z, u, v, w, NEW2):
            return no_sheet()
    for i in range(star.moved + star.dying):
        if not _is_in(state, sheet, old_facet(state, star, i)):
            return no_sheet()
    return sheet


@lean_kernel
def _is_in(state, sheet, f):
    """Tell whether facet `f` is of the sheet's patch and faces its way."""
    if state.patch[f] != sheet.patch:
        return False
    x, y, z = area_vector(state.points, state.facets[f, 0], state.facets[f, 1], state.facets[f, 2])
    return _faces(sheet.x, sheet.y, sheet.z, x, y, z, OLD2)


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
