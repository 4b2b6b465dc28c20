"""A crack's surface from the files that its options name: triangles, points, fronts or voxels."""

import numpy as np

from craftmesh.cracks.fit_bounds import Numbers
from craftmesh.cracks.measured import crack_through_fronts, crack_through_points
from craftmesh.cracks.options import CrackOptions, crack_files, given_file
from craftmesh.cracks.prescription import check_crack
from craftmesh.cracks.series import GivenSurface
from craftmesh.cracks.swept_path import crack_along_path
from craftmesh.cracks.voxel_crack import crack_through_voxels
from craftmesh.errors import CraftmeshError
from craftmesh.io.front_csv import read_fronts, read_path
from craftmesh.io.point_files import read_points
from craftmesh.io.surface_files import listed_suffixes, read_triangles
from craftmesh.io.vtk import read_crack
from craftmesh.types import Voxels
from craftmesh.voxels.reading import read_marked


def given_surface(
    options: CrackOptions,
    increment: int,
    box: np.ndarray,
    grid: Voxels | None = None,
    l_min: float | None = None,
) -> tuple[GivenSurface | None, Numbers]:
    """Return the surface of `increment`, None for shapes by numbers, and how far it is from its source.

    box (2, 3): the model's; grid: its voxels where they are known; l_min: by which a surface may be off
    measured points. Raises CraftmeshError that names the key or the file.
    """
    check_crack(options, increment)
    if options.shape == "surface":
        return _triangulated(options, increment), {}
    if options.shape == "fronts":
        names = [name for key, name in crack_files(options, increment).items() if key != "front"]
        fronts = [_one_front(name) for name in names or [str(given_file(options, increment))]]
        return crack_through_fronts(fronts, box, options.spacing, options.inside)
    if options.shape == "points":
        cloud, fronts = read_points(given_file(options, increment)), read_fronts(str(options.front))
        return crack_through_points(cloud, fronts, box, options.spacing, l_min)
    if options.shape == "path":
        return crack_along_path(read_path(given_file(options, increment)), options, increment, box)
    if options.shape == "voxels":
        marked = read_marked(given_file(options, increment), options.label, grid)
        return crack_through_voxels(*marked, box, options.spacing)
    return None, {}


def _triangulated(options: CrackOptions, increment: int) -> GivenSurface:
    """Return the triangles of a file; a .vtp's lines are its fronts, but for those of options.front."""
    path = given_file(options, increment)
    if not path.is_file():
        raise CraftmeshError(
            f"crack.file {path} does not exist; expected a triangulated surface .vtp, {listed_suffixes()}"
        )
    if path.suffix.lower() != ".vtp":
        surface = GivenSurface(*read_triangles(path))
    else:
        known = read_crack(path)
        fronts = tuple(known.points[front] for front in known.fronts)
        surface = GivenSurface(known.points, known.triangles, fronts)
    if not options.front:
        return surface
    return GivenSurface(surface.points, surface.triangles, tuple(read_fronts(options.front)))


def _one_front(path: str) -> np.ndarray:
    fronts = read_fronts(path)
    if len(fronts) > 1:
        raise CraftmeshError(f"{path}: has {len(fronts)} fronts; expected one in the file of an increment")
    return fronts[0]
