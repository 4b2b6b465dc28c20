"""Options for filling the grains with tetrahedra."""

from dataclasses import dataclass
from typing import Literal

from craftmesh.options import Options, option
from craftmesh.tetrahedra.meshers import TETWILD


@dataclass(frozen=True)
class TetrahedralizeOptions(Options):
    """Options of the stage `tetrahedralize`: mesher, its bounds and limits, and optional steps."""

    mesher: str = option(
        "tetgen", "tetgen, tetgen-cli, tetwild (the whole model), or package.module:Class of your own"
    )
    radius_edge_ratio: float = option(1.4, "TetGen's bound on circumradius over shortest edge", at_least=1)
    min_dihedral: float = option(10.0, "TetGen's bound on dihedral angles", "degrees", above=0, below=90)
    switches: str = option("", "the mesher's switches in full, in place of the two bounds above")
    interior_points: bool = option(True, "place points inside the grains by the sizing function (Eq. 3)")
    optimise: bool = option(True, "improve tets inside the grains, then slide points within the surface")
    time_limit: float = option(600.0, "longest time for one attempt at one grain", "s", above=0)
    memory_limit: float = option(16.0, "largest address space that a worker process may add", "GB", above=0)
    repair: bool = option(True, "first move points of facets that intersect or are degenerate")
    fallback: Literal["tetwild", "none"] = option(
        TETWILD,
        "what happens when a grain fails every attempt: the whole model by pytetwild, or an error",
    )
    envelope: float = option(
        0.1, "tetwild moves facets by this at most, in shortest target lengths", above=0
    )
    whole_time_limit: float = option(14400.0, "longest time for tetwild", "s", above=0)

    @property
    def all_switches(self) -> str:
        """The mesher's switches of the first attempt: `switches`, or TetGen's with the two bounds."""
        return self.switches or f"pYq{self.radius_edge_ratio:g}/{self.min_dihedral:g}AQ"
