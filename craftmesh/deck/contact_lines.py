"""Lines of the deck by which lips of cracks press on each other."""

from collections.abc import Iterator

import numpy as np

from craftmesh.deck.inp_format import number
from craftmesh.mechanics.model import ElasticModel
from craftmesh.mesh.mesh_sets import is_lip

# Pressure over overlap, times the body's length over its stiffness: lips of a crack a quarter of the body
# long overlap by 2e-3 of what they would without contact. Ten times as much has CalculiX take up to 12
# iterations an increment where lips meet, in place of 8. Its own (50 E) depends on the unit of length.
_PENALTY = 1e3


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
