"""Cracks in an infinite body whose K are known, and the displacements far from any crack."""

import numpy as np
from spherical_cap import cap_intensities

YOUNG, POISSON = 70e3, 0.3
LENS_POISSON = 0.22
COPPER = (168.4e3, 121.4e3, 75.4e3)


def penny(radius: float, normal, stress, poisson: float = POISSON):
    """Return K_I, K_II, K_III (k, 3) as a function of points and frames: Sneddon; Kassir and Sih."""
    traction = np.asarray(stress) @ normal
    opening = traction @ normal

    def k_of(points, tangent, binormal):
        root = np.sqrt(radius / np.pi)
        shear = 4 / (2 - poisson) * root
        k = [np.full(len(points), 2 * root * opening), shear * binormal @ traction]
        return np.column_stack([*k, shear * (1 - poisson) * tangent @ traction])

    return k_of


def loaded_penny(radius: float, centre, pulls: str):
    """The same for a penny in z = const whose lips bear one of LIP_LOADS.

    K_I = 2 / root(pi a) int p r / root(a^2 - r^2) dr; K_II of a shear outwards and K_III of one round the
    axis have r^2 / a for r, for any Poisson's ratio (M. K. Kassir and G. C. Sih, 1975): lips that slide by
    r root(a^2 - r^2) bear a shear linear in r. K_I of a pressure x / a: 4/3 root(a / pi) x / a (Galin).
    """
    root = np.sqrt(radius / np.pi)

    def k_of(points, tangent, binormal):
        out = (points - centre) / radius
        way = {"radial": out, "torsion": np.cross([0.0, 0, 1], out)}.get(pulls, 0 * out)
        k = {"parabola": 2 / 3, "cone": np.pi / 2, "wedge": 2.4 + 4 / 3 * out[:, 0]}.get(pulls, 0.0)
        shear = [4 / 3 * (way * axis).sum(axis=1) for axis in (binormal, tangent)]
        return root * np.column_stack([k + 0 * out[:, 0], *shear])

    return k_of


# Pressure, and traction on lip A along x and y, at places x, y over the radius.
LIP_LOADS = {
    "parabola": lambda x, y: (1 - x * x - y * y, 0, 0),
    "cone": lambda x, y: (np.hypot(x, y), 0, 0),
    "wedge": lambda x, y: (1.2 + x + 0 * y, 0, 0),
    "torsion": lambda x, y: (0, -y, x),
    "radial": lambda x, y: (0, x, y),
}


# Stress across an edge crack at x over its depth, and K over root(pi a) in a half space without Poisson's
# effect: the singular integral equation of an edge crack, solved to six digits (Stallybrass 1970).
EDGE_LOADS = {
    "uniform": (lambda x: 1 + 0 * x, 1.12152),
    "linear": (lambda x: x, 0.68286),
    "parabola": (lambda x: x * x, 0.52549),
}


def loaded_edge(depth: float, load: str):
    """The same for an edge crack in z = const whose lips bear one of EDGE_LOADS."""

    def k_of(points, *_frames):
        return np.tile([EDGE_LOADS[load][1] * np.sqrt(np.pi * depth), 0.0, 0.0], (len(points), 1))

    return k_of


def heated(radius: float, centre, hot, size: float, strain: float):
    """The same for a penny in z = const beside a hot ball in its plane: K of the stress without the crack.

    hot: the ball's middle, `size` its radius.
    """

    def stress_at(offset):
        away = np.linalg.norm(offset + centre - hot, axis=-1)
        return YOUNG / (1 + POISSON) * _ball(size, strain) / away**3

    return opened_by(radius, centre, stress_at)


def opened_by(radius: float, centre, stress_at):
    """The same for a penny in z = const, of the stress across it, stress_at(offsets from its centre).

    Source: L. A. Galin; M. K. Kassir and G. C. Sih (1975), with the stress as a Fourier series round the
    centre.
    """
    angle = np.linspace(0, 2 * np.pi, 256, endpoint=False)
    node, weight = np.polynomial.legendre.leggauss(64)
    turn = np.pi / 4 * (node + 1)
    x, y = (radius * np.sin(turn)[:, None] * wave(angle) for wave in (np.cos, np.sin))
    stress = stress_at(np.stack([x, y, 0 * x], axis=-1))
    order = np.arange(100)
    waves = np.fft.rfft(stress, axis=1)[:, order] / len(angle) * np.where(order, 2, 1)
    part = (
        np.pi / 4 * ((weight * np.sin(turn))[:, None] * waves * np.sin(turn)[:, None] ** order).sum(axis=0)
    )

    def k_of(points, *_frames):
        at = np.arctan2(*(points - centre)[:, [1, 0]].T)
        k = 2 * np.sqrt(radius / np.pi) * (part * np.exp(1j * at[:, None] * order)).real.sum(axis=1)
        return np.column_stack([k, 0 * k, 0 * k])

    return k_of


LINEAR, PARABOLA, SPOT = "linear", "parabola", "spot"
_SLOPE, _SPOT = np.array([0.5, -0.3, 0.6]), np.array([1.0, 0.4, 0])  # over the radius; the middle of a spot


def warmed(kind: str, offset, radius: float, strain: float):
    """Return temperatures (k,) and displacements (k, 3) of an infinite body without a crack, at offsets.

    The strain is that of temperature 1. A linear temperature strains the body freely. -(x^2 + y^2) / a^2
    is the sum of two layerings, each held along its layers; a spot, exp(-R^2 / a^2), is a ball without
    stress far away (S. P. Timoshenko and J. N. Goodier, 1970).
    """
    x, wide = offset / radius, strain * radius
    free = wide * (1 + POISSON) / (1 - POISSON)
    if kind == LINEAR:
        along = x @ _SLOPE
        return along, wide * (along[:, None] * x - 0.5 * (x * x).sum(axis=1)[:, None] * _SLOPE)
    if kind == PARABOLA:
        return -(x[:, 0] ** 2) - x[:, 1] ** 2, -free / 3 * x**3 * [1, 1, 0]
    out = x - _SPOT
    away = np.linalg.norm(out, axis=1)
    return np.exp(-(away**2)), free * _heat_within(away)[:, None] * out


def warmed_penny(kind: str, radius: float, centre, stress, strain: float):
    """The same for a penny in z = const in a warmed body with a stress far away."""
    plane = YOUNG * strain / (1 - POISSON)

    def stress_at(offset):
        x = offset / radius
        away = np.linalg.norm(x - _SPOT, axis=-1)
        own = {PARABOLA: (x**2).sum(axis=-1), SPOT: _heat_within(away) - np.exp(-(away**2))}
        return plane * own.get(kind, 0.0) + stress[2, 2] + 0 * away

    return opened_by(radius, centre, stress_at)


def _heat_within(away):
    """Return the integral of exp(-r^2) r^2 from 0 to distances, over their cube."""
    from scipy.special import erf

    return (0.5 * np.sqrt(np.pi) * erf(away) - away * np.exp(-(away**2))) / (2 * away**3)


def round_inclusion(points, hot, size: float, strain: float):
    """Return the displacements (k, 3) outside a hot ball in an infinite body: Eshelby."""
    out = points - np.asarray(hot)
    return _ball(size, strain) * out / np.linalg.norm(out, axis=1, keepdims=True) ** 3


def _ball(size: float, strain: float) -> float:
    return strain * size**3 * (1 + POISSON) / (3 * (1 - POISSON))


def ellipse(a: float, b: float, centre, stress: float):
    """The same for an ellipse in z = const in tension along z, semi-axes a > b along x and y: Irwin."""
    from scipy.special import ellipe

    def k_of(points, *_frames):
        x, y = (points - centre)[:, 0] / a, (points - centre)[:, 1] / b
        angle = np.arctan2(y, x)
        shape = (np.sin(angle) ** 2 + (b / a) ** 2 * np.cos(angle) ** 2) ** 0.25
        k = stress * np.sqrt(np.pi * b) / ellipe(1 - (b / a) ** 2) * shape
        return np.column_stack([k, 0 * k, 0 * k])

    return k_of


def crystal_penny(tensor, radius: float, normal, stress):
    """The same in a crystal of stiffness (3, 3, 3, 3): A. Hoenig, Acta Mech. 30 (1978)."""
    u = np.cross(normal, [1.0, 0, 0] if abs(normal[0]) < 0.9 else [0, 1.0, 0])
    u /= np.linalg.norm(u)
    turn = np.linspace(0, 2 * np.pi, 64, endpoint=False)[:, None]
    round_it = np.cos(turn) * u + np.sin(turn) * np.cross(normal, u)
    mean = barnett_lothe(tensor, round_it, normal).mean(axis=0)
    jump = 2 * np.sqrt(radius / np.pi) * np.linalg.solve(mean, np.asarray(stress) @ normal)

    def k_of(_points, tangent, binormal):
        k = barnett_lothe(tensor, binormal, normal) @ jump
        axes = (np.broadcast_to(normal, k.shape), binormal, tangent)
        return np.column_stack([(k * axis).sum(axis=1) for axis in axes])

    return k_of


def barnett_lothe(tensor, binormal, normal, count: int = 64):
    """Return Barnett's and Lothe's L (k, 3, 3) for fronts square to binormals (k, 3) and a normal."""
    total = 0
    for angle in (np.arange(count) + 0.5) * 2 * np.pi / count:
        m = np.cos(angle) * binormal + np.sin(angle) * normal
        n = -np.sin(angle) * binormal + np.cos(angle) * normal
        mm, mn, nn = (_contracted(tensor, *pair) for pair in ((m, m), (m, n), (n, n)))
        total = total + mm - mn @ np.linalg.inv(nn) @ np.swapaxes(mn, 1, 2)
    return total / count


def _contracted(tensor, u, v):
    return np.einsum("ki,ijlm,km->kjl", u, tensor, v, optimize=True)


def lens(radius: float):
    """The same for a cap of 45 degrees of a sphere, rim of that radius, in unit hydrostatic tension.

    Lip A is outside the sphere and goes inwards at the rim. For a Poisson's ratio of LENS_POISSON.
    In units of 2 / pi root(pi radius) K_I is 0.88900 and K_II -0.24530; the digits that are often printed,
    0.877 and 0.235 (Code_Aster's SSLV155, after J. P. Pereira et al., Int. J. Numer. Meth. Eng. 77, 2009),
    are not exact.
    """
    root = np.sqrt(radius * np.sqrt(2))
    opening, sliding = (k * root for k in cap_intensities(np.pi / 4, LENS_POISSON))

    def k_of(points, *_frames):
        return np.tile([opening, sliding, 0.0], (len(points), 1))

    return k_of


def newman_raju(angle, radius: float, thickness: float, half_width: float):
    """K_I (k,) of a semicircular surface crack in unit tension at angles from the surface: NASA TP-1578."""
    q = 1 + 1.464
    root = np.sqrt(radius / thickness)
    m = 1.04 + (-0.54 + 0.89 / 1.2) * root**4 + (0.5 - 1 / 1.65) * root**8
    g = 1 + (0.1 + 0.35 * root**4) * (1 - np.sin(angle)) ** 2
    width = np.sqrt(1 / np.cos(np.pi * radius / (2 * half_width) * root))
    return np.sqrt(np.pi * radius / q) * m * g * width


def newman_raju_corner(angle, depth: float, width: float, thickness: float):
    """K_I (k,) of a quarter-elliptical corner crack, depth <= width, in unit tension: NASA TM-85793.

    angle: of the ellipse, from the face that the semi-axis `width` lies in; depth: along the thickness.
    """
    ratio, part = depth / width, depth / thickness
    q = 1 + 1.464 * ratio**1.65
    m = 1.08 - 0.03 * ratio + (-0.44 + 1.06 / (0.3 + ratio)) * part**2
    m += (-0.5 + 0.25 * ratio + 14.8 * (1 - ratio) ** 15) * part**4
    g = 1 + (0.08 + 0.4 * part**2) * (1 - np.sin(angle)) ** 3
    g *= 1 + (0.08 + 0.15 * part**2) * (1 - np.cos(angle)) ** 3
    place = (ratio**2 * np.cos(angle) ** 2 + np.sin(angle) ** 2) ** 0.25
    return np.sqrt(np.pi * depth / q) * m * g * place


def displacements_of_opening(points, places, jumps, normals, tensor):
    """Return displacements (n, 3) of points far from a crack whose facets open.

    places, jumps, normals (f, 3): centres of the facets, their openings times area, their unit normals
    towards the side that moves by the jump; tensor (3, 3, 3, 3).
    """
    double = np.einsum("jkpq,fj,fk->fpq", tensor, jumps, normals, optimize=True)
    slope = kelvin_slope if _is_isotropic(tensor) else green_slope
    found = np.zeros((len(points), 3))
    for row, point in enumerate(points):
        found[row] = -np.einsum("fipq,fpq->i", slope(tensor, point - places), double)
    return found


def _is_isotropic(tensor) -> bool:
    lame, shear, unit = tensor[0, 0, 1, 1], tensor[0, 1, 0, 1], np.eye(3)
    volume, forth, back = (
        np.einsum(pair, unit, unit) for pair in ("ij,kl->ijkl", "ik,jl->ijkl", "il,jk->ijkl")
    )
    return bool(np.abs(tensor - lame * volume - shear * (forth + back)).max() < 1e-9 * shear)


def kelvin_slope(tensor, offset):
    """Return what `green_slope` does, of an isotropic stiffness, in closed form."""
    lame, shear = tensor[0, 0, 1, 1], tensor[0, 1, 0, 1]
    poisson = lame / (2 * (lame + shear))
    distance = np.linalg.norm(offset, axis=1)
    n = offset / distance[:, None]
    unit = np.eye(3)
    total = 3 * n[:, :, None, None] * n[:, None, :, None] * n[:, None, None, :]
    total += (3 - 4 * poisson) * unit[:, :, None] * n[:, None, None, :]
    total -= unit[:, None, :] * n[:, None, :, None] + unit[None, :, :] * n[:, :, None, None]
    return -total / (16 * np.pi * shear * (1 - poisson) * distance**2)[:, None, None, None]


def green_slope(tensor, offset, count: int = 32):
    """Return the derivatives (f, 3, 3, 3), the last index that of the place, of Green's function.

    Barnett's integral over the directions square to the line of sight (Phys. Stat. Sol. B 49, 1972).
    """
    distance = np.linalg.norm(offset, axis=1)
    sight = offset / distance[:, None]
    helper = np.where(np.abs(sight[:, :1]) < 0.7, [[1.0, 0, 0]], [[0, 1.0, 0]])
    u = np.cross(sight, helper)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v, total = np.cross(sight, u), 0
    for angle in (np.arange(count // 2) + 0.5) * 2 * np.pi / count:  # the integrand has the period pi
        x = np.cos(angle) * u + np.sin(angle) * v
        inverse = np.linalg.inv(_contracted(tensor, x, x))
        mixed = _contracted(tensor, x, sight)
        bent = inverse @ (mixed + np.swapaxes(mixed, 1, 2)) @ inverse
        total = total - sight[:, None, None, :] * inverse[..., None] + x[:, None, None, :] * bent[..., None]
    step = 2 * np.pi / (count // 2)
    return total * step / (8 * np.pi**2 * distance**2)[:, None, None, None]
