"""Which way and how far each point of a front goes, which stay and why, and the load cycles it takes."""

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
    CLOSED: "K_I is not over 0",
    ARRESTED: "Delta K is not over grow.threshold",
    NOISE: "K is not over its own doubt",
}
# Of sigma root(pi a): K under that says nothing. With five edges to the radius exact K are off by up to
# 0.43 % of it (the lens and the crystal of docs/fracture.md), and K_II of a penny under compression, which
# is 0, by 0.54 %.
NOISE_SHARE = 0.01


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
    """Return the step of the points of a crack's fronts from their K, and the load cycles that it takes.

    The step lacks the frames of the points (normal, binormal are NaN); `dataclasses.replace` sets them.
    `criterion_of` gives the kink angle and the driving force, `reasons` the points that stay. A point that
    is not trusted takes the K of the nearest trusted point. Where K gives no direction the kink angle is 0.
    Without `known`, K counts as exact.

    k (n, 3): K_I, K_II, K_III; last: the front before; laws: by point, by default the options' own;
    stiffness (n, 6, 6) and ways (n,): as in `criterion_of`; least (n, 3): K at the other end of the cycle,
    in place of the options' stress ratio. Raises CraftmeshError as `criterion_of` and its functions do.
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
    """Return a mask of points whose K says which way they would go, by the words (n,) why they stay."""
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


def _cycle_peak(
    criterion: Criterion, angle: np.ndarray, driving: np.ndarray, k: np.ndarray, other: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return kink angle, driving force, R (n,) and K (n, 3) at the end of a cycle that drives each point.

    That is the end with the larger driving force, which sets the kink angle. R is the force of the other
    end in that direction divided by it. K_I < 0 of the other, as without contact, counts in R as it is.
    """
    angle_there = criterion.angles(other)
    there = criterion.driving(opened(other), angle_there)
    turned = there > driving
    angle, driving = np.where(turned, angle_there, angle), np.where(turned, there, driving)
    k, other = np.where(turned[:, None], other, k), np.where(turned[:, None], k, other)
    drives = driving > 0
    ratio = np.where(drives, criterion.driving(other, angle) / np.where(drives, driving, 1.0), 0.0)
    return angle, driving, np.clip(ratio, LEAST_RATIO, 1.0), k
