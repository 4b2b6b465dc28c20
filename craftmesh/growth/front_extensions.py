"""Kink angles and extensions of a solved crack's fronts: the columns of sif.csv that `grow_crack` takes."""

from collections.abc import Mapping

import numpy as np

from craftmesh.arguments import typed
from craftmesh.cracks.polyline import polyline
from craftmesh.errors import CraftmeshError
from craftmesh.growth.extension import CrackFronts, Evidence, doubts, kinks_and_extensions
from craftmesh.growth.front_step import FrontStep
from craftmesh.growth.grow import row_spacing
from craftmesh.growth.kink_angle import SlipField, slip_ways
from craftmesh.growth.options import NEAR_FIELD, SLIP, GrowthOptions, check_cycle
from craftmesh.growth.rates import laws_of, local_rates
from craftmesh.growth.relaxation import rows_along
from craftmesh.growth.steps import Counted, counted, crack_size
from craftmesh.growth.trust import trusted
from craftmesh.mechanics.front_parameters import FrontParameters
from craftmesh.mechanics.lips import mean_traction
from craftmesh.mechanics.materials import turned
from craftmesh.mechanics.model import ElasticModel
from craftmesh.mechanics.stress import mean_stress
from craftmesh.mesh.front_frames import FrontFrames, front_frames
from craftmesh.types import Crack, Solution

CYCLES = ("cycles", "doubt", "ahead", "ahead_doubt")


@typed
def front_extensions(
    crack: Crack,
    model: ElasticModel,
    solutions: Mapping[str, Solution],
    found: Mapping[str, FrontParameters],
    options: GrowthOptions = GrowthOptions(),  # noqa: B008 (frozen)
    last: Counted | None = None,
    slip: SlipField | None = None,
) -> tuple[dict[str, np.ndarray], dict]:
    """Return the columns of sif.csv, with kink angles and extensions, and a report with the load cycles.

    found: parameters along the fronts by load case, as `stress_intensities` returns them for `solutions`;
    empty if the mesh has no front. The load cases of options.cycle count, by default the first. last: the
    previous front, as `counted_front` reads it from a report; slip: the content of options.slip_table.
    Raise CraftmeshError if the cycle names unknown load cases, or the criterion lacks orientations or slip.
    """
    check_cycle(options.cycle, list(model.by_load()))
    size = crack_size(crack, model.mesh.box)
    if not found:
        none = dict.fromkeys(("node", "kink_angle", "extension", "stays"), np.zeros(0))
        stands = counted(last, size, 0.0, 0.0, 0.0, 0.0)
        return {"points": np.zeros((0, 3))} | none, _cycles(stands, options)
    name, *others = options.cycle or list(found)[:1]
    solution, parameters, frames = solutions[name], found[name], front_frames(model.mesh)
    trust = trusted(parameters.flags.tolist(), parameters.front, parameters.s)
    stress = mean_stress(model, solution.displacement)
    stress += mean_traction(model.by_load()[name].load, model.mesh)
    of_grains, axes = model.stiffness()[np.searchsorted(model.grains, frames.grain)], frames.axes
    lines = [polyline(crack.points[front]) for front in crack.fronts]
    growth, cycles = kinks_and_extensions(
        parameters.k,
        CrackFronts(
            size,
            rows_along(lines, frames.points, frames.binormal),
            row_spacing(frames.points),
            float(np.median(parameters.error[trust.steers])),
        ),
        options,
        Evidence(
            parameters.points,
            doubts(parameters.error, stress, size),
            trust.steers,
            "contact_closed" in solution.record,
            parameters.front,
        ),
        last,
        local_rates(laws_of(options), frames.grain, model.phase_of),
        turned(of_grains, axes) if options.criterion == NEAR_FIELD else None,
        found[others[0]].k if others else None,
        _slip_angles(model, frames, options, slip) if options.criterion == SLIP else None,
    )
    report: dict = {"stress": stress} | _cycles(cycles, options) | {"doubted": trust.doubted}
    columns = parameters.columns()
    ways = _columns(growth, report, bool(others))
    return columns | ways | {"flags": columns.pop("flags")}, report


def counted_front(report: Mapping[str, float | None]) -> Counted | None:
    """Return the front in a report of `front_extensions`; None if the front did not extend.

    Raise CraftmeshError for any other report.
    """
    if not set(Counted._fields) <= report.keys():
        raise CraftmeshError(
            "no growth to count on from in this report; give the --json of `craftmesh fracture --crack`"
        )
    last = Counted(*(report[key] or 0.0 for key in Counted._fields))
    return last if last.rate > 0 else None


def _cycles(count: Counted, options: GrowthOptions) -> dict[str, float | None]:
    """Return a front's report entries for `counted_front`; cycles are None unless da/dN is known."""
    known = options.has_rates
    return {key: value if known or key not in CYCLES else None for key, value in count._asdict().items()}


def _slip_angles(
    model: ElasticModel, frames: FrontFrames, options: GrowthOptions, slip: SlipField | None
) -> np.ndarray:
    """Return the kink angles (n,) of the front nodes along the most active slip planes."""
    unknown = sorted(set(frames.grain.tolist()) - set(model.axes))
    if unknown:
        raise CraftmeshError(
            f"grow.criterion slip: grain {unknown[0]} at the front has no orientation; give orientations "
            "with the microstructure"
        )
    if slip is None:
        raise CraftmeshError(
            f"slip_table is {options.slip_table!r}, but only commands read it; pass its content as `slip`"
        )
    turns = np.array([model.own_axes(grain) for grain in frames.grain.tolist()])
    return slip_ways(frames, turns, slip, options.ring)


def _columns(
    growth: FrontStep, counted: Mapping[str, float | None], by_pair: bool
) -> dict[str, np.ndarray]:
    """Return the columns of sif.csv that describe the growth; kink angles in degrees.

    If da/dN is known, every row has the load cycles to this front and their doubt, da/dN, and the cycles
    for the node's extension at that rate, NaN at nodes that stay. Delta K and R are included if `by_pair`:
    if two load cases form the cycle.
    """
    angle = np.degrees(growth.kink_angle)
    way = {"kink_angle": angle, "extension": growth.extension, "driving": growth.driving}
    way |= {"delta_K": growth.delta_k, "R": growth.ratio} if by_pair else {}
    way |= {"rate": growth.rate, "power": growth.power}
    if counted["cycles"] is not None:
        way |= {"cycles": np.full(len(angle), counted["cycles"])}
        way |= {"cycles_doubt": np.full(len(angle), counted["doubt"])}
        goes = growth.da_dn > 0
        ahead = growth.extension / np.where(goes, growth.da_dn, 1.0)
        way |= {"da_dN": growth.da_dn, "cycles_ahead": np.where(goes, ahead, np.nan)}
    return way | {"stays": growth.stays}
