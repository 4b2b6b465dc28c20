"""Interior points of a grain, spaced by the sizing function (paper, Eq. 3).

Points of a lattice in the grain come first, then points of a layer above its facets where there is room.
"""

import numpy as np

from craftmesh.sizing.sizing import Lengths
from craftmesh.surface.kernels.bins import Grid, cells_of, fill_bins, grid_over
from craftmesh.surface.measure import area_vectors
from craftmesh.tetrahedra.grain_surface import GrainSurface
from craftmesh.tetrahedra.kernels.interior_fill import mark_clear, mark_inside, thin_out

# Lengths in target edge lengths l: height of the layer's points above their facets, width of a lattice
# cell, and smallest distances of an interior point from surface vertices, from facets and from other
# interior points. They are chosen on six volumes, whose tetrahedra then have median edges of .93 to .945 l.
LAYER_HEIGHT = 0.62
LATTICE_CELL = 1.02
FROM_VERTEX = 0.5
FROM_FACET = 0.4
APART = 0.68
# Assumed largest ratio of l near a facet to the largest l at its corners; it limits the search.
LARGER = 1.5
# A lattice cell is split in eight while it is wider than LATTICE_CELL * l by more than this factor.
SPLIT = 1.53
# Number of sizes within a factor of two that are tried for the first cell.
COARSEST = 16
# Points along each axis of the box at which these sizes are compared.
PROBES_PER_AXIS = 32
# Limits for strongly varying l: halvings of the first cell, and bins along the longest axis.
MAX_LEVELS = 12
MAX_CELLS_PER_AXIS = 200
OCTANTS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])


def interior_points(
    surface: GrainSurface, points: np.ndarray, tets: np.ndarray, sizing: Lengths, cell: float | None = None
) -> np.ndarray:
    """Return points (k, 3) inside the grain, spaced by about the target edge length l, `sizing.at`.

    points, tets: a first mesh of the grain, which defines the inside. A body-centred octree lattice of
    cells of about 1.02 l has priority, because its tetrahedra are the best. Facets with enough room (crack
    facets on both sides) get a point at a height of .62 l. cell: edge of the lattice's first cells, so that
    grains have one lattice; None: the best one for the grain.
    """
    low, high = surface.points.min(0), surface.points.max(0)
    cell = cell or lattice_cell(np.stack([low, high]), sizing)
    candidates = np.concatenate([_lattice(low, high, cell, sizing), _layer(surface, sizing)])
    candidates = candidates[((candidates > low) & (candidates < high)).all(1)]
    if not len(candidates):
        return candidates
    size = sizing.at(candidates)
    width = max(np.sqrt(size.min() * size.max()), (high - low).max() / MAX_CELLS_PER_AXIS)
    grid = grid_over(low, high, float(width))
    cells = cells_of(candidates, grid)
    bins = fill_bins(cells, cells, grid)
    chosen = mark_inside(candidates, bins, points, tets)
    reach = FROM_FACET * LARGER * sizing.at(surface.points)[surface.facets].max(axis=1)
    chosen &= mark_clear(candidates, FROM_FACET * size, bins, surface.points[surface.facets], reach)
    return _spaced(candidates[chosen], size[chosen], surface.points, grid)


def _spaced(candidates: np.ndarray, size: np.ndarray, vertices: np.ndarray, grid: Grid) -> np.ndarray:
    """Return the candidates (k, 3) that are far enough from the vertices and from earlier candidates.

    size: target length l at each candidate; FROM_VERTEX and APART are the smallest distances in l.
    """
    count = len(vertices)
    points = np.concatenate([vertices, candidates])
    apart = np.zeros((len(points), 2))
    apart[count:] = size[:, None] * [FROM_VERTEX, APART]
    cells = cells_of(points, grid)
    stays = thin_out(points, count, apart, fill_bins(cells, cells, grid))
    return candidates[stays[count:]]


def _layer(surface: GrainSurface, sizing: Lengths) -> np.ndarray:
    """Return points (k, 3) at LAYER_HEIGHT * l from the facets' centroids, perpendicular to the facets.

    They lie on the inner side; internal facets have points on both sides. Facets without area have none.
    """
    normal = area_vectors(surface.points, surface.facets)
    length = np.linalg.norm(normal, axis=1)
    sound = length > 0
    normal = normal[sound] / length[sound, None]
    centre = surface.points[surface.facets[sound]].mean(1)
    offset = LAYER_HEIGHT * sizing.at(centre)[:, None] * normal
    internal = surface.internal[sound]
    return np.concatenate([centre - offset, (centre + offset)[internal]])


def _lattice(low: np.ndarray, high: np.ndarray, cell: float, sizing: Lengths) -> np.ndarray:
    """Return centres and corners (k, 3) of octree cells of about LATTICE_CELL * l, coarse cells first.

    Corners of the first cells are multiples of `cell`, so lattices in two bodies have the same points where
    the lengths are the same.
    """
    start, stop = np.floor(low / cell).astype(int), np.ceil(high / cell).astype(int)
    cells = np.stack(np.meshgrid(*map(np.arange, start, stop), indexing="ij"), -1).reshape(-1, 3)
    found = []
    for level in range(MAX_LEVELS):
        centres = (cells + 0.5) * cell
        fine = LATTICE_CELL * sizing.at(centres) * SPLIT < cell
        if level == MAX_LEVELS - 1:
            fine[:] = False
        found += [centres[~fine], lattice_corners(cells[~fine]) * cell]
        cells = (2 * cells[fine][:, None] + OCTANTS).reshape(-1, 3)
        cell /= 2
        if not len(cells):
            break
    return np.concatenate(found)


def lattice_corners(cells: np.ndarray) -> np.ndarray:
    """Return the distinct corners (k, 3) of unit cells with lowest corners `cells` (n, 3), in cell order.

    All eight corners are used, also corners on faces of neighbouring larger cells: there they smooth the
    step from one cell width to the next.
    """
    if not len(cells):
        return cells
    least = cells.min(axis=0)
    corners = (cells[:, None] + OCTANTS).reshape(-1, 3)
    places = np.ravel_multi_index((corners - least).T, cells.max(axis=0) - least + 2)
    first = np.unique(places, return_index=True)[1]
    return corners[np.sort(first)]


def lattice_cell(box: np.ndarray, sizing: Lengths) -> float:
    """Return the edge of first cells in a box (2, 3) whose repeated halves fit LATTICE_CELL * l best.

    Places count by the density of points there.
    """
    shares = (np.arange(PROBES_PER_AXIS) + 0.5) / PROBES_PER_AXIS
    axes = (box[0] + shares[:, None] * (box[1] - box[0])).T
    local = LATTICE_CELL * sizing.at(np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3))
    weight = (local.min() / local) ** 3
    cells = local.max() * 2 ** (0.5 - np.arange(COARSEST) / COARSEST)
    misfit = np.log2(cells[:, None] / local)
    misfit -= np.maximum(np.ceil(misfit - np.log2(SPLIT)), 0)
    return float(cells[(weight * misfit**2).sum(axis=1).argmin()])
