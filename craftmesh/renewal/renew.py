"""The mesh of the next increment: the mesh before with a renewed part, or else a mesh made from scratch.

This is the one module of the package that calls other stages.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from craftmesh.arguments import typed
from craftmesh.assembly.assemble import assemble
from craftmesh.errors import CraftmeshError
from craftmesh.gradation.gradate import GradateOptions, gradate
from craftmesh.insertion.insert import insert_crack
from craftmesh.insertion.options import InsertOptions
from craftmesh.mesh.mesh_sets import NEW
from craftmesh.mesh.shape_measures import is_flat, is_poor, shape_measures
from craftmesh.progress import silent
from craftmesh.renewal.cut_out import cut_out, tets_of
from craftmesh.renewal.numbering import NumberMap, renumbered
from craftmesh.renewal.options import RenewOptions
from craftmesh.renewal.put_back import put_back
from craftmesh.renewal.region import changed_tets, widened
from craftmesh.renewal.whole import Whole, grain_tets_of, whole_of_mesh
from craftmesh.sizing.sizing import Sizing
from craftmesh.surface.measure import volumes_of
from craftmesh.tetrahedra.interior_points import lattice_cell
from craftmesh.tetrahedra.options import TetrahedralizeOptions
from craftmesh.tetrahedra.volume import fill_grains, mesh_volume, optimised_volume
from craftmesh.types import CRACK, Crack, Surface, TetMesh
from craftmesh.voxels.islands import Island


@dataclass(frozen=True)
class StageOptions:
    """The options of the stages that make a mesh (insert, gradate, tetrahedralize), and of the renewal."""

    renew: RenewOptions = field(default_factory=RenewOptions)
    insert: InsertOptions = field(default_factory=InsertOptions)
    gradate: GradateOptions = field(default_factory=GradateOptions)
    tetrahedralize: TetrahedralizeOptions = field(default_factory=TetrahedralizeOptions)


# Largest rise of the mean aspect ratio over that of the last mesh made from scratch, beyond which the next
# mesh is made from scratch.
MOST_RISE = 0.03


class History(NamedTuple):
    """What the next increment needs to know about a mesh.

    lengths (n,): target lengths that the nodes were made for; aspect_ratio: mean aspect ratio of the last
    mesh that was made from scratch; cell: edge of the first cells of its lattice of interior points.
    """

    lengths: np.ndarray
    aspect_ratio: float
    cell: float


def history_of(mesh: TetMesh, sizing: Sizing) -> History:
    """Return the history of a mesh that was made from scratch for a sizing."""
    return History(sizing.at(mesh.points), mean_aspect_ratio(mesh), lattice_cell(mesh.box, sizing))


def mean_aspect_ratio(mesh: TetMesh) -> float:
    """Return the mean aspect ratio of a mesh's elements."""
    return float(shape_measures(mesh.points, mesh.tets)[:, 1].mean())


@dataclass(frozen=True)
class Renewed:
    """The mesh of an increment, and its history for the next one.

    The mesh has the element set NEW. numbers: rows of the nodes and elements of the mesh before in this
    mesh. report: as of `assemble`, with `meshing` (record of the grains) and `renewed`: share, the fraction
    of the elements before that changed; elements_kept; and from_scratch, the reason if none are kept.
    """

    mesh: TetMesh
    history: History
    numbers: NumberMap
    report: dict[str, Any]
    warnings: tuple[str, ...] = ()


@typed
def renew_mesh(
    before: TetMesh,
    history: History,
    surface: Surface,
    crack: Crack,
    sizing: Sizing,
    options: StageOptions | None = None,
    islands: Sequence[Island] | None = None,
    workers: int = 1,
    progress: Callable[[float, str], None] = silent,
) -> Renewed:
    """Return the 4-node mesh of a crack as the mesh `before` with a renewed part.

    Elements that neither the new part of the crack nor a changed target length touches keep nodes, numbers
    and bits. history: of the mesh before, from `history_of` or from its own renewal; surface: the surface
    of the grains without a crack. If too much changes, or if the renewed part breaks a promise, the whole
    mesh is made from scratch, and a warning says why. Raises CraftmeshError if that fails, too.
    """
    options = options or StageOptions()
    try:
        return _with_new_part(before, history, surface, crack, sizing, options, workers)
    except CraftmeshError as error:
        why = f"{error}"
    mesh, report, warnings = mesh_from_scratch(surface, crack, sizing, options, islands, workers, progress)
    mesh = replace(mesh, element_sets={NEW: np.arange(len(mesh.tets))})
    gone = NumberMap(np.full(len(before.points), -1), np.full(len(before.tets), -1))
    told = report | {"renewed": {"share": 1.0, "elements_kept": 0, "from_scratch": why}}
    warnings = (f"the mesh is made from scratch: {why}", *warnings)
    return Renewed(mesh, history_of(mesh, sizing), gone, told, warnings)


def mesh_from_scratch(
    surface: Surface,
    crack: Crack,
    sizing: Sizing,
    options: StageOptions,
    islands: Sequence[Island] | None,
    workers: int,
    progress: Callable[[float, str], None],
) -> tuple[TetMesh, dict[str, Any], tuple[str, ...]]:
    """Return the 4-node mesh of a crack in a surface, a report, and warnings.

    surface: grains without the crack. The report is that of `assemble`, with `meshing`, the record of the
    grains.
    """
    cut, _ = insert_crack(surface, crack, sizing, options.insert, progress)
    fitted, _ = gradate(cut, sizing, options.gradate, progress, crack=crack)
    volume, _ = mesh_volume(fitted, sizing, options.tetrahedralize, islands, workers, progress)
    mesh, report = assemble(volume.surface, volume.grain_tets, crack)
    return mesh, report | {"meshing": volume.record}, volume.warnings


def _with_new_part(
    before: TetMesh,
    history: History,
    surface: Surface,
    crack: Crack,
    sizing: Sizing,
    options: StageOptions,
    workers: int,
) -> Renewed:
    """Return the mesh with a renewed part; raises CraftmeshError if a promise would be broken."""
    mean = mean_aspect_ratio(before)
    if mean > history.aspect_ratio + MOST_RISE:
        raise CraftmeshError(
            f"the mesh before has a mean aspect ratio of {mean:.4f}, over {MOST_RISE} more than the last "
            f"mesh made from scratch, {history.aspect_ratio:.4f}"
        )
    whole = whole_of_mesh(before, history.lengths)
    chosen = changed_tets(whole, crack, sizing)
    share = float(chosen.mean())
    if options.renew.reuse == "auto" and share > options.renew.most_renewed:
        raise CraftmeshError(
            f"{share:.0%} of the elements change, which is over most_renewed {options.renew.most_renewed:g}"
        )
    renewed, volume = whole, None
    if chosen.any():
        filled = _filled(whole, chosen, surface, crack, sizing, options, history.cell, workers)
        body = cut_out(filled, widened(filled, filled.origin < 0), with_crack=True)
        volume = optimised_volume(body.surface, tets_of(filled, body), sizing, options.tetrahedralize)
        renewed = put_back(filled, body, volume.surface, volume.grain_tets, sizing)
        _refuse_broken(renewed, surface, options)
    grain_tets, rows = grain_tets_of(renewed)
    mesh, report = assemble(renewed.surface, grain_tets, crack)
    made_for = np.empty(len(mesh.points))
    made_for[mesh.tets] = renewed.lengths[renewed.tets[rows]]
    result, numbers, node = renumbered(before, mesh, renewed.origin[rows])
    made_for[node] = made_for.copy()
    kept = int((renewed.origin >= 0).sum())
    told = report | {"renewed": {"share": share, "elements_kept": kept}}
    told |= {"meshing": volume.record} if volume else {}
    warnings = volume.warnings if volume else ()
    return Renewed(result, history._replace(lengths=made_for), numbers, told, warnings)


def _filled(
    whole: Whole,
    chosen: np.ndarray,
    surface: Surface,
    crack: Crack,
    sizing: Sizing,
    options: StageOptions,
    cell: float,
    workers: int,
) -> Whole:
    """Return the model with new tets, not optimised yet, instead of the chosen tets, a mask (m,).

    surface: grains without the crack, for their volumes. Raises CraftmeshError if the crack in the part is
    farther off the given one than is promised, or if a grain cannot be meshed.
    """
    part = cut_out(whole, chosen, with_crack=False)
    old = whole.surface.facets[whole.surface.kind == CRACK]
    known = whole.surface.points[np.unique(old)]
    cut, inserted = insert_crack(part.surface, crack, sizing, options.insert, known=known)
    if inserted["crack_off_times"] > 1:
        raise CraftmeshError(
            f"the renewed crack would be {inserted['crack_off_times']:.2g} times farther off the given "
            "crack than is promised"
        )
    now, wanted = (volumes_of(one) for one in (whole.surface, surface))
    own = volumes_of(part.surface)
    targets = {k: own[k] + wanted[k] - now[k] for k in own if k in wanted and k in now}
    targets = {k: volume for k, volume in targets.items() if volume > 0}
    fitted, _ = gradate(cut, sizing, options.gradate, volumes=targets, crack=crack, boundaries=surface)
    plain = replace(options.tetrahedralize, optimise=False)
    filled, _ = fill_grains(fitted, sizing, plain, workers=workers, cell=cell)
    if filled.record["left"]:
        raise CraftmeshError(filled.warnings[-1] if filled.failures else "tetwild meshes only whole models")
    return put_back(whole, part, filled.surface, filled.grain_tets, sizing)


def _refuse_broken(renewed: Whole, surface: Surface, options: StageOptions) -> None:
    """Raise CraftmeshError for poor or flat new tets, and for grains of another volume than in `surface`.

    Without options.tetrahedralize.optimise, poor tets are allowed, as in a mesh made from scratch. A volume
    may differ by the fraction options.gradate.volume_tolerance.
    """
    measures = shape_measures(renewed.points, renewed.tets[renewed.origin < 0])
    poor = int((is_poor(measures) | is_flat(measures)).sum())
    if poor and options.tetrahedralize.optimise:
        raise CraftmeshError(
            f"{poor} tetrahedra of the renewed part would be poor (shape factor under 0.02 or a dihedral "
            "angle under 10 or over 160 degrees)"
        )
    now, wanted = (volumes_of(one) for one in (renewed.surface, surface))
    drift = {k: abs(now.get(k, 0.0) / volume - 1) for k, volume in wanted.items() if volume > 0}
    grain = max(drift, key=lambda k: drift[k])
    if drift[grain] > options.gradate.volume_tolerance:
        raise CraftmeshError(
            f"the volume of grain {grain} would differ by {drift[grain]:.1%} from the remeshed surface's; "
            f"expected at most {options.gradate.volume_tolerance:.1%}"
        )
