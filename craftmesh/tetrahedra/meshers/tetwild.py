"""fTetWild (the PyPI package `pytetwild`, MPL-2.0), which takes any facets and moves them a little."""

from dataclasses import dataclass

import numpy as np

from craftmesh.tetrahedra.meshers.base import MesherRefusal

# fTetWild stops to improve the mesh at this energy; 3 is that of the regular tetrahedron.
STOP_ENERGY = 10.0


@dataclass(frozen=True)
class TetWildTask:
    """Facets (m, 3) on points to mesh, with target edge lengths (b,) on the points of background tets.

    envelope: largest distance of the mesh's facets from those given, in model units.
    """

    points: np.ndarray
    facets: np.ndarray
    background_points: np.ndarray
    background_tets: np.ndarray
    lengths: np.ndarray
    envelope: float


def tetwild(_: None, task: TetWildTask) -> tuple[np.ndarray, np.ndarray]:
    """Return (points, tets) that fill a box round the facets and follow them; for a worker process.

    The tets (t, 4) int64 have volumes >= 0. Nothing says which of their faces lie on the facets. It
    shuffles by a random device that cannot be seeded, so no two meshes of the same input are the same.
    """
    import pytetwild

    diagonal = np.linalg.norm(np.ptp(task.points, axis=0))
    points, tets = pytetwild.tetrahedralize(
        np.array(task.points, np.float64),
        np.array(task.facets, np.int32),
        edge_length_abs=float(task.lengths.max()),
        epsilon=float(task.envelope / diagonal),
        stop_energy=STOP_ENERGY,
        simplify=False,
        num_threads=1,
        disable_filtering=True,
        quiet=True,
        bg_vertices=np.array(task.background_points, np.float64),
        bg_tets=np.array(task.background_tets, np.int32),
        bg_values=np.array(task.lengths, np.float64),
    )
    if not len(tets):
        raise MesherRefusal("pytetwild made no tetrahedra")
    # its tets turn the other way round
    return np.asarray(points, float), np.asarray(tets, np.int64)[:, [0, 2, 1, 3]]
