"""Lines of the deck for two rigid plates that compress a body, without friction; for Abaqus alone."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from craftmesh.deck.inp_format import number
from craftmesh.mechanics.load import Fixed, Load
from craftmesh.types import TetMesh

_NAME = "PLATE_{}"
# Of the distance of a face's corners from its middle: the body spreads, and shall not slip off the plate.
_RADIUS = 2.0


def plate_lines(load: Load, mesh: TetMesh) -> Iterator[str]:
    """Yield a disc on each plane of the box that `load` moves or holds, in contact with it.

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
