"""K of a crack on a cap of a sphere in hydrostatic tension, as exact as wished: dual series of Legendre.

The opening is a sum of harmonics of the sphere; tractions of each follow from the harmonic solutions inside
and outside, and vanish on the cap in the mean with all openings that are possible there. Openings with the
root of the distance from the rim are integrals of odd functions of an angle (Mehler and Dirichlet), whose
harmonics are spherical Bessel functions. K has seven digits with ten terms.
Sources: A. I. Lur'e, Three-dimensional Problems of the Theory of Elasticity (1964), for the harmonics;
M. A. Martynenko, A. F. Ulitko (1979) and P. A. Martin, Int. J. Solids Struct. 38 (2001), for the problem.
"""

import numpy as np
from scipy.special import spherical_jn

TERMS, HARMONICS = 10, 3000


def cap_intensities(angle: float, poisson: float) -> tuple[float, float]:
    """Return K_I and K_II in unit tension of a cap of `angle` radians from the pole of a unit sphere.

    K_II is negative where the outer lip goes towards the pole, against the normal out of the sphere.
    """
    n = np.arange(HARMONICS)
    opening, sliding = _harmonics(n, angle)
    both = np.zeros((HARMONICS, 2, 2 * TERMS))
    both[:, 0, :TERMS], both[:, 1, TERMS:] = opening, sliding
    measure = np.column_stack([2 / (2 * n + 1), 2 * n * (n + 1) / (2 * n + 1)])
    stiffness = measure[:, :, None] * tractions(n, poisson)
    # what stays for large n is summed to infinity: Bessel functions are orthogonal over the half numbers
    flat = -1 / (4 * (1 - poisson))
    stiffness -= flat * np.stack([np.ones(HARMONICS), (n + 0.5) ** 2], axis=1)[:, :, None] * np.eye(2)
    system = np.einsum("nak,nab,nbl->kl", both, stiffness, both, optimize=True)
    k = np.arange(TERMS)
    system += np.diag(flat * np.pi * np.concatenate([angle / (4 * k + 3), (4 * k + 5) / angle]))
    pull = np.concatenate([-2 * opening[0], np.zeros(TERMS)])
    found = np.linalg.solve(0.5 * (system + system.T), pull)
    at_rim = found[:TERMS].sum(), -(found[TERMS:] @ (4 * k + 5)) / angle
    unit = np.sqrt(2 * np.pi / np.sin(angle)) / (4 * (1 - poisson))
    return float(unit * at_rim[0]), float(unit * at_rim[1])


def _harmonics(n: np.ndarray, angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the coefficients (n, TERMS) of P_n in the openings, of its slopes in the slidings.

    Those of the integral of P_(2k+1)(t / angle) dt / (cos a - cos t)^(1/2) from a to the angle, and of the
    slope of the same with P_(2k+1) - P_(2k+3), which vanishes at the rim.
    """
    k = np.arange(TERMS)
    x = ((n + 0.5) * angle)[:, None]
    sign = np.sqrt(2) * (-1.0) ** k
    return sign * angle * spherical_jn(2 * k + 1, x), sign * angle * (4 * k + 5) * spherical_jn(
        2 * k + 2, x
    ) / x


def tractions(n: np.ndarray, poisson: float) -> np.ndarray:
    """Return the matrices (n, 2, 2) from displacements' jumps over the unit sphere, outside less inside.

    Jumps along r as P_n and along the angle as its slope; tractions likewise, over twice the shear modulus.
    """
    inside, pull_inside, outside, pull_outside = solutions(n, poisson)
    system = np.concatenate(
        [np.concatenate([-inside, outside], axis=2), np.concatenate([pull_inside, -pull_outside], axis=2)],
        axis=1,
    )
    scale = np.abs(system).max(axis=1, keepdims=True)
    scale[scale == 0] = 1.0
    given = np.zeros((len(n), 4, 2))
    given[:, [0, 1], [0, 1]] = 1.0
    radial = n == 0  # P_0 has no slope
    system[radial, 1:4:2] = 0
    system[radial, 1, 1] = system[radial, 3, 2] = 1.0
    given[radial, 1] = 0
    amounts = np.linalg.solve(system / scale, given) / np.swapaxes(scale, 1, 2)
    return pull_inside @ amounts[:, :2]


def solutions(n: np.ndarray, poisson: float) -> tuple[np.ndarray, ...]:
    """Return displacements and tractions (n, 2, 2) of both solutions inside the unit sphere, and outside.

    Rows: along r as P_n, along the angle as its slope; columns: r^(n+1), r^(n-1), and r^-n, r^-(n+2).
    """
    n = np.asarray(n, float)
    one, nu = np.ones(len(n)), poisson
    tables = (
        (((n + 1) * (n - 2 + 4 * nu), n), (n + 5 - 4 * nu, one)),
        (((n + 1) * (n * n - n - 2 - 2 * nu), n * (n - 1)), (n * n + 2 * n - 1 + 2 * nu, n - 1)),
        ((n * (n + 3 - 4 * nu), -(n + 1)), (4 - 4 * nu - n, one)),
        ((-n * (n * n + 3 * n - 2 * nu), (n + 1) * (n + 2)), (n * n - 2 + 2 * nu, -(n + 2))),
    )
    return tuple(np.moveaxis(np.array(table), 2, 0) for table in tables)
