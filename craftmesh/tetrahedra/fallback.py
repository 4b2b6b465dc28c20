"""The last resort: if grains are left without tets, the whole model is meshed again."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from craftmesh.errors import CraftmeshError
from craftmesh.progress import silent
from craftmesh.sizing.sizing import Lengths
from craftmesh.tetrahedra.diagnose import shortened
from craftmesh.tetrahedra.meshers import TETWILD
from craftmesh.tetrahedra.options import TetrahedralizeOptions
from craftmesh.types import GrainTets, Surface


@dataclass(frozen=True)
class Completion:
    """Tets of all grains and the surface they lie on.

    whole_model: report of the mesh of the whole model, None if each grain was meshed on its own; warning: a
    line about that mesh, None without it or if the user chose mesher tetwild.
    """

    surface: Surface
    grain_tets: Sequence[GrainTets]
    whole_model: dict | None = None
    warning: str | None = None


def completed(
    given: Completion,
    record: dict,
    sizing_of: Callable[[], Lengths | None],
    options: TetrahedralizeOptions,
    progress: Callable[[float, str], None] = silent,
) -> Completion:
    """Return the tets `given` or, if the record lists grains without tets, a mesh of the whole model.

    record: from `record_of` or `merged`; its key `left` lists grains without tets. sizing_of: returns the
    sizing, called only if pytetwild meshes the whole model. Raises CraftmeshError if pytetwild's mesh
    fails, or if it would be needed and options.fallback is none, except with mesher tetwild.
    """
    if not record.get("left"):
        return given
    if options.fallback == "none" and record["mesher"] != TETWILD:
        raise CraftmeshError(
            f"{_reason(record)} ({_first_failure(record)}) and fallback is none; repair the surface there "
            f"(craftmesh check names its breaches) or set fallback to {TETWILD}"
        )
    from craftmesh.tetrahedra.whole.whole_model import mesh_whole_model

    try:
        surface, grain_tets, report = mesh_whole_model(given.surface, sizing_of(), options, progress)
    except CraftmeshError as error:
        raise CraftmeshError(f"{_reason(record)}; then {error}") from None
    return Completion(surface, grain_tets, report, _warning(record, report))


def _warning(record: dict, report: dict) -> str | None:
    if record["mesher"] == TETWILD:
        return None
    return (
        f"{_reason(record)}; the whole model was meshed by pytetwild instead: grain boundaries lie "
        f"within {report['envelope']:.3g} of the surface and the largest change of a grain's "
        f"volume is {100 * report['volume_drift_worst']:.3g} % (grain "
        f"{report['volume_drift_grain']}); another run gives another mesh"
    )


def _first_failure(record: dict) -> str:
    grain, failure = min(record["failed"].items(), key=lambda item: int(item[0]))
    return f"grain {grain}: {failure['reason']}"


def _reason(record: dict) -> str:
    if record["mesher"] == TETWILD:
        return f"mesher {TETWILD} is for the whole model"
    return f"every attempt of {record['mesher']} failed at grains {shortened(record['left'])}"
