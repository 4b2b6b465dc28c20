"""Crack surfaces as triangulated sheets: flat, wavy, rough, kinked or twisted, over discs and strips."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.measure import meets_box

Height = Callable[[np.ndarray, np.ndarray], np.ndarray]
RELIEFS = ("flat", "wavy", "fractal", "kinked", "twisted", "kinked fractal", "twisted wavy")
RELIEF_SHARES = (0.15, 0.2, 0.15, 0.2, 0.15, 0.1, 0.05)
LARGEST_KINK = 60.0  # degrees
MOST_CURVED = 0.2  # over l_min: edges of l_min are 0.025 l_min off such a curve, half of what is a fault
SHORTEST_WAVE = 8.0  # l_min: shorter waves would ask for facets that l_min does not allow
MOST_SPOKES = 720
MOST_RINGS = 60


@dataclass(frozen=True)
class Sheet:
    """A crack as it is given: points (n, 3), triangles (m, 3), and its fronts as polylines (k, 3).

    flat: the whole sheet is planar; crease (k, 2, 3): segments along which it is kinked.
    """

    points: np.ndarray
    triangles: np.ndarray
    fronts: tuple[np.ndarray, ...]
    flat: bool


@dataclass(frozen=True)
class Relief:
    """Height of a sheet over its plane, and the crease that the triangles follow.

    crease: distance from the origin and angle (radians) of the crease's normal in the plane, or None.
    """

    height: Height
    crease: tuple[float, float] | None = None
    kind: str = "flat"


def draw_relief(rng: np.random.Generator, kind: str, size: float, l_min: float) -> Relief:
    """Return a relief over a sheet of about `size` in its plane."""
    parts: list[Height] = []
    crease = None
    if "wavy" in kind:
        parts.append(_waves(rng, size, l_min, count=int(rng.integers(1, 4)), slope=rng.uniform(0.1, 0.7)))
    if "fractal" in kind:
        parts.append(_fractal(rng, size, l_min))
    if "kinked" in kind:
        crease = (float(rng.uniform(-0.3, 0.6) * size), float(rng.choice([0.0, np.pi / 2])))
        parts.append(_kink(crease, rng.choice([-1, 1]) * np.radians(rng.uniform(5, LARGEST_KINK))))
    if "twisted" in kind:
        turn = min(np.radians(rng.uniform(5, 40)), 0.6 * MOST_CURVED / l_min * size) * rng.choice([-1, 1])
        parts.append(lambda u, v: u * np.tan(turn * np.tanh(v / size)))
    return Relief(lambda u, v: sum((part(u, v) for part in parts), np.zeros(np.shape(u))), crease, kind)


def _waves(rng: np.random.Generator, size: float, l_min: float, count: int, slope: float) -> Height:
    """Return a sum of sines whose slopes add up to at most `slope`."""
    terms = []
    for _ in range(count):
        length = max(rng.uniform(0.5, 2.5) * size, SHORTEST_WAVE * l_min)
        angle, phase = rng.uniform(0, 2 * np.pi, 2)
        terms.append((2 * np.pi / length, angle, phase, slope / count * length / (2 * np.pi)))
    share = min(1.0, MOST_CURVED / l_min / sum(k**2 * high for k, _, _, high in terms))
    return lambda u, v: sum(
        share * high * np.sin(k * (u * np.cos(angle) + v * np.sin(angle)) + phase)
        for k, angle, phase, high in terms
    )


def _fractal(rng: np.random.Generator, size: float, l_min: float) -> Height:
    """Return a self-affine roughness with slopes of up to about 25 degrees; short waves are left out."""
    hurst, terms = rng.uniform(0.5, 0.9), []
    length = 2 * size
    while length > SHORTEST_WAVE * l_min or not terms:
        for _ in range(3):
            angle, phase = rng.uniform(0, 2 * np.pi, 2)
            terms.append((2 * np.pi / length, angle, phase, (length / size) ** hurst))
        length *= 0.6
    steepest = np.sqrt(sum((k * high) ** 2 for k, _, _, high in terms) / 2)
    scale = rng.uniform(0.05, 0.3) / steepest
    # three times the root mean square, which the sum of that many waves hardly passes
    most_curved = 3 * scale * np.sqrt(sum((k**2 * high) ** 2 for k, _, _, high in terms) / 2)
    scale *= min(1.0, MOST_CURVED / l_min / most_curved)
    return lambda u, v: sum(
        scale * high * np.sin(k * (u * np.cos(angle) + v * np.sin(angle)) + phase)
        for k, angle, phase, high in terms
    )


def _kink(crease: tuple[float, float], turn: float) -> Height:
    offset, angle = crease
    return lambda u, v: np.tan(turn) * np.maximum(u * np.cos(angle) + v * np.sin(angle) - offset, 0)


def disc(semi_axes: tuple[float, float], relief: Relief, step: float) -> Sheet:
    """Return a sheet over an ellipse in local coordinates, all its rim front; triangles of about `step`.

    Rings and spokes go round a point of the crease, so that the crease runs along two spokes.
    """
    a, b = semi_axes
    offset, angle = relief.crease or (0.0, 0.0)
    pole = offset * np.array([np.cos(angle), np.sin(angle)])
    pole *= min(1.0, 0.7 / max(np.hypot(pole[0] / a, pole[1] / b), 1e-12))
    if relief.kind == "flat":
        spokes, rings = 3000, 1
    else:
        spokes = 4 * int(np.clip(2 * np.pi * max(a, b) / step / 4, 12, MOST_SPOKES / 4))
        rings = int(np.clip(max(a, b) / step, 6, MOST_RINGS))
    turn = angle + 2 * np.pi * np.arange(spokes) / spokes
    way = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    rim = pole + _reach(pole, way, a, b)[:, None] * way
    share = np.arange(1, rings + 1) / rings
    plane = np.concatenate([pole[None], (pole + share[:, None, None] * (rim - pole)).reshape(-1, 2)])
    points = np.column_stack([plane, relief.height(*plane.T)])
    front = points[-spokes:]
    return Sheet(
        points, _ring_triangles(spokes, rings), (np.vstack([front, front[:1]]),), relief.kind == "flat"
    )


def _reach(pole: np.ndarray, way: np.ndarray, a: float, b: float) -> np.ndarray:
    """Return the distances from `pole` to the ellipse along the unit vectors `way` (n, 2)."""
    p, d = pole / (a, b), way / (a, b)
    dd, pd, pp = (d**2).sum(axis=1), d @ p, p @ p
    return (-pd + np.sqrt(pd**2 + dd * (1 - pp))) / dd


def _ring_triangles(spokes: int, rings: int) -> np.ndarray:
    i, j = np.arange(spokes), (np.arange(spokes) + 1) % spokes
    triangles = [np.stack([0 * i, 1 + i, 1 + j], axis=1)]
    for ring in range(rings - 1):
        inner, outer = 1 + ring * spokes, 1 + (ring + 1) * spokes
        triangles += [
            np.stack([inner + i, outer + i, outer + j], axis=1),
            np.stack([inner + i, outer + j, inner + j], axis=1),
        ]
    return np.concatenate(triangles)


def strip(depth: Height, back: float, half_width: float, relief: Relief, step: float) -> Sheet:
    """Return a sheet over -back < u < depth(0, v), |v| < half_width, whose front is the edge u = depth.

    Where the relief has a crease along the front, one line of points follows it.
    """
    columns = int(np.clip(2 * half_width / step, 8, 160))
    v = np.linspace(-half_width, half_width, columns + 1)
    reach = depth(np.zeros_like(v), v)
    rows = int(np.clip((back + reach.mean()) / step, 4, 100))
    offset, angle = relief.crease or (0.0, np.pi / 2)
    if relief.crease and angle == 0.0:
        crease = np.minimum(offset, 0.8 * reach.min())
        upper = max(int(rows * (reach.mean() - crease) / (reach.mean() + back)), 2)
        share = np.concatenate([np.linspace(-back, crease, max(rows - upper, 2) + 1)[:-1]])
        below = np.repeat(share[:, None], len(v), axis=1)
        above = crease + np.linspace(0, 1, upper + 1)[:, None] * (reach - crease)
        u = np.concatenate([below, above])
    else:
        if relief.crease:
            v = np.sort(np.append(np.delete(v, np.abs(v - offset).argmin()), offset))
            reach = depth(np.zeros_like(v), v)
        u = -back + np.linspace(0, 1, rows + 1)[:, None] * (back + reach)
    plane = np.stack([u, np.broadcast_to(v, u.shape)], axis=-1).reshape(-1, 2)
    points = np.column_stack([plane, relief.height(*plane.T)])
    straight = relief.kind == "flat"
    return Sheet(points, _grid_triangles(*u.shape), (points[-len(v) :],), straight)


def _grid_triangles(rows: int, columns: int) -> np.ndarray:
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    first = np.stack([corner, corner + columns, corner + columns + 1], axis=1)
    return np.concatenate([first, np.stack([corner, corner + columns + 1, corner + 1], axis=1)])


def placed(sheet: Sheet, centre: np.ndarray, frame: np.ndarray) -> Sheet:
    """Return the sheet with its local axes along the rows of `frame` (3, 3) and its origin at `centre`."""
    fronts = tuple(centre + front @ frame for front in sheet.fronts)
    return Sheet(centre + sheet.points @ frame, sheet.triangles, fronts, sheet.flat)


def with_rim(sheet: Sheet, box: np.ndarray) -> Sheet:
    """Return the sheet with the other edges of its rim that reach into the box as fronts: it ends there."""
    edges, _, count = unique_edges(sheet.triangles)
    rim = sheet.points[edges[count == 1]]
    given = {tuple(point) for front in sheet.fronts for point in front.tolist()}
    inside = rim[meets_box(rim[:, [0, 1, 1]], box)]
    other = (edge for edge in inside if not given.issuperset(map(tuple, edge.tolist())))
    return replace(sheet, fronts=(*sheet.fronts, *other))


def samples(sheet: Sheet, count: int = 6000) -> tuple[np.ndarray, np.ndarray]:
    """Return points (count, 3) spread evenly over the sheet's area, and the unit normals there."""
    rng = np.random.default_rng(0)
    corners = sheet.points[sheet.triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(cross, axis=1)
    row = rng.choice(len(size), count, p=size / size.sum())
    s, t = np.sqrt(rng.random(count)), rng.random(count)
    weight = np.stack([1 - s, s * (1 - t), s * t], axis=1)
    return np.einsum("nk,nkd->nd", weight, corners[row]), cross[row] / size[row, None]
