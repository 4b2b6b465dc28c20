"""The tets that join one point to given faces, and the search for the best place of that point."""

from collections import namedtuple
from itertools import product

import numpy as np

from craftmesh.jit import lean_kernel
from craftmesh.tetrahedra.kernels.tet_objective import GAIN, faults_at
from craftmesh.tetrahedra.kernels.tet_quality import quality_at

# The first `count` faces (f, 3) on points, each positive with the apex as fourth corner, and the measure
# of quality that counts.
Cone = namedtuple("Cone", "points faces count measure")
# The climb. All are chosen by hand; lengths are parts of the cone's size.
# Step of the finite differences that give the direction: small beside the steps, large beside rounding.
DIFFERENCE = 1e-4
# The first step taken; a step that helps lets the next one grow, one that does not is tried shorter.
FIRST_STEP = 0.15
LONGER, SHORTER = 1.3, 0.4
TRIALS = 5
# Of a cone's two worst tets, the second counts for the direction when it is this close to the worst.
CLOSE = 0.03
# Two opposite directions that sum up to less than this lead nowhere.
LEVEL = 1e-6
# A step that gains less quality ends the climb.
LEAST_GAIN = 1e-3
# Rounds of a walk, whose steps are halved where none helps: unit steps along the axes, the diagonals of
# faces, and those of the cube. Inside, the first is this part of the length given.
ROUNDS = 10
INSIDE_STEP = 0.25
ANYWHERE = np.eye(3)
_STEPS = np.array([step for step in product((-1.0, 0.0, 1.0), repeat=3) if any(step)])
DIRECTIONS = _STEPS / np.linalg.norm(_STEPS, axis=1, keepdims=True)


@lean_kernel
def worst_at(cone, x, y, z, floor):
    """Worst quality of the cone from (x, y, z); ends at the first tet that is not over `floor`."""
    points, faces, measure = cone.points, cone.faces, cone.measure
    worst = 1e300
    for i in range(cone.count):
        worst = min(worst, quality_at(points, faces[i, 0], faces[i, 1], faces[i, 2], x, y, z, measure))
        if worst <= floor:
            return worst
    return worst


@lean_kernel
def mean_at(cone, x, y, z):
    """Mean quality of the cone from (x, y, z)."""
    points, faces, measure = cone.points, cone.faces, cone.measure
    total = 0.0
    for i in range(cone.count):
        total += quality_at(points, faces[i, 0], faces[i, 1], faces[i, 2], x, y, z, measure)
    return total / cone.count


@lean_kernel
def _ascent(cone, i, place, value, h):
    """Unit direction in which the quality of tet i of the cone rises fastest (finite differences)."""
    points, measure = cone.points, cone.measure
    a, b, c = cone.faces[i, 0], cone.faces[i, 1], cone.faces[i, 2]
    x, y, z = place
    dx = quality_at(points, a, b, c, x + h, y, z, measure) - value
    dy = quality_at(points, a, b, c, x, y + h, z, measure) - value
    dz = quality_at(points, a, b, c, x, y, z + h, measure) - value
    length = np.sqrt(dx * dx + dy * dy + dz * dz) + 1e-300
    return dx / length, dy / length, dz / length


@lean_kernel
def _climb_direction(cone, place, h):
    """Direction in which the worst tet of the cone (and the second, if close) improves; not normed."""
    points, faces, measure = cone.points, cone.faces, cone.measure
    x, y, z = place
    first, second, i_first, i_second = 1e300, 1e300, -1, -1
    for i in range(cone.count):
        value = quality_at(points, faces[i, 0], faces[i, 1], faces[i, 2], x, y, z, measure)
        if value < first:
            second, i_second = first, i_first
            first, i_first = value, i
        elif value < second:
            second, i_second = value, i
    gx, gy, gz = _ascent(cone, i_first, place, first, h)
    if i_second >= 0 and second <= first + CLOSE:
        dx, dy, dz = _ascent(cone, i_second, place, second, h)
        gx, gy, gz = gx + dx, gy + dy, gz + dz
    return gx, gy, gz


@lean_kernel
def climb(cone, place, size, steps, best):
    """Hill climb for the apex with the best worst quality, `best` at first; return place and quality.

    size: a length of the cone, of which the first step is a part.
    """
    x, y, z = place
    step = FIRST_STEP * size
    for _ in range(steps):
        gx, gy, gz = _climb_direction(cone, (x, y, z), DIFFERENCE * size)
        length = np.sqrt(gx * gx + gy * gy + gz * gz)
        if length < LEVEL:
            break
        gain = 0.0
        for _ in range(TRIALS):
            px, py, pz = x + step * gx / length, y + step * gy / length, z + step * gz / length
            value = worst_at(cone, px, py, pz, best)
            if value > best:
                x, y, z, gain, best = px, py, pz, value - best, value
                step *= LONGER
                break
            step *= SHORTER
        if gain < LEAST_GAIN:
            break
    return (x, y, z), best


@lean_kernel
def _goal(cone, x, y, z, best, lighter):
    """Worst quality of the cone from (x, y, z), or what it weighs, negative; exact where over `best`."""
    return -faults_at(cone, x, y, z, -best) if lighter else worst_at(cone, x, y, z, best)


@lean_kernel
def walk(cone, place, step, disc, free, span, lighter):
    """Walk while the worst quality rises, up to the end of `span`; return place and quality.

    step: the first one's length; disc: a place and how far from it the walk may lead; free (3, 3) makes of
    each step one that is allowed; lighter: the value is what the cone weighs by its faults, negative.
    """
    x, y, z = place
    home, reach = disc
    best, enough = span
    for _ in range(ROUNDS):
        found = False
        for way in range(len(DIRECTIONS)):
            dx, dy, dz = DIRECTIONS[way]
            px = x + step * (free[0, 0] * dx + free[0, 1] * dy + free[0, 2] * dz)
            py = y + step * (free[1, 0] * dx + free[1, 1] * dy + free[1, 2] * dz)
            pz = z + step * (free[2, 0] * dx + free[2, 1] * dy + free[2, 2] * dz)
            if (px - home[0]) ** 2 + (py - home[1]) ** 2 + (pz - home[2]) ** 2 > reach * reach:
                continue
            value = _goal(cone, px, py, pz, best, lighter)
            if value > best + GAIN:
                x, y, z, best, found = px, py, pz, value, True
                if best >= enough:
                    return (x, y, z), best
        if not found:
            step *= 0.5
    return (x, y, z), best
