"""Sheets: stars within one patch, where all facets of this patch nearby have similar normals.

A star is the set of facets that an operation changes. New facets of a sheet need fewer intersection tests:

Different grains lie behind and ahead of a patch. So a line that crosses two facets of one patch from behind
to ahead crosses, between them, a facet of another patch or of this patch from ahead to behind. Therefore,
in a convex region where all facets belong to one patch and have similar normals, no line along the normals
crosses two of them. If a new star with such normals replaces an old one there, it intersects neither itself
nor its patch. Only facets of other patches must be tested. A facet that does not meet the new star is
outside the space between old and new star if it has a corner outside this space.
"""

from collections import namedtuple

import numpy as np

from craftmesh.gradation.kernels.star import old_facet, star_patch
from craftmesh.jit import lean_kernel
from craftmesh.surface.kernels.facet_shape import area_vector
from craftmesh.surface.kernels.hinges import SHARP_WEDGE

# The patch of a star and its mean unit normal (x, y, z); the patch is -1 if the star is not a sheet.
Sheet = namedtuple("Sheet", "patch x y z")
# Codes of a cell without facets, and of a cell whose facets have different patches or directions. Another
# code is the facets' common patch times the number of directions, plus the row in WAYS of the common
# direction of their normals.
EMPTY, MIXED = range(-2, 0)
# Directions (26, 3): unit vectors from a cube's centre to its corners, edges and faces.
WAYS = np.array([way for way in np.ndindex(3, 3, 3) if way != (1, 1, 1)]) - 1.0
WAYS /= np.linalg.norm(WAYS, axis=1, keepdims=True)
# Degrees: largest angles between a cell's facets and their direction, and between this direction and a
# sheet's normal, chosen by hand.
OF_CELL, OF_SHEET = 50.0, 38.0
# Squared cosines of the largest angles: between a cell's facets and its direction, between this direction
# and a sheet's normal, and between the normals of old and of new facets and their sheet's normal. The last
# one ensures that no two facets of a sheet enclose a sharp dihedral angle.
CELL2, SHEET2, OLD2, NEW2 = (
    np.cos(np.radians([OF_CELL, OF_SHEET, OF_CELL + OF_SHEET, 180 - SHARP_WEDGE - OF_CELL - OF_SHEET])) ** 2
)


@lean_kernel
def set_rows(state, star):
    """Set state.star_ends and state.star_normal for the star's new facets.

    A row of star_ends has the two corners after the tip (the corner that all new facets share), a row of
    star_normal the facet's unit normal, 0 without area.
    """
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
    """Return whether the angle between (u, v, w) and the unit vector (x, y, z) is within the limit.

    cosine2: squared cosine of the limit.
    """
    along = x * u + y * v + z * w
    return along > 0.0 and along * along >= cosine2 * (u * u + v * v + w * w)


@lean_kernel
def join(common, patch, x, y, z):
    """Return the code of a grid cell's facets, for their patch and direction, after one more is entered.

    The code is 26 * patch + the row in WAYS of the direction nearest to the first facet's normal, or MIXED
    if a facet has another patch or direction. common: the code before, EMPTY for the first facet; patch and
    (x, y, z): patch and area vector of the new facet.
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
    """Return whether all facets of a grid cell have the sheet's patch and a direction near its normal.

    common: the cell's code, as from `join`.
    """
    if common < 0 or common // len(WAYS) != sheet.patch:
        return False
    way = common % len(WAYS)
    return _faces(sheet.x, sheet.y, sheet.z, WAYS[way, 0], WAYS[way, 1], WAYS[way, 2], SHEET2)


@lean_kernel
def no_sheet():
    """Return the Sheet of a star that is not a sheet, with patch -1."""
    return Sheet(np.int64(-1), 0.0, 0.0, 0.0)


@lean_kernel
def sheet_of(state, star):
    """Return the sheet of a star, or `no_sheet` if its facets differ too much in patch or normal.

    state.star_normal must have the normals of the new facets (set_rows); old facets are checked too.
    """
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
    """Return whether facet `f` is of the sheet's patch and has a similar normal."""
    if state.patch[f] != sheet.patch:
        return False
    x, y, z = area_vector(state.points, state.facets[f, 0], state.facets[f, 1], state.facets[f, 2])
    return _faces(sheet.x, sheet.y, sheet.z, x, y, z, OLD2)


@lean_kernel
def _height(points, sheet, v):
    return points[v, 0] * sheet.x + points[v, 1] * sheet.y + points[v, 2] * sheet.z


@lean_kernel
def keep_foreign(state, grid, star, sheet, near):
    """Keep the facets of other patches that may meet new facets, of the first `near` in grid.candidate.

    Return their number. Return -1 if the star is not a sheet: a candidate of its patch has another normal,
    or a candidate of another patch lies within the heights of the star.
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
        if below == 3 or above == 3 or low == high:  # a flat star covers the same region as before
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
    """Return the smallest and the largest height of the star's vertices along the sheet's normal."""
    low = high = _height(state.points, sheet, star.vertex)
    for v in (star.tip, star.gone if star.gone >= 0 else star.tip):
        h = _height(state.points, sheet, v)
        low, high = min(low, h), max(high, h)
    for i in range(star.moved):
        for k in range(2):
            h = _height(state.points, sheet, state.star_ends[i, k])
            low, high = min(low, h), max(high, h)
    return low, high
