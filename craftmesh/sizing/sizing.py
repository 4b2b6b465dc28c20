"""The element-sizing function: target edge lengths by distance to defects (gradation paper, Eq. 2-3)."""

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, runtime_checkable

import numpy as np
import scipy

from craftmesh.arguments import Frozen, as_array, refuse_unlike, typed
from craftmesh.errors import CraftmeshError
from craftmesh.options import Options, option
from craftmesh.sizing.length_field import LengthField, curvature_lengths
from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.measure import edge_lengths
from craftmesh.types import Surface, Voxels


@runtime_checkable
class Lengths(Protocol):
    """Target edge lengths as a function of position: a `Sizing` (Eq. 3), a LengthField or a LocalSizing."""

    def at(self, points: np.ndarray) -> np.ndarray:
        """Return the target edge lengths (n,), in model units, at points (n, 3)."""
        ...


# Growth per distance of lengths from curvature and clearance, if options.gradation gives no limit.
FREE_GROWTH = 0.5
# Largest growth per distance of lengths by Eq. 3, if options.gradation gives no limit: an edge is at most
# twice as long as its neighbour.
STEEPEST = 1.0


@dataclass(frozen=True)
class SizingOptions(Options):
    """The numbers of Eq. 3 and where to refine; None stands for the default, which depends on l0.

    The default of l0 is the surface's median edge; in a campaign it is the voxel's edge.
    """

    l_min: float | None = option(
        None, "edge length at the defects; default l0 / 2 (Eq. 3)", "model units", above=0
    )
    l0: float | None = option(
        None,
        "original edge length; default: voxel edge in a campaign, else the median edge (Eq. 3)",
        "model units",
        above=0,
    )
    l_max: float | None = option(
        None, "edge length far from the defects; default 3 l0 (Eq. 3)", "model units", above=0
    )
    r0: float | None = option(
        None, "refinement-zone radius R_0; default 8 l0 (Eq. 3)", "model units", at_least=0
    )
    r1: float | None = option(
        None, "transition-zone radius R_1; default 16 l0 (Eq. 3)", "model units", at_least=0
    )
    exponent: float | None = option(None, "power-law exponent a within R_0; default 1 (Eq. 3)", above=0)
    gradation: float | None = option(
        None, "largest ratio of neighbouring edges' lengths; default 2; large values: no limit", above=1
    )
    curvature: float | None = option(
        None, "largest turn of the surface along one edge; default: not limited", "degrees", above=0
    )
    points: str | None = option(
        None, "CSV file of more points to refine around: x,y,z, voids id,x,y,z,r, or Avizo's pore table"
    )
    field: str | None = option(
        None, "file (.vtp or .vti) with upper bounds of target lengths at its points or cells"
    )
    field_array: str = option("length", "name of the array of lengths in that file")
    around_voids: bool = option(False, "refine around the enclosed voids as well")

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.l_min is not None and self.l_max is not None and self.l_min > self.l_max:
            raise CraftmeshError(
                f"l_min is {self.l_min:g}; expected at most l_max, which is {self.l_max:g}"
            )
        if self.r0 is not None and self.r1 is not None and self.r1 < self.r0:
            raise CraftmeshError(f"r1 is {self.r1:g}; expected at least r0, which is {self.r0:g}")

    @property
    def growth(self) -> float | None:
        """Largest growth of lengths per distance, gradation - 1; None if gradation is not given."""
        return None if self.gradation is None else self.gradation - 1


@dataclass(frozen=True)
class Sizing(Frozen):
    """Target edge lengths (Eq. 3) around `sources` (k, 3), the points of crack fronts or void surfaces.

    At a distance r from the nearest source, Eq. 3 is l_min + (l0 - l_min) (r / r0)^exponent up to r0. From
    there it goes linearly to l_max at r1. Without sources it is l_max everywhere, which coarsens uniformly.
    growth: largest growth of lengths per distance; None: STEEPEST. others: objects with `at(points)`, such
    as another Sizing or a LengthField; the smallest of all lengths counts, and their own growth limits
    apply. Raise CraftmeshError if l_min > l_max, if r0 > r1, or if the sources are not finite.
    """

    l_min: float
    l0: float
    l_max: float
    r0: float
    r1: float
    exponent: float
    sources: np.ndarray
    growth: float | None = None
    others: tuple[Lengths, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "sources", as_array("sources", self.sources, float, (None, 3)))
        numbers = {k: getattr(self, k) for k in ("l_min", "l0", "l_max", "r0", "r1", "exponent")}
        for name, value in numbers.items():
            as_array(name, value, float, ())
        SizingOptions(**numbers)
        if self.growth is not None and not as_array("growth", self.growth, float, ()) > 0:
            raise CraftmeshError(f"growth is {self.growth}; expected a finite number > 0, or None")
        refuse_unlike("others", self.others, tuple[Lengths, ...])

    def __repr__(self) -> str:
        numbers = ", ".join(
            f"{name} {getattr(self, name):.6g}" for name in ("l_min", "l0", "l_max", "r0", "r1")
        )
        others = f", {len(self.others)} further lengths" * bool(self.others)
        return f"Sizing({numbers}, {len(self.sources)} sources{others})"

    @cached_property
    def _tree(self) -> "scipy.spatial.cKDTree":
        return scipy.spatial.cKDTree(self.sources)

    @property
    def limit(self) -> float:
        """Largest growth of lengths per distance."""
        return STEEPEST if self.growth is None else self.growth

    def at(self, points: np.ndarray) -> np.ndarray:
        """Return target edge lengths (n,) at `points` (n, 3): the smallest of Eq. 2-3 and all `others`."""
        points = as_array("points", points, float, (None, 3))
        length = np.full(len(points), float(self.l_max))
        if len(self.sources):
            reach = self.r1 + (self.l_max - self.l_min) / self.limit
            beyond = reach * (1 + 1e-9) if reach > 0 else np.inf
            length = self.at_distance(self._tree.query(points, distance_upper_bound=beyond)[0])
        for other in self.others:
            length = np.minimum(length, other.at(points))
        return length

    def at_distance(self, r: np.ndarray) -> np.ndarray:
        """Return target edge lengths at distances `r` from the nearest source: Eq. 3 with limited growth.

        The length is the minimum of L(s) + limit (r - s) over s <= r, where L is Eq. 3. This is the largest
        function below Eq. 3 that grows no faster than the limit.
        """
        r = np.asarray(r, float)
        length = self._equation_3(r)
        for s in self._steepest():
            start = self._equation_3(np.array([s]))[0]
            length = np.where(r >= s, np.minimum(length, start + self.limit * (r - s)), length)
        return length

    def _steepest(self) -> list[float]:
        """Return the distances at which Eq. 3 can begin to grow faster than the limit."""
        marks = [0.0, self.r0, self.r1]
        rise = self.l0 - self.l_min
        if self.exponent > 1 and rise > 0 and self.r0 > 0:
            share = min(self.limit * self.r0 / (self.exponent * rise), 1.0)
            marks.append(self.r0 * share ** (1 / (self.exponent - 1)))
        return marks

    def _equation_3(self, r: np.ndarray) -> np.ndarray:
        length = np.full(r.shape, float(self.l_max))
        near = r <= self.r0
        between = (r > self.r0) & (r <= self.r1)
        reach = self.r0 if self.r0 > 0 else 1.0
        length[near] = self.l_min + (self.l0 - self.l_min) * (r[near] / reach) ** self.exponent
        share = (r[between] - self.r0) / max(self.r1 - self.r0, np.finfo(float).tiny)
        length[between] = self.l0 + (self.l_max - self.l0) * share
        return length


def median_edge(surface: Surface) -> float:
    """Return the median edge length of `surface`; raise CraftmeshError if it has no facets."""
    edges = unique_edges(surface.facets)[0]
    if not len(edges):
        raise CraftmeshError("the surface has no facets to take l0 from; give l0")
    return float(np.median(edge_lengths(surface.points, edges)))


def voxel_edge(voxels: Voxels) -> float:
    """Return the edge length of a cube with a voxel's volume, in model units."""
    return float(np.cbrt(voxels.spacing.prod()))


@typed
def sizing_for(
    surface: Surface | None, sources: np.ndarray, options: SizingOptions, others: tuple[Lengths, ...] = ()
) -> Sizing:
    """Return the sizing around `sources` (k, 3), with defaults from the median edge of `surface`.

    others: further sizings and LengthFields, of which the smallest length counts; LengthFields get the
    growth limit of options.gradation. The caller reads the files options.points and options.field. Without
    a surface, l0 must be given, and curvature is ignored. Raise CraftmeshError, naming the key, if the
    numbers are inconsistent.
    """
    l0 = _original_length(surface, options)
    default = {"l_min": l0 / 2, "l0": l0, "l_max": 3 * l0, "r0": 8 * l0, "r1": 16 * l0, "exponent": 1.0}
    given = {k: getattr(options, k) for k in default if getattr(options, k) is not None}
    if "r1" not in given and "r0" in given:
        default["r1"] = 2 * given["r0"]
    if "r0" not in given and "r1" in given:
        default["r0"] = given["r1"] / 2
    numbers = {k: float(v) for k, v in (default | given).items()}
    growth = options.growth
    if options.curvature is not None and surface is not None:
        free = FREE_GROWTH if growth is None else growth
        others = (*others, curvature_lengths(surface, options.curvature, numbers["l_min"], free))
    if growth is not None:
        others = tuple(o.limited(growth) if isinstance(o, LengthField) else o for o in others)
    return Sizing(**numbers, sources=sources, growth=growth, others=tuple(others))


def _original_length(surface: Surface | None, options: SizingOptions) -> float:
    if options.l0 is not None:
        return options.l0
    if surface is None:
        raise CraftmeshError("l0 is missing; give it, or a surface, whose median edge is the default")
    return median_edge(surface)


def densify(polyline: np.ndarray, step: float) -> np.ndarray:
    """Return `polyline` (n, 3) with points added so that neighbours are at most `step` apart.

    The given points stay, so the distance r of a place from the result is that from the polyline within
    step^2 / (8 r). Raise CraftmeshError if `polyline` is not an array (n, 3) or `step` is not > 0.
    """
    polyline = as_array("polyline", polyline, float, (None, 3))
    if not as_array("step", step, float, ()) > 0:
        raise CraftmeshError(f"step is {step}; expected a length > 0")
    if len(polyline) < 2:
        return polyline
    span = np.diff(polyline, axis=0)
    parts = np.maximum(np.ceil(np.linalg.norm(span, axis=1) / step).astype(np.int64), 1)
    segment = np.repeat(np.arange(len(span)), parts)
    place = np.arange(len(segment)) - np.repeat(np.cumsum(parts) - parts, parts)
    inner = polyline[segment] + span[segment] * (place / parts[segment])[:, None]
    return np.concatenate([inner, polyline[-1:]])


# Cells per l_min along each axis; each cell keeps only its shortest length.
CELLS = 2
# Edge length in a narrow gap, as between a crack and a face, in widths of the gap. With 3, twice as many
# tets have an aspect ratio over 5 in kinked discs next to a face.
PER_WIDTH = 2.5


def where_short(places: np.ndarray, lengths: np.ndarray, sizing: Sizing) -> LengthField | None:
    """Return lengths (k,) at places (k, 3) as a field where they are below the sizing's; None if nowhere.

    Each cell of l_min / CELLS keeps only its shortest length. Lengths are in model units, and grow by
    sizing.growth per distance, or FREE_GROWTH if that is None.
    """
    short = np.flatnonzero(lengths < sizing.l_max)
    short = short[lengths[short] < sizing.at(places[short])]
    if not len(short):
        return None
    short = short[np.argsort(lengths[short], kind="stable")]
    cells = np.floor((places[short] - places[short].min(axis=0)) * (CELLS / sizing.l_min))
    short = short[np.unique(cells, axis=0, return_index=True)[1]]
    growth = FREE_GROWTH if sizing.growth is None else sizing.growth
    return LengthField(places[short], lengths[short]).limited(growth)
