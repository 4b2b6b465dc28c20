"""The last rung of the ladder, shared by the verbs that make the whole mesh: grains without tets."""

from collections.abc import Callable, Sequence
from typing import Any

from craftmesh.assembly.assemble import assemble
from craftmesh.commands.stage_io import warn
from craftmesh.errors import CraftmeshError
from craftmesh.progress import ProgressLine
from craftmesh.tetrahedra.meshers.base import TETWILD
from craftmesh.tetrahedra.record import with_counts
from craftmesh.types import GrainTets, Surface, TetMesh


def complete_mesh(
    surface: Surface,
    grain_tets: Sequence[GrainTets],
    record: dict,
    sizing_of: Callable[[], Any],
    options: Any,
) -> tuple[TetMesh, dict]:
    """Return the assembled mesh and its report, with the record under `meshing`.

    Where grains are left, the whole model is meshed anew by pytetwild and a warning says so. Raises
    CraftmeshError when that fails, or when options.fallback is none.
    """
    whole_model = None
    if record.get("left") and options.fallback == "none" and record["mesher"] != TETWILD:
        raise CraftmeshError(
            f"{_reason(record)} ({_first_failure(record)}) and fallback is none; repair the surface there "
            f"(craftmesh check names its breaches) or set fallback to {TETWILD}"
        )
    if record.get("left"):
        from craftmesh.tetrahedra.whole.whole_model import mesh_whole_model

        with ProgressLine("whole model") as progress:
            try:
                surface, grain_tets, whole_model = mesh_whole_model(surface, sizing_of(), options, progress)
            except CraftmeshError as error:
                raise CraftmeshError(f"{_reason(record)}; then {error}") from None
        if record["mesher"] != TETWILD:
            warn(
                f"{_reason(record)}; the whole model was meshed by pytetwild instead: grain boundaries lie "
                f"within {whole_model['envelope']:.3g} of the surface and the largest change of a grain's "
                f"volume is {100 * whole_model['volume_drift_worst']:.3g} % (grain "
                f"{whole_model['volume_drift_grain']}); another run gives another mesh"
            )
    mesh, report = assemble(surface, grain_tets)
    return mesh, report | {"meshing": with_counts(record, whole_model)}


def _first_failure(record: dict) -> str:
    grain, failure = min(record["failed"].items(), key=lambda item: int(item[0]))
    return f"grain {grain}: {failure['reason']}"


def _reason(record: dict) -> str:
    if record["mesher"] == TETWILD:
        return f"mesher {TETWILD} is for the whole model"
    ids = ", ".join(map(str, record["left"][:6]))
    more = f" and {len(record['left']) - 6} more" if len(record["left"]) > 6 else ""
    return f"every attempt of {record['mesher']} failed at grains {ids}{more}"
