"""What to integrate along a front."""

from dataclasses import dataclass

from craftmesh.options import Options, option

# Below it K errs by 0.2-0.5 % more, up to 1.7 % at single nodes.
LEAST_RADIUS = 2.5
# The front's edges, between which there is nothing to find.
LEAST_PIECES = 1.0


@dataclass(frozen=True)
class FractureOptions(Options):
    """How the parameters along a crack's front are found."""

    radius: float = option(
        4.0,
        "radius of the integrals where there is room, in edges of the front; 2.5 where there is none",
        at_least=LEAST_RADIUS,
        at_most=12,
    )
    knots: float = option(
        4.0,
        "pieces of the splines fitted to K, in edges of the front; in crystals half as long again",
        at_least=LEAST_PIECES,
        at_most=100,
    )
    probe: float | None = option(
        None,
        "radius at which the tangential stress round the front is probed, in edges of the front; none: not",
        above=0,
        at_most=12,
    )
