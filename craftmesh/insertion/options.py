"""Options of the stitch: how near points are joined and how far they may move."""

from dataclasses import dataclass

from craftmesh.options import option


@dataclass(frozen=True)
class StitchOptions:
    """How near points have to be to be joined, and how far the stitch may move them."""

    tolerance: float = option(1e-6, "points closer than this share of the model's diagonal are one")
    snap: float = option(0.2, "points this near the crack move onto it, in local edge lengths; 0: none")
    snap_front: float = option(
        0.3, "trace points this near the front move onto it, in local edge lengths; 0: none"
    )
    max_turn: float = option(40.0, "facets may turn by at most this much when points are moved", "degrees")
