"""Kink angle and extension of each front point, reasons to stay, and the load cycles of the step.

The doubt of K is its estimated error, in the unit of K.
"""

import numpy as np

from craftmesh.growth.driving import driving_force
from craftmesh.growth.front_points import FrontPoints
from craftmesh.growth.front_step import FrontStep
from craftmesh.growth.kink_angle import kink_angles_of, opened
from craftmesh.growth.options import LEAST_RATIO, STRESS, Block, GrowthOptions
from craftmesh.growth.rates import LoadCycle, largest, laws_of, local_rates, open_share
from craftmesh.growth.relaxation import over_step
from craftmesh.growth.steps import ROOT, CycleCount, counted, growth_to, step_length

CLOSED, ARRESTED, NOISE = "closed", "arrested", "noise"
UNSTABLE, YIELDS = "unstable", "yields"
STAYS = {
    CLOSED: "K_I is not above its estimated error",
    ARRESTED: "Delta K is not above the threshold",
    NOISE: "the driving force is not above the estimated error of K",
    UNSTABLE: "the driving force reaches K_c",
    YIELDS: "the mean stress over the net section reaches grow.yield_stress",
}
ENDS = {UNSTABLE, YIELDS}  # reasons that end the growth of the whole crack, even at a single point
# Fraction of sigma sqrt(pi a) below which K counts as noise, with the mean stress sigma and the crack size
# a. With five edges per radius, K differs from the exact value by up to 0.43 % of sigma sqrt(pi a) (the
# lens and the crystal of docs/fracture.md). K_II of a penny under compression, exactly 0, is found as
# 0.54 % of it.
NOISE_SHARE = 0.01
# Change of ln K from which the exponent d ln(da/dN) / d ln(K) is computed, and the digits to which it is
# rounded, because rounding errors of 1e-11 remain.
LITTLE, DIGITS = 1e-4, 9


def doubts(error: np.ndarray, stress: float, radius: float) -> np.ndarray:
    """Return the doubt (n,) of K: the larger of its estimated `error` (n,) and the noise of the mesh.

    The noise is NOISE_SHARE times stress sqrt(pi radius), about K of a crack of that radius under `stress`.
    """
    return np.maximum(error, NOISE_SHARE * stress * np.sqrt(np.pi * radius))


def reasons(front: FrontPoints, peak: LoadCycle, rate: np.ndarray, options: GrowthOptions) -> np.ndarray:
    """Return the reasons (n,) why points stay, keys of STAYS; "" at points that extend.

    front: points with the doubt of K; peak: the load cycle with the largest driving force at each point;
    rate (n,): da/dN. A K_I under minus its doubt counts as closed. A K_I within its doubt does too if the
    driving force is tangential_stress or K_I and the solution has no contact between the crack faces.
    """
    words = np.full(len(rate), "", object)
    words[rate <= 0] = ARRESTED
    if not front.contact and options.driving in (STRESS, "K_I"):
        words[peak.front.k[:, 0] <= front.doubt] = CLOSED
    words[peak.driving <= front.doubt] = NOISE
    words[peak.front.k[:, 0] < -front.doubt] = CLOSED
    reaches = np.isinf(rate) | (peak.driving >= (options.toughness or np.inf))
    words[(words == "") & reaches] = UNSTABLE
    if options.yield_stress is not None and front.net_stress >= options.yield_stress:
        words[:] = YIELDS
    return words


def kinks_and_extensions(front: FrontPoints, options: GrowthOptions) -> tuple[FrontStep, CycleCount]:
    """Return the step of a crack's front points, and the load cycles of the step.

    Points that are not trusted take K of the nearest trusted point. `kink_angles_of` and `driving_force`
    give directions and driving forces in each load cycle; the cycle with the largest driving force sets the
    direction. `reasons` gives the points that stay. The kink angle is 0 at points that stay, except at
    ARRESTED ones. Raise CraftmeshError for contradicting options, and for errors in rate laws or
    user-supplied functions.
    """
    front = front.from_trusted()
    blocks = options.cycles()
    cycles = [_cycle(front, block, options) for block in blocks]
    count = np.array([block.number for block in blocks])
    laws = local_rates(laws_of(options), front.grain, front.phase)

    def rate_at(scale: float) -> np.ndarray:
        return count @ np.stack([laws.rate(one.scaled(scale)) for one in cycles]) / count.sum()

    peak = largest(cycles)
    da_dn = rate_at(1.0)
    stays = reasons(front, peak, da_dn, options)
    goes = stays == ""
    da_dn = np.where(goes, da_dn, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        power = np.round(np.log(rate_at(np.exp(LITTLE)) / da_dn) / LITTLE, DIGITS)
    rate, exponent, counts = _rates(front, peak, da_dn, power, options)
    step = FrontStep.of(
        front.points,
        front.normal,
        front.binormal,
        np.where(goes | (stays == ARRESTED), peak.angle, 0.0),
        over_step(rate, exponent, counts.step, front.rows),
        trusted=front.trusted & has_way(stays),
        stays=stays,
        rate=rate,
        power=np.full(len(rate), exponent),
        da_dn=da_dn,
        delta_k=peak.delta_k,
        ratio=peak.ratio,
        driving=peak.driving,
    )
    return step, counts


def has_way(stays: np.ndarray) -> np.ndarray:
    """Return a mask (n,) of points whose K gives a direction, from their reasons (n,) to stay."""
    return ~np.isin(stays, (CLOSED, NOISE))


def _rates(
    front: FrontPoints, cycle: LoadCycle, rate: np.ndarray, powers: np.ndarray, options: GrowthOptions
) -> tuple[np.ndarray, float, CycleCount]:
    """Return relative rates (n,), their exponent d ln(rate) / d ln(K), and the step with its load cycles.

    The relative rate is da/dN over its median, within options.limits; with law uniform it is 1, and the
    exponent 0. It is 0 at points that stay. cycle: with the largest driving force at each point; rate (n,):
    da/dN, 0 at points that stay; powers (n,): d ln(da/dN) / d ln(K), not finite where unknown.
    """
    goes, last = rate > 0, front.last
    if not goes.any():
        return rate, 0.0, counted(last, front.size, 0.0, 0.0, 0.0, 0.0)
    known = goes & np.isfinite(powers)
    middle, power = float(np.median(rate[goes])), float(np.median(powers[known])) if known.any() else 0.0
    growth = growth_to(last, middle, power)
    length = min((one.length for one in front.rows), default=np.inf)
    farthest = float(rate.max()) / middle if options.law != "uniform" else 1.0
    change = growth / power if power else ROOT
    step = step_length(options, front.size, length, front.edge, change, farthest)
    opens = np.median(open_share(options.closure, cycle.ratio)) * front.error
    error = float(opens / np.median(cycle.delta_k[goes]))
    count = counted(last, front.size, step, middle, power, error)
    if options.law == "uniform":
        return goes.astype(float), 0.0, count
    least, most = options.limits
    return np.where(goes, np.clip(rate / middle, least, most), 0.0), power, count


def _cycle(front: FrontPoints, block: Block, options: GrowthOptions) -> LoadCycle:
    """Return one load cycle at the front points.

    The peak is the end with the larger driving force. The stress ratio R is given by the block or, for ends
    of two load cases and with a residual stress, 1 - D(K - K') / D(K), with K at the peak, K' at the other
    end, and the driving force D in the peak's direction. For proportional loads this is the ratio of the
    loads. A negative K_I of the other end, as from a solution without contact, is not set to 0.
    R is clipped to LEAST_RATIO..1.
    """

    def drive(k: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        here = front.with_k(k)
        angle = kink_angles_of(here, options)
        return angle, driving_force(front.with_k(opened(k)), angle, options)

    k = front.at(block.largest)
    angle, driving = drive(k)
    if block.ratio is not None and not front.still:
        ratio = np.full(len(k), block.ratio)
    else:
        other = front.at(block.smallest)
        angle_there, there = drive(other)
        turned = there > driving
        angle, driving = np.where(turned, angle_there, angle), np.where(turned, there, driving)
        k, other = np.where(turned[:, None], other, k), np.where(turned[:, None], k, other)
        drives = driving > 0
        change = driving_force(front.with_k(opened(k) - other), angle, options)
        ratio = np.where(drives, 1 - change / np.where(drives, driving, 1.0), 0.0)
        ratio = np.clip(ratio, LEAST_RATIO, 1.0)
    delta_k = open_share(options.closure, ratio) * np.maximum(driving, 0.0)
    return LoadCycle(driving, ratio, delta_k, angle, front.with_k(k))
