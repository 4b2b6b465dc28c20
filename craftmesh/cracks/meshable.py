"""A crack as it goes to the mesh: not along a face, and its sheets apart, across each other, or one."""

from collections.abc import Collection, Sequence

import numpy as np

from craftmesh.cracks.along_faces import refuse_along_faces
from craftmesh.cracks.along_sheets import refuse_along_sheets
from craftmesh.cracks.grazing_fronts import ending_on_faces
from craftmesh.cracks.merged_sheets import MERGED, merged_sheets
from craftmesh.cracks.sheets import joined, sheets
from craftmesh.types import Crack


def meshable(
    cracks: Sequence[Crack],
    box: np.ndarray,
    l_min: float,
    of_facets: Collection[int] = (),
    is_guess: bool = False,
) -> Crack:
    """Return given cracks as one, fronts that graze a face ended there and sheets that overlap made one.

    box (2, 3), l_min in model units. of_facets: the numbers of cracks made of a surface's facets, which
    have to stay as they are. is_guess: l_min is; fronts beside a face are left to the insertion then.
    Raises CraftmeshError for sheets along a face of the box or along each other, between which there is no
    room for tetrahedra.
    """
    parts = []
    for number, crack in enumerate(cracks):
        for sheet in sheets(crack):
            if number not in of_facets:
                sheet = ending_on_faces(sheet, box, l_min)
            refuse_along_faces(sheet, box, l_min, fronts_too=not is_guess)
            parts.append(sheet)
    merged = merged_sheets(joined(parts), box, l_min, MERGED * l_min)
    refuse_along_sheets(merged, box, l_min)
    return merged
