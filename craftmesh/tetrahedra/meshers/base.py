"""What a tetrahedral mesher has to do, and how one is found by name."""

from typing import Protocol

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.options import own_code

BUILT_IN = {
    "tetgen": "craftmesh.tetrahedra.meshers.tetgen:TetGenMesher",
    "tetgen-cli": "craftmesh.tetrahedra.meshers.tetgen_program:TetGenProgram",
}
# Not a mesher of single grains: `tetrahedra/whole/` meshes all of them at once with it.
TETWILD = "tetwild"


class MesherRefusal(Exception):
    """A mesher's own reason for not meshing a surface."""


class Mesher(Protocol):
    """A mesher of one closed surface that keeps the surface as it is."""

    def mesh(
        self,
        points: np.ndarray,
        facets: np.ndarray,
        markers: np.ndarray,
        interior_points: np.ndarray,
        holes: np.ndarray,
        switches: str,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return (points, tets) with the input points first, in order and bit for bit.

        points (n, 3); facets (m, 3) boundary and internal facets, all kept; markers (m,) > 0;
        interior_points (k, 3) become vertices after `points`; holes (h, 3) seeds in regions to leave
        empty; switches: the mesher's own language. The tets (t, 4) int64 have positive volumes (corners
        1, 2, 3 turn right-handed towards corner 4). Raises MesherRefusal.
        """
        ...


def load_mesher(name: str) -> Mesher:
    """Return the mesher called `name`: a built-in one, or `package.module:Class` of another."""
    made = own_code("mesher", BUILT_IN.get(name, name), (*BUILT_IN, TETWILD))
    try:
        return made()
    except TypeError as error:
        raise CraftmeshError(f"mesher {name!r}: {error}; expected a class without arguments") from error


def check_mesher(name: str) -> None:
    """Raise CraftmeshError unless `name` is a mesher; programs are looked for where grains are meshed."""
    if name not in (*BUILT_IN, TETWILD) and not callable(getattr(load_mesher(name), "mesh", None)):
        raise CraftmeshError(f"mesher {name!r} has no method mesh; see craftmesh.tetrahedra.meshers.base")
