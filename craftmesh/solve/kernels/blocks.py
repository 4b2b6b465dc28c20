"""Products and sweeps with a symmetric matrix of 3 x 3 blocks, stored on and above the diagonal.

The matrix is L + D + U with L the transpose of U; `start`, `column` and `upper` are the rows of U, as in
`assembly`. Vectors are (n, 3).
"""

import numpy as np

from craftmesh.jit import lean_kernel


@lean_kernel
def multiply(start, column, upper, diagonal, x, out):
    """Fill `out` with (L + D + U) x and return x . out."""
    for i in range(len(x)):
        d = diagonal[i]
        for r in range(3):
            out[i, r] = d[r, 0] * x[i, 0] + d[r, 1] * x[i, 1] + d[r, 2] * x[i, 2]
    total = 0.0
    for i in range(len(x)):
        x0, x1, x2 = x[i, 0], x[i, 1], x[i, 2]
        a, b, c = out[i, 0], out[i, 1], out[i, 2]
        for place in range(start[i], start[i + 1]):
            u = upper[place]
            j = np.int64(column[place])
            y0, y1, y2 = x[j, 0], x[j, 1], x[j, 2]
            a += u[0, 0] * y0 + u[0, 1] * y1 + u[0, 2] * y2
            b += u[1, 0] * y0 + u[1, 1] * y1 + u[1, 2] * y2
            c += u[2, 0] * y0 + u[2, 1] * y1 + u[2, 2] * y2
            out[j, 0] += u[0, 0] * x0 + u[1, 0] * x1 + u[2, 0] * x2
            out[j, 1] += u[0, 1] * x0 + u[1, 1] * x1 + u[2, 1] * x2
            out[j, 2] += u[0, 2] * x0 + u[1, 2] * x1 + u[2, 2] * x2
        out[i, 0], out[i, 1], out[i, 2] = a, b, c
        total += x0 * a + x1 * b + x2 * c  # row i is complete: later rows do not add to it
    return total


@lean_kernel
def solve_lower(start, column, upper, inverse, right, out):
    """Fill `out` with x of (L + D) x = right; `right` is overwritten with D x. inverse (n, 3, 3): of D."""
    for i in range(len(right)):
        d = inverse[i]
        b0, b1, b2 = right[i, 0], right[i, 1], right[i, 2]
        x0 = d[0, 0] * b0 + d[0, 1] * b1 + d[0, 2] * b2
        x1 = d[1, 0] * b0 + d[1, 1] * b1 + d[1, 2] * b2
        x2 = d[2, 0] * b0 + d[2, 1] * b1 + d[2, 2] * b2
        out[i, 0], out[i, 1], out[i, 2] = x0, x1, x2
        for place in range(start[i], start[i + 1]):
            u = upper[place]
            j = np.int64(column[place])
            right[j, 0] -= u[0, 0] * x0 + u[1, 0] * x1 + u[2, 0] * x2
            right[j, 1] -= u[0, 1] * x0 + u[1, 1] * x1 + u[2, 1] * x2
            right[j, 2] -= u[0, 2] * x0 + u[1, 2] * x1 + u[2, 2] * x2


@lean_kernel
def negative_upper(start, column, upper, x, out):
    """Fill `out` with -U x, the residual of a right-hand side after `solve_lower`."""
    for i in range(len(x)):
        a, b, c = 0.0, 0.0, 0.0
        for place in range(start[i], start[i + 1]):
            u = upper[place]
            j = np.int64(column[place])
            y0, y1, y2 = x[j, 0], x[j, 1], x[j, 2]
            a -= u[0, 0] * y0 + u[0, 1] * y1 + u[0, 2] * y2
            b -= u[1, 0] * y0 + u[1, 1] * y1 + u[1, 2] * y2
            c -= u[2, 0] * y0 + u[2, 1] * y1 + u[2, 2] * y2
        out[i, 0], out[i, 1], out[i, 2] = a, b, c


@lean_kernel
def subtract_lower(start, column, upper, x, out):
    """Subtract L x from `out` (n, 3), in place; L, the lower part, is given by the rows of U."""
    for i in range(len(x)):
        x0, x1, x2 = x[i, 0], x[i, 1], x[i, 2]
        for place in range(start[i], start[i + 1]):
            u = upper[place]
            j = np.int64(column[place])
            out[j, 0] -= u[0, 0] * x0 + u[1, 0] * x1 + u[2, 0] * x2
            out[j, 1] -= u[0, 1] * x0 + u[1, 1] * x1 + u[2, 1] * x2
            out[j, 2] -= u[0, 2] * x0 + u[1, 2] * x1 + u[2, 2] * x2


@lean_kernel
def solve_upper(start, column, upper, inverse, right, out):
    """Fill `out` with x of (D + U) x = right. inverse (n, 3, 3): of D."""
    for i in range(len(right) - 1, -1, -1):
        a, b, c = right[i, 0], right[i, 1], right[i, 2]
        for place in range(start[i], start[i + 1]):
            u = upper[place]
            j = np.int64(column[place])
            y0, y1, y2 = out[j, 0], out[j, 1], out[j, 2]
            a -= u[0, 0] * y0 + u[0, 1] * y1 + u[0, 2] * y2
            b -= u[1, 0] * y0 + u[1, 1] * y1 + u[1, 2] * y2
            c -= u[2, 0] * y0 + u[2, 1] * y1 + u[2, 2] * y2
        d = inverse[i]
        out[i, 0] = d[0, 0] * a + d[0, 1] * b + d[0, 2] * c
        out[i, 1] = d[1, 0] * a + d[1, 1] * b + d[1, 2] * c
        out[i, 2] = d[2, 0] * a + d[2, 1] * b + d[2, 2] * c


@lean_kernel
def dot(x, y):
    """Return the sum of products of two arrays (n, 3), summed in one order on every machine."""
    total = 0.0
    for i in range(len(x)):
        total += x[i, 0] * y[i, 0] + x[i, 1] * y[i, 1] + x[i, 2] * y[i, 2]
    return total
