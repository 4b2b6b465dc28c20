"""What flat, poor and stretched tets weigh, and the place of a point where those round it weigh the least.

A rise of the worst quality spreads what the surface forces on one tet over several, until all are as bad:
an aspect ratio of 7.4 four times for one of 9. Where what they weigh is to fall they count each.
"""

from craftmesh.jit import lean_kernel
from craftmesh.tetrahedra.kernels.tet_cone import beside
from craftmesh.tetrahedra.kernels.tet_quality import POOR, WHOLE, quality_at

# The quality by WHOLE from which tets are neither poor nor stretched, and that of flat ones: sin 5 degrees.
SOUND_FROM = 2 * POOR
FLAT_TO = 0.0872
# What a stretched, a poor and a flat tet weigh, and one without volume. With any number of stretched and
# poor ones for a flat one a noisy volume went from 386, 93 and 30 to 926, 197 and 26.
OF_STRETCHED, OF_POOR, OF_FLAT, NO_TET = 1.0, 10.0, 100.0, 1e9
# Over a limit, weights fall to those beyond it over so much quality: a search sees the way down, and no tet
# is left on the limit itself.
RAMP = 0.012
# The worst of the stretched tets weigh more than the best by this part.
SLOPE = 0.2
# A change has to lower the weight by this much.
FALL = 0.05
# A search: the first step in the lengths given, how steps shrink, rounds.
FIRST_STEP = 0.25
SHORTER = 0.5
ROUNDS = 8


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
def faults_of(state, listed, count):
    """Return what the tets listed weigh; the state's qualities are by WHOLE."""
    total = 0.0
    for i in range(count):
        total += fault_weight(state.quality[listed[i]])
    return total


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


@lean_kernel
def lightest_place(cone, place, size, weight):
    """Return the place that a walk from one finds, and what the cone weighs there; `weight` at first.

    size: a length of the cone, of which the first step is a part.
    """
    x, y, z = place
    step = FIRST_STEP * size
    for _ in range(ROUNDS):
        found = False
        for way in range(6):
            px, py, pz = beside(x, y, z, way, step)
            value = faults_at(cone, px, py, pz, weight)
            if value < weight:
                x, y, z, weight, found = px, py, pz, value, True
        if weight <= 0.0:
            break
        if not found:
            step *= SHORTER
    return (x, y, z), weight
