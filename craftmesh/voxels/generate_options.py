"""A synthetic polycrystal in numbers; apart from its making, so that a campaign is read without it."""

import math
from dataclasses import dataclass

from craftmesh.errors import CraftmeshError
from craftmesh.options import Options, option

SMALLEST_RADIUS = 1.5  # voxels; smaller bodies are specks that cleaning absorbs


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
    voids: int = option(0, "number of enclosed spherical voids", at_least=0)
    void_radius: float = option(3.0, "radius of the voids", "model units", above=0)
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
        least = SMALLEST_RADIUS * max(self.spacing)
        if self.voids and self.void_radius < least:
            raise CraftmeshError(
                f"void_radius is {self.void_radius:g}; expected at least {SMALLEST_RADIUS} voxels, "
                f"{least:g}"
            )
