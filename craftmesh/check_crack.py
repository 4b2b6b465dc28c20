"""The invariants of a crack's surface, each breach said in one sentence."""

import numpy as np

from craftmesh.connectivity import unique_edges
from craftmesh.measure import area_vectors
from craftmesh.types import Crack


def check_crack(crack: Crack) -> list[str]:
    """Return one sentence per breach: flat triangles, branches, folded (u, v), fronts off the boundary."""
    breaches = []
    area = np.linalg.norm(area_vectors(crack.points, crack.triangles), axis=1)
    if not len(area):
        return ["the crack has no triangles; expected at least one"]
    flat = np.flatnonzero(area <= 1e-14 * area.max())
    if len(flat):
        breaches.append(f"{len(flat)} triangles without area, the first is {flat[0]}")
    edges, _, count = unique_edges(crack.triangles)
    if (count > 2).any():
        breaches.append(f"{(count > 2).sum()} edges with more than two triangles; a crack must not branch")
    breaches += _check_parameters(crack)
    breaches += _check_fronts(crack, edges[count == 1])
    return breaches


def _check_parameters(crack: Crack) -> list[str]:
    a, b, c = (crack.uv[crack.triangles[:, i]] for i in range(3))
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    turn = np.sign(ux * vy - uy * vx)
    folded = int(min((turn <= 0).sum(), (turn >= 0).sum()))
    return [f"{folded} triangles are folded in (u, v); expected all to turn alike"] if folded else []


def _check_fronts(crack: Crack, boundary: np.ndarray) -> list[str]:
    if not crack.fronts:
        return ["the crack has no front; expected at least one inside the box"]
    on_boundary = set(map(tuple, np.sort(boundary, axis=1).tolist()))
    breaches = []
    for number, front in enumerate(crack.fronts, 1):
        pairs = np.sort(np.stack([front[:-1], front[1:]], axis=1), axis=1).tolist()
        off = sum(tuple(pair) not in on_boundary for pair in pairs)
        if off:
            breaches.append(f"front {number}: {off} of {len(pairs)} edges are not on the crack's boundary")
    return breaches
