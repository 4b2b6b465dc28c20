"""Open-cell foams: struts along the edges at which the cells of a tessellation, its pores, meet."""

from collections.abc import Sequence

import numpy as np
from scipy import ndimage

from craftmesh.errors import CraftmeshError


def struts(pores: np.ndarray, spacing: Sequence[float], density: float, growth: float) -> np.ndarray:
    """Return (nx, ny, nz) bool: the material of a foam whose pores are the cells (nx, ny, nz) int.

    With the distances b, e, q of a voxel from the nearest boundary, edge and node of the cells, it is
    material where e <= t, and where e q < growth t^2 and e b < t^2; t, the radius of struts between nodes,
    is chosen for the relative density. Struts thicken within growth t of a node. The largest connected
    piece is kept, hollows within it are filled. Raises CraftmeshError for pores without edges and struts
    under three voxels thick.
    Source: Tucker, Spear, Integr. Mater. Manuf. Innov. 8 (2019), there with t = 1 voxel.
    """
    foreign = _foreign_cells(pores)
    if foreign.max() < 2:
        raise CraftmeshError("pores meet along no edge, where struts would be; expected more pores")
    # distances of voxels from the nearest boundary, edge and node of the cells, inf where there is none
    boundary, edge, node = (
        ndimage.distance_transform_edt(foreign < least, sampling=spacing).astype(np.float32)
        if (foreign >= least).any()
        else np.full(foreign.shape, np.inf, np.float32)
        for least in (1, 2, 3)
    )
    least = edge  # the smallest t at which a voxel is material
    if growth:
        with np.errstate(invalid="ignore"):  # on an edge without a node
            thick = np.sqrt(edge * np.maximum(node / growth, boundary))
        least = np.fmin(edge, thick)
    radius = np.quantile(least, density, method="inverted_cdf")
    if radius < max(spacing):
        raise CraftmeshError(
            f"relative_density is {density:g}; its struts are under three voxels thick; expected at least "
            f"{(least <= max(spacing)).mean():.3f}, or fewer pores, or more voxels (shape)"
        )
    return ndimage.binary_fill_holes(largest_piece(least <= radius))


def largest_piece(material: np.ndarray) -> np.ndarray:
    """Return (nx, ny, nz) bool: the voxels of the largest piece of those that faces connect."""
    pieces, count = ndimage.label(material)
    return pieces == np.bincount(pieces.ravel())[1:].argmax() + 1 if count else material


def _foreign_cells(cells: np.ndarray) -> np.ndarray:
    """Return (nx, ny, nz) int8: how many other cells are among those of a voxel's face neighbours."""
    padded = np.pad(cells, 1, mode="edge")
    count = np.zeros(cells.shape, np.int8)
    seen = [cells]
    for axis in range(3):
        for step in (1, -1):
            neighbour = np.roll(padded, step, axis=axis)[1:-1, 1:-1, 1:-1]
            count += np.logical_and.reduce([neighbour != other for other in seen])
            seen.append(neighbour)
    return count
