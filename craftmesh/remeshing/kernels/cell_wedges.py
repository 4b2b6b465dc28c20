"""Cell points at which a grain would touch itself: the grain's smallest wedge gets a point of its own.

The segments around a cell point form the link of the point. A wedge is a part of a grain at the point; the
segments that bound a wedge form a cycle. A grain with two wedges would touch itself at the point.
"""

from craftmesh.jit import kernel, lean_kernel
from craftmesh.remeshing.kernels.cell_faces import add_segment

OUTSIDE_LABELS = 6
_MANY = 1000


@lean_kernel
def _bounds_grain(segment, grain):
    """Return whether `grain` is a label of the segment."""
    return segment[2] == grain or segment[3] == grain


@lean_kernel
def _walk_wedge(link, size, grain, start, used, ring, across):
    """Follow one cycle of the link with `grain` on the right, from segment `start`; return its length.

    The segment from ring[i] to ring[i + 1] has the label across[i] on its left. Visited segments become
    True in `used`.
    """
    n, segment = 0, start
    while segment >= 0 and not used[segment]:
        used[segment] = True
        tail, head, right, left = link[segment]
        ring[n], across[n], end = (tail, left, head) if right == grain else (head, right, tail)
        n += 1
        segment = -1
        for s in range(size):
            if not used[s] and (
                (link[s, 2] == grain and link[s, 0] == end) or (link[s, 3] == grain and link[s, 1] == end)
            ):
                segment = s
                break
    return n


@lean_kernel
def _is_simple_wedge(across, n):
    """Return whether the wedge has two or more neighbour labels, each on one run of the cycle."""
    runs = 0
    for i in range(n):
        if across[i] == across[i - 1 if i else n - 1]:
            continue
        runs += 1
        for k in range(n):
            if k != i and across[k] == across[i] and across[k] != across[k - 1 if k else n - 1]:
                return False
    return runs > 0


@kernel
def _smallest_wedge(link, size, grain, used, ring, across):
    """Return the number of a grain's wedges, and length and first segment of its shortest simple wedge.

    A wedge is simple if each neighbour label lies on one run of its cycle (`_is_simple_wedge`); length:
    number of segments in the cycle. Without a simple wedge, length and first segment are _MANY and -1.
    """
    used[:size] = False
    wedges, shortest, start = 0, _MANY, -1
    for s in range(size):
        if not used[s] and _bounds_grain(link[s], grain):
            n = _walk_wedge(link, size, grain, s, used, ring, across)
            wedges += 1
            if n < shortest and _is_simple_wedge(across, n):
                shortest, start = n, s
    return wedges, shortest, start


@lean_kernel
def _wedge_to_cut(link, size, used, ring, across):
    """Return a grain with several wedges, and the first segment of its shortest simple wedge; or -1, -1.

    Of several such grains, the grain with the shortest simple wedge is returned. Simple, and the length of
    a wedge: see `_smallest_wedge`.
    """
    best, best_grain, best_start = _MANY, -1, -1
    for first in range(size):
        for column in (2, 3):
            grain = link[first, column]
            if grain < OUTSIDE_LABELS:
                continue
            seen = False
            for s in range(first):
                seen |= _bounds_grain(link[s], grain)
            if seen:
                continue
            wedges, shortest, start = _smallest_wedge(link, size, grain, used, ring, across)
            if wedges > 1 and shortest < best:
                best, best_grain, best_start = shortest, grain, start
    return best_grain, best_start


@kernel
def _place_wedge_point(at, new, apex, ring, across, n):
    """Put point `new` halfway from the cell point `apex` to the middle of a wedge with the cycle ring (n,).

    across (n,): labels next to it. If one is a box plane, `new` keeps the cell point's coordinate normal to
    that plane.
    """
    at[new] = 0.0
    for i in range(n):
        at[new] += at[ring[i]] / n
    at[new] = 0.5 * (at[new] + at[apex])
    for i in range(n):
        if across[i] < OUTSIDE_LABELS:
            axis = across[i] // 2
            at[new, axis] = at[apex, axis]


@lean_kernel
def add_facet(sheets, count, segment, point):
    """Append the facet from a segment to a cell point; return the new count of facets."""
    row = sheets[count]
    row[0], row[1], row[2], row[3], row[4] = segment[0], segment[1], point, segment[2], segment[3]
    return count + 1


@kernel
def cut_tied_wedge(link, size, apex, new, at, sheets, count, scratch):
    """Let one wedge of a grain with several end at the point `new` instead of `apex`, and place `new`.

    The wedge has the fewest segments (`_wedge_to_cut`). Its facets, from its segments to `new`, are
    appended to the facets `sheets`, and `link` loses these segments. Where the wedge's neighbour label
    changes, `link` gets a segment to `new`, so that it stays the link of `apex`. Return whether there was
    such a wedge, the link's size and the number of facets.
    """
    used, ring, across = scratch.used, scratch.ring, scratch.across
    grain, start = _wedge_to_cut(link, size, used, ring, across)
    if start < 0:
        return False, size, count
    used[:size] = False
    n = _walk_wedge(link, size, grain, start, used, ring, across)
    _place_wedge_point(at, new, apex, ring, across, n)
    kept = 0
    for s in range(size):
        if used[s]:
            count = add_facet(sheets, count, link[s], new)
        else:
            for column in range(4):
                link[kept, column] = link[s, column]
            kept += 1
    for i in range(n):
        before = across[i - 1 if i else n - 1]
        if before != across[i]:
            kept = add_segment(link, kept, ring[i], new, before, across[i])
    return True, kept, count


@lean_kernel
def cone(link, size, apex, sheets, count):
    """Append a facet from each segment of the link to the cell point; return the new count of facets."""
    for s in range(size):
        count = add_facet(sheets, count, link[s], apex)
    return count


@kernel
def middle_of(link, size, at, apex):
    """Put the cell point `apex` at the mean of the midpoints of its link's segments."""
    at[apex] = 0.0
    for s in range(size):
        at[apex] += 0.5 * (at[link[s, 0]] + at[link[s, 1]]) / size
