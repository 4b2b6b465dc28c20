"""A table of faces tried on a cube: what is wrong with it in every body, known before there is a mesh."""

from collections.abc import Sequence

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.faces import FaceRow
from craftmesh.mechanics.load import load_on
from craftmesh.mesh.mesh_sets import node_sets_of
from craftmesh.mesh.tet_connectivity import FACE_CORNERS
from craftmesh.types import BOX_PLANES, TetMesh

# Corners 0 to 7 of a cube, x fastest, and its tetrahedra along the diagonal.
_CORNERS = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
_TETS = np.array(
    [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]], np.int32
)


def check_faces(rows: Sequence[FaceRow]) -> None:
    """Raise CraftmeshError for rows that `load_on` refuses on a cube of edge 1."""
    try:
        load_on(_cube(), rows)
    except CraftmeshError as error:
        raise CraftmeshError(
            f"faces, tried on a cube of edge 1: {str(error).removeprefix('load: ')}"
        ) from None


def _cube() -> TetMesh:
    corners = _CORNERS[_TETS[:, FACE_CORNERS]]
    face_sets = {
        plane: np.argwhere((corners[..., number // 2] == number % 2).all(axis=2))
        for number, plane in enumerate(BOX_PLANES)
    }
    grain = np.ones(len(_TETS), np.int32)
    return TetMesh(_CORNERS, _TETS, grain, node_sets_of(_TETS, face_sets, []), face_sets)
