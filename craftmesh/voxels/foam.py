"""Open-cell foams: struts along the edges of a tessellation, whose cells are the pores."""

from collections.abc import Sequence

import numpy as np
import scipy

from craftmesh.errors import CraftmeshError

_AROUND = np.ones((3, 3, 3), bool)


def struts(
    pores: np.ndarray, spacing: Sequence[float], density: float, growth: float, shape: float, cut: str = ""
) -> np.ndarray:
    """Return a mask (nx, ny, nz) of the material of a foam whose pores are the cells (nx, ny, nz) int.

    A voxel at distances b, e, q from the nearest boundary, edge and node of the cells is material if e <=
    t, or if e q <= growth t^2 and e b <= shape t^2. The strut radius t between nodes follows from the
    relative density. Struts thicken within growth t of a node: as webs along the cells' boundaries if
    `shape` is small, on all sides if it is large. Only the largest connected piece is kept, and hollows in
    it are filled. Struts that end at a box face normal to an axis in `cut` are removed. Raises
    CraftmeshError for pores without edges, and for struts under three voxels thick. Source: Tucker, Spear,
    Integr. Mater. Manuf. Innov. 8 (2019), there with t = 1 voxel.
    """
    foreign = _foreign_cells(pores)
    if foreign.max() < 2:
        raise CraftmeshError("pores meet along no edge, so there are no struts; set more pores")
    # distances of voxels from the nearest boundary, edge and node of the cells; 1e30 if there is none
    boundary, edge, node = (
        scipy.ndimage.distance_transform_edt(foreign < least, sampling=spacing).astype(np.float32)
        if (foreign >= least).any()
        else np.full(foreign.shape, 1e30, np.float32)
        for least in (1, 2, 3)
    )
    least = edge  # the smallest t at which a voxel is material
    if growth and shape:
        least = np.minimum(edge, np.sqrt(edge * np.maximum(node / growth, boundary / shape)))
    radius = np.quantile(least, density, method="inverted_cdf")
    if radius < max(spacing):
        raise CraftmeshError(
            f"relative_density {density:g} makes struts under three voxels thick; set it to at least "
            f"{(least <= max(spacing)).mean():.3f}, or set fewer pores, or more voxels (shape)"
        )
    material = least <= radius
    if cut:
        material &= ~_loose_ends(foreign, node > radius, spacing, cut)
    return scipy.ndimage.binary_fill_holes(largest_piece(material))


def largest_piece(material: np.ndarray) -> np.ndarray:
    """Return a mask (nx, ny, nz) of the largest face-connected component of the mask `material`."""
    pieces, count = scipy.ndimage.label(material)
    return pieces == np.bincount(pieces.ravel())[1:].argmax() + 1 if count else material


def _foreign_cells(cells: np.ndarray) -> np.ndarray:
    """Return for each voxel (nx, ny, nz) the number, int8, of other cells among its six face neighbours.

    cells: the pore of each voxel.
    """
    padded = np.pad(cells, 1, mode="edge")
    count = np.zeros(cells.shape, np.int8)
    seen = [cells]
    for axis in range(3):
        for step in (1, -1):
            neighbour = np.roll(padded, step, axis=axis)[1:-1, 1:-1, 1:-1]
            count += np.logical_and.reduce([neighbour != other for other in seen])
            seen.append(neighbour)
    return count


def _loose_ends(
    foreign: np.ndarray, is_off_nodes: np.ndarray, spacing: Sequence[float], axes: str
) -> np.ndarray:
    """Return a mask (nx, ny, nz) of voxels whose nearest edge ends at a box face normal to one of `axes`.

    foreign: from `_foreign_cells`; is_off_nodes: mask of the voxels that may be in the result.
    """
    is_edge = foreign >= 2
    edges, count = scipy.ndimage.label(
        is_edge & ~scipy.ndimage.binary_dilation(foreign >= 3, _AROUND), _AROUND
    )
    ends = np.zeros(count + 1, bool)
    for axis in map("xyz".index, axes):
        ends[edges.take((0, -1), axis=axis)] = True
    ends[0] = False
    nearest = scipy.ndimage.distance_transform_edt(
        ~is_edge, sampling=spacing, return_distances=False, return_indices=True
    )
    return ends[edges][tuple(nearest)] & is_off_nodes
