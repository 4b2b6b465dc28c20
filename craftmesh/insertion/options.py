"""Options of the insertion: how far points may move onto the crack."""

from dataclasses import dataclass

from craftmesh.options import Options, option
from craftmesh.surface.guarded_move import MoveBounds


@dataclass(frozen=True)
class InsertOptions(Options):
    """How near to the crack points move onto it, and how far facets may turn with them."""

    snap: float = option(
        0.2, "points this near the crack move onto it, in local edge lengths; 0: none", at_least=0
    )
    snap_front: float = option(
        0.3, "trace points this near the front move onto it, in local edge lengths; 0: none", at_least=0
    )
    max_turn: float = option(
        40.0,
        "facets may turn by at most this much when points are moved",
        "degrees",
        at_least=0,
        at_most=180,
    )

    @property
    def bounds(self) -> MoveBounds:
        """What a move onto the crack may do to facets."""
        return MoveBounds(turn=self.max_turn)
