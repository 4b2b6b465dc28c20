"""The search for all pairs of intersecting triangles, through a grid of cells, layer by layer."""

from collections import namedtuple

import numpy as np

from craftmesh.jit import kernel, lean_kernel
from craftmesh.surface.kernels.bins import cell_along, grid_over
from craftmesh.surface.kernels.even_stars import even_stars
from craftmesh.surface.kernels.triangles import triangles_intersect

# The facets (k, 3) that reach into the present layer of grid cells; their bounds (k, 6), lower ones first;
# the first and last cells (k, 6) of these bounds; the facets' ids (k,); and a mask (k,) of the facets with
# which pairs are looked for.
Layer = namedtuple("Layer", "facets bounds cells ids chosen")
# Most cells of the grid: CELLS_PER_FACET per facet, plus MORE_CELLS.
CELLS_PER_FACET, MORE_CELLS = 8, 1000
# Cells grow by this factor until they are few enough.
WIDER = 1.25


@kernel
def _extents(points, facets):
    """Return the largest extent (m,) of each facet along an axis, and the bounding box of all facets."""
    extent, least, most = np.zeros(len(facets)), np.full(3, np.inf), np.full(3, -np.inf)
    for f in range(len(facets)):
        for k in range(3):
            a, b, c = points[facets[f, 0], k], points[facets[f, 1], k], points[facets[f, 2], k]
            low, high = min(a, b, c), max(a, b, c)
            extent[f] = max(extent[f], high - low)
            least[k] = min(least[k], low)
            most[k] = max(most[k], high)
    return extent, least, most


@kernel
def _by_layer(points, facets, grid):
    """Return facets (m,) sorted by first layer, the start of each layer, and the most facets in a layer."""
    layers = grid.shape[0]
    first, start, change = (
        np.empty(len(facets), np.int32),
        np.zeros(layers + 1, np.int64),
        np.zeros(layers + 1),
    )
    for f in range(len(facets)):
        a, b, c = points[facets[f, 0], 0], points[facets[f, 1], 0], points[facets[f, 2], 0]
        first[f] = cell_along(grid, min(a, b, c), 0)
        start[first[f] + 1] += 1
        change[first[f]] += 1
        change[cell_along(grid, max(a, b, c), 0) + 1] -= 1
    start = np.cumsum(start)
    order, end = np.empty(len(facets), np.int32), start.copy()
    for f in range(len(facets)):
        order[end[first[f]]] = f
        end[first[f]] += 1
    return order, start, int(np.cumsum(change).max())


@lean_kernel
def _share_even_star(facets, f, g, even):
    """Return whether facets f and g share a point in the mask `even` (n,) and so cannot intersect."""
    for i in range(3):
        v = facets[f, i]
        if even[v] and (facets[g, 0] == v or facets[g, 1] == v or facets[g, 2] == v):
            return True
    return False


@lean_kernel
def _set_box(points, facets, f, grid, bounds, cells, row):
    """Write the bounds of facet f, and its first and last cells, into a row of `bounds` and `cells`."""
    for k in range(3):
        a, b, c = points[facets[f, 0], k], points[facets[f, 1], k], points[facets[f, 2], k]
        bounds[row, k] = min(a, b, c)
        bounds[row, 3 + k] = max(a, b, c)
        cells[row, k] = cell_along(grid, bounds[row, k], k)
        cells[row, 3 + k] = cell_along(grid, bounds[row, 3 + k], k)


@kernel
def _near_chosen(points, facets, chosen, grid):
    """Return a mask (m,) of the chosen facets, and of facets that share a grid cell with one."""
    near, (nx, ny, nz) = chosen.copy(), grid.shape
    marked = np.zeros((nx, ny, nz), np.bool_)
    bounds, box = np.empty((1, 6)), np.empty((1, 6), np.int64)
    for marks in (True, False):
        for f in range(len(facets)):
            if chosen[f] != marks:
                continue
            _set_box(points, facets, f, grid, bounds, box, 0)
            for i in range(box[0, 0], box[0, 3] + 1):
                for j in range(box[0, 1], box[0, 4] + 1):
                    for k in range(box[0, 2], box[0, 5] + 1):
                        marked[i, j, k] |= marks
                        near[f] |= marked[i, j, k]
    return near


@lean_kernel
def _enter(points, facets, chosen, grid, layer, row):
    """Fill a row of the layer from the facet whose id stands in it."""
    f = layer.ids[row]
    layer.chosen[row] = chosen[f]
    for k in range(3):
        layer.facets[row, k] = facets[f, k]
    _set_box(points, facets, f, grid, layer.bounds, layer.cells, row)


@lean_kernel
def _next_layer(points, facets, chosen, grid, layer, count, i, entering):
    """Keep the rows of `layer` that reach layer i, add the facets `entering`, return the number of rows."""
    kept = 0
    for row in range(count):
        if layer.cells[row, 3] >= i:
            layer.ids[kept] = layer.ids[row]
            kept += 1
    for f in entering:
        layer.ids[kept] = f
        kept += 1
    for row in range(kept):
        _enter(points, facets, chosen, grid, layer, row)
    return kept


@lean_kernel
def _fill(cells, count, width, start):
    """Set start[c] to where the rows of cell c will end; return the number of entries in all cells.

    A row is a facet of the layer with its first and last cells; a layer is `width` cells wide.
    """
    start[:] = 0
    for row in range(count):
        for j in range(cells[row, 1], cells[row, 4] + 1):
            for k in range(cells[row, 2], cells[row, 5] + 1):
                start[j * width + k] += 1
    for cell in range(1, len(start)):
        start[cell] += start[cell - 1]
    return start[-1]


@lean_kernel
def _place(cells, count, width, start, items):
    """Put the rows into their cells in `items`, ascending; turn the cells' ends in `start` into starts."""
    for row in range(count - 1, -1, -1):
        for j in range(cells[row, 1], cells[row, 4] + 1):
            for k in range(cells[row, 2], cells[row, 5] + 1):
                start[j * width + k] -= 1
                items[start[j * width + k]] = row


@lean_kernel
def _bounds_meet_in_cell(layer, f, g, i, j, k):
    """Return whether the bounds of facets in rows f and g meet and their common part begins in this cell.

    Each pair is thus found in one cell only.
    """
    p, q, bounds = layer.cells[f], layer.cells[g], layer.bounds
    if max(p[0], q[0]) != i or max(p[1], q[1]) != j or max(p[2], q[2]) != k:
        return False
    return (
        bounds[f, 0] <= bounds[g, 3]
        and bounds[g, 0] <= bounds[f, 3]
        and bounds[f, 1] <= bounds[g, 4]
        and bounds[g, 1] <= bounds[f, 4]
        and bounds[f, 2] <= bounds[g, 5]
        and bounds[g, 2] <= bounds[f, 5]
    )


@lean_kernel
def _pairs_in_cell(points, layer, even, items, i, j, k, pairs, found):
    """Append the intersecting pairs whose common bounds begin in this cell; return how many there are."""
    facets, chosen = layer.facets, layer.chosen
    for x in range(len(items)):
        f = items[x]
        for y in range(x + 1, len(items)):
            g = items[y]
            if not (chosen[f] or chosen[g]) or not _bounds_meet_in_cell(layer, f, g, i, j, k):
                continue
            if not _share_even_star(facets, f, g, even) and triangles_intersect(
                points, facets[f, 0], facets[f, 1], facets[f, 2], facets[g, 0], facets[g, 1], facets[g, 2]
            ):
                if found == len(pairs):
                    return found
                pairs[found, 0] = min(layer.ids[f], layer.ids[g])
                pairs[found, 1] = max(layer.ids[f], layer.ids[g])
                found += 1
    return found


@kernel
def _search(points, facets, chosen, grid, limit):
    """Return the pairs (k, 2) of intersecting facets, unsorted; the search ends after `limit` pairs."""
    order, first, room = _by_layer(points, facets, grid)
    even = even_stars(points, facets)
    layer = Layer(
        np.empty((room, 3), np.int64),
        np.empty((room, 6)),
        np.empty((room, 6), np.int64),
        np.empty(room, np.int64),
        np.empty(room, np.bool_),
    )
    width, count, found = grid.shape[2], 0, 0
    start, items = np.empty(grid.shape[1] * width + 1, np.int64), np.empty(0, np.int64)
    pairs = np.empty((limit, 2), np.int64)
    for i in range(grid.shape[0]):
        entering = order[first[i] : first[i + 1]]
        count = _next_layer(points, facets, chosen, grid, layer, count, i, entering)
        total = _fill(layer.cells, count, width, start)
        if total > len(items):
            items = np.empty(2 * total, np.int64)
        _place(layer.cells, count, width, start, items)
        for cell in range(len(start) - 1):
            inside = items[start[cell] : start[cell + 1]]
            if len(inside) > 1:
                j, k = cell // width, cell % width
                found = _pairs_in_cell(points, layer, even, inside, i, j, k, pairs, found)
                if found == limit:
                    return pairs
    return pairs[:found].copy()


def intersecting_pairs(
    points: np.ndarray, facets: np.ndarray, limit: int = 100_000, chosen: np.ndarray | None = None
) -> np.ndarray:
    """Return the pairs (k, 2) int64 of `facets` (m, 3) that meet in more than their shared vertices.

    Touching counts as meeting (`triangles_intersect`). Pairs come sorted, lower facet first. The search
    ends after `limit` pairs. chosen (m,) bool: only pairs with one of these facets are looked for.
    """
    facets = np.require(facets, np.int32, ["C", "W"])
    points = np.require(points, np.float64, ["C", "W"])  # kernels would compile again for read-only arrays
    if len(facets) < 2:
        return np.zeros((0, 2), np.int64)
    extent, least, most = _extents(points, facets)
    width = max(float(np.median(extent)), float(extent.mean()) / 2, 1e-300)
    while np.prod(np.floor((most - least) / width) + 1) > CELLS_PER_FACET * len(facets) + MORE_CELLS:
        width *= WIDER
    grid, rows = grid_over(least, most, width), np.arange(len(facets))
    if chosen is not None:
        rows = np.flatnonzero(_near_chosen(points, facets, chosen, grid))
        facets = facets[rows]
    chosen = np.ones(len(facets), bool) if chosen is None else chosen[rows]
    pairs = rows[_search(points, facets, chosen, grid, int(limit))]
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
