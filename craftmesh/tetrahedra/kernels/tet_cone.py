"""The tets that join one point to given faces, and the search for the best position of this point."""

from collections import namedtuple
from itertools import product

import numpy as np

from craftmesh.jit import lean_kernel
from craftmesh.tetrahedra.kernels.tet_objective import GAIN, faults_at
from craftmesh.tetrahedra.kernels.tet_quality import quality_at

# Tets that join an apex to the first `count` faces (f, 3) on points. At the start each tet has a positive
# volume; measure: of quality (`tet_quality`).
Cone = namedtuple("Cone", "points faces count measure")
# Number of iterations of a search. Steps go along the axes, face diagonals and space diagonals of a cube,
# and are halved if none helps. The first step is FIRST_STEP times a length that the caller chooses: half
# the edge for an insertion, the smaller of target length and reach for a move.
SEARCH_ITERATIONS = 10
FIRST_STEP = 0.25
ANYWHERE = np.eye(3)
_STEPS = np.array([step for step in product((-1.0, 0.0, 1.0), repeat=3) if any(step)])
DIRECTIONS = _STEPS / np.linalg.norm(_STEPS, axis=1, keepdims=True)


@lean_kernel
def worst_at(cone, x, y, z, floor):
    """Return the worst quality of the cone's tets, which join its faces to the apex (x, y, z).

    The search ends at a quality of `floor` or less, which is then returned.
    """
    points, faces, measure = cone.points, cone.faces, cone.measure
    worst = 1e300
    for i in range(cone.count):
        worst = min(worst, quality_at(points, faces[i, 0], faces[i, 1], faces[i, 2], x, y, z, measure))
        if worst <= floor:
            return worst
    return worst


@lean_kernel
def goal_at(cone, x, y, z, best, lighter):
    """Return the value of the cone's tets with the apex at (x, y, z); more is better.

    It is their worst quality or, if `lighter`, minus their fault weight, a penalty on flat, poor and
    stretched tets. The value is exact only if it exceeds `best`.
    """
    return -faults_at(cone, x, y, z, -best) if lighter else worst_at(cone, x, y, z, best)


@lean_kernel
def walk(cone, place, step, disc, ways, span, lighter):
    """Move the cone's apex from `place` while the value of `goal_at` rises; return position and value.

    step: length of the first step; disc: (centre, radius) within which the apex stays; ways (3, 3): rows
    are the directions of moves; span: the value at `place`, and a value that ends the search. There are at
    most SEARCH_ITERATIONS iterations.
    """
    x, y, z = place
    home, reach = disc
    best, enough = span
    for _ in range(SEARCH_ITERATIONS):
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
