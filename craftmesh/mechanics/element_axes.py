"""Orientations of single elements, by the voxels in which they lie."""

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.orientation import quaternion_to_matrix
from craftmesh.types import TetMesh, Voxels


def element_axes(mesh: TetMesh, voxels: Voxels) -> np.ndarray:
    """Return the sample components (m, 6) of the axes [100] and [010] of each element, NaN unknown.

    They are those of the voxel of its grain that is nearest to its middle. Raises CraftmeshError for voxels
    whose orientations are not kept.
    """
    if voxels.voxel_orientations is None:
        raise CraftmeshError(
            "orientations: element, and the microstructure has those of grains alone; import it with "
            "voxel_orientations, from a file that has them"
        )
    middle = (mesh.points[mesh.tets[:, :4]].mean(axis=1) - voxels.origin) / voxels.spacing - 0.5
    within = np.clip(np.round(middle).astype(int), 0, np.array(voxels.labels.shape) - 1)
    known = np.isfinite(voxels.voxel_orientations).all(axis=3)
    boxes = ndimage.find_objects(np.where(known, np.maximum(voxels.labels, 0), 0))
    other = (voxels.labels[tuple(within.T)] != mesh.grain) | ~known[tuple(within.T)]
    for grain in np.unique(mesh.grain[other]).tolist():
        box = boxes[grain - 1] if grain <= len(boxes) else None
        rows = np.flatnonzero(other & (mesh.grain == grain))
        if box is not None:
            first = [part.start for part in box]
            places = np.argwhere((voxels.labels[box] == grain) & known[box]) + first
            near = cKDTree(places * voxels.spacing).query(middle[rows] * voxels.spacing)[1]
            within[rows], other[rows] = places[near], False
    matrices = quaternion_to_matrix(voxels.voxel_orientations[tuple(within.T)].astype(float))
    axes = matrices[:, :, :2].transpose(0, 2, 1).reshape(-1, 6)
    axes[other] = np.nan
    return axes
