"""Lines of the deck for contact: lips of cracks on each other, and two rigid plates, for Abaqus alone."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from craftmesh.deck.inp_format import number
from craftmesh.mechanics.load import Fixed, Load
from craftmesh.mechanics.model import ElasticModel
from craftmesh.mesh.mesh_sets import is_lip
from craftmesh.types import TetMesh

# Pressure over overlap, times the body's length over its stiffness: lips of a crack a quarter of the body
# long overlap by 2e-3 of what they would without contact. Ten times as much has CalculiX take up to 12
# iterations an increment where lips meet, in place of 8. Its own (50 E) depends on the unit of length.
_PENALTY = 1e3

_NAME = "PLATE_{}"
# Of the distance of a face's corners from its middle: the body spreads, and shall not slip off the plate.
_RADIUS = 2.0


def contact_lines(model: ElasticModel) -> Iterator[str]:
    """Yield a contact pair, without friction, of the two lips of each crack."""
    mesh = model.mesh
    lips = [name for name, faces in mesh.face_sets.items() if is_lip(name) and len(faces)]
    if lips:
        stiffness = _PENALTY * model.stiffness().max() / np.ptp(mesh.box, axis=0).max()
        yield "*SURFACE INTERACTION, NAME=LIPS\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n"
        yield f"{number(float(stiffness))}\n"
    for name in [name for name in lips if name.endswith("A")]:
        yield f"*CONTACT PAIR, INTERACTION=LIPS, TYPE=SURFACE TO SURFACE\n{name}, {name[:-1]}B\n"


def plate_lines(load: Load, mesh: TetMesh) -> Iterator[str]:
    """Yield a disc on each plane of the box that `load` moves or holds, in contact without friction.

    An analytical rigid surface, which touches the body on the left of its profile: START to LINE outwards
    has the side towards b, a point on its axis, left. Its reference node follows the mesh's in number.
    """
    yield "*SURFACE INTERACTION, NAME=PLATES\n"
    middle, half = mesh.box.mean(axis=0), np.ptp(mesh.box, axis=0) / 2
    for node, plane in enumerate(_planes(load), start=len(mesh.points) + 1):
        axis = "XYZ".index(plane[0])
        at = middle.copy()
        at[axis] = mesh.box[int(plane.endswith("MAX")), axis]
        place, inwards = (", ".join(map(number, point.tolist())) for point in (at, middle))
        radius = number(float(_RADIUS * np.linalg.norm(np.delete(half, axis))))
        yield (
            f"*NODE, NSET={_NAME.format(plane)}\n{node}, {place}\n"
            f"*SURFACE, TYPE=REVOLUTION, NAME={_NAME.format(plane)}\n{place}, {inwards}\n"
            f"START, 0.0, 0.0\nLINE, {radius}, 0.0\n"
            f"*RIGID BODY, ANALYTICAL SURFACE={_NAME.format(plane)}, REF NODE={node}\n"
            "*CONTACT PAIR, INTERACTION=PLATES, TYPE=SURFACE TO SURFACE, SMALL SLIDING, ADJUST=0.0\n"
            f"{plane}, {_NAME.format(plane)}\n"
            f"*BOUNDARY\n{_NAME.format(plane)}, 1, 6\n"
        )


def on_plates(load: Load) -> Load:
    """Return the load whose displacements of those planes are the plates'."""
    planes = _planes(load)

    def carried(parts: tuple[Fixed, ...]) -> tuple[Fixed, ...]:
        return tuple(
            replace(part, name=_NAME.format(part.name)) if part.name in planes else part for part in parts
        )

    return replace(load, held=carried(load.held), moved=carried(load.moved))


def _planes(load: Load) -> list[str]:
    """Return the near and the far plane across the axis along which the load moves one."""
    (moved,) = load.moved
    return [f"{'XYZ'[moved.axis]}{end}" for end in ("MIN", "MAX")]
