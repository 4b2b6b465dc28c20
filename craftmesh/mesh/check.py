"""Checks of the invariants of a volume, crack, surface or mesh."""

from craftmesh.arguments import typed
from craftmesh.cracks.check_crack import check_crack
from craftmesh.mesh.check_tets import check_tets
from craftmesh.surface.check_surface import check_surface
from craftmesh.types import Crack, Surface, TetMesh, Voxels


@typed
def check(thing: Voxels | Crack | Surface | TetMesh) -> list[str]:
    """Return a sentence for each broken invariant of a volume, crack, surface or mesh; [] for none."""
    if isinstance(thing, Voxels):
        return [] if (thing.labels > 0).any() else ["no voxel belongs to a grain; expected labels > 0"]
    if isinstance(thing, Crack):
        return check_crack(thing)
    return check_surface(thing) if isinstance(thing, Surface) else check_tets(thing)
