"""Objectives of the optimiser: the worst quality, the sum of aspect ratios, or the fault weight.

Raising the worst quality spreads the bad shape that the surface forces on one tet over several tets, until
all are equally bad. The fault weight instead adds a penalty for each flat, poor or stretched tet.

By WORST, the value of a set of tets is its worst quality. By RATIOS, it is the sum of the aim's reference
minus the aspect ratio over its tets. By FAULTS, it is minus the sum of its fault weights. A change must
raise the value by the aim's gain.
"""

from collections import namedtuple

import numpy as np

from craftmesh.jit import lean_kernel
from craftmesh.mesh.shape_measures import FLAT_DIHEDRALS
from craftmesh.tetrahedra.kernels.tet_cavity import worst_of
from craftmesh.tetrahedra.kernels.tet_quality import (
    COMBINED_QUALITY,
    INVERTED,
    POOR,
    VOLUME_LENGTH,
    aspect_ratio_of,
    aspect_ratio_over,
    quality_at,
    quality_of,
)

# Objectives. FAULTS needs the measure COMBINED_QUALITY.
WORST, RATIOS, FAULTS = range(3)
# objective; measure of quality; floor: quality that WORST and FAULTS aim at, and below which RATIOS takes
# no tet unless a replaced tet was lower; gain: smallest rise of the value, negative if it may fall;
# reference: number subtracted from each aspect ratio. With the mean of all tets as reference, a rise of the
# value lowers the mean, also if the number of tets changes.
Aim = namedtuple("Aim", "objective measure floor gain reference")
# Smallest rise of the value by an insertion, for each objective. It is larger than for other operations,
# because an insertion adds elements.
INSERTION_GAIN = (0.01, 1.0, 0.5)
# Smallest rise of the worst quality, and smallest fall of the fault weight, by other operations, so that
# rounding causes no endless changes.
GAIN, FALL = 1e-4, 0.05
# Quality by COMBINED_QUALITY from which tets are neither poor nor stretched, and quality below which they
# are flat.
SOUND_FROM = 2 * POOR
FLAT_TO = float(np.sin(np.radians(FLAT_DIHEDRALS[0])))
# Fault weights of a stretched, a poor and a flat tet, and of a tet without volume. With a weight of a flat
# tet above that of any number of poor tets, volumes with rough surfaces would end with twice as many poor
# tets.
OF_STRETCHED, OF_POOR, OF_FLAT, NO_TET = 1.0, 10.0, 100.0, 1e9
# Range of quality above a limit (POOR or SOUND_FROM) over which the weight falls gradually, so that a
# search has a slope to follow and no tet stays on the limit itself.
RAMP = 0.012
# Fraction by which the worst stretched tet weighs more than the best.
SLOPE = 0.2


@lean_kernel
def fault_weight(quality):
    """Return the fault weight of a tet with this quality by COMBINED_QUALITY: 0 if neither poor nor
    stretched."""
    if quality >= SOUND_FROM + RAMP:
        return 0.0
    if quality >= SOUND_FROM:
        return OF_STRETCHED * (SOUND_FROM + RAMP - quality) / RAMP
    if quality >= POOR:
        stretched = OF_STRETCHED * (1.0 + SLOPE * (SOUND_FROM - quality) / POOR)
        share = max(POOR + RAMP - quality, 0.0) / RAMP
        return (1.0 - share) * stretched + share * OF_POOR
    if quality >= FLAT_TO:
        return OF_POOR * POOR / quality
    # a tet without volume weighs more than any tet with a volume
    return min(OF_FLAT * FLAT_TO / quality, 0.5 * NO_TET) if quality > 0.0 else NO_TET


@lean_kernel
def joined(one, other, objective):
    """Return the value of the union of two sets of tets with the values `one` and `other`.

    For the objective WORST it is the smaller value, else the sum.
    """
    return min(one, other) if objective == WORST else one + other


@lean_kernel
def of_none(objective):
    """Return the value of an empty set of tets, from which `joined` starts."""
    return INVERTED if objective == WORST else 0.0


@lean_kernel
def _worth(points, corners, quality, aim):
    """Return the value of one tet by the aim's objective; corners: its four nodes.

    quality: the tet's quality by the aim's measure.
    """
    if aim.objective == WORST:
        return quality
    if aim.objective == FAULTS:
        return -fault_weight(quality)
    a, b, c, d = corners
    return aim.reference - aspect_ratio_of(points, a, b, c, d)


@lean_kernel
def sound_worth(points, corners, aim, limit):
    """Return the value of a new tet with nodes `corners`, -INVERTED if its quality is not over `limit`."""
    a, b, c, d = corners
    if aim.objective == RATIOS and aim.measure == VOLUME_LENGTH:
        ratio = aspect_ratio_over(points, a, b, c, points[d, 0], points[d, 1], points[d, 2], limit)
        return aim.reference - ratio if ratio < INVERTED else -INVERTED
    quality = quality_of(points, a, b, c, d, aim.measure)
    return _worth(points, corners, quality, aim) if quality > limit else -INVERTED


@lean_kernel
def value_of(state, listed, count, aim):
    """Return the value of the tets listed[:count] by the aim's objective.

    state.quality must be by the aim's measure.
    """
    tets, value = state.tets, of_none(aim.objective)
    for i in range(count):
        t = listed[i]
        corners = (tets[t, 0], tets[t, 1], tets[t, 2], tets[t, 3])
        value = joined(value, _worth(state.points, corners, state.quality[t], aim), aim.objective)
    return value


@lean_kernel
def value_of_new(state, made, aim, work):
    """Return the value of the new tets work.new[:made] by the aim's objective.

    Their qualities by the aim's measure must be in work.new_quality.
    """
    new, value = work.new, of_none(aim.objective)
    for i in range(made):
        corners = (new[i, 0], new[i, 1], new[i, 2], new[i, 3])
        value = joined(value, _worth(state.points, corners, work.new_quality[i], aim), aim.objective)
    return value


@lean_kernel
def limit_for(state, listed, count, aim):
    """Return the quality that each tet that replaces listed[:count] must exceed, at least 0.

    For WORST it is the old tets' worst quality plus the aim's gain; for RATIOS the smaller of this worst
    quality and the aim's floor; for FAULTS it is 0.
    """
    if aim.objective == FAULTS:
        return 0.0
    worst = worst_of(state.quality, listed, count)
    return max(worst + aim.gain if aim.objective == WORST else min(worst, aim.floor), 0.0)


@lean_kernel
def faults_at(cone, x, y, z, limit):
    """Return the fault weight, summed over the cone's tets with the apex at (x, y, z).

    It is a penalty on flat, poor and stretched tets (`fault_weight`). The sum ends early when it reaches
    `limit`.
    """
    points, faces = cone.points, cone.faces
    total = 0.0
    for i in range(cone.count):
        quality = quality_at(points, faces[i, 0], faces[i, 1], faces[i, 2], x, y, z, COMBINED_QUALITY)
        total += fault_weight(quality)
        if total >= limit:
            break
    return total
