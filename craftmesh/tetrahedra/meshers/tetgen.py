"""TetGen behind the mesher's interface (the PyPI package `tetgen`, AGPL-3.0)."""

import numpy as np

from craftmesh.tetrahedra.meshers.base import MesherRefusal


class TetGenMesher:
    """TetGen 1.6; it prints, holds the GIL and may crash, so it belongs in a worker process."""

    def mesh(
        self,
        points: np.ndarray,
        facets: np.ndarray,
        markers: np.ndarray,
        interior_points: np.ndarray,
        holes: np.ndarray,
        switches: str,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Mesh as `Mesher` promises."""
        import tetgen

        everything = np.concatenate([points, interior_points]) if len(interior_points) else points
        try:
            plc = tetgen.TetGen(
                np.ascontiguousarray(everything, np.float64),
                np.ascontiguousarray(facets, np.int32),
                np.ascontiguousarray(markers, np.int32),
            )
            for seed in holes:
                plc.add_hole([float(x) for x in seed])
            nodes, tets, *_ = plc.tetrahedralize(switches=switches)
        except RuntimeError as error:
            raise MesherRefusal(str(error) or "TetGen failed") from error
        if not len(tets):
            raise MesherRefusal("TetGen made no tetrahedra")
        return np.asarray(nodes), np.asarray(tets, np.int64)
