"""Triangulated crack surfaces, as a file or a growth step may give them."""

import numpy as np


def wavy_disc(radius, amplitude, rings=8) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) and triangles (m, 3) of a disc about 0 whose height is a wave of the amplitude."""
    points, triangles, before = [[0.0, 0.0]], [], [0]
    for ring in range(1, rings + 1):
        angle = np.arange(6 * ring) * np.pi / (3 * ring)
        start = len(points)
        points += (radius * ring / rings * np.stack([np.cos(angle), np.sin(angle)], axis=1)).tolist()
        now = list(range(start, start + 6 * ring))
        i = j = 0
        while i < len(now) or (j < len(before) and ring > 1):
            outer = ring == 1 or (i + 0.5) / len(now) <= (j + 0.5) / len(before)
            a, b = now[i % len(now)], before[j % len(before)]
            if i < len(now) and (outer or j >= len(before)):
                triangles.append([a, now[(i + 1) % len(now)], b])
                i += 1
            else:
                triangles.append([b, a, before[(j + 1) % len(before)]])
                j += 1
        before = now
    uv = np.array(points)
    height = amplitude * np.sin(2 * uv[:, 0] / radius) * np.cos(1.5 * uv[:, 1] / radius)
    return np.column_stack([uv, height]), np.array(triangles)


def over_grid(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles of a sheet through places (n, k) of a grid."""
    ids = np.arange(z.size).reshape(z.shape)
    a, b, c, d = (v.ravel() for v in (ids[:-1, :-1], ids[1:, :-1], ids[1:, 1:], ids[:-1, 1:]))
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return np.stack([x, y, z], axis=-1).reshape(-1, 3), triangles


def bowl(centre, radius, opening, around=96, rings=40) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) and triangles (m, 3) of a sphere up to `opening` degrees from its lower pole."""
    polar = np.radians(opening) * (np.arange(rings) + 1) / rings
    turn = 2 * np.pi * np.arange(around) / around
    out = np.stack(
        [
            np.sin(polar)[:, None] * np.cos(turn),
            np.sin(polar)[:, None] * np.sin(turn),
            -np.cos(polar)[:, None] + 0 * turn,
        ],
        axis=-1,
    )
    points = np.asarray(centre) + radius * np.concatenate([[[0, 0, -1.0]], out.reshape(-1, 3)])
    j = np.arange(around)
    k = (j + 1) % around
    triangles = [np.column_stack([0 * j, 1 + k, 1 + j])]
    for ring in range(rings - 1):
        a, b = 1 + ring * around + j, 1 + ring * around + k
        triangles += [np.column_stack([a, b, a + around]), np.column_stack([b, b + around, a + around])]
    return points, np.concatenate(triangles)
