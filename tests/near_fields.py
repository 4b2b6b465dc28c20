"""Exact displacements round cracks, written out: Williams' fields, Stroh's by eigenvectors, a penny's."""

import numpy as np

YOUNG, POISSON = 70.0, 0.3
SHEAR = YOUNG / (2 * (1 + POISSON))


def polar(points):
    """r and theta about the front x = 0, z = 0 of a crack behind it; lips' thetas need their side."""
    return np.hypot(points[:, 0], points[:, 2]), np.arctan2(points[:, 2], points[:, 0])


def williams(r, theta, mode):
    """Displacements (n, 3) along binormal, normal and tangent for unit K of mode 1, 2 or 3."""
    scale, k = np.sqrt(r / (2 * np.pi)) / (2 * SHEAR), 3 - 4 * POISSON
    cos, sin, turn = np.cos(theta / 2), np.sin(theta / 2), np.cos(theta)
    rows = {
        1: (cos * (k - turn), sin * (k - turn), 0 * r),
        2: (sin * (k + 2 + turn), -cos * (k - 2 + turn), 0 * r),
        3: (0 * r, 0 * r, 4 * sin),
    }[mode]
    return scale[:, None] * np.stack(rows, axis=1)


def stroh(tensor, r, theta, mode):
    """The same in a crystal of stiffness (3, 3, 3, 3), from the eigenvectors of Stroh's matrix."""
    q, rr, t = tensor[:, 0, :, 0], tensor[:, 0, :, 1], tensor[:, 1, :, 1]
    inverse = np.linalg.inv(t)
    upper = np.hstack([-inverse @ rr.T, inverse])
    lower = np.hstack([rr @ inverse @ rr.T - q, -rr @ inverse])
    values, vectors = np.linalg.eig(np.vstack([upper, lower]))
    kept = values.imag > 0
    p, a, b = values[kept], vectors[:3, kept], vectors[3:, kept]
    axis = {1: 1, 2: 0, 3: 2}[mode]
    amplitude = np.linalg.solve(b, np.eye(3)[axis].astype(complex))
    root = np.sqrt(np.cos(theta)[:, None] + p * np.sin(theta)[:, None])
    return np.sqrt(2 * r / np.pi)[:, None] * ((root * amplitude) @ a.T).real


def penny_in_tension(points, above, radius=1.0, stress=1.0):
    """Displacements round a penny in z = 0 of an infinite body; above: which nodes are over the crack.

    Source: V. I. Fabrikant, Applications of Potential Theory in Mechanics (1989).
    """
    rho, z = np.hypot(points[:, 0], points[:, 1]), np.abs(points[:, 2])
    far, near = np.hypot(radius + rho, z), np.hypot(radius - rho, z)
    l1, l2 = (far - near) / 2, (far + near) / 2
    root1 = np.sqrt(np.maximum(radius**2 - l1**2, 0))
    root2 = np.sqrt(np.maximum(l2**2 - radius**2, 0))
    gap = np.maximum(l2**2 - l1**2, 1e-300)
    angle = np.arcsin(np.minimum(radius / l2, 1))
    within = 2 * radius**2 * z * root1 / (l2**2 * gap)
    across = (1 - 2 * POISSON) * (radius * root2 / l2**2 - angle) + within
    up = 2 * (1 - POISSON) * (root1 - z * angle) + z * (angle - radius * root2 / gap)
    moved = np.empty_like(points)
    moved[:, :2] = stress / (2 * np.pi * SHEAR) * across[:, None] * points[:, :2]
    moved[:, 2] = np.where(above, 1, -1) * stress / (np.pi * SHEAR) * up
    moved += stress / YOUNG * points * [-POISSON, -POISSON, 1]
    return moved
