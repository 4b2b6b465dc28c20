"""Changes of the tetrahedra inside grains of a whole model, grain by grain, the surface as it is."""

from collections.abc import Callable

import numpy as np

from craftmesh.sizing.lengths import Lengths
from craftmesh.sizing.surface_sizing import LocalSizing
from craftmesh.tetrahedra.grain_surface import grain_surfaces
from craftmesh.tetrahedra.whole_mesh import Model
from craftmesh.types import GrainTets

# What is done to the tets of a grain: of points (n, 3), tets (m, 4), how many points lie on the surface,
# crack facets inside (c, 3) and target lengths it makes points and tets; those on the surface, the first
# ones, stay.
Change = Callable[[np.ndarray, np.ndarray, int, np.ndarray, Lengths], tuple[np.ndarray, np.ndarray]]


def changed_inside(model: Model, grains: np.ndarray, change: Change) -> Model:
    """Return the model with the tets of `grains` changed; their target lengths are the surface's own."""
    result = list(model.grain_tets)
    surfaces = {one.grain: one for one in grain_surfaces(model.surface, grains)}
    for i, one in enumerate(model.grain_tets):
        if one.grain not in surfaces:
            continue
        surface = surfaces[one.grain]
        points = np.concatenate([model.surface.points[one.nodes], one.interior])
        internal = np.searchsorted(one.nodes, surface.nodes[surface.facets[surface.internal]])
        sizing = LocalSizing(surface.points, surface.facets)
        points, tets = change(points, one.tets, len(one.nodes), internal, sizing)
        result[i] = GrainTets(one.grain, one.nodes, points[len(one.nodes) :], tets)
    return Model(model.surface, result)
