"""The cracks of a growth series, prescribed increment by increment or read from files."""

import numpy as np

from craftmesh.cracks.shapes import CrackOptions, prescribed_crack, surface_file
from craftmesh.cracks.triangulated import boundary_loops, crack_from_triangles
from craftmesh.errors import CraftmeshError
from craftmesh.surface.measure import area_vectors
from craftmesh.types import Crack


def crack_of_increment(options: CrackOptions, increment: int, box) -> Crack:
    """Return the crack of `increment` in the box (2, 3), reading its files where the shape is `surface`.

    A .vtp written as a crack keeps its fronts; a front in options.front (csv) goes before it; else the
    boundary within the box is front. Raises CraftmeshError as prescribed_crack and the readers do.
    """
    if options.shape != "surface":
        return prescribed_crack(options, increment, box)
    path = surface_file(options, increment)
    if not path.is_file():
        raise CraftmeshError(
            f"crack.file {path} does not exist; expected a triangulated surface .vtp or .stl"
        )
    fronts = None
    if path.suffix.lower() == ".stl":
        from craftmesh.io.stl import read_stl

        points, triangles = read_stl(path)
    else:
        from craftmesh.io.vtk import read_crack

        known = read_crack(path)
        points, triangles = known.points, known.triangles
        fronts = [known.points[front] for front in known.fronts] or None
    if options.front is not None:
        from craftmesh.io.front_csv import read_front_points

        fronts = [read_front_points(options.front)]
    return crack_from_triangles(points, triangles, fronts, box)


def check_crack(crack: Crack) -> list[str]:
    """Return one sentence per breach: empty, degenerate or folded triangles, bad boundary, bad fronts."""
    breaches = []
    if not len(crack.triangles):
        return ["the crack has no triangles"]
    if not np.isfinite(crack.points).all() or not np.isfinite(crack.uv).all():
        return ["the crack has points that are not finite"]
    a, b, c = (crack.uv[crack.triangles[:, i]] for i in range(3))
    u, v = b - a, c - a
    twice = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    if twice.min() < 0 < twice.max():
        breaches.append(f"{int((twice < 0).sum())} triangles are turned over in (u, v)")
    flat = np.linalg.norm(area_vectors(crack.points, crack.triangles), axis=1) == 0
    if flat.any():
        breaches.append(f"{int(flat.sum())} triangles have no area")
    try:
        boundary = {pair for loop in boundary_loops(crack.triangles) for pair in zip(loop[:-1], loop[1:])}
    except CraftmeshError as error:
        return [*breaches, str(error)]
    if not crack.fronts:
        breaches.append("the crack has no front")
    for number, front in enumerate(crack.fronts, 1):
        edges = zip(front[:-1].tolist(), front[1:].tolist())
        off = sum((a, b) not in boundary and (b, a) not in boundary for a, b in edges)
        if off:
            breaches.append(f"front {number} has {off} edges that are not on the crack's boundary")
    return breaches
