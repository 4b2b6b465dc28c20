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
# Rounds of a walk, whose steps are halved where none helps: unit steps along the axes, the diagonals of
# faces, and those of the cube. The first is this part of the length given.
ROUNDS = 10
FIRST_STEP = 0.25
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
def goal_at(cone, x, y, z, best, lighter):
    """Worst quality of the cone from (x, y, z), or what it weighs, negative; exact where over `best`."""
    return -faults_at(cone, x, y, z, -best) if lighter else worst_at(cone, x, y, z, best)


@lean_kernel
def walk(cone, place, step, disc, ways, span, lighter):
    """Walk while the worst quality rises, up to the end of `span`; return place and quality.

    step: the first one's length; disc: a place and how far from it the walk may lead; it goes along
    the rows of ways (3, 3); lighter: the value is what the cone weighs by its faults, negative.
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
