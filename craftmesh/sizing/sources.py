"""The sizing function around the defects of a model: crack fronts, voids and points, from plain arrays."""

from dataclasses import dataclass, field, replace

import numpy as np

from craftmesh.sizing.length_field import LengthField
from craftmesh.sizing.sizing import Sizing, SizingOptions, densify, sizing_for
from craftmesh.types import Surface


def _none(columns: int) -> np.ndarray:
    return field(default_factory=lambda: np.zeros((0, columns)))


@dataclass(frozen=True, eq=False)
class Defects:
    """What edges are refined around, beside the voids of the surface itself; in model units but for voids.

    fronts: polylines (n, 3), such as crack fronts; points (k, 3); voids (v, 4): x, y, z, r in fractions of
    the surface's box, r of the cube root of its volume.
    """

    fronts: tuple[np.ndarray, ...] = ()
    points: np.ndarray = _none(3)
    voids: np.ndarray = _none(4)


def sizing_around(
    defects: Defects, surface: Surface, options: SizingOptions, lengths: LengthField | None = None
) -> Sizing:
    """Return the sizing function around all `defects` of a model; the least of all lengths counts.

    Sources on fronts and on the spheres of voids are l_min / 2 apart. `surface` gives the default of l0,
    the box of the voids, the curvature and, with options.around_voids, the points of its own voids;
    lengths: a field of largest lengths. Raises CraftmeshError as `sizing_for`.
    """
    plain = sizing_for(surface, options, np.zeros((0, 3)), () if lengths is None else (lengths,))
    step = plain.l_min / 2
    sources = [densify(front, step) for front in defects.fronts]
    if options.around_voids:
        sources.append(void_points(surface))
    sources.append(defects.points)
    if len(defects.voids):
        sources.append(points_on_voids(defects.voids, surface, step))
    return replace(plain, sources=np.concatenate([plain.sources, *sources]))


def void_points(surface: Surface) -> np.ndarray:
    """Return the points (k, 3) of the facets that bound enclosed voids."""
    return surface.points[np.unique(surface.facets[(surface.sides < 0).any(axis=1)])]


def points_on_voids(voids: np.ndarray, surface: Surface, step: float) -> np.ndarray:
    """Return points (k, 3) about `step` apart on the spheres of `voids` (v, 4), in fractions of the box."""
    used = surface.points[np.unique(surface.facets)]
    low = used.min(axis=0)
    extent = used.max(axis=0) - low
    centres = low + voids[:, :3] * extent
    radii = voids[:, 3] * np.cbrt(extent.prod())
    return np.concatenate([_sphere(c, r, step) for c, r in zip(centres, radii)])


def _sphere(centre: np.ndarray, radius: float, step: float) -> np.ndarray:
    """Return points on a sphere, about `step` apart, along a Fibonacci spiral."""
    count = int(np.clip(np.ceil(4 * np.pi * (radius / step) ** 2), 12, 100_000))
    place = np.arange(count) + 0.5
    height = 1 - 2 * place / count
    turn = np.pi * (1 + np.sqrt(5)) * place
    ring = np.sqrt(1 - height**2)
    return centre + radius * np.stack([ring * np.cos(turn), ring * np.sin(turn), height], axis=1)
