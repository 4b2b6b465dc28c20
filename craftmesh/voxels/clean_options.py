"""What is cleaned in a labelled volume; apart from the cleaning, so that a campaign is read without it."""

from dataclasses import dataclass

from craftmesh.options import Options, option


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
