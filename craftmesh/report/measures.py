"""The numbers in the report: the paper's table of elements, and the growth of cracks."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from craftmesh.growth.grow import REPAIRS
from craftmesh.growth.trust import Trust, doubted_sentence, trusted
from craftmesh.mechanics.crystals import described_materials
from craftmesh.mechanics.materials import parse_materials
from craftmesh.mechanics.model_options import ModelOptions
from craftmesh.report.case_files import Case, Failure, Increment

# Number of tetrahedra in a cube with the edge length of a uniform mesh. Measured on the demo's volume with
# edges of 1.5, 1.2 and 0.9: 11.6, 10.9 and 10.4, which falls as the surface matters less. The smallest is
# used, so that reductions are not overestimated. (`campaign/job_resources` has the number for gradated
# meshes.)
UNIFORM_TETS = 10.4


class Row(NamedTuple):
    """An increment's row in the paper's table; unknown values are None. Fractions are in percent.

    uniform: number of elements of a uniform mesh with edges l_min; reduction: percent fewer elements than
    these; dof: degrees of freedom; aspect: mean aspect ratio; under_5: percent of elements with a ratio
    below 5; poor: percent of poor elements; drift, worst_drift: mean and largest volume change of grains.
    With reuse of the mesh before: renewed, percent of its elements that the crack changed; kept, percent of
    the new elements that come from it; from_scratch, why none are kept, else "".
    """

    increment: str
    elements: int
    uniform: float | None
    reduction: float | None
    dof: int
    aspect: float
    under_5: float
    poor: float
    drift: float | None
    worst_drift: float | None
    crack_area: float
    front_length: float
    renewed: float | None
    kept: float | None
    from_scratch: str


class GrownRow(NamedTuple):
    """K, kink angle and extension of an increment's crack: smallest and largest value along the fronts.

    K and kink angle are taken at reliable nodes (`of_trusted`). extension is None if the crack does not go
    on. cycles: load cycles up to here and their estimated error, None without a growth law that gives them.
    """

    increment: str
    k_1: tuple[float, float]
    k_2: tuple[float, float]
    k_3: tuple[float, float]
    kink_angle: tuple[float, float] | None
    extension: tuple[float, float] | None
    cycles: tuple[float, float] | None


def table_row(increment: Increment) -> Row:
    """Return an increment's row of the table, with values that its files do not have as None."""
    measured, l_min = increment.quality, increment.lengths.get("l_min")
    drift, renewed = measured.get("volume_drift", {}), measured.get("renewed", {})
    uniform = UNIFORM_TETS * measured["volume"] / l_min**3 if l_min else None
    return Row(
        increment=increment.name,
        elements=measured["elements"],
        uniform=uniform,
        reduction=None if uniform is None else 100 * (1 - measured["elements"] / uniform),
        dof=measured.get("dof_second_order", measured["dof"]),
        aspect=measured["ar_mean"],
        under_5=measured["ar_under_5_pct"],
        poor=measured["poor_pct"],
        drift=_percent(drift.get("mean")),
        worst_drift=_percent(drift.get("worst")),
        crack_area=measured["crack_area"],
        front_length=measured["front_length"],
        renewed=_percent(renewed.get("share")),
        kept=_percent(renewed["elements_kept"] / measured["elements"]) if renewed else None,
        from_scratch=renewed.get("from_scratch", ""),
    )


def grown_rows(case: Case) -> list[GrownRow]:
    """Return a row for each increment of a case whose front has K."""
    return [
        _grown(increment.name, increment.front, increment.growth or {})
        for increment in case.increments
        if increment.front is not None
    ]


def _grown(name: str, front: Mapping[str, np.ndarray], growth: Mapping[str, Any]) -> GrownRow:
    goes_on = bool(growth) and not growth["ended"]
    return GrownRow(
        increment=name,
        k_1=_range(of_trusted(front, "K_I")),
        k_2=_range(of_trusted(front, "K_II")),
        k_3=_range(of_trusted(front, "K_III")),
        kink_angle=_range(of_trusted(front, "kink_angle")) if "kink_angle" in front else None,
        extension=tuple(growth["extension"]) if goes_on else None,
        cycles=(float(front["cycles"][0]), float(front["cycles_doubt"][0])) if "cycles" in front else None,
    )


def trust_of(front: Mapping[str, np.ndarray]) -> Trust:
    """Return the nodes of a sif.csv that steer growth, and the fronts without reliable ones (`Trust`)."""
    return trusted(front["flags"].tolist(), front.get("front"), front.get("s"))


def of_trusted(front: Mapping[str, np.ndarray], column: str) -> np.ndarray:
    """Return a column of sif.csv at the nodes that steer growth, those whose own K counts.

    If these have no value, return it at all nodes.
    """
    own = front[column][trust_of(front).steers]
    return own if np.isfinite(own).any() else front[column]


class Verdict(NamedTuple):
    """is_good: whether all cases are complete; a sentence on it; counts: numbers of cases by outcome."""

    is_good: bool
    sentence: str
    counts: str


def verdict(cases: Sequence[Case], failed: Sequence[Failure]) -> Verdict:
    """Return the verdict on all cases.

    cases: those with increments; failed: failures of cases that lack increments.
    """
    lacking = {one.case for one in failed}
    wrong = {one.case for one in failed if one.log}
    asked = len(lacking | {case.name for case in cases})
    parts = [f"{asked - len(lacking)} of {asked} made"]
    parts += [f"{len(wrong)} failed"] * bool(wrong) + [f"{len(lacking - wrong)} unfinished"] * (
        lacking != wrong
    )
    sentence = "All cases are made" if asked > 1 else "The case is made"
    if lacking:
        sentence = f"Not all is made: {', '.join(sorted(lacking))}"
    return Verdict(not lacking, sentence, ", ".join(parts))


def materials(case: Case) -> str:
    """Return words for a case's materials: a user material, the default, or a material for each phase."""
    inp = case.record["config"].get("inp", {})
    if inp.get("user_material"):
        return f"{Path(inp['user_material']).name}, a user material"
    given = tuple(inp.get("material", ()))
    if given == ModelOptions().material:
        return f"{given[0]}, the default, which stands in for yours; give it as inp.material"
    described = described_materials(parse_materials(given), case.crystals) if given else {}
    return "; ".join(
        f"phase {key} is {words}" if key is not None else words for key, words in described.items()
    )


def life(case: Case) -> str:
    """Return words for the load cycles to the last crack and their error, or why there are none."""
    counted = [(row.cycles, row.increment) for row in grown_rows(case) if row.cycles]
    if counted:
        cycles, name = counted[-1]
        return f"{with_error(*cycles)} load cycles to the crack of increment {name}"
    if case.record["growth"] == "prescribed":
        return "no cycles, as the crack is prescribed; growth in the case table lets it grow"
    return "no growth law given; set grow.coefficient or grow.rates"


def with_error(value: float, error: float) -> str:
    """Return "value ± error", the error with two digits and the value rounded to the same place.

    If the error is not finite or not positive, return the value with two digits alone.
    """
    if not (np.isfinite(error) and error > 0):
        return f"{value:.2g}"
    place = 1 - int(np.floor(np.log10(error)))
    return " ± ".join(
        f"{round(x, place):,.{max(place, 0)}f}".replace(",", "\u202f") for x in (value, error)
    )


def outcome(case: Case) -> str:
    """Return sentences on the progress of a case, its doubtful fronts, and its repaired grown cracks."""
    found = [(one.name, trust_of(one.front).doubted) for one in case.increments if one.front is not None]
    doubts = [f"Increment {name}: {doubted_sentence(fronts)}." for name, fronts in found if fronts]
    repairs = [
        f"Growth from increment {one.name}: {REPAIRS[name]}{f' ({count} times)' * (count > 1)}."
        for one in case.increments
        for name, count in (one.growth or {}).get("repairs", {}).items()
    ]
    return " ".join([_outcome(case), *doubts, *repairs])


def _outcome(case: Case) -> str:
    done, asked = len(case.increments), case.record["increments"]
    for increment in case.increments:
        if increment.growth and increment.growth["ended"]:
            return f"The crack stops after increment {increment.name}: {increment.growth['ended']}."
    if done < asked:
        return f"{done} of {asked} increments are done."
    return f"{done} increment{'s' * (done != 1)}, as many as requested."


def totals(rows: Sequence[Row]) -> dict[str, float | None]:
    """Return the summary's numbers from the rows of all increments: sums and extremes, None if unknown."""
    reductions = [row.reduction for row in rows if row.reduction is not None]
    drifts = [row.worst_drift for row in rows if row.worst_drift is not None]
    return {
        "elements": sum(row.elements for row in rows),
        "largest": max((row.elements for row in rows), default=0),
        "least_reduction": min(reductions, default=None),
        "most_reduction": max(reductions, default=None),
        "worst_poor": max((row.poor for row in rows), default=None),
        "worst_drift": max(drifts, default=None),
    }


def _range(values: np.ndarray) -> tuple[float, float]:
    return float(np.nanmin(values)), float(np.nanmax(values))


def _percent(share: float | None) -> float | None:
    return None if share is None else 100 * share
