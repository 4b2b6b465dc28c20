"""Folders of surfaces, one file a grain, as other tools write them."""

from pathlib import Path

import numpy as np
from surface_writer import write_triangles

from craftmesh.surface.connectivity import compact


def write_grain_folder(folder, surface, prefix="grain", suffix=".stl"):
    """Write `<prefix>_<id><suffix>` per grain, normals outward, crack facets inside a grain left out."""
    Path(folder).mkdir(parents=True, exist_ok=True)
    paths = []
    for grain in surface.grains.tolist():
        behind, ahead = (surface.sides == grain).T
        facets = np.concatenate([surface.facets[behind & ~ahead], surface.facets[ahead & ~behind][:, ::-1]])
        paths.append(Path(folder) / f"{prefix}_{grain}{suffix}")
        points, corners, _ = compact(surface.points, facets)
        write_triangles(paths[-1], points, corners)
    return paths
