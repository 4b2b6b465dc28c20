"""Options of the renewal."""

from dataclasses import dataclass
from typing import Literal

from craftmesh.options import Options, option


@dataclass(frozen=True)
class RenewOptions(Options):
    """Options that decide whether an increment's mesh is the mesh before with a renewed part."""

    reuse: Literal["never", "auto", "always"] = option(
        "never",
        "whether an increment keeps the elements of the one before that its crack does not change: never, "
        "where less than most_renewed changes (auto), or always",
    )
    most_renewed: float = option(
        0.5,
        "largest share of the elements that auto renews; above it the mesh is made from scratch",
        above=0,
    )
