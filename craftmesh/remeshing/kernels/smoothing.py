"""Laps of class-constrained smoothing."""

from craftmesh.jit import kernel


@kernel
def lap(points, start, neighbour, fixed, weight):
    """Return points (n, 3) moved by `weight` of the way to the mean of their neighbours, all at once.

    start (n + 1,), neighbour (k,): compressed rows; fixed (n, 3): coordinates that stay.
    """
    moved = points.copy()
    for v in range(len(points)):
        n = start[v + 1] - start[v]
        if n == 0:
            continue
        for axis in range(3):
            if fixed[v, axis]:
                continue
            total = 0.0
            for i in range(start[v], start[v + 1]):
                total += points[neighbour[i], axis]
            moved[v, axis] += weight * (total / n - points[v, axis])
    return moved
