"""Limits under which every operation of the gradation is free, and what a refused one must leave alone."""

from craftmesh.gradation.passes import Limits
from craftmesh.gradation.state import State

INF = float("inf")
# No guard but that against intersections asks for anything.
OPEN = Limits(INF, INF, INF, 0.0, 0.0, -1.0, INF, INF, INF, False, INF)


def frozen(state: State) -> list[bytes]:
    """Return all of the mesh and its guards but for the spare row, and the marks of walks."""
    n = int(state.mesh.used[0])
    rows = {name: array for name, array in (state.mesh._asdict() | state.guards._asdict()).items()}
    for name in ("stamp", "facet_stamp", "clock"):
        del rows[name]
    for name in ("points", "size"):
        rows[name] = rows[name][:n]
    return [array.tobytes() for array in rows.values()]
