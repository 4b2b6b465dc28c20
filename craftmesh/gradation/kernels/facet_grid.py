"""A grid of facet lists that stays valid while facets change, for intersection tests inside kernels.

An item is one entry of a facet in the list of a cell. Facets that have moved or are dead leave items
behind; queries unlink the items of dead facets.
"""

from collections import namedtuple

import numpy as np

from craftmesh.gradation.kernels.sheets import EMPTY, goes_on, join
from craftmesh.jit import lean_kernel
from craftmesh.surface.kernels.facet_shape import area_vector

# origin (3,), inverse cell size (1,), cells per axis (3,); first item of each cell, -1 for none; code of
# the common patch and direction of each cell's facets (sheets.join); facet and next item of each item;
# number of items used (1,); for each facet (6,) the lowest and highest cell per axis that it was last
# entered in; candidates of the last query, and their bounds in columns (6, c); mask of candidates that meet
# the box of the last `list_hits`, and these facets.
FacetGrid = namedtuple(
    "FacetGrid", "origin scale dims first common facet after used covered candidate bounds met hits"
)
# Number of items that no operation exceeds; if fewer are free, the grid is rebuilt.
ROOM_PER_STEP = 60000
# Most cells; cells are enlarged until there are no more.
MOST_CELLS = 6_000_000
# Most facets that one query may find; an operation with more nearby is refused (`intersection`).
MOST_CANDIDATES = 16384
# Stamp of removed facets.
GONE = 2**62


def make_grid(low: np.ndarray, high: np.ndarray, cell: float, items: int, facets: int) -> FacetGrid:
    """Return an empty grid around the box from `low` to `high` (3,), with room for `items` and `facets`.

    The cells are `cell` wide, or wider if there would be more than MOST_CELLS.
    """
    low, high = low - cell, high + cell
    while np.prod(np.ceil((high - low) / cell)) > MOST_CELLS:
        cell *= 1.25
    dims = np.ceil((high - low) / cell).astype(np.int64) + 1
    return FacetGrid(
        low,
        np.array([1.0 / cell]),
        dims,
        np.full(int(dims.prod()), -1, np.int32),
        np.full(int(dims.prod()), EMPTY, np.int32),
        np.empty(items, np.int32),
        np.empty(items, np.int32),
        np.zeros(1, np.int64),
        np.empty((facets, 6), np.int32),
        np.empty(MOST_CANDIDATES, np.int64),
        np.empty((6, MOST_CANDIDATES)),
        np.empty(MOST_CANDIDATES, np.int8),
        np.empty(MOST_CANDIDATES, np.int64),
    )


@lean_kernel
def has_room(grid):
    """Return whether ROOM_PER_STEP items, entries of the cells' lists, are free for one more operation."""
    return grid.used[0] + ROOM_PER_STEP < len(grid.facet)


@lean_kernel
def _cell(x, axis, origin, scale, dims):
    return max(0, min(dims[axis] - 1, np.int64((x - origin[axis]) * scale[0])))


@lean_kernel
def insert_facet(grid, points, f, a, b, c, patch):
    """Enter facet `f` with corners (a, b, c) into the cells that its box meets; return False if full.

    patch: the facet's patch. Cells that the facet was in before its last change keep their items.
    """
    x, y, z = area_vector(points, a, b, c)
    origin, scale, dims, covered = grid.origin, grid.scale, grid.dims, grid.covered
    first, after, item_facet = grid.first, grid.after, grid.facet
    i0 = _cell(min(points[a, 0], points[b, 0], points[c, 0]), 0, origin, scale, dims)
    i1 = _cell(max(points[a, 0], points[b, 0], points[c, 0]), 0, origin, scale, dims)
    j0 = _cell(min(points[a, 1], points[b, 1], points[c, 1]), 1, origin, scale, dims)
    j1 = _cell(max(points[a, 1], points[b, 1], points[c, 1]), 1, origin, scale, dims)
    k0 = _cell(min(points[a, 2], points[b, 2], points[c, 2]), 2, origin, scale, dims)
    k1 = _cell(max(points[a, 2], points[b, 2], points[c, 2]), 2, origin, scale, dims)
    item = grid.used[0]
    for i in range(i0, i1 + 1):
        for j in range(j0, j1 + 1):
            inside = covered[f, 0] <= i <= covered[f, 1] and covered[f, 2] <= j <= covered[f, 3]
            for k in range(k0, k1 + 1):
                cell = (i * dims[1] + j) * dims[2] + k
                grid.common[cell] = join(grid.common[cell], patch, x, y, z)
                if inside and covered[f, 4] <= k <= covered[f, 5]:
                    continue
                if item >= len(item_facet):
                    return False
                item_facet[item] = f
                after[item] = first[cell]
                first[cell] = item
                item += 1
    grid.used[0] = item
    covered[f, 0] = i0
    covered[f, 1] = i1
    covered[f, 2] = j0
    covered[f, 3] = j1
    covered[f, 4] = k0
    covered[f, 5] = k1
    return True


@lean_kernel
def fill_grid(grid, points, facets, patch, alive, facet_count):
    """Empty the grid and enter all living facets; return False if the item lists are too short."""
    grid.first[:] = -1
    grid.common[:] = EMPTY
    grid.used[0] = 0
    grid.covered[:] = -1
    for f in range(facet_count):
        if alive[f]:
            a, b, c = facets[f, 0], facets[f, 1], facets[f, 2]
            if not insert_facet(grid, points, f, a, b, c, patch[f]):
                return False
    return True


@lean_kernel
def _set_bounds(points, facets, f, low, high, bounds, n):
    """Set column `n` of `bounds` to the bounds of facet `f`; return whether they meet the box.

    low, high: the box. The loop has no branch, which is faster.
    """
    a = facets[f, 0]
    b = facets[f, 1]
    c = facets[f, 2]
    meets = True
    for axis in range(3):
        p = points[a, axis]
        q = points[b, axis]
        r = points[c, axis]
        least = min(p, q, r)
        most = max(p, q, r)
        meets &= (least <= high[axis]) & (most >= low[axis])
        bounds[2 * axis, n] = least
        bounds[2 * axis + 1, n] = most
    return meets


@lean_kernel
def gather_candidates(grid, points, facets, alive, facet_stamp, mark, sheet, low, high):
    """List in grid.candidate the facets whose bounds meet the box from `low` to `high`.

    Return their number, -1 if too many. Cells whose facets all continue `sheet` (same patch and similar
    normals as the star) are skipped. Facets with facet_stamp >= `mark` are skipped too, which includes
    removed facets (GONE); all other facets of the visited cells get facet_stamp = mark.
    """
    origin, scale, dims = grid.origin, grid.scale, grid.dims
    first, after, item_facet = grid.first, grid.after, grid.facet
    candidate, bounds = grid.candidate, grid.bounds
    i0 = _cell(low[0], 0, origin, scale, dims)
    i1 = _cell(high[0], 0, origin, scale, dims)
    j0 = _cell(low[1], 1, origin, scale, dims)
    j1 = _cell(high[1], 1, origin, scale, dims)
    k0 = _cell(low[2], 2, origin, scale, dims)
    k1 = _cell(high[2], 2, origin, scale, dims)
    count = 0
    for i in range(i0, i1 + 1):
        for j in range(j0, j1 + 1):
            for k in range(k0, k1 + 1):
                cell = (i * dims[1] + j) * dims[2] + k
                if grid.common[cell] == EMPTY or goes_on(grid.common[cell], sheet):
                    continue
                last = -1
                item = np.int64(first[cell])
                while item >= 0:
                    f = np.int64(item_facet[item])
                    following = np.int64(after[item])
                    if facet_stamp[f] < mark:
                        last = item
                        facet_stamp[f] = mark
                        candidate[count] = f
                        count += _set_bounds(points, facets, f, low, high, bounds, count)
                        if count >= len(candidate):
                            return -1
                    elif alive[f]:
                        last = item
                    elif last < 0:
                        first[cell] = following
                    else:
                        after[last] = following
                    item = following
    return count


@lean_kernel
def list_hits(grid, near, points, a, b, c):
    """Write to grid.hits the ids of the first `near` candidates whose bounds meet the bounds of (a, b, c).

    a, b, c: corners of a facet. Return the number of hits. The loops have no branch, which is faster.
    """
    candidate, bounds, met, hits = grid.candidate, grid.bounds, grid.met, grid.hits
    x0 = min(points[a, 0], points[b, 0], points[c, 0])
    x1 = max(points[a, 0], points[b, 0], points[c, 0])
    y0 = min(points[a, 1], points[b, 1], points[c, 1])
    y1 = max(points[a, 1], points[b, 1], points[c, 1])
    z0 = min(points[a, 2], points[b, 2], points[c, 2])
    z1 = max(points[a, 2], points[b, 2], points[c, 2])
    for n in range(near):
        along_x = (bounds[0, n] <= x1) & (bounds[1, n] >= x0)
        along_y = (bounds[2, n] <= y1) & (bounds[3, n] >= y0)
        met[n] = along_x & along_y & (bounds[4, n] <= z1) & (bounds[5, n] >= z0)
    count = 0
    for n in range(near):
        hits[count] = candidate[n]
        count += met[n]
    return count
