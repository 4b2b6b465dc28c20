"""The tets that join one point to given faces, and the search for the best position of this point."""

from collections import namedtuple
from itertools import product

import numpy as np

from craftmesh.jit import lean_kernel
from craftmesh.tetrahedra.kernels.tet_objective import GAIN, faults_at
from craftmesh.tetrahedra.kernels.tet_quality import quality_at

# The first `count` faces (f, 3) on points, each positive with the apex as fourth corner, and the measure
# of quality.
Cone = namedtuple("Cone", "points faces count measure")
# Iterations of a search. Steps go along the axes, face diagonals and space diagonals of a cube, and are
# halved if none helps. The first step is this fraction of the given length.
ROUNDS = 10
FIRST_STEP = 0.25
ANYWHERE = np.eye(3)
_STEPS = np.array([step for step in product((-1.0, 0.0, 1.0), repeat=3) if any(step)])
DIRECTIONS = _STEPS / np.linalg.norm(_STEPS, axis=1, keepdims=True)


@lean_kernel
def worst_at(cone, x, y, z, floor):
    """Return the worst quality of the cone from (x, y, z), or the first quality not over `floor`."""
    points, faces, measure = cone.points, cone.faces, cone.measure
    worst = 1e300
    for i in range(cone.count):
        worst = min(worst, quality_at(points, faces[i, 0], faces[i, 1], faces[i, 2], x, y, z, measure))
        if worst <= floor:
            return worst
    return worst


@lean_kernel
def goal_at(cone, x, y, z, best, lighter):
    """Return the cone's worst quality from (x, y, z) or, if `lighter`, its negative fault weight.

    The value is exact if it exceeds `best`.
    """
    return -faults_at(cone, x, y, z, -best) if lighter else worst_at(cone, x, y, z, best)


@lean_kernel
def walk(cone, place, step, disc, ways, span, lighter):
    """Move the apex while the value of `goal_at` rises; return its position and value.

    step: length of the first step; disc: (centre, radius) within which the apex stays; ways (3, 3): rows
    are the directions of moves; span: the value at `place`, and a value that ends the search.
    """
    x, y, z = place
    home, reach = disc
    best, enough = span
    for _ in range(ROUNDS):
        found = False
        for way in range(len(DIRECTIONS)):
            dx, dy, dz = DIRECTIONS[way]
            px = x + step * (ways[0, 0] * dx + ways[1, 0] * dy + ways[2, 0] * dz)
            py = y + step * (ways[0, 1] * dx + ways[1, 1] * dy + ways[2, 1] * dz)
            pz = z + step * (ways[0, 2] * dx + ways[1, 2] * dy + ways[2, 2] * dz)
            if (px - home[0]) ** 2 + (py - home[1]) ** 2 + (pz - home[2]) ** 2 > reach * reach:
                continue
            value = goal_at(cone, px, py, pz, best, lighter)
            if value > best + GAIN:
                x, y, z, best, found = px, py, pz, value, True
                if best >= enough:
                    return (x, y, z), best
        if not found:
            step *= 0.5
    return (x, y, z), best
