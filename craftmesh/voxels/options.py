"""What is cleaned and made of voxels; apart from the doing, so that a campaign is read without it."""

import math
from dataclasses import dataclass

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.options import Options, option

SMALLEST_RADIUS = 1.5  # voxels; smaller bodies are specks that cleaning absorbs


@dataclass(frozen=True)
class CleanOptions(Options):
    """What to do with unindexed voxels, islands of few voxels, rough boundaries, and grains in pieces."""

    fill_unindexed: bool = option(False, "give voxels without a grain to the grains around them")
    min_island_voxels: int = option(
        0,
        "absorb connected pieces of fewer voxels, small grains and voids included, into a neighbour",
        at_least=0,
    )
    smoothing_rounds: int = option(
        0, "rounds of curvature flow that smooth noisy grain boundaries, volumes kept", at_least=0
    )
    split_pieces: bool = option(
        False, "make each disconnected piece of a grain a grain of its own, with ids after the largest"
    )
    allow_single_grain: bool = option(False, "accept a volume that is one grain throughout")


@dataclass(frozen=True)
class GenerateOptions(Options):
    """A synthetic polycrystal on a grid of voxels."""

    shape: tuple[int, int, int] = option((48, 48, 48), "voxels along x, y, z", at_least=2)
    spacing: tuple[float, float, float] = option(
        (1.0, 1.0, 1.0), "voxel spacing along x, y, z", "model units", above=0
    )
    origin: tuple[float, float, float] = option((0.0, 0.0, 0.0), "lower corner of the box", "model units")
    grains: int = option(30, "number of cells, without embedded grains", at_least=1)
    seed: int = option(0, "seed of all random numbers", at_least=0)
    relaxation: int = option(1, "rounds that move each cell's seed to the cell's centre", at_least=0)
    size_spread: float = option(
        0.0, "spread of grain sizes: 0 a Voronoi, towards 1 a Laguerre tessellation", at_least=0, below=1
    )
    columnar_axis: str = option("z", "axis along which columnar_ratio stretches", choices=("x", "y", "z"))
    columnar_ratio: float = option(
        1.0, "length of the grains along columnar_axis over their width", above=0
    )
    lath_ratio: float = option(
        1.0, "width of the grains over their thickness, along the axis that follows columnar_axis", above=0
    )
    raggedness: float = option(
        0.0, "how far grain boundaries stray from their cells, root mean square", "voxels", at_least=0
    )
    shuffled: float = option(
        0.0, "chance of each voxel to take the grain of a random neighbour", at_least=0, at_most=1
    )
    shuffle_rounds: int = option(1, "how often the voxels are shuffled", at_least=0)
    pores: int = option(
        0, "number of pores of an open-cell foam whose struts the grains fill; 0: no foam", at_least=0
    )
    pore_spread: float = option(0.0, "spread of pore sizes, as size_spread of grains", at_least=0, below=1)
    relative_density: float = option(0.2, "material of the foam over the box", above=0, below=1)
    strut_growth: float = option(
        4.0, "struts thicken within this many of their radii of a node; up to 1: not", at_least=0
    )
    strut_shape: float = option(
        1.0, "where struts thicken: small, webs along the pores' boundaries; large, all round", at_least=0
    )
    cut_ends: str = option(
        "", "axes across whose box faces struts that end there are cut off: x, y, z or several, as in xy"
    )
    voids: int = option(0, "number of spherical voids", at_least=0)
    void_radius: float = option(3.0, "radius of the voids, or of the smallest", "model units", above=0)
    void_radius_max: float = option(
        0.0, "radius of the largest void, uniform between; 0: all alike", "model units", at_least=0
    )
    voids_cross: bool = option(
        False,
        "centres anywhere in the material: voids may cut one another and the surface, and open to the air "
        "there; else enclosed and apart",
    )
    voids_from: str | None = option(
        None, "file of more voids, placed as given: a table as sizing.points takes it"
    )
    embedded_grains: int = option(0, "grains wholly inside another grain, one each", at_least=0)
    embedded_pairs: int = option(0, "pairs of touching grains wholly inside another grain", at_least=0)
    embedded_fraction: float = option(
        0.6, "radius of an embedded body over the room in its host", above=0, below=1
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        voxels = math.prod(self.shape)
        if self.grains > voxels:
            raise CraftmeshError(f"grains is {self.grains}; expected at most the {voxels} voxels of shape")
        if set(self.cut_ends) - set("xyz"):
            raise CraftmeshError(f"cut_ends is {self.cut_ends!r}; expected x, y, z or several, as in xy")
        self._check_voids()

    @property
    def box(self) -> np.ndarray:
        """(2, 3) lower and upper corner of the volume."""
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
