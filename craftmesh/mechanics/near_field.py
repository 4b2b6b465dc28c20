"""Fields around a crack front in any crystal: of unit K, and of unit forces along the front.

Local axes 1, 2, 3 are the binormal, the normal and the tangent of the front; r and theta are polar in the
plane of the first two, theta = 0 ahead of the crack, +pi on lip A, -pi on lip B.

Stroh's formalism without its eigenvectors: with w = (u, phi), displacements and stress functions, a field
that grows with r^(1/2) obeys dw/dtheta = N(theta) w / 2, where N is the fundamental elasticity matrix in
the rotated axes. This equation is integrated step by step, so isotropic and other degenerate materials need
no case of their own. Source: T. C. T. Ting, Anisotropic Elasticity (1996), chapters 5-7, 11.
"""

from dataclasses import dataclass

import numpy as np

from craftmesh.mechanics.materials import COMPONENT

# Axes of the unit forces along the front. The MODES fields are those of K_II, K_I, K_III (in the order of
# the axes along which the lips separate), then those of the forces, which give the strain along the
# binormal and the shear towards the tangent.
AXES_OF_FORCES = (0, 2)
MODES = 3 + len(AXES_OF_FORCES)
# Largest theta. Fields continue past the lips at +-pi, because lips may bend: theta of a point is chosen
# within pi of pi/2 or -pi/2, the middle of the point's side of the crack.
LARGEST_ANGLE = 1.5 * np.pi
# Number of intervals in theta. Cubic interpolation in them errs by 1e-6 of the field in copper.
CELLS = 96
_STEPS = 2  # integration steps in each interval


@dataclass(frozen=True, eq=False)
class NearField:
    """Displacement gradients around straight crack fronts in k crystals, as functions of theta.

    angles (c + 1,): ends of the intervals in theta; value (k, c + 1, MODES, 3, 2): derivatives of the three
    displacements along axes 1 and 2, times r^(1/2) for unit K and times r for unit forces per length;
    slope: derivatives of value by theta. opening (k, 3, 3): the matrix L^-1 of Barnett and Lothe; J = K .
    L^-1 K / 2 with K in the order of the axes, K_II, K_I, K_III.
    """

    angles: np.ndarray
    value: np.ndarray
    slope: np.ndarray
    opening: np.ndarray


def near_field(stiffness: np.ndarray) -> NearField:
    """Return the fields in k crystals.

    stiffness (k, 6, 6): in the front's local axes, components in the order 11, 22, 33, 12, 13, 23.
    """
    tensor = as_tensor(stiffness)
    half = CELLS // 2
    steps = half * _STEPS
    fine = np.linspace(0.0, LARGEST_ANGLE, 2 * steps + 1)
    sides = [_propagated(tensor, sign * fine) for sign in (1.0, -1.0)]
    start = _start(sides[0][0][steps * 2 // 3])
    waves, matrices = [], []
    for transfer, matrix in sides:
        waves.append(transfer[::_STEPS] @ start)
        matrices.append(matrix[:: 2 * _STEPS])
    wave = np.concatenate([waves[1][:0:-1], waves[0]])
    matrix = np.concatenate([matrices[1][:0:-1], matrices[0]])
    angles = np.linspace(-LARGEST_ANGLE, LARGEST_ANGLE, CELLS + 1)
    at_lips = [waves[i][half * 2 // 3][:, :3] for i in range(2)]
    opening = (at_lips[0] - at_lips[1]) / np.sqrt(8 / np.pi)
    opening = 0.5 * (opening + np.swapaxes(opening, 1, 2))
    value, slope = _gradients(angles, wave, matrix, opening)
    return NearField(angles, value, slope, opening)


def as_tensor(stiffness: np.ndarray) -> np.ndarray:
    """Return stiffnesses (k, 6, 6), in the order 11, 22, 33, 12, 13, 23, as tensors (k, 3, 3, 3, 3)."""
    return stiffness[:, COMPONENT[:, :, None, None], COMPONENT[None, None]]


def fundamental_matrix(tensor: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Return the fundamental elasticity matrix N (a, k, 6, 6) in axes rotated by angles (a,) about axis 3.

    tensor (k, 3, 3, 3, 3): the stiffnesses.
    """
    zero = np.zeros(len(angles))
    m = np.stack([np.cos(angles), np.sin(angles), zero], axis=1)
    n = np.stack([-np.sin(angles), np.cos(angles), zero], axis=1)
    q, r, t = (
        np.einsum("ai,zijkl,al->azjk", u, tensor, v, optimize=True) for u, v in ((m, m), (m, n), (n, n))
    )
    inverse = np.linalg.inv(t)
    across = np.swapaxes(r, -1, -2)
    upper = np.concatenate([-inverse @ across, inverse], axis=-1)
    lower = np.concatenate([r @ inverse @ across - q, -r @ inverse], axis=-1)
    return np.concatenate([upper, lower], axis=-2)


def _propagated(tensor: np.ndarray, fine: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return matrices (s + 1, k, 6, 6) that carry w from angle 0 to every second angle of `fine`, and N.

    fine (2 s + 1,): angles from 0 on, with the middles of steps, which the Runge-Kutta method needs. N
    (2 s + 1, k, 6, 6) is the fundamental matrix at all angles of `fine`.
    """
    matrix = fundamental_matrix(tensor, fine)
    step = fine[2] - fine[0]
    transfer = [np.broadcast_to(np.eye(6), matrix.shape[1:])]
    for k in range(0, len(fine) - 1, 2):
        w = transfer[-1]
        k1 = 0.5 * matrix[k] @ w
        k2 = 0.5 * matrix[k + 1] @ (w + 0.5 * step * k1)
        k3 = 0.5 * matrix[k + 1] @ (w + 0.5 * step * k2)
        k4 = 0.5 * matrix[k + 2] @ (w + step * k3)
        transfer.append(w + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4))
    return np.array(transfer), matrix


def _start(to_lip: np.ndarray) -> np.ndarray:
    """Return w (k, 6, 3) at theta = 0 for unit K along each axis; to_lip (k, 6, 6) carries w to theta = pi.

    Ahead of the front the stress functions are given by unit K; on the lip, at theta = pi, they vanish.
    """
    functions = np.sqrt(2 / np.pi) * np.broadcast_to(np.eye(3), (len(to_lip), 3, 3))
    moved = -np.linalg.solve(to_lip[:, 3:, :3], to_lip[:, 3:, 3:] @ functions)
    return np.concatenate([moved, functions], axis=1)


def _gradients(
    angles: np.ndarray, wave: np.ndarray, matrix: np.ndarray, opening: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return value and slope of NearField from w (a, k, 6, 3) of unit K and N (a, k, 6, 6).

    dN/dtheta = -(1 + N^2). A force -2 pi a per length along the front gives u = a ln r + ..., whose
    derivative by theta is the upper left part of N times a; lips stay free of traction.
    """
    squared = matrix @ matrix
    moved = wave[..., :3, :]
    turned = 0.5 * (matrix @ wave)[..., :3, :]
    bent = -0.5 * moved - 0.25 * (squared @ wave)[..., :3, :]
    log = np.broadcast_to(
        -opening[:, :, list(AXES_OF_FORCES)] / (2 * np.pi), (len(angles), *opening.shape[:2], 2)
    )
    log_turned = matrix[..., :3, :3] @ log
    log_bent = -log - squared[..., :3, :3] @ log
    along_r = np.concatenate([0.5 * moved, log], axis=-1)
    along_r_turned = np.concatenate([0.5 * turned, 0 * log], axis=-1)
    round_it = np.concatenate([turned, log_turned], axis=-1)
    round_it_turned = np.concatenate([bent, log_bent], axis=-1)
    cos, sin = (f(angles)[:, None, None, None] for f in (np.cos, np.sin))
    value = np.stack([cos * along_r - sin * round_it, sin * along_r + cos * round_it], axis=-1)
    slope = np.stack(
        [
            cos * (along_r_turned - round_it) - sin * (along_r + round_it_turned),
            sin * (along_r_turned - round_it) + cos * (along_r + round_it_turned),
        ],
        axis=-1,
    )
    by_crystal = (1, 0, 3, 2, 4)
    return np.ascontiguousarray(value.transpose(by_crystal)), np.ascontiguousarray(
        slope.transpose(by_crystal)
    )
