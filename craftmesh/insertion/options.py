"""Options of the insertion: how far points may move onto the crack."""

from dataclasses import dataclass

from craftmesh.options import Options, option
from craftmesh.surface.guarded_move import MoveBounds


@dataclass(frozen=True)
class InsertOptions(Options):
    """How near to the crack points move onto it, and how far facets may turn in such moves."""

    snap: float = option(
        0.2, "distance, in edge lengths, within which points move to the crack; 0: none", at_least=0
    )
    snap_front: float = option(
        0.3, "distance, in edge lengths, within which trace points move to the front; 0: none", at_least=0
    )
    max_turn: float = option(
        40.0,
        "largest angle by which a facet may turn when its points move",
        "degrees",
        at_least=0,
        at_most=180,
    )

    @property
    def bounds(self) -> MoveBounds:
        """Bounds on the change of facets in a move onto the crack."""
        return MoveBounds(turn=self.max_turn)
