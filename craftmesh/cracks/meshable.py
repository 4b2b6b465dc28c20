"""A crack as it goes to the mesh: not along a face, and its sheets apart, across each other, or one."""

import numpy as np

from craftmesh.cracks.along_faces import refuse_along_faces
from craftmesh.cracks.along_sheets import refuse_along_sheets
from craftmesh.cracks.grazing_fronts import ending_on_faces
from craftmesh.cracks.merged_sheets import MERGED, merged_sheets
from craftmesh.cracks.sheets import joined, sheets
from craftmesh.types import Crack


def meshable(crack: Crack, box: np.ndarray, l_min: float) -> Crack:
    """Return a given crack with fronts that graze a face ended there, and sheets that overlap made one.

    box (2, 3), l_min in model units. Raises CraftmeshError for sheets along a face of the box or along each
    other, between which there is no room for tetrahedra.
    """
    parts = sheets(crack)
    for sheet in parts:
        refuse_along_faces(sheet, box, l_min)
    crack = joined([ending_on_faces(sheet, box, l_min) for sheet in parts])
    merged = merged_sheets(crack, box, l_min, MERGED * l_min)
    refuse_along_sheets(merged, box, l_min)
    return merged
