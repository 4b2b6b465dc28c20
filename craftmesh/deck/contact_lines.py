"""Lines of the deck by which lips of cracks press on each other."""

from collections.abc import Iterator

from craftmesh.mesh.mesh_sets import is_lip
from craftmesh.types import TetMesh

_INTERACTION = "*SURFACE INTERACTION, NAME=LIPS\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=HARD\n"


def contact_lines(mesh: TetMesh) -> Iterator[str]:
    """Yield a contact pair, without friction, of the two lips of each crack."""
    lips = [
        name for name, faces in mesh.face_sets.items() if is_lip(name) and name.endswith("A") and len(faces)
    ]
    if lips:
        yield _INTERACTION
    for name in lips:
        yield f"*CONTACT PAIR, INTERACTION=LIPS, TYPE=SURFACE TO SURFACE\n{name}, {name[:-1]}B\n"
