"""Multi-material marching cubes: the conformal surface of a labelled volume, made slab by slab.

The volume is padded with six outside labels, and cells are cells of its dual grid. So the planes, edges and
corners of the box come out exactly. A surface point's id is stored only while later cells can need it.
"""

import numpy as np

from craftmesh.jit import kernel, lean_kernel
from craftmesh.remeshing.kernels.cell_sheets import MAX_FACETS, cell_sheets, new_scratch
from craftmesh.remeshing.kernels.cell_tables import FIRST_CELL_POINT, MAX_POINTS, POINT_SLOT
from craftmesh.remeshing.kernels.cell_wedges import OUTSIDE_LABELS
from craftmesh.surface.patches import PLANES

OUTSIDE = 0


@kernel
def _with_room(array, used, more):
    """Return `array`, or a copy of twice its length if `more` rows after `used` rows do not fit."""
    if used + more <= len(array):
        return array
    larger = np.empty((2 * len(array), array.shape[1]), array.dtype)
    for row in range(used):
        for column in range(array.shape[1]):
            larger[row, column] = array[row, column]
    return larger


@lean_kernel
def _read_cell(ranks, i, j, k, labels):
    """Copy the corner labels (8,) of the cell (i, j, k); return whether they differ."""
    mixed = False
    for c in range(8):
        labels[c] = ranks[i + (c >> 2), j + (c >> 1 & 1), k + (c & 1)]
        mixed |= labels[c] != labels[0]
    return mixed


@lean_kernel
def _point_id(p, j, k, slab_ids, free):
    """Return the id of edge or face point p of the cell in row j, column k; a first use gets id `free`."""
    layer, slot, dj, dk = POINT_SLOT[p]
    if slab_ids[layer, slot, j + dj, k + dk] < 0:
        slab_ids[layer, slot, j + dj, k + dk] = free
    return slab_ids[layer, slot, j + dj, k + dk]


@kernel
def _number_points(sheets, count, solid, cell, at, slab_ids, points, n_points, ids):
    """Give ids to the local points of facets that bound a grain; return the new number of points."""
    ids[:] = -1
    for f in range(count):
        if not (solid[sheets[f, 3]] or solid[sheets[f, 4]]):
            continue
        for corner in range(3):
            p = sheets[f, corner]
            if ids[p] >= 0:
                continue
            ids[p] = (
                _point_id(p, cell[1], cell[2], slab_ids, n_points) if p < FIRST_CELL_POINT else n_points
            )
            if ids[p] == n_points:
                for axis in range(3):
                    points[n_points, axis] = cell[axis] - 0.5 + at[p, axis]
                n_points += 1
    return n_points


@kernel
def _next_slab(slab_ids):
    """Copy the ids on the slab's upper side to the lower side of the next slab; reset all other ids."""
    _, slots, ny, nz = slab_ids.shape
    for slot in range(slots):
        for j in range(ny):
            for k in range(nz):
                slab_ids[0, slot, j, k] = slab_ids[1, slot, j, k]
    slab_ids[1:] = -1


@kernel
def _march(ranks, solid, scratch):
    """Return points (n, 3) and rows (m, 5) of facets: three point ids, rank behind and rank ahead.

    ranks (nx, ny, nz): labels of the padded volume as ranks; solid: mask of the ranks that are grains.
    """
    nx, ny, nz = ranks.shape
    slab_ids = np.full((3, 3, ny, nz), -1, np.int64)
    points = np.empty((1024, 3))
    facets = np.empty((1024, 5), np.int32)
    n_points = n_facets = 0
    labels, cell = np.empty(8, np.int64), np.empty(3, np.int64)
    ids = np.empty(MAX_POINTS, np.int64)
    sheets = scratch.sheets
    for i in range(nx - 1):
        for j in range(ny - 1):
            for k in range(nz - 1):
                if not _read_cell(ranks, i, j, k, labels):
                    continue
                count = cell_sheets(labels, scratch)
                points = _with_room(points, n_points, MAX_POINTS)
                facets = _with_room(facets, n_facets, MAX_FACETS)
                cell[0], cell[1], cell[2] = i, j, k
                n_points = _number_points(
                    sheets, count, solid, cell, scratch.at, slab_ids, points, n_points, ids
                )
                for f in range(count):
                    if solid[sheets[f, 3]] or solid[sheets[f, 4]]:
                        for corner in range(3):
                            facets[n_facets, corner] = ids[sheets[f, corner]]
                        facets[n_facets, 3], facets[n_facets, 4] = sheets[f, 3], sheets[f, 4]
                        n_facets += 1
        _next_slab(slab_ids)
    return points[:n_points].copy(), facets[:n_facets].copy()


def _ranks_by_volume(labels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return each voxel's label rank, by voxel count and then by label, and the labels in this order."""
    found = np.unique(labels)
    index = np.searchsorted(found, labels)
    order = np.lexsort((found, np.bincount(index.ravel())))
    rank = np.empty(len(found), np.int32)
    rank[order] = np.arange(len(found))
    return rank[index], found[order]


def _pad_with_outside(ranks: np.ndarray) -> np.ndarray:
    """Return ranks + 6 padded with a layer of outside labels 0..5; on edges x wins over y, y over z."""
    padded = np.empty(np.array(ranks.shape) + 2, np.int32)
    padded[1:-1, 1:-1, 1:-1] = ranks + OUTSIDE_LABELS
    for axis in (2, 1, 0):
        layer = np.moveaxis(padded, axis, 0)
        layer[0], layer[-1] = 2 * axis, 2 * axis + 1
    return padded


def march(labels: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return the conformal surface between the labels (nx, ny, nz) of a volume, in voxels from its corner.

    Labels > 0 are grains, 0 is outside, -k the void k; only facets that bound a grain are returned.
    Returns points (n, 3) float64 with the box at [0, shape], facets (m, 3) int32, sides (m, 2) int32
    (labels behind and ahead of the normal) and kind (m,) uint8: 0, or 1..6 for the planes of the box.
    Grains of different volume may be renumbered without a change of the surface. The face rule follows
    Wu & Sullivan (2003), see `cell_faces`.
    """
    ranks, ranked = _ranks_by_volume(labels)
    label_of = np.concatenate([np.full(OUTSIDE_LABELS, OUTSIDE), ranked]).astype(np.int32)
    points, rows = _march(_pad_with_outside(ranks), label_of > 0, new_scratch())
    facets, behind, ahead = np.ascontiguousarray(rows[:, :3]), rows[:, 3], rows[:, 4]
    sides = np.stack([label_of[behind], label_of[ahead]], axis=1)
    kind = np.where(behind < OUTSIDE_LABELS, behind + 1, 0).astype(np.uint8)
    for plane, axis, upper in PLANES:
        points[facets[kind == plane].ravel(), axis] = labels.shape[axis] if upper else 0.0
    return points, facets, sides, kind
