"""How the grains are filled with tetrahedra."""

from dataclasses import dataclass

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.options import option
from craftmesh.tetrahedra.meshers.base import TETWILD

WHOLE_MODEL = ("envelope", "whole_time_limit")


@dataclass(frozen=True)
class TetrahedralizeOptions:
    """How grains are filled with tetrahedra."""

    mesher: str = option(
        "tetgen", "tetgen, tetgen-cli, tetwild (the whole model), or package.module:Class of your own"
    )
    radius_edge_ratio: float = option(1.4, "TetGen's bound on circumradius over shortest edge")
    min_dihedral: float = option(10.0, "TetGen's bound on dihedral angles", "degrees")
    switches: str = option("", "the mesher's switches in full, in place of the two bounds above")
    interior_points: bool = option(True, "place points inside the grains by the sizing function (Eq. 3)")
    optimise: bool = option(True, "improve the tetrahedra inside the grains; the surface stays")
    time_limit: float = option(600.0, "longest time for one attempt at one grain", "s")
    memory_limit: float = option(16.0, "largest address space of a worker process", "GB")
    repair: bool = option(True, "first move points of facets that intersect or are degenerate")
    fallback: str = option(
        TETWILD,
        "what happens when a grain fails every attempt: the whole model by pytetwild, or an error",
        choices=(TETWILD, "none"),
    )
    envelope: float = option(0.1, "tetwild moves facets by this at most, in shortest target lengths")
    whole_time_limit: float = option(14400.0, "longest time for tetwild", "s")

    def __post_init__(self):
        for name in ("radius_edge_ratio", "min_dihedral", "time_limit", "memory_limit", *WHOLE_MODEL):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise CraftmeshError(f"{name} is {value}; expected a number > 0")
        if self.radius_edge_ratio < 1:
            raise CraftmeshError(f"radius_edge_ratio is {self.radius_edge_ratio:g}; expected at least 1")

    @property
    def all_switches(self) -> str:
        """The switches of the first attempt."""
        return self.switches or f"pYq{self.radius_edge_ratio:g}/{self.min_dihedral:g}AQ"
