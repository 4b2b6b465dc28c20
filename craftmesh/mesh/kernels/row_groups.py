"""Grouping of equal (low, key) rows in linear time: faces and edges of meshes with millions of cells."""

import numpy as np

from craftmesh.jit import kernel, lean_kernel


@kernel
def group_rows(low, key, n_low):
    """Bring equal rows (low[i], key[i]) together: return `order` (k,) and group starts `first` (g + 1,).

    low (k,) int64 in 0..n_low - 1; key (k,) int64. Group j holds the rows order[first[j]:first[j + 1]],
    ascending; groups come sorted by low, then key.
    """
    end = np.zeros(n_low + 1, np.int64)
    for value in low:
        end[value + 1] += 1
    order, keys = np.empty(len(low), np.int64), np.empty(len(low), np.int64)
    _to_starts(end)
    for row in range(len(low)):
        _enter(order, keys, end, low[row], row, key[row])
    return _grouped(order, keys, end)


@kernel
def group_faces(tets, faces, triples, n_points):
    """Group the faces of tets (m, 4) and the triples (k, 3) by corners; return `order` and `first`.

    Results as in `group_rows`. Row 4 * t + f is the face of tet t with the corners faces[f], faces (4, 3);
    row 4 * m + i is triple i. Corners are below n_points. Groups come sorted by their lowest corner.
    """
    end = np.zeros(n_points + 1, np.int64)
    count = 4 * len(tets)
    for row in range(count + len(triples)):
        low, _ = _face_key(tets, faces, triples, row, count, n_points)
        end[low + 1] += 1
    _to_starts(end)
    order = np.empty(count + len(triples), np.int64)
    keys = np.empty(len(order), np.int64)
    for row in range(len(order)):
        low, key = _face_key(tets, faces, triples, row, count, n_points)
        _enter(order, keys, end, low, row, key)
    return _grouped(order, keys, end)


@lean_kernel
def _face_key(tets, faces, triples, row, count, n_points):
    """Return the lowest corner of a row, and a key of the other two."""
    if row < count:
        t, f = row >> 2, row & 3
        a, b, c = tets[t, faces[f, 0]], tets[t, faces[f, 1]], tets[t, faces[f, 2]]
    else:
        a, b, c = triples[row - count, 0], triples[row - count, 1], triples[row - count, 2]
    low, high = min(a, b, c), max(a, b, c)
    return low, (a + b + c - low - high) * n_points + high


@lean_kernel
def _to_starts(end):
    """Turn row counts, entry b + 1 for bucket b, into starts, entry b for bucket b; in place."""
    for bucket in range(len(end) - 1):
        end[bucket + 1] += end[bucket]


@lean_kernel
def _enter(order, keys, end, bucket, row, key):
    order[end[bucket]], keys[end[bucket]] = row, key
    end[bucket] += 1


@kernel
def _grouped(order, keys, end):
    """Sort the buckets, which end at `end`, by keys; return the rows' order and the groups' starts."""
    first = np.empty(len(order) + 1, np.int64)
    groups = start = 0
    for bucket in range(len(end) - 1):
        _sort_by_key(order, keys, start, end[bucket])
        for i in range(start, end[bucket]):
            if i == start or keys[i] != keys[i - 1]:
                first[groups] = i
                groups += 1
        start = end[bucket]
    first[groups] = len(order)
    return order, first[: groups + 1].copy()


@lean_kernel
def _sort_by_key(order, keys, start, end):
    """Sort order[start:end] and keys[start:end] by key, stably, by insertion: about 20 rows."""
    for i in range(start + 1, end):
        row, key = order[i], keys[i]
        j = i - 1
        while j >= start and keys[j] > key:
            order[j + 1], keys[j + 1] = order[j], keys[j]
            j -= 1
        order[j + 1], keys[j + 1] = row, key
