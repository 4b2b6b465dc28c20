"""Objectives of the optimiser: the worst quality, the sum of aspect ratios, or the weight of faults.

Raising the worst quality spreads the shape that the surface forces on one tet over several tets, until all
are equally bad. The weight of faults counts each faulty tet instead.

The value of a set of tets is its worst quality, minus its sum of aspect ratios (each less the aim's
reference), or minus its fault weights. A change must raise the value by the aim's gain.
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

# Objectives. FAULTS needs the measure WHOLE.
WORST, RATIOS, FAULTS = range(3)
# objective; measure of quality; floor: quality that passes aim at, below which RATIOS lowers no tet (except
# tets that are lower already); gain: minimum rise of the value, negative if it may fall; reference: number
# subtracted from each aspect ratio. With the mean of all as reference, the mean falls for any number of
# tets.
Aim = namedtuple("Aim", "objective measure floor gain reference")
# Minimum gain of an insertion, by objective; an insertion costs elements.
INSERTION_GAIN = (0.01, 1.0, 0.5)
# Minimum rise of the worst quality, and minimum fall of the fault weight, so that rounding causes no
# endless changes.
GAIN, FALL = 1e-4, 0.05
# Quality by WHOLE from which on tets are neither poor nor stretched, and below which they are flat.
SOUND_FROM = 2 * POOR
FLAT_TO = float(np.sin(np.radians(FLAT_DIHEDRALS[0])))
# Weights of a stretched, a poor and a flat tet, and of a tet without volume. If a flat tet outweighed any
# number of others, noisy volumes would end with twice as many poor tets.
OF_STRETCHED, OF_POOR, OF_FLAT, NO_TET = 1.0, 10.0, 100.0, 1e9
# Width in quality over which the weight falls above a limit, so that a search has a slope to follow and no
# tet stays on the limit itself.
RAMP = 0.012
# Fraction by which the worst stretched tet weighs more than the best.
SLOPE = 0.2


@lean_kernel
def fault_weight(quality):
    """Return the fault weight of a tet with this quality by WHOLE: 0 if neither poor nor stretched."""
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
    """Return the value of the union of two sets of tets with the values `one` and `other`."""
    return min(one, other) if objective == WORST else one + other


@lean_kernel
def of_none(objective):
    """Return the value of an empty set of tets."""
    return INVERTED if objective == WORST else 0.0


@lean_kernel
def _worth(points, corners, quality, aim):
    """Return the value of one tet; corners: its four nodes; quality: by the aim's measure."""
    if aim.objective == WORST:
        return quality
    if aim.objective == FAULTS:
        return -fault_weight(quality)
    a, b, c, d = corners
    return aim.reference - aspect_ratio_of(points, a, b, c, d)


@lean_kernel
def sound_worth(points, corners, aim, limit):
    """Return the value of a new tet with four corners, -INVERTED if its quality is not over the limit."""
    a, b, c, d = corners
    if aim.objective == RATIOS and aim.measure == VOLUME_LENGTH:
        ratio = aspect_ratio_over(points, a, b, c, points[d, 0], points[d, 1], points[d, 2], limit)
        return aim.reference - ratio if ratio < INVERTED else -INVERTED
    quality = quality_of(points, a, b, c, d, aim.measure)
    return _worth(points, corners, quality, aim) if quality > limit else -INVERTED


@lean_kernel
def value_of(state, listed, count, aim):
    """Return the value of the tets listed[:count]; the state's qualities are by the aim's measure."""
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
    """Return the quality that all tets which replace listed[:count] must exceed."""
    if aim.objective == FAULTS:
        return 0.0
    worst = worst_of(state.quality, listed, count)
    return max(worst + aim.gain if aim.objective == WORST else min(worst, aim.floor), 0.0)


@lean_kernel
def faults_at(cone, x, y, z, limit):
    """Return the fault weight of the cone from (x, y, z), or a partial sum that reaches `limit`."""
    points, faces = cone.points, cone.faces
    total = 0.0
    for i in range(cone.count):
        quality = quality_at(points, faces[i, 0], faces[i, 1], faces[i, 2], x, y, z, WHOLE)
        total += fault_weight(quality)
        if total >= limit:
            break
    return total
