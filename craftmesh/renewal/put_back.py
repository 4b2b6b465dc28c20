"""Put a body that was cut out and meshed again back into its model."""

from collections.abc import Sequence

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.renewal.cut_out import Part
from craftmesh.renewal.whole import Whole, whole_of, with_surface_first
from craftmesh.sizing.sizing import Lengths
from craftmesh.types import BORDER, GrainTets, Surface


def put_back(
    whole: Whole, part: Part, surface: Surface, grain_tets: Sequence[GrainTets], sizing: Lengths
) -> Whole:
    """Return the model with new tets instead of the tets of `part`.

    surface, grain_tets: the body of `part` meshed again, with the same points of the border, its facets of
    kind BORDER. Tets that stay come first in the result. Raises CraftmeshError if the border has changed.
    """
    new = whole_of(surface, grain_tets, sizing)
    ids = len(whole.points) + np.arange(len(new.points))
    border = np.unique(surface.facets[surface.kind == BORDER])
    ids[border] = _same_places(part, new.points[border], int((surface.kind == BORDER).sum()))
    own, stays = surface.kind != BORDER, ~part.chosen
    old = whole.surface
    return with_surface_first(
        np.concatenate([whole.points, new.points]),
        np.concatenate([whole.lengths, new.lengths]),
        np.concatenate([whole.tets[stays], ids[new.tets]]),
        np.concatenate([whole.grain[stays], new.grain]),
        np.concatenate([whole.origin[stays], new.origin]),
        (
            np.concatenate([old.facets[~part.gone], ids[surface.facets[own]]]),
            np.concatenate([old.sides[~part.gone], surface.sides[own]]),
            np.concatenate([old.kind[~part.gone], surface.kind[own]]),
        ),
    )


def _same_places(part: Part, places: np.ndarray, facets: int) -> np.ndarray:
    """Return the model's node (k,) at each of the points `places` (k, 3) on the border of the part.

    facets: number of facets of the border. Raises CraftmeshError if points or this number have changed.
    """
    on_border = part.surface.kind == BORDER
    before = np.unique(part.surface.facets[on_border])
    node = {tuple(place): n for place, n in zip(part.surface.points[before].tolist(), part.nodes[before])}
    found = [node.get(tuple(place), -1) for place in places.tolist()]
    if facets != on_border.sum() or len(found) != len(before) or -1 in found:
        raise CraftmeshError("meshing changed the border of the part to renew; please report this")
    return np.array(found, np.int64)
