"""Which way and how far each point of a front goes, which stay and why, and the load cycles it takes."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.growth.kink_angle import (
    driving_intensity,
    kink_angles,
    largest_near_stress,
    near_stress,
    tangential_intensity,
)
from craftmesh.growth.options import LEAST_RATIO, GrowthOptions
from craftmesh.growth.rates import LocalRates, laws_of, local_rates, open_share
from craftmesh.growth.relaxation import FrontRows, over_step
from craftmesh.growth.steps import ROOT, Counted, counted, growth_to, step_length
from craftmesh.growth.trust import sources

CLOSED, ARRESTED, NOISE = "closed", "arrested", "noise"
STAYS = {
    CLOSED: "K_I is not over 0",
    ARRESTED: "Delta K is not over grow.threshold",
    NOISE: "K is not over its own doubt",
}
# Of sigma root(pi a): K under that says nothing. With five edges to the radius exact K are off by up to
# 0.43 % of it (the lens and the crystal of docs/fracture.md), and K_II of a penny under compression, which
# is 0, by 0.54 %.
NOISE_SHARE = 0.01
NEAR_FIELD, SLIP = "near_field", "slip"


class Evidence(NamedTuple):
    """How far K of front points says something: what a driving force is held against.

    points (n, 3); doubt (n,): of K, in its unit. trusted (n,) bool: points that are not take K of the
    trusted ones next to them on their front (n,), see `growth.trust`. contact: whether the field is one in
    which lips do not overlap, so that K_II of closed lips is true.
    """

    points: np.ndarray
    doubt: np.ndarray
    trusted: np.ndarray
    contact: bool = False
    front: np.ndarray | None = None


def doubts(error: np.ndarray, stress: float, radius: float) -> np.ndarray:
    """Return the doubt (n,) of K: its own `error` (n,), or what the mesh alone makes.

    That is NOISE_SHARE of what the body's mean `stress` would give a crack of that radius.
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
    """Return why each point stays, a word of STAYS, or "" where it goes on: (n,) texts.

    k (n, 3); driving (n,): the intensity that drives a point; span (n,): its Delta K over a cycle, which
    has to be over the threshold; doubt (n,): of K. contact: see Evidence.
    """
    words = np.full(len(k), "", object)
    words[span <= threshold] = ARRESTED
    if not contact:
        words[k[:, 0] <= doubt] = CLOSED
    words[driving <= doubt] = NOISE
    words[k[:, 0] < -doubt] = CLOSED
    return words


class CrackFronts(NamedTuple):
    """The fronts of a crack: its size, the rows of each, the edges of their mesh, and the error of K."""

    size: float
    rows: Sequence[FrontRows] = ()
    edge: float = 0.0
    error: float = 0.0


class KinksAndExtensions(NamedTuple):
    """Kink angle (n,) in radians, extension (n,) and driving intensity (n,) of each point of a front.

    rate (n,): da/dN over its median, what the extensions of law power go with, and power: d ln(rate) / d
    ln(K) of it; 1 and 0 of law uniform. stays (n,): why a point does not extend, see `reasons`; the kink
    angle is 0 where K says none. counted: the load cycles. delta_k (n,): what the rate goes with; ratio
    (n,): R of the cycle. da_dn (n,): by the laws, 0 where a point stays.
    """

    kink_angle: np.ndarray
    extension: np.ndarray
    driving: np.ndarray
    rate: np.ndarray
    power: float
    stays: np.ndarray
    counted: Counted
    delta_k: np.ndarray
    ratio: np.ndarray
    da_dn: np.ndarray


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
) -> KinksAndExtensions:
    """Return which way and how far points with K_I, K_II, K_III (n, 3) of a crack's fronts go.

    The way is that of the criterion (Erdogan & Sih 1963 by default). Points that are not trusted take K of
    those next to them. Points stay as `reasons` says; without what is known of K it counts as exact.
    last: the front before; laws: of the points, those of the options by default; stiffness (n, 6, 6): as in
    `largest_near_stress`, which the criterion near_field asks for; least (n, 3): K at the other end of the
    cycle, in place of the options' stress ratio; ways (n,): kink angles of criterion slip, by `slip_ways`.
    Raises CraftmeshError as kink_angles does.
    """
    doubt = np.zeros(len(k)) if known is None else known.doubt
    if known is not None:
        source = sources(known.points, known.trusted, known.front)
        k, doubt, least = k[source], doubt[source], None if least is None else least[source]
    angle, driving, ratio, k = _of_cycle(k, least, options, stiffness, ways)
    laws = laws or local_rates(laws_of(options), np.zeros(len(k), int), {})
    opened = open_share(options.closure, ratio)
    span = opened * np.maximum(driving, 0.0)
    stays = reasons(k, driving, span, laws.threshold, doubt, known is not None and known.contact)
    goes = stays == ""
    angle = np.where(goes | (stays == ARRESTED), angle, 0.0)
    da_dn = np.where(goes, laws.rate(span), 0.0)
    rate, power, count = _rates(
        span, da_dn, float(np.median(opened)) * fronts.error, fronts, options, laws, last
    )
    extension = over_step(rate, power, count.step, fronts.rows)
    return KinksAndExtensions(angle, extension, driving, rate, power, stays, count, span, ratio, da_dn)


def _rates(
    span: np.ndarray,
    rate: np.ndarray,
    error: float,
    fronts: CrackFronts,
    options: GrowthOptions,
    laws: LocalRates,
    last: Counted | None,
) -> tuple[np.ndarray, float, Counted]:
    """Return rates (n,) over their median, their power of K, and the step with its cycles.

    span (n,): Delta K; rate (n,): da/dN, 0 of points that stay; error: of Delta K.
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


def _of_cycle(
    k: np.ndarray,
    least: np.ndarray | None,
    options: GrowthOptions,
    stiffness: np.ndarray | None,
    ways: np.ndarray | None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return kink angle, driving intensity, ratio R (n,) and K (n, 3) of the load that drives each point.

    Of both ends of a cycle that is the one with the larger intensity, which has the kink angle; R is the
    other's intensity that way over it. K_I < 0 of the other, as without contact, counts in R as it is.
    """
    angle, driving = _largest(k, options, stiffness, ways)
    if least is None:
        return angle, driving, np.full(len(k), options.stress_ratio), k
    other_angle, other = _largest(least, options, stiffness, ways)
    turned = other > driving
    angle, driving = np.where(turned, other_angle, angle), np.where(turned, other, driving)
    k, least = np.where(turned[:, None], least, k), np.where(turned[:, None], k, least)
    if options.criterion == NEAR_FIELD and stiffness is not None:
        low = near_stress(least, angle, stiffness)
    else:
        low = tangential_intensity(least, angle)
    drives = driving > 0
    ratio = np.where(drives, low / np.where(drives, driving, 1.0), 0.0)
    return angle, driving, np.clip(ratio, LEAST_RATIO, 1.0), k


def _largest(
    k: np.ndarray, options: GrowthOptions, stiffness: np.ndarray | None, ways: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray]:
    """Return kink angles and driving intensities (n,) of the criterion; K_I < 0 counts as K_I = 0."""
    if options.criterion == SLIP:
        if ways is None:
            raise CraftmeshError("grow.criterion is slip, and its angles are not given; see slip_ways")
        return ways, driving_intensity(k, ways)
    if options.criterion != NEAR_FIELD:
        angle = kink_angles(k, options.criterion, options.poisson)
        return angle, driving_intensity(k, angle)
    if stiffness is None:
        raise CraftmeshError(
            "grow.criterion is near_field, and the crystals are not known; expected their stiffness"
        )
    return largest_near_stress(np.column_stack([np.maximum(k[:, 0], 0.0), k[:, 1:]]), stiffness)
