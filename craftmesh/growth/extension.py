"""Kink angle and extension of each front point, reasons to stay, and the load cycles of the step."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from craftmesh.growth.front_step import FrontStep
from craftmesh.growth.kink_angle import Criterion, criterion_of, opened
from craftmesh.growth.options import LEAST_RATIO, GrowthOptions
from craftmesh.growth.rates import LocalRates, laws_of, local_rates, open_share
from craftmesh.growth.relaxation import FrontRows, over_step
from craftmesh.growth.steps import ROOT, Counted, counted, growth_to, step_length
from craftmesh.growth.trust import sources

CLOSED, ARRESTED, NOISE = "closed", "arrested", "noise"
STAYS = {
    CLOSED: "K_I is not above its estimated error",
    ARRESTED: "Delta K is not above grow.threshold",
    NOISE: "the driving force is not above the estimated error of K",
}
# Fraction of sigma sqrt(pi a) below which K counts as noise. With five edges per radius, K differs from the
# exact value by up to 0.43 % of it (the lens and the crystal of docs/fracture.md). K_II of a penny under
# compression is exactly 0, and comes out as 0.54 %.
NOISE_SHARE = 0.01


class Evidence(NamedTuple):
    """Reliability of K at front points; `reasons` compares driving forces with it.

    doubt (n,): estimated error of K, in its unit. trusted (n,): False at points that take K of the nearest
    trusted point on their front, see `growth.trust`. contact: True if the solution keeps crack faces from
    overlapping, so that K_II of closed faces is valid. front (n,): number of each point's front.
    """

    points: np.ndarray
    doubt: np.ndarray
    trusted: np.ndarray
    contact: bool = False
    front: np.ndarray | None = None


def doubts(error: np.ndarray, stress: float, radius: float) -> np.ndarray:
    """Return the doubt (n,) of K: the larger of its estimated `error` (n,) and the error from the mesh.

    The error from the mesh is NOISE_SHARE times K of a crack of size `radius` under the mean `stress`.
    """
    return np.maximum(error, NOISE_SHARE * stress * np.sqrt(np.pi * radius))


def reasons(
    k: np.ndarray,
    driving: np.ndarray,
    span: np.ndarray,
    threshold: float | np.ndarray,
    doubt: np.ndarray,
    contact: bool = False,
) -> np.ndarray:
    """Return the reasons (n,) why points stay, keys of STAYS; "" at points that extend.

    k (n, 3): K_I, K_II, K_III; driving (n,): driving force, in the unit of K; span (n,): effective Delta K
    of a cycle, which must exceed the threshold; doubt (n,): error of K; contact: see Evidence.
    """
    words = np.full(len(k), "", object)
    words[span <= threshold] = ARRESTED
    if not contact:
        words[k[:, 0] <= doubt] = CLOSED
    words[driving <= doubt] = NOISE
    words[k[:, 0] < -doubt] = CLOSED
    return words


class CrackFronts(NamedTuple):
    """The fronts of a crack.

    size: crack size, in model units; rows: indices of the points of each front; edge: edge length of the
    fronts; error: median estimated error of K.
    """

    size: float
    rows: Sequence[FrontRows] = ()
    edge: float = 0.0
    error: float = 0.0


def kinks_and_extensions(
    k: np.ndarray,
    fronts: CrackFronts,
    options: GrowthOptions,
    known: Evidence | None = None,
    last: Counted | None = None,
    laws: LocalRates | None = None,
    stiffness: np.ndarray | None = None,
    least: np.ndarray | None = None,
    ways: np.ndarray | None = None,
) -> tuple[FrontStep, Counted]:
    """Return the step of a crack's front points from their K, and the load cycles of the step.

    `criterion_of` gives kink angles and driving forces, `reasons` the points that stay. A point that is not
    trusted takes K of the nearest trusted point. The kink angle is 0 at points that stay as CLOSED or
    NOISE. Normals and binormals are NaN in the step; `dataclasses.replace` sets them.

    k (n, 3): K_I, K_II, K_III; known: reliability of K, exact if None; last: the previous front; laws: rate
    laws by point, those of the options if None; stiffness (n, 6, 6), ways (n,): as in `criterion_of`; least
    (n, 3): K at the other end of the cycle, instead of the options' stress ratio. Raise CraftmeshError as
    `criterion_of` and its functions do.
    """
    count = len(k)
    known = known or Evidence(np.zeros((count, 3)), np.zeros(count), np.ones(count, bool))
    source = sources(known.points, known.trusted, known.front)
    k, doubt = k[source], known.doubt[source]
    criterion = criterion_of(options, stiffness, ways)
    angle = criterion.angles(k)
    driving = criterion.driving(opened(k), angle)
    ratio = np.full(count, options.stress_ratio)
    if least is not None:
        angle, driving, ratio, k = _cycle_peak(criterion, angle, driving, k, least[source])
    laws = laws or local_rates(laws_of(options), np.zeros(count, int), {})
    share = open_share(options.closure, ratio)
    span = share * np.maximum(driving, 0.0)
    stays = reasons(k, driving, span, laws.threshold, doubt, known.contact)
    goes = stays == ""
    angle = np.where(goes | (stays == ARRESTED), angle, 0.0)
    da_dn = np.where(goes, laws.rate(span), 0.0)
    rate, power, cycles = _rates(
        span, da_dn, float(np.median(share)) * fronts.error, fronts, options, laws, last
    )
    step = FrontStep.of(
        known.points,
        kink_angle=angle,
        extension=over_step(rate, power, cycles.step, fronts.rows),
        trusted=known.trusted & has_way(stays),
        stays=stays,
        rate=rate,
        power=np.full(count, power),
        da_dn=da_dn,
        delta_k=span,
        ratio=ratio,
        driving=driving,
    )
    return step, cycles


def has_way(stays: np.ndarray) -> np.ndarray:
    """Return a mask (n,) of points whose K gives a direction, from their reasons (n,) to stay."""
    return ~np.isin(stays, (CLOSED, NOISE))


def _rates(
    span: np.ndarray,
    rate: np.ndarray,
    error: float,
    fronts: CrackFronts,
    options: GrowthOptions,
    laws: LocalRates,
    last: Counted | None,
) -> tuple[np.ndarray, float, Counted]:
    """Return relative rates (n,), their exponent d ln(rate) / d ln(K), and the step with its load cycles.

    The relative rate is da/dN over its median, within the options' limits; with law uniform it is 1, and
    the exponent 0. It is 0 at points that stay. span (n,): effective Delta K; rate (n,): da/dN, 0 at points
    that stay; error: error of Delta K, in its unit.
    """
    goes = rate > 0
    if not goes.any():
        return rate, 0.0, counted(last, fronts.size, 0.0, 0.0, 0.0, 0.0)
    middle, power = float(np.median(rate[goes])), float(np.median(laws.power(span)[goes]))
    growth = growth_to(last, middle, power)
    front = min((one.length for one in fronts.rows), default=np.inf)
    farthest = float(rate.max()) / middle if options.law != "uniform" else 1.0
    step = step_length(
        options, fronts.size, front, fronts.edge, growth / power if power else ROOT, farthest
    )
    count = counted(last, fronts.size, step, middle, power, error / float(np.median(span[goes])))
    if options.law == "uniform":
        return goes.astype(float), 0.0, count
    least, most = options.limits
    floor = np.where(laws.threshold > 0, 0.0, least)
    return np.where(goes, np.clip(rate / middle, floor, most), 0.0), power, count


def _cycle_peak(
    criterion: Criterion, angle: np.ndarray, driving: np.ndarray, k: np.ndarray, other: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return kink angle, driving force, R (n,) and K (n, 3) at each point's peak of the cycle.

    The peak is the cycle end with the larger driving force; it sets the kink angle. R is the other end's
    driving force in that direction divided by the peak's. A negative K_I of the other end, as from a
    solution without contact, is not set to 0. angle, driving, k: at one end; other (n, 3): K at the other
    end.
    """
    angle_there = criterion.angles(other)
    there = criterion.driving(opened(other), angle_there)
    turned = there > driving
    angle, driving = np.where(turned, angle_there, angle), np.where(turned, there, driving)
    k, other = np.where(turned[:, None], other, k), np.where(turned[:, None], k, other)
    drives = driving > 0
    ratio = np.where(drives, criterion.driving(other, angle) / np.where(drives, driving, 1.0), 0.0)
    return angle, driving, np.clip(ratio, LEAST_RATIO, 1.0), k
