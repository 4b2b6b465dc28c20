"""Grouping of equal (low, key) rows in linear time: faces and edges of meshes with millions of cells."""

import numpy as np

from craftmesh.jit import kernel


@kernel
def group_rows(low, key, n_low):
    """Bring equal rows (low[i], key[i]) together: return `order` (k,) and group starts `first` (g + 1,).

    low (k,) int64 in 0..n_low - 1; key (k,) int64. Group j holds the rows order[first[j]:first[j + 1]],
    ascending; groups come sorted by low, then key.
    """
    end = np.zeros(n_low + 1, np.int64)
    for value in low:
        end[value + 1] += 1
    for bucket in range(n_low):
        end[bucket + 1] += end[bucket]
    order = np.empty(len(low), np.int64)
    for row in range(len(low)):
        order[end[low[row]]] = row
        end[low[row]] += 1
    first = np.empty(len(low) + 1, np.int64)
    groups = 0
    start = 0
    for bucket in range(n_low):
        _sort_by_key(order, key, start, end[bucket])
        for i in range(start, end[bucket]):
            if i == start or key[order[i]] != key[order[i - 1]]:
                first[groups] = i
                groups += 1
        start = end[bucket]
    first[groups] = len(low)
    return order, first[: groups + 1].copy()


@kernel
def _sort_by_key(order, key, start, end):
    """Sort order[start:end] by key, equal keys in their old order; buckets are short (some 20 rows)."""
    for i in range(start + 1, end):
        row = order[i]
        j = i - 1
        while j >= start and key[order[j]] > key[row]:
            order[j + 1] = order[j]
            j -= 1
        order[j + 1] = row
