"""Boundaries of grains: equal points, edges where a boundary is open, and its shells."""

import numpy as np

from craftmesh.jit import kernel, lean_kernel
from craftmesh.surface.kernels.facet_shape import squared_distance
from craftmesh.surface.kernels.union_find import root_of


@lean_kernel
def _slot(bits, row, mask):
    """Return the slot, 0 to mask, of bits[row] (3,) in a hash table; mask + 1 must be a power of two."""
    key = bits[row, 0] * np.uint64(0x9E3779B97F4A7C15)
    key ^= (bits[row, 1] * np.uint64(0xC2B2AE3D27D4EB4F)) >> np.uint64(7)
    key ^= bits[row, 2] * np.uint64(0x165667B19E3779F9)
    key ^= key >> np.uint64(29)
    return np.int64((key * np.uint64(0xBF58476D1CE4E5B9)) >> np.uint64(32)) & mask


@kernel
def lowest_equal_rows(bits):
    """Return for each row of bits (n, 3) uint64 the lowest row (n,) that equals it, maybe itself."""
    size = 16
    while size < 2 * len(bits):
        size *= 2
    table = np.full(size, -1, np.int64)
    lowest = np.empty(len(bits), np.int64)
    for row in range(len(bits)):
        slot = _slot(bits, row, size - 1)
        other = table[slot]
        while other >= 0 and not (
            bits[other, 0] == bits[row, 0]
            and bits[other, 1] == bits[row, 1]
            and bits[other, 2] == bits[row, 2]
        ):
            slot = (slot + 1) & (size - 1)
            other = table[slot]
        if other < 0:
            table[slot] = other = row
        lowest[row] = other
    return lowest


@kernel
def close_pairs(points, reach, width):
    """Return the pairs (k, 2) of points (n, 3) at most `reach` apart, the lower id last; some come twice.

    Points are found by a hash of their cell. width: of the cells, at least twice the reach (not checked).
    """
    pairs, found = np.empty((64, 2), np.int64), 0
    size = 16
    while size < 2 * len(points):
        size *= 2
    newest, before = np.full(size, -1, np.int64), np.empty(len(points), np.int64)
    low, high, cell = np.empty(3, np.int64), np.empty(3, np.int64), np.empty((1, 3), np.uint64)
    for p in range(len(points)):
        for k in range(3):
            low[k] = np.floor((points[p, k] - reach) / width)
            high[k] = np.floor((points[p, k] + reach) / width)
        for side in range(8):
            is_new = True
            for k in range(3):
                is_upper = side >> k & 1 == 1
                is_new = is_new and not (is_upper and low[k] == high[k])
                cell[0, k] = np.uint64(high[k] if is_upper else low[k])
            if not is_new:
                continue
            other = newest[_slot(cell, 0, size - 1)]
            while other >= 0:
                if squared_distance(points, p, other) <= reach * reach:
                    if found == len(pairs):
                        pairs = np.concatenate((pairs, np.empty_like(pairs)))
                    pairs[found, 0] = p
                    pairs[found, 1] = other
                    found += 1
                other = before[other]
        for k in range(3):
            cell[0, k] = np.uint64(np.int64(np.floor(points[p, k] / width)))
        slot = _slot(cell, 0, size - 1)
        before[p] = newest[slot]
        newest[slot] = p
    return pairs[:found].copy()


@kernel
def unbalanced_edges(facets, sides, first, after):
    """Return rows (k, 3) of edges where a label's boundary is not closed: label, lower and higher point.

    sides (m, 2) int32: labels behind and ahead of each facet, as in `open_edges`; first, after: corner
    lists of the facets.
    """
    found, n = np.empty((64, 3), np.int64), 0
    tally = np.empty((64, 3), np.int64)  # label, higher point, balance
    for low in range(len(first)):
        count = 0
        corner = first[low]
        while corner >= 0:
            f, k = corner // 3, corner % 3
            ahead, behind = facets[f, (k + 1) % 3], facets[f, (k + 2) % 3]
            if sides[f, 0] != sides[f, 1]:
                if count + 4 > len(tally):
                    tally = np.concatenate((tally, np.empty_like(tally)))
                for side in range(2):
                    way = 1 - 2 * side
                    if sides[f, side] != 0 and ahead >= low:
                        count = _tallied(tally, count, sides[f, side], ahead, way)
                    if sides[f, side] != 0 and behind > low:
                        count = _tallied(tally, count, sides[f, side], behind, -way)
            corner = after[corner]
        for row in range(count):
            if tally[row, 2] != 0:
                if n == len(found):
                    found = np.concatenate((found, np.empty_like(found)))
                found[n, 0] = tally[row, 0]
                found[n, 1] = low
                found[n, 2] = tally[row, 1]
                n += 1
    return found[:n].copy()


@lean_kernel
def _tallied(tally, count, label, high, way):
    """Add `way`, +1 or -1, to the balance of a label's edge to point `high`; return the number of rows.

    A row of `tally` is label, point, balance; `count` rows are in use, and one is added for a new edge.
    """
    for row in range(count):
        if tally[row, 0] == label and tally[row, 1] == high:
            tally[row, 2] += way
            return count
    tally[count, 0] = label
    tally[count, 1] = high
    tally[count, 2] = way
    return count + 1


@kernel
def outer_shells(facets, start, swept, points):
    """Return the number (g,) of shells of each grain that enclose a volume above 0.

    start (g + 1,): grain i has the facets start[i] to start[i + 1]; swept (m,): their signed volumes;
    points: number of points. A shell is a set of facets connected at points.
    """
    count = np.zeros(len(start) - 1, np.int64)
    parent, volume = np.empty(points, np.int64), np.zeros(points)
    for grain in range(len(count)):
        rows = range(start[grain], start[grain + 1])
        for f in rows:
            for k in range(3):
                parent[facets[f, k]] = facets[f, k]
        for f in rows:
            for k in range(1, 3):
                parent[root_of(parent, facets[f, k])] = root_of(parent, facets[f, 0])
        for f in rows:
            volume[root_of(parent, facets[f, 0])] += swept[f]
        for f in rows:
            root = root_of(parent, facets[f, 0])
            count[grain] += volume[root] > 0
            volume[root] = 0.0
    return count
