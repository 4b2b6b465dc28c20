"""The end of the verbs that make the whole mesh: grains without tets, assembly, report."""

from collections.abc import Callable, Sequence

from craftmesh.assembly.assemble import assemble
from craftmesh.assembly.fit import refuse_other_surface
from craftmesh.commands.stage_io import warn
from craftmesh.mesh.bodies import severed_sentence
from craftmesh.mesh.flat_tets import flat_sentence, flat_tets
from craftmesh.progress import ProgressLine
from craftmesh.sizing.lengths import Lengths
from craftmesh.tetrahedra.fallback import Completion, completed
from craftmesh.tetrahedra.flat_places import given_way
from craftmesh.tetrahedra.options import TetrahedralizeOptions
from craftmesh.tetrahedra.record import with_counts
from craftmesh.tetrahedra.whole_optimisation import optimised_whole
from craftmesh.types import Crack, GrainTets, Surface, TetMesh


def complete_mesh(
    surface: Surface,
    grain_tets: Sequence[GrainTets],
    record: dict,
    sizing_of: Callable[[], Lengths | None],
    options: TetrahedralizeOptions,
    crack: Crack | None = None,
) -> tuple[TetMesh, dict]:
    """Return the assembled mesh and its report, with the record under `meshing`.

    crack: the given one, which tells what is one crack, see assemble.
    """
    refuse_other_surface(surface, grain_tets)
    with ProgressLine("whole model") as progress:
        whole = completed(Completion(surface, grain_tets), record, sizing_of, options, progress)
    if whole.warning:
        warn(whole.warning)
    opened = given_way(whole.surface, whole.grain_tets)
    if opened.warning:
        warn(opened.warning)
    surface, grain_tets, poor, smooth = opened.surface, opened.grain_tets, opened.poor, None
    if options.optimise:
        smoothed = optimised_whole(surface, grain_tets)
        surface, grain_tets, smooth = smoothed.surface, smoothed.grain_tets, smoothed.report
        poor = dict.fromkeys(record.get("poor", {}) | poor, []) | smoothed.poor
    mesh, report = assemble(surface, grain_tets, crack)
    flat = flat_sentence(flat_tets(mesh))
    for sentence in (flat, severed_sentence(mesh)):
        if sentence:
            warn(sentence)
    meshing = with_counts(record, whole.whole_model, opened.report, smooth, poor)
    return mesh, report | {"meshing": meshing}
