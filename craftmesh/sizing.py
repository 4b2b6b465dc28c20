"""The element-sizing function: target edge lengths from the distance to the defects (paper, Eq. 2-3)."""

from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from craftmesh.connectivity import unique_edges
from craftmesh.errors import CraftmeshError
from craftmesh.options import option
from craftmesh.types import Surface


@dataclass(frozen=True)
class SizingOptions:
    """The numbers of Eq. 3; a None takes its default from l0, and l0 from the surface's median edge."""

    l_min: float | None = option(None, "edge length at the defects; default l0 / 2 (Eq. 3)", "length")
    l0: float | None = option(None, "original edge length; default the median edge (Eq. 3)", "length")
    l_max: float | None = option(None, "edge length far from the defects; default 3 l0 (Eq. 3)", "length")
    r0: float | None = option(None, "refinement-zone radius R_0; default 8 l0 (Eq. 3)", "length")
    r1: float | None = option(None, "transition-zone radius R_1; default 16 l0 (Eq. 3)", "length")
    exponent: float | None = option(None, "power-law exponent a within R_0; default 1 (Eq. 3)")

    def __post_init__(self):
        for item in fields(self):
            value = getattr(self, item.name)
            if value is not None and not np.isfinite(value):
                raise CraftmeshError(f"{item.name} is {value}; expected a finite number")
            if value is not None and value < 0 or value == 0 and item.name not in ("r0", "r1"):
                raise CraftmeshError(f"{item.name} is {value}; expected a number > 0")


@dataclass(frozen=True)
class Sizing:
    """Target edge lengths (Eq. 3) around `sources` (k, 3), the points of crack fronts or void surfaces.

    Without sources the target is l_max everywhere, which coarsens uniformly. Raises CraftmeshError
    when the lengths are not ordered or the sources are not finite.
    """

    l_min: float
    l0: float
    l_max: float
    r0: float
    r1: float
    exponent: float
    sources: np.ndarray

    def __post_init__(self):
        sources = np.array(self.sources, float).reshape(-1, 3)
        if not np.isfinite(sources).all():
            bad = int(np.flatnonzero(~np.isfinite(sources).all(1))[0])
            raise CraftmeshError(f"sources[{bad}] is {sources[bad].tolist()}; expected finite coordinates")
        sources.flags.writeable = False
        object.__setattr__(self, "sources", sources)
        numbers = {k: getattr(self, k) for k in ("l_min", "l0", "l_max", "r0", "r1", "exponent")}
        SizingOptions(**numbers)
        if self.l_min > self.l_max:
            raise CraftmeshError(
                f"l_min is {self.l_min:g}; expected at most l_max, which is {self.l_max:g}"
            )
        if self.r1 < self.r0:
            raise CraftmeshError(f"r1 is {self.r1:g}; expected at least r0, which is {self.r0:g}")

    @cached_property
    def _tree(self) -> cKDTree:
        return cKDTree(self.sources)

    def at(self, points: np.ndarray) -> np.ndarray:
        """Return the (n,) target edge lengths at `points` (n, 3), by Eq. 2 and 3."""
        points = np.asarray(points, float).reshape(-1, 3)
        if not len(self.sources):
            return np.full(len(points), float(self.l_max))
        beyond = self.r1 * (1 + 1e-9) if self.r1 > 0 else np.inf
        distance, _ = self._tree.query(points, distance_upper_bound=beyond)
        return self.at_distance(distance)

    def at_distance(self, r: np.ndarray) -> np.ndarray:
        """Return the target edge lengths (Eq. 3) at distances `r` from the nearest source."""
        r = np.asarray(r, float)
        length = np.full(r.shape, float(self.l_max))
        near = r <= self.r0
        between = (r > self.r0) & (r <= self.r1)
        reach = self.r0 if self.r0 > 0 else 1.0
        length[near] = self.l_min + (self.l0 - self.l_min) * (r[near] / reach) ** self.exponent
        share = (r[between] - self.r0) / max(self.r1 - self.r0, np.finfo(float).tiny)
        length[between] = self.l0 + (self.l_max - self.l0) * share
        return length


def median_edge(surface: Surface) -> float:
    """Return the median edge length of `surface`."""
    edges = unique_edges(surface.facets)[0]
    if not len(edges):
        raise CraftmeshError("the surface has no facets to take l0 from; give l0")
    span = surface.points[edges[:, 1]] - surface.points[edges[:, 0]]
    return float(np.median(np.linalg.norm(span, axis=1)))


def sizing_for(surface: Surface, options: SizingOptions, sources: np.ndarray) -> Sizing:
    """Return the sizing around `sources` (k, 3), with defaults from the median edge of `surface`.

    Raises CraftmeshError, naming the key, when the numbers do not fit each other.
    """
    l0 = median_edge(surface) if options.l0 is None else options.l0
    default = {"l_min": l0 / 2, "l0": l0, "l_max": 3 * l0, "r0": 8 * l0, "r1": 16 * l0, "exponent": 1.0}
    given = {k: getattr(options, k) for k in default if getattr(options, k) is not None}
    if "r1" not in given and "r0" in given:
        default["r1"] = 2 * given["r0"]
    if "r0" not in given and "r1" in given:
        default["r0"] = given["r1"] / 2
    return Sizing(**{k: float(v) for k, v in (default | given).items()}, sources=sources)


def densify(polyline: np.ndarray, step: float) -> np.ndarray:
    """Return `polyline` (n, 3) with points added so that no two neighbours are over `step` apart.

    The given points stay, so the distance to the result is the distance to the polyline within
    step^2 / (8 r). Raises CraftmeshError when `step` is not > 0.
    """
    polyline = np.asarray(polyline, float).reshape(-1, 3)
    if not step > 0:
        raise CraftmeshError(f"step is {step}; expected a length > 0")
    if len(polyline) < 2:
        return polyline.copy()
    span = np.diff(polyline, axis=0)
    parts = np.maximum(np.ceil(np.linalg.norm(span, axis=1) / step).astype(np.int64), 1)
    segment = np.repeat(np.arange(len(span)), parts)
    place = np.arange(len(segment)) - np.repeat(np.cumsum(parts) - parts, parts)
    inner = polyline[segment] + span[segment] * (place / parts[segment])[:, None]
    return np.concatenate([inner, polyline[-1:]])
