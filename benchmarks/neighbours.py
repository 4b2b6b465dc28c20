"""K of cracks next to each other or to a free face, as exact as wished: integral equations, solved here.

Sources: M. K. Kassir and G. C. Sih, Three-dimensional Crack Problems (1975), for K of a penny under any
pressure; V. I. Fabrikant, Applications of Potential Theory in Mechanics (1989), for the stress around it in
its plane; R. P. Srivastava and K. Singh, Int. J. Eng. Sci. 7 (1969), for a penny below a face; G. D. Gupta
and F. Erdogan, J. Appl. Mech. 41 (1974), for the kernel of a crack square to a face.
"""

import numpy as np
from scipy.special import spherical_jn

TERMS = 12  # of each opening of a penny below a face: seven digits from a depth of half the radius on
RINGS, SPOKES = 48, 192  # of places in a penny: eight digits down to a gap of a tenth of the radius
TURNS, STILL = 60, 1e-12  # of the two pennies, until their pressures change by less


def two_pennies(radius: float, centre, apart: float):
    """Return K (k, 3) as a function of points and frames, of two pennies in z = const in unit tension.

    They are side by side along x about `centre`, their middles `apart` radii away from each other.
    """
    pair = CoplanarPennies(apart)

    def k_of(points, *_frames):
        x, y = ((points - centre) / radius).T[:2]
        k = 2 * np.sqrt(radius / np.pi) * pair.k1(np.arctan2(y, apart / 2 - np.abs(x)))
        return np.column_stack([k, 0 * k, 0 * k])

    return k_of


class CoplanarPennies:
    """Two pennies of radius 1 in one plane, their middles `apart`, in unit tension.

    The pressure on each is 1 plus the stress that the other causes there, taken by turns until it is still.
    """

    def __init__(self, apart: float):
        node, weight = np.polynomial.legendre.leggauss(RINGS)
        self._height = (node + 1) / 2  # root(1 - r^2) of the rings
        self._radius = np.sqrt(1 - self._height**2)
        self._weight = weight / 2
        self._order = np.arange(SPOKES // 2)
        angle = 2 * np.pi * np.arange(SPOKES) / SPOKES
        # the other's middle is at x = apart; its pressure is the mirror image of this one's
        x = apart - self._radius[:, None] * np.cos(angle)
        y = self._radius[:, None] * np.sin(angle)
        pressure, self.waves = np.ones((RINGS, SPOKES)), np.zeros((RINGS, SPOKES // 2))
        for _ in range(TURNS):
            waves = np.fft.rfft(pressure, axis=1)[:, self._order].real / SPOKES
            self.waves = waves * np.where(self._order, 2, 1)
            before, pressure = pressure, 1 + self.stress(np.hypot(x, y), np.arctan2(y, x))
            if np.abs(pressure - before).max() < STILL:
                break

    def stress(self, r, angle):
        """Return the stress across the plane that one penny causes at polar coordinates about it."""
        total = np.zeros_like(r)
        for radius, weight, waves in zip(self._radius, self._height**2 * self._weight, self.waves):
            ratio = radius / r * np.exp(1j * angle)
            total += weight / (r**2 - radius**2) * np.polynomial.polynomial.polyval(ratio, waves).real
        return 2 / np.pi / np.sqrt(r**2 - 1) * total

    def k1(self, angle):
        """Return K_I (k,) over that of one penny alone at angles from the direction of the other."""
        part = (self._weight[:, None] * self.waves * self._radius[:, None] ** self._order).sum(axis=0)
        return np.cos(np.outer(angle, self._order)) @ part


def penny_below_face(radius: float, middle, depth: float):
    """The same for one penny in z = const under unit pressure, `depth` radii below a free face."""
    k1, k2 = below_face(depth)

    def k_of(points, _tangent, binormal):
        out = ((points - middle) / radius * binormal).sum(axis=1)
        return 2 * np.sqrt(radius / np.pi) * np.column_stack([k1 + 0 * out, k2 * out, 0 * out])

    return k_of


def below_face(depth: float) -> tuple[float, float]:
    """Return K_I and K_II, over the K_I far from any face, of a penny of radius 1 parallel to a free face.

    K_II is positive where the lip next to the face slides outwards; depth: distance from the face. The
    tractions vanish in the mean with all openings that have the root of the distance from the rim. The
    Hankel transforms of these are spherical Bessel functions over the wave number k.
    """
    m = np.arange(TERMS)
    node, weight = np.polynomial.legendre.leggauss(400)
    k = (node + 1) * 20 / depth  # exp(-2 k depth) is nothing beyond
    image = 20 / depth * weight * np.exp(-2 * k * depth)
    reach = k * depth
    opening, sliding = (np.array([spherical_jn(2 * one + odd, k) for one in m]) for odd in (1, 2))
    both = -(opening * (image * 2 * reach**2)) @ sliding.T
    parts = [
        [opening * (image * (1 + 2 * reach + 2 * reach**2)) @ opening.T, both],
        [both.T, sliding * (image * (1 - 2 * reach + 2 * reach**2)) @ sliding.T],
    ]
    system = np.diag(np.pi / 2 / np.concatenate([4 * m + 3, 4 * m + 5])) - np.block(parts)
    pull = np.zeros(2 * TERMS)
    pull[0] = np.pi / 6  # for an opening of 1 without the face
    found = np.linalg.solve(system, pull).reshape(2, TERMS) @ (-1.0) ** m
    return float(found[0]), float(found[1])


def crack_square_to_face(half: float, middle: float):
    """The same for a crack along x of that half length, its middle `middle` of these from a face x = 0."""
    near, far = square_to_face(middle)

    def k_of(points, *_frames):
        k = np.sqrt(np.pi * half) * np.where(points[:, 0] < middle * half, near, far)
        return np.column_stack([k, 0 * k, 0 * k])

    return k_of


def square_to_face(middle: float, count: int = 200) -> tuple[float, float]:
    """Return K_I over root(pi) at the ends near to and far from a free face of a crack of half length 1.

    Under unit tension along the face, in plane strain; middle: its middle's distance from the face.
    """
    s = np.cos(np.pi * (np.arange(count) + 0.5) / count)
    at = np.cos(np.pi * np.arange(1, count) / count)
    # slopes of the opening are g / root(1 - s^2); both ends are closed, so that they sum to 0
    system = np.vstack([slope_kernel((at + middle)[:, None], s + middle), np.ones(count)]) / count
    g = np.linalg.solve(system, np.append(np.ones(count - 1), 0.0))
    order = np.arange(count)
    waves = np.cos(np.outer(order, np.arccos(s))) @ g * np.where(order, 2, 1) / count
    return float(abs(waves @ (-1.0) ** order)), float(abs(waves.sum()))


def slope_kernel(x, t):
    """Return the stress at a distance x from a free face by a slope of the opening at t, up to a factor."""
    return 1 / (t - x) - 1 / (t + x) + 6 * x / (t + x) ** 2 - 4 * x**2 / (t + x) ** 3
