"""Options of the integrals along a front."""

from dataclasses import dataclass

from craftmesh.options import Options, option

# Smallest radius of the tube in edges of the front. With smaller radii K errs by 0.2 to 0.5 % more, up to
# 1.7 % at single nodes.
LEAST_RADIUS = 2.5
# Shortest spline piece in edges of the front; the mesh has no information within an edge.
LEAST_PIECES = 1.0


@dataclass(frozen=True)
class FractureOptions(Options):
    """Options of the parameters K, J and T along a crack front."""

    radius: float = option(
        4.0,
        "radius of the integration domain where there is room, in edges of the front; else down to 2.5",
        at_least=LEAST_RADIUS,
        at_most=12,
    )
    knots: float = option(
        4.0,
        "length of the spline pieces fitted to K, in edges of the front; in crystals 1.5 times this",
        at_least=LEAST_PIECES,
        at_most=100,
    )
    probe: float | None = option(
        None,
        "radius at which the stress around the front is probed, in edges of the front; none: no probe",
        above=0,
        at_most=12,
    )
