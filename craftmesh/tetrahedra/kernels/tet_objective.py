"""What a change has to better: the worst quality, the sum of aspect ratios, or what tets at fault weigh.

A rise of the worst quality spreads what the surface forces on one tet over several, until all are as bad.
Where what they weigh is to fall they count each.

The value of some tets is their worst quality, or less the sum; a change has to raise it by the aim's gain.
"""

from collections import namedtuple

import numpy as np

from craftmesh.jit import lean_kernel
from craftmesh.mesh.shape_measures import FLAT_DIHEDRALS
from craftmesh.tetrahedra.kernels.tet_cavity import worst_of
from craftmesh.tetrahedra.kernels.tet_quality import (
    INVERTED,
    POOR,
    VOLUME_LENGTH,
    WHOLE,
    aspect_ratio_of,
    aspect_ratio_over,
    quality_at,
    quality_of,
)

# Objectives. FAULTS go by the measure WHOLE.
WORST, RATIOS, FAULTS = range(3)
# The objective; the measure of quality; the quality that passes go for, which by RATIOS no tet falls under,
# unless it was; what the value has to gain, less than 0 where it may fall; what is taken off each ratio, so
# that with the mean of all the mean falls, whatever the numbers of tets.
Aim = namedtuple("Aim", "objective measure floor gain reference")
# What an insertion has to gain, by objective: it costs elements.
INSERTION_GAIN = (0.01, 1.0, 0.5)
# What the worst quality has to rise by, and what faults weigh to fall, so that rounding starts no endless
# changes.
GAIN, FALL = 1e-4, 0.05
# The quality by WHOLE from which tets are neither poor nor stretched, and that of flat ones.
SOUND_FROM = 2 * POOR
FLAT_TO = float(np.sin(np.radians(FLAT_DIHEDRALS[0])))
# What a stretched, a poor and a flat tet weigh, and one without volume. Where a flat one outweighs any
# number of others, noisy volumes end with twice as many poor ones.
OF_STRETCHED, OF_POOR, OF_FLAT, NO_TET = 1.0, 10.0, 100.0, 1e9
# Over a limit, weights fall to those beyond it over so much quality: a search sees the way down, and no tet
# is left on the limit itself.
RAMP = 0.012
# The worst of the stretched tets weigh more than the best by this part.
SLOPE = 0.2


@lean_kernel
def fault_weight(quality):
    """Return what a tet of a quality by WHOLE weighs: 0 where it is sound."""
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
    return min(OF_FLAT * FLAT_TO / quality, NO_TET) if quality > 0.0 else NO_TET


@lean_kernel
def joined(one, other, objective):
    """Return the value of two sets of tets together."""
    return min(one, other) if objective == WORST else one + other


@lean_kernel
def of_none(objective):
    """Return the value of no tets."""
    return INVERTED if objective == WORST else 0.0


@lean_kernel
def _worth(points, corners, quality, aim):
    """Return the value of one tet of a quality."""
    if aim.objective == WORST:
        return quality
    if aim.objective == FAULTS:
        return -fault_weight(quality)
    a, b, c, d = corners
    return aim.reference - aspect_ratio_of(points, a, b, c, d)


@lean_kernel
def sound_worth(points, corners, aim, limit):
    """Return the value of a new tet; -INVERTED if its quality is not over the limit."""
    a, b, c, d = corners
    if aim.objective == RATIOS and aim.measure == VOLUME_LENGTH:
        ratio = aspect_ratio_over(points, a, b, c, points[d, 0], points[d, 1], points[d, 2], limit)
        return aim.reference - ratio if ratio < INVERTED else -INVERTED
    quality = quality_of(points, a, b, c, d, aim.measure)
    return _worth(points, corners, quality, aim) if quality > limit else -INVERTED


@lean_kernel
def value_of(state, listed, count, aim):
    """Return the value of the tets listed; the state's qualities are by the aim's measure."""
    tets, value = state.tets, of_none(aim.objective)
    for i in range(count):
        t = listed[i]
        corners = (tets[t, 0], tets[t, 1], tets[t, 2], tets[t, 3])
        value = joined(value, _worth(state.points, corners, state.quality[t], aim), aim.objective)
    return value


@lean_kernel
def value_of_new(state, made, aim, work):
    """Return the value of the new tets `work.new[:made]`, whose qualities are known."""
    new, value = work.new, of_none(aim.objective)
    for i in range(made):
        corners = (new[i, 0], new[i, 1], new[i, 2], new[i, 3])
        value = joined(value, _worth(state.points, corners, work.new_quality[i], aim), aim.objective)
    return value


@lean_kernel
def limit_for(state, listed, count, aim):
    """Return the quality that all tets in place of those listed have to exceed."""
    if aim.objective == FAULTS:
        return 0.0
    worst = worst_of(state.quality, listed, count)
    return max(worst + aim.gain if aim.objective == WORST else min(worst, aim.floor), 0.0)


@lean_kernel
def faults_at(cone, x, y, z, limit):
    """Return what the tets of the cone from (x, y, z) weigh; ends where that passes `limit`."""
    points, faces = cone.points, cone.faces
    total = 0.0
    for i in range(cone.count):
        quality = quality_at(points, faces[i, 0], faces[i, 1], faces[i, 2], x, y, z, WHOLE)
        total += fault_weight(quality)
        if total >= limit:
            break
    return total
