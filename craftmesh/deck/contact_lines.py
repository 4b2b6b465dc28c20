"""Lines of the deck for contact: of crack lips on each other, and of two rigid plates (only for Abaqus)."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from craftmesh.deck.inp_format import number
from craftmesh.mechanics.load import Fixed, Load
from craftmesh.mechanics.model import ElasticModel
from craftmesh.mesh.mesh_sets import is_lip
from craftmesh.types import TetMesh

# Contact stiffness (pressure over overlap), in units of the body's elastic stiffness over its length. Lips
# of a crack a quarter of the body long then overlap by 2e-3 of their overlap without contact. With ten
# times as much stiffness CalculiX takes up to 12 iterations per increment where lips meet, instead of 8.
# CalculiX' default (50 E) depends on the unit of length.
_PENALTY = 1e3
# Stiffness of sticking lips against slip, in units of the contact stiffness. In a block that is cut
# through, pressed and sheared, the shear force of CalculiX then differs by 0.3 % from the built-in
# solver's. It differs by 1.8 % with 0.01, and by 0.2 % with 1, with 13 iterations instead of 9.
_STICKING = 0.1

_NAME = "PLATE_{}"
# Radius of a plate over the distance of a face's corners from its middle: the compressed body spreads, and
# must not slip off the plate.
_RADIUS = 2.0


def contact_lines(model: ElasticModel) -> Iterator[str]:
    """Yield a contact pair for the two lips (crack faces) of each crack, if there are any.

    The second value of *FRICTION is CalculiX's slope of the shear stress over the slip where lips stick.
    For Abaqus it is a slip rate, which a table of one row does not depend on.
    """
    mesh = model.mesh
    lips = [name for name, faces in mesh.face_sets.items() if is_lip(name) and len(faces)]
    if lips:
        stiffness = _PENALTY * model.stiffness().max() / np.ptp(mesh.box, axis=0).max()
        yield "*SURFACE INTERACTION, NAME=LIPS\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n"
        yield f"{number(float(stiffness))}\n"
        if model.lip_friction:
            slope = float(_STICKING * stiffness)
            yield f"*FRICTION\n{number(model.lip_friction)}, {number(slope)}\n"
    for name in [name for name in lips if name.endswith("A")]:
        yield f"*CONTACT PAIR, INTERACTION=LIPS, TYPE=SURFACE TO SURFACE\n{name}, {name[:-1]}B\n"


def plate_lines(load: Load, mesh: TetMesh) -> Iterator[str]:
    """Yield lines of rigid discs in frictionless contact with the box planes that `load` holds and moves.

    A disc is an analytical rigid surface of revolution. It touches the body on the left of its profile,
    which runs outwards from START to LINE: left is the side of the second axis point, inside the body. The
    numbers of the reference nodes follow the mesh's node numbers.
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
    """Return the load with the displacements of both planes prescribed to the plates instead."""
    planes = _planes(load)

    def carried(parts: tuple[Fixed, ...]) -> tuple[Fixed, ...]:
        return tuple(
            replace(part, name=_NAME.format(part.name)) if part.name in planes else part for part in parts
        )

    return replace(load, held=carried(load.held), moved=carried(load.moved))


def _planes(load: Load) -> list[str]:
    """Return the MIN and the MAX plane normal to the axis along which the load moves a plane.

    The load must move exactly one plane (not checked).
    """
    (moved,) = load.moved
    return [f"{'XYZ'[moved.axis]}{end}" for end in ("MIN", "MAX")]
