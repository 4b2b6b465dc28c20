"""Fill each grain with tetrahedra by its own call of a mesher, in worker processes that may fail."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np

from craftmesh.arguments import typed
from craftmesh.errors import MeshingError
from craftmesh.processes.job import Job, Limits
from craftmesh.processes.worker import run_tasks
from craftmesh.progress import silent
from craftmesh.sizing.sizing import Lengths
from craftmesh.tetrahedra.grain_meshing import Setting, mesh_grain
from craftmesh.tetrahedra.grain_surface import GrainSurface, grain_surfaces
from craftmesh.tetrahedra.interior_points import lattice_cell
from craftmesh.tetrahedra.meshers import BUILT_IN, load_mesher
from craftmesh.tetrahedra.meshing_attempts import Attempt, Ladder, MeshingTask, attempts
from craftmesh.tetrahedra.options import TetrahedralizeOptions
from craftmesh.types import GrainTets, Surface
from craftmesh.voxels.islands import Island


@typed
def tetrahedralize(
    surface: Surface,
    sizing: Lengths | None = None,
    options: TetrahedralizeOptions | None = None,
    islands: Sequence[Island] | None = None,
    grains: Iterable[int] | None = None,
    workers: int = 1,
    progress: Callable[[float, str], None] = silent,
    cell: float | None = None,
) -> tuple[list[GrainTets], dict]:
    """Return the tetrahedra of each grain (default: all) by ascending id, and a report.

    The surface is kept: all facets, crack facets inside grains included, are faces of tetrahedra, and
    its nodes keep every bit. sizing: `at(points)` gives target edge lengths (paper, Eq. 3); None uses
    the surface's edge lengths. islands: voids and grains within grains, with seeds (points inside
    them); a seed outside its island is replaced. cell: edge of the first cells of the interior points'
    lattice; None: `lattice_cell` of the surface's box. The result does not depend on `workers`. The
    report is described in `Ladder.report`. Raises MeshingError, with the tets of the other grains, if
    a grain fails in every attempt, and CraftmeshError for unknown grains or an unknown mesher.
    """
    options = options or TetrahedralizeOptions()
    load_mesher(options.mesher)
    tried = attempts(options.all_switches, options.interior_points)
    ladder = Ladder(tried, grain_surfaces(surface, grains), options.mesher in BUILT_IN, progress)
    limits = Limits(options.time_limit, options.memory_limit)
    if sizing is not None:
        cell = cell or lattice_cell(surface.box, sizing)
    job = Job(mesh_grain, Setting(options, sizing, cell), limits, load_kernels)
    run_tasks(job, ladder.tasks(islands or ()), ladder, workers)
    result, report, failures = ladder.grain_tets(), ladder.report(), ladder.failed()
    if failures:
        more = f" ({len(failures)} grains in all)" if len(failures) > 1 else ""
        what = "; repair the surface there (craftmesh check names its breaches)"
        raise MeshingError(failures[0].sentence() + more + what, failures, tuple(result), report)
    return result, report


class FanMesher:
    """A mesher of convex surfaces, for `load_kernels`: tetrahedra join the facets to one point inside."""

    def mesh(
        self, points: np.ndarray, facets: np.ndarray, *_others: object
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return nodes (n + 1, 3) and tets (m, 4) for points (n, 3) and facets (m, 3)."""
        centre = np.full(len(facets), len(points))
        return np.vstack([points, points.mean(axis=0)]), np.column_stack([facets[:, [0, 2, 1]], centre])


def load_kernels(setting: Setting) -> None:
    """Mesh a small cube with FanMesher to load all kernels; a real mesher prints and may crash."""
    options = replace(setting.options, mesher=f"{__name__}:FanMesher", interior_points=True, optimise=True)
    corners = np.stack(np.meshgrid([0.0, 1.0], [0.0, 1.0], [0.0, 1.0], indexing="ij"), -1).reshape(-1, 3)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    facets = np.array([[q[i] for i in half] for q in quads for half in ((0, 1, 2), (0, 2, 3))], np.int64)
    cube = GrainSurface(1, np.arange(8), corners, facets, np.zeros(12, bool), np.arange(12))
    mesh_grain(Setting(options, None), MeshingTask(cube, np.zeros((0, 3)), Attempt("", True)))


def grains_of_chunk(surface: Surface, part: int, parts: int) -> list[int]:
    """Return the sorted grain ids of chunk `part` (1 to `parts`); all chunks have about as many facets."""
    labels, facets = np.unique(surface.sides, return_counts=True)
    facets, labels = facets[labels > 0], labels[labels > 0]
    load = np.zeros(parts, np.int64)
    mine = []
    for index in np.argsort(-facets, kind="stable"):
        lightest = int(np.argmin(load))
        load[lightest] += facets[index]
        if lightest == part - 1:
            mine.append(int(labels[index]))
    return sorted(mine)
