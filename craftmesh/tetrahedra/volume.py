"""Tetrahedra of a whole model: grain by grain, then moves of the surface."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from craftmesh.arguments import typed
from craftmesh.errors import CraftmeshError, MeshingError
from craftmesh.progress import silent
from craftmesh.sizing.sizing import Lengths
from craftmesh.tetrahedra.diagnose import GrainFailure
from craftmesh.tetrahedra.fallback import Completion, completed
from craftmesh.tetrahedra.grain_meshing import optimised
from craftmesh.tetrahedra.grain_surface import Mended, grain_surfaces, mended
from craftmesh.tetrahedra.meshers import TETWILD
from craftmesh.tetrahedra.options import TetrahedralizeOptions
from craftmesh.tetrahedra.record import poor_by_grain, record_of, with_counts
from craftmesh.tetrahedra.surface_moves import given_way, slid
from craftmesh.tetrahedra.tetrahedralize import tetrahedralize
from craftmesh.tetrahedra.whole_mesh import Model
from craftmesh.types import GrainTets, Surface
from craftmesh.voxels.islands import Island


@dataclass(frozen=True)
class Volume:
    """Tetrahedra of the grains and the surface that they lie on: the two inputs of `assemble`.

    record: failed attempts and poor tets by grain, as in quality.json (`record_of`); warnings: lines about
    changes of the surface and failed grains; failures: one per failed grain.
    """

    surface: Surface
    grain_tets: Sequence[GrainTets]
    record: dict
    warnings: tuple[str, ...] = ()
    failures: tuple[GrainFailure, ...] = ()

    def warned(self, *texts: str | None) -> "Volume":
        """Return the volume with `texts` as further warnings; None and "" are skipped."""
        return replace(self, warnings=(*self.warnings, *(text for text in texts if text)))


@typed
def mesh_volume(
    surface: Surface,
    sizing: Lengths | None = None,
    options: TetrahedralizeOptions | None = None,
    islands: Sequence[Island] | None = None,
    workers: int = 1,
    progress: Callable[[float, str], None] = silent,
) -> tuple[Volume, dict]:
    """Return the tetrahedra of all grains with their surface, and a report of the grains.

    The surface is repaired where facets intersect, and each grain is filled. Then surface points move along
    the surface to lower the mean aspect ratio, and off the surface at faulty tetrahedra. sizing:
    `at(points)` gives target edge lengths; None uses the surface's edge lengths. islands: see
    `tetrahedralize`. The result does not depend on `workers`. Raises MeshingError, with the record as its
    report, if a grain fails every attempt and the fallback is none or fails too.
    """
    options = options or TetrahedralizeOptions()
    filled, report = fill_grains(surface, sizing, options, islands, None, workers, progress)
    return complete_volume(filled, lambda: sizing, options, progress), report


def fill_grains(
    surface: Surface,
    sizing: Lengths | None,
    options: TetrahedralizeOptions,
    islands: Sequence[Island] | None = None,
    grains: Iterable[int] | None = None,
    workers: int = 1,
    progress: Callable[[float, str], None] = silent,
    cell: float | None = None,
) -> tuple[Volume, dict]:
    """Return the repaired surface with the tetrahedra of `grains` (default: all), and a report.

    The surface is repaired only with options.repair. Grains that fail every attempt have no tetrahedra; the
    record lists them under `left`. With mesher tetwild, which meshes the whole model later, these are all
    grains, and the report is empty. cell: see `tetrahedralize`.
    """
    found = mended(surface) if options.repair else Mended(surface)
    wanted = surface.grains.tolist() if grains is None else list(grains)
    if options.mesher == TETWILD:
        record = record_of(options.mesher, {}, wanted, found.report)
        return Volume(found.surface, (), record).warned(found.warning), {}
    failures: tuple[GrainFailure, ...] = ()
    warning = None
    try:
        tets, report = tetrahedralize(
            found.surface, sizing, options, islands, wanted, workers, progress, cell
        )
    except MeshingError as error:
        tets, report, failures, warning = list(error.done), error.report, error.failures, str(error)
    record = record_of(options.mesher, report, [failure.grain for failure in failures], found.report)
    return Volume(found.surface, tets, record, failures=failures).warned(found.warning, warning), report


def optimised_volume(
    surface: Surface,
    grain_tets: Sequence[GrainTets],
    sizing: Lengths,
    options: TetrahedralizeOptions,
) -> Volume:
    """Return the given tetrahedra of all grains, optimised as `mesh_volume` does with the same options.

    grain_tets: tetrahedra that fill the grains of `surface`, one entry per grain by ascending id. Without
    options.optimise only faulty tetrahedra change. Raises WrongMesh if they do not fill a grain.
    """
    better = list(grain_tets)
    if options.optimise:
        for k, (given, bounds) in enumerate(zip(grain_tets, grain_surfaces(surface), strict=True)):
            nodes = np.concatenate([surface.points[given.nodes], given.interior])
            nodes, tets, _ = optimised(bounds, nodes, given.tets, sizing)
            better[k] = GrainTets(given.grain, given.nodes, nodes[len(given.nodes) :], tets)
    filled = Volume(surface, better, record_of(options.mesher, {}, [], None))
    return complete_volume(filled, lambda: sizing, options)


def complete_volume(
    filled: Volume,
    sizing_of: Callable[[], Lengths | None],
    options: TetrahedralizeOptions,
    progress: Callable[[float, str], None] = silent,
) -> Volume:
    """Return the tetrahedra of all grains after the surface moves of `mesh_volume`.

    filled: all grains of the repaired surface, from any number of chunks. If its record lists grains
    without tetrahedra, the whole model is meshed by pytetwild; only then `sizing_of` is called for the
    sizing. Raises MeshingError if that mesh fails, or if it is needed and options.fallback is none.
    """
    given, record = Completion(filled.surface, filled.grain_tets), filled.record
    try:
        if filled.failures and options.fallback == "none":
            raise CraftmeshError(filled.warnings[-1])
        whole = completed(given, record, sizing_of, options, progress)
    except CraftmeshError as error:
        raise MeshingError(str(error), filled.failures, tuple(filled.grain_tets), record) from None
    model, smooth = Model(whole.surface, sorted(whole.grain_tets, key=lambda one: one.grain)), None
    if options.optimise:
        model, smooth = slid(model)
    opened = given_way(model)
    surface, tets = opened.model.surface, opened.model.grain_tets
    poor: dict[str, list] = dict.fromkeys(record.get("poor", {}), []) | poor_by_grain(opened.model)
    counts = with_counts(record, whole.whole_model, opened.report, smooth, poor)
    volume = replace(filled, surface=surface, grain_tets=tets, record=counts)
    return volume.warned(whole.warning, opened.warning)
