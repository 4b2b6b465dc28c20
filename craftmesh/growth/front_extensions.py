"""Kink angles and extensions of a solved crack's fronts: the columns of sif.csv that `grow_crack` takes."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from craftmesh.arguments import typed
from craftmesh.cracks.polyline import polyline
from craftmesh.errors import CraftmeshError
from craftmesh.growth.extension import doubts, kinks_and_extensions
from craftmesh.growth.front_points import FrontPoints
from craftmesh.growth.front_step import FrontStep
from craftmesh.growth.grow import row_spacing
from craftmesh.growth.net_section import largest_net_stress
from craftmesh.growth.options import SLIP, GrowthOptions, check_cycle
from craftmesh.growth.relaxation import rows_along
from craftmesh.growth.slip_planes import SlipField, slip_kink_angles
from craftmesh.growth.steps import CycleCount, counted, crack_size
from craftmesh.growth.trust import trusted
from craftmesh.mechanics.faces import RESIDUAL
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
    last: CycleCount | None = None,
    slip: SlipField | None = None,
) -> tuple[dict[str, np.ndarray], dict]:
    """Return the columns of sif.csv, with kink angles and extensions, and a report with the load cycles.

    found: K and other parameters along the fronts by load case, as `stress_intensities` returns them for
    `solutions`; empty if the mesh has no front. The load cases of options.cycle or options.blocks count, by
    default the first. last: the previous front, as `counted_front` reads it from a report; slip: the
    content of options.slip_table, for criterion slip. The report has the mean stress, the fields of
    `CycleCount`, and `doubted`, numbers of fronts without a reliable node. Raise CraftmeshError if the
    cycle names unknown load cases, if block_table is given, or if the criterion lacks orientations or slip.
    """
    check_cycle(options, list(model.by_load()))
    if options.block_table:
        raise CraftmeshError(
            f"block_table is {options.block_table!r}, but only commands read it; pass its rows as blocks"
        )
    size = crack_size(crack, model.mesh.box)
    if not found:
        none = dict.fromkeys(("node", "kink_angle", "extension", "stays"), np.zeros(0))
        stands = counted(last, size, 0.0, 0.0, 0.0, 0.0)
        return {"points": np.zeros((0, 3))} | none, _cycles(stands, options)
    name = [*options.loads, *found][0]
    parameters, frames = found[name], front_frames(model.mesh)
    trust = trusted(parameters.flags.tolist(), parameters.front, parameters.s)
    stress = mean_stress(model, solutions[name].displacement)
    stress += mean_traction(model.by_load()[name].load, model.mesh)
    stiffness = model.stiffness()[np.searchsorted(model.grains, frames.grain)]
    lines = [polyline(crack.points[front]) for front in crack.fronts]
    shares = {one.name: one.factors.get(RESIDUAL, 0.0) for one in model.combinations if RESIDUAL in found}
    still = {load: share * found[RESIDUAL].k for load, share in shares.items()}
    front = FrontPoints.of(
        parameters.k,
        size,
        loads={load: one.k for load, one in found.items()},
        points=parameters.points,
        binormal=frames.binormal,
        normal=frames.normal,
        tangent=frames.tangent,
        T=parameters.T,
        doubt=doubts(parameters.error, stress, size),
        trusted=trust.steers,
        front=parameters.front,
        grain=frames.grain,
        phase=np.array([model.phase_of[grain] or 0 for grain in frames.grain.tolist()], int),
        orientation=_orientations(model, frames.grain),
        stiffness=turned(stiffness, frames.axes),
        edge=row_spacing(frames.points),
        error=float(np.median(parameters.error[trust.steers])),
        contact="contact_closed" in solutions[name].record,
        rows=rows_along(lines, frames.points, frames.binormal),
        last=last,
        still=still | {"": still[name]} if still else {},
    )
    if options.criterion == SLIP:
        slip_angle = _slip_angles(front, frames, options, slip, len(model.grains) > 1)
        front = replace(front, slip_angle=slip_angle)
    report: dict = {"stress": stress}
    if options.yield_stress is not None:
        # a residual stress is in balance with itself, so that it loads no whole section
        fields = {load: one.displacement for load, one in solutions.items()}
        if still:
            fields = {load: one - shares[load] * fields[RESIDUAL] for load, one in fields.items()}
        front = replace(front, net_stress=largest_net_stress(model, fields, options, name))
        report |= {"net_stress": front.net_stress}
    growth, cycles = kinks_and_extensions(front, options)
    report |= _cycles(cycles, options) | {"doubted": trust.doubted}
    columns = parameters.columns()
    ways = _columns(growth, report, bool(options.blocks or still) or len(options.loads) > 1)
    return columns | ways | {"flags": columns.pop("flags")}, report


def counted_front(
    report: Mapping[str, float | None], growth: Mapping[str, Any] | None = None
) -> CycleCount | None:
    """Return the front and its load cycles from a report of `front_extensions`; None if it did not extend.

    growth: the report of `grow_crack` on this front; its `laid` is the fraction of the step that was laid,
    which counts; without it the whole step counts. Raise CraftmeshError for a report without these fields.
    """
    if not set(CycleCount._fields) <= report.keys():
        raise CraftmeshError(
            "this report has no load cycles to continue; give the --json of `craftmesh fracture --crack`"
        )
    last = CycleCount(*(report[key] or 0.0 for key in CycleCount._fields))
    if last.rate <= 0:
        return None
    laid = float((growth or {}).get("laid", 1.0))
    return last.laid(laid) if laid < 1 else last


def _cycles(count: CycleCount, options: GrowthOptions) -> dict[str, float | None]:
    """Return a front's entries in the report, by the fields of `CycleCount`.

    Load cycles and their doubt are None unless da/dN is known in its unit.
    """
    known = options.has_rates
    return {key: value if known or key not in CYCLES else None for key, value in count._asdict().items()}


def _orientations(model: ElasticModel, grains: np.ndarray) -> np.ndarray:
    """Return active rotations (n, 3, 3) from crystal to sample axes in grains (n,); NaN where unknown."""
    found = np.full((len(grains), 3, 3), np.nan)
    for grain in np.intersect1d(grains, list(model.axes)).tolist():
        found[grains == grain] = model.own_axes(grain)
    return found


def _slip_angles(
    front: FrontPoints,
    frames: FrontFrames,
    options: GrowthOptions,
    slip: SlipField | None,
    has_boundaries: bool,
) -> np.ndarray:
    """Return the kink angle (n,) at each front node along the slip plane that is most active in `slip`.

    Without grains in `slip`, means would cross grain boundaries. So a body with boundaries needs them.
    """
    unknown = np.unique(front.grain[np.isnan(front.orientation).any(axis=(1, 2))])
    if len(unknown):
        raise CraftmeshError(
            f"grow.criterion slip: grain {unknown[0]} at the front has no orientation; give orientations "
            "with the microstructure"
        )
    if slip is None:
        raise CraftmeshError(
            f"slip_table is {options.slip_table!r}, but only commands read it; pass its content as `slip`"
        )
    if slip.grain is None and has_boundaries:
        raise CraftmeshError(
            f"{slip.source}: has no column grain, but the body has several grains; add it, so that a front "
            "node reads slip of its own grain"
        )
    return slip_kink_angles(frames, front.orientation, slip, options, front.grain)


def _columns(
    growth: FrontStep, counted: Mapping[str, float | None], by_pair: bool
) -> dict[str, np.ndarray]:
    """Return the columns of sif.csv that describe the growth; kink angles in degrees.

    If da/dN is known in its unit, every row has the load cycles to this front and their doubt, da/dN, and
    the cycles for the node's extension at that rate, NaN at nodes that stay. counted: the report's entries
    with these cycles. Delta K and R are included if `by_pair`, that is, if two load cases form the cycle,
    blocks are given or there is a residual stress; they belong to the cycle with the largest driving force.
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
