"""Options for cleaning and generating voxels, in their own module so that campaigns import no more."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.options import Options, option

SMALLEST_RADIUS = 1.5  # voxels, smallest radius of voids and embedded grains; cleaning may absorb others


@dataclass(frozen=True)
class CleanOptions(Options):
    """How to clean unindexed voxels, islands of few voxels, rough boundaries, and grains in pieces."""

    fill_unindexed: bool = option(False, "give voxels without a grain to the grains around them")
    min_island_voxels: int = option(
        0,
        "connected pieces with fewer voxels, also whole grains and voids, are given to a neighbour",
        at_least=0,
    )
    smoothing_rounds: int = option(
        0, "iterations of curvature flow that smooths noisy boundaries at constant volume", at_least=0
    )
    split_pieces: bool = option(
        False, "make each disconnected piece of a grain a new grain, with ids after the largest"
    )
    allow_single_grain: bool = option(False, "accept a volume that consists of one grain")


@dataclass(frozen=True)
class GenerateOptions(Options):
    """A synthetic polycrystal on a grid of voxels."""

    shape: tuple[int, int, int] = option((48, 48, 48), "voxels along x, y, z", at_least=2)
    spacing: tuple[float, float, float] = option(
        (1.0, 1.0, 1.0), "voxel spacing along x, y, z", "model units", above=0
    )
    origin: tuple[float, float, float] = option((0.0, 0.0, 0.0), "lower corner of the box", "model units")
    grains: int = option(30, "number of grains, not counting embedded grains", at_least=1)
    seed: int = option(0, "seed of all random numbers", at_least=0)
    relaxation: int = option(1, "iterations that move each grain's seed to the grain's centre", at_least=0)
    size_spread: float = option(
        0.0, "spread of grain sizes; 0: Voronoi, larger: Laguerre tessellation", at_least=0, below=1
    )
    columnar_axis: Literal["x", "y", "z"] = option("z", "axis along which columnar_ratio stretches")
    columnar_ratio: float = option(
        1.0, "ratio of the grains' length along columnar_axis to their width", above=0
    )
    lath_ratio: float = option(
        1.0, "ratio of the grains' width to their thickness along the axis after columnar_axis", above=0
    )
    raggedness: float = option(
        0.0, "root mean square deviation of ragged grain boundaries from smooth ones", "voxels", at_least=0
    )
    shuffled: float = option(
        0.0, "probability that a voxel gets the grain of a random neighbour (noise)", at_least=0, at_most=1
    )
    shuffle_rounds: int = option(1, "number of times that `shuffled` is applied", at_least=0)
    pores: int = option(
        0, "number of pores of an open-cell foam, whose struts contain the grains; 0: no foam", at_least=0
    )
    pore_spread: float = option(0.0, "spread of pore sizes, as size_spread of grains", at_least=0, below=1)
    relative_density: float = option(0.2, "volume fraction of material in the foam", above=0, below=1)
    strut_growth: float = option(
        4.0, "struts thicken within this distance of a node, in strut radii; up to 1: nowhere", at_least=0
    )
    strut_shape: float = option(
        1.0, "shape of thickened struts: small: webs between pores; large: thicker on all sides", at_least=0
    )
    cut_ends: str = option(
        "", "remove struts that end at box faces normal to these axes: x, y, z or several, such as xy"
    )
    voids: int = option(0, "number of spherical voids", at_least=0)
    void_radius: float = option(3.0, "radius of the voids, or smallest radius", "model units", above=0)
    void_radius_max: float = option(
        0.0, "largest radius, uniformly distributed; 0: all equal", "model units", at_least=0
    )
    voids_cross: bool = option(
        False,
        "place void centres anywhere in the material, so that voids may overlap or be open at the surface; "
        "otherwise voids are enclosed and separate",
    )
    voids_from: str | None = option(
        None, "file of further voids at given places, in a format of sizing.points"
    )
    embedded_grains: int = option(0, "number of grains completely inside another grain", at_least=0)
    embedded_pairs: int = option(0, "number of touching pairs completely inside another grain", at_least=0)
    embedded_fraction: float = option(
        0.6, "ratio of an embedded body's radius to the largest that fits", above=0, below=1
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        voxels = math.prod(self.shape)
        if self.grains > voxels:
            raise CraftmeshError(f"grains is {self.grains}; expected at most {voxels}, the voxels of shape")
        if set(self.cut_ends) - set("xyz"):
            raise CraftmeshError(f"cut_ends is {self.cut_ends!r}; expected x, y, z or several, such as xy")
        self._check_voids()

    @property
    def box(self) -> np.ndarray:
        """Lower and upper corner of the volume (2, 3)."""
        return np.array(self.origin) + [[0.0] * 3, np.multiply(self.shape, self.spacing)]

    def _check_voids(self) -> None:
        least = SMALLEST_RADIUS * max(self.spacing)
        if self.voids and self.void_radius < least:
            raise CraftmeshError(
                f"void_radius is {self.void_radius:g}; expected at least {SMALLEST_RADIUS} voxels, "
                f"{least:g}"
            )
        if self.void_radius_max and self.void_radius_max < self.void_radius:
            raise CraftmeshError(
                f"void_radius_max is {self.void_radius_max:g}; expected at least void_radius, "
                f"{self.void_radius:g}"
            )
