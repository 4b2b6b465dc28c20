"""Which way and how far the fronts of a solved crack go: the columns of sif.csv that `grow_crack` takes."""

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
    """Return the columns of sif.csv of a crack that goes on, and a report with its load cycles.

    found: what is known along its fronts by load, as `stress_intensities` returns it for `solutions`; none
    where the mesh has no front. Those of options.cycle count, else the first. last: the front before, as
    `counted_front` reads it from a report; slip: what options.slip_table holds. Raises CraftmeshError for a
    cycle of other loads, and for crystals whose orientation the criterion needs.
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
    """Return the front of a report of `front_extensions`; None where it did not go on.

    Raises CraftmeshError for another report.
    """
    if not set(Counted._fields) <= report.keys():
        raise CraftmeshError(
            "no growth to count on from; expected the --json of `craftmesh fracture --crack`"
        )
    last = Counted(*(report[key] or 0.0 for key in Counted._fields))
    return last if last.rate > 0 else None


def _cycles(count: Counted, options: GrowthOptions) -> dict[str, float | None]:
    """Return a front's cycles as `counted_front` reads them; null without a law that gives them."""
    known = options.has_rates
    return {key: value if known or key not in CYCLES else None for key, value in count._asdict().items()}


def _slip_angles(
    model: ElasticModel, frames: FrontFrames, options: GrowthOptions, slip: SlipField | None
) -> np.ndarray:
    """Return the kink angles (n,) of the front nodes along the planes that slip most."""
    unknown = sorted(set(frames.grain.tolist()) - set(model.axes))
    if unknown:
        raise CraftmeshError(
            f"grow.criterion slip: grain {unknown[0]} at the front has no orientation; give orientations "
            "with the microstructure"
        )
    if slip is None:
        raise CraftmeshError(
            f"slip_table is {options.slip_table!r}, which commands read; give the slip that it holds"
        )
    turns = np.array([model.own_axes(grain) for grain in frames.grain.tolist()])
    return slip_ways(frames, turns, slip, options.ring)


def _columns(
    growth: FrontStep, counted: Mapping[str, float | None], by_pair: bool
) -> dict[str, np.ndarray]:
    """Return the columns of sif.csv that say how a front goes on; kink angles in degrees.

    Load cycles to the front and their doubt stand in every row, where a law gives them; so do da/dN and the
    cycles in which each node goes its extension at that rate, NaN where it stays. Delta K and R stand where
    they are those of two loads.
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
