"""Exchange of voxels between grains, one by one, without splitting a grain or making a new contact."""

import numpy as np

from craftmesh.jit import kernel

# Voxels, distance from an exchanged voxel within which its old grain must stay connected. With 3, handles
# made by shuffling are cut; with 1, a third of the noise on lath boundaries would stay.
CONNECTION_DISTANCE = 3


@kernel
def exchange(padded, strides, place, wanted, voxels, bounds, contacts, count, mark):
    """Give voxels their wanted grains, where allowed; return the number of voxels changed.

    padded (n,): grain of each voxel, < 0 if it has none, padded by at least CONNECTION_DISTANCE; strides
    (3,): of this array. place, wanted (k,): voxels and their wanted grains, in the order of trial. voxels
    (g,): number of voxels of each grain, updated here; bounds (g, 2): its limits. contacts: sorted keys
    (`contact_key` with `count`) of the pairs of labels that may touch. mark (n,) int32: scratch, zeros
    before and after.
    """
    done = 0
    for i in range(len(place)):
        v, new = place[i], wanted[i]
        old = padded[v]
        if old == new or voxels[old] <= bounds[old, 0] or voxels[new] >= bounds[new, 1]:
            continue
        if _may_take(padded, strides, v, new, contacts, count) and _holds(padded, strides, v, old, mark):
            padded[v] = new
            voxels[old] -= 1
            voxels[new] += 1
            done += 1
    return done


@kernel
def _may_take(padded, strides, v, new, contacts, count):
    """Return True if grain `new` touches voxel v, and may touch all labels that do."""
    touches = False
    for axis in range(3):
        for way in (-1, 1):
            other = padded[v + way * strides[axis]]
            if other == new:
                touches = True
            elif other != padded[v] and not _is_contact(new, other, contacts, count):
                return False
    return touches


@kernel
def contact_key(low, high, count):
    """Return one integer for a pair of labels, both between -count and count; also for arrays."""
    return (low + count) * 2 * count + high + count


@kernel
def _is_contact(a, b, contacts, count):
    key = contact_key(min(a, b), max(a, b), count)
    at = np.searchsorted(contacts, key)
    return at < len(contacts) and contacts[at] == key


@kernel
def _holds(padded, strides, v, old, mark):
    """Return True if the face neighbours of v in grain `old` are connected within CONNECTION_DISTANCE
    without v."""
    beside = np.empty(6, np.int64)
    found = 0
    for axis in range(3):
        for way in (-1, 1):
            u = v + way * strides[axis]
            if padded[u] == old:
                beside[found] = u
                found += 1
    if found < 2:
        return True
    return _connected(padded, strides, v, old, beside[:found], 1, mark) or _connected(
        padded, strides, v, old, beside[:found], CONNECTION_DISTANCE, mark
    )


@kernel
def _connected(padded, strides, v, old, beside, reach, mark):
    """Return True if paths in grain `old`, within `reach` of v along each axis, connect all of `beside`.

    `beside` (k,): face neighbours of v in the grain; mark (n,) int32: scratch, zeros before and after.
    """
    width = 2 * reach + 1
    queue = np.empty((width**3, 4), np.int64)
    queue[0, 0] = beside[0]
    for axis in range(3):
        queue[0, 1 + axis] = 0
    for axis in range(3):
        for way in (-1, 1):
            if v + way * strides[axis] == beside[0]:
                queue[0, 1 + axis] = way
    mark[v] = 1
    mark[beside[0]] = 1
    head, tail, met = 0, 1, 1
    while head < tail and met < len(beside):
        for axis in range(3):
            for way in (-1, 1):
                at = queue[head, 1 + axis] + way
                u = queue[head, 0] + way * strides[axis]
                if abs(at) > reach or padded[u] != old or mark[u]:
                    continue
                mark[u] = 1
                queue[tail] = queue[head]
                queue[tail, 0] = u
                queue[tail, 1 + axis] = at
                tail += 1
                if abs(queue[tail - 1, 1]) + abs(queue[tail - 1, 2]) + abs(queue[tail - 1, 3]) == 1:
                    met += 1
        head += 1
    mark[v] = 0
    for i in range(tail):
        mark[queue[i, 0]] = 0
    return met == len(beside)
