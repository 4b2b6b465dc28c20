"""The sizing function around the defects of a model: crack fronts, voids and points, given as arrays."""

from dataclasses import dataclass, field, replace

import numpy as np

from craftmesh.arguments import Frozen, typed
from craftmesh.sizing.clearance import clearance_lengths
from craftmesh.sizing.length_field import LengthField
from craftmesh.sizing.sizing import Sizing, SizingOptions, densify, sizing_for
from craftmesh.types import Crack, Surface


def _none(columns: int) -> np.ndarray:
    return field(default_factory=lambda: np.zeros((0, columns)))


@dataclass(frozen=True, eq=False)
class Defects(Frozen):
    """Defects around which edges are refined, in addition to the surface's own voids; in model units.

    crack: its fronts, and where it comes near to box faces or itself; points (k, 3), such as a front's;
    spheres (s, 4): x, y, z, r.
    """

    crack: Crack | None = None
    points: np.ndarray = _none(3)
    spheres: np.ndarray = _none(4)

    def __post_init__(self) -> None:
        self._convert("points", float, (None, 3))
        self._convert("spheres", float, (None, 4))

    @property
    def centres(self) -> np.ndarray:
        """The points, then the centres of the spheres (n, 3)."""
        return np.concatenate([self.points, self.spheres[:, :3]])

    def __repr__(self) -> str:
        return f"Defects({self.crack}, {len(self.points)} points, {len(self.spheres)} spheres)"


@typed
def sizing_around(
    surface: Surface | None,
    defects: Defects,
    options: SizingOptions,
    lengths: LengthField | None = None,
) -> Sizing:
    """Return the sizing function around all `defects` of a model; the smallest of all lengths counts.

    Sources on fronts and spheres are at most l_min / 2 apart. `surface` gives the default of l0, the
    curvature, the box and, with options.around_voids, the points of its voids; it may be None if only
    points and spheres are given. lengths: a field of upper bounds. Raise CraftmeshError as `sizing_for`
    does.
    """
    crack = defects.crack
    plain = sizing_for(surface, np.zeros((0, 3)), options, () if lengths is None else (lengths,))
    step = plain.l_min / 2
    sources = [densify(crack.points[front], step) for front in crack.fronts] if crack else []
    if options.around_voids and surface is not None:
        sources.append(void_points(surface))
    sources.append(defects.points)
    sources += [_on_sphere(sphere[:3], sphere[3], step) for sphere in defects.spheres]
    sizing = replace(plain, sources=np.concatenate([plain.sources, *sources]))
    if crack is None or surface is None:
        return sizing
    clearance = clearance_lengths(crack, surface.box, sizing)
    return sizing if clearance is None else replace(sizing, others=(*sizing.others, clearance))


def void_points(surface: Surface) -> np.ndarray:
    """Return the points (k, 3) of facets that bound enclosed voids."""
    return surface.points[np.unique(surface.facets[(surface.sides < 0).any(axis=1)])]


def touches_box(spheres: np.ndarray, box: np.ndarray) -> np.ndarray:
    """Return a mask (s,) of spheres (s, 4) that intersect or touch the box (2, 3)."""
    low, high = box
    nearest = np.clip(spheres[:, :3], low, high)
    return np.linalg.norm(nearest - spheres[:, :3], axis=1) <= spheres[:, 3]


def _on_sphere(centre: np.ndarray, radius: float, step: float) -> np.ndarray:
    """Return points on a sphere, about `step` apart, along a Fibonacci spiral."""
    count = int(np.clip(np.ceil(4 * np.pi * (radius / step) ** 2), 12, 100_000))
    place = np.arange(count) + 0.5
    height = 1 - 2 * place / count
    turn = np.pi * (1 + np.sqrt(5)) * place
    ring = np.sqrt(1 - height**2)
    return centre + radius * np.stack([ring * np.cos(turn), ring * np.sin(turn), height], axis=1)
