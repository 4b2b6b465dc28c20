"""Remeshing of labels split on either side of a crack: the surface with the crack's facets in it."""

from collections.abc import Callable

import numpy as np
from scipy.spatial import cKDTree

from craftmesh.cracks.near_sheet import NearSheet
from craftmesh.cracks.split_voxels import SplitVoxels, first_sheet, joined_surface
from craftmesh.progress import silent
from craftmesh.remeshing.kernels.marching import march
from craftmesh.remeshing.remesh import RemeshOptions, finished, smooth
from craftmesh.sizing.sizing import densify
from craftmesh.surface.measure import meets_box
from craftmesh.surface.patches import held_by_box
from craftmesh.types import Surface, Voxels

# Share of its way to the crack that a point goes after each lap. Facets of points that go all the way at
# once become slivers and stay as voxel steps: up to 0.56 voxels off the crack, with this 0.43, at 0 0.48.
DRAWN = 0.4
# Of a voxel: how far points on a kink are from each other, and from the points that are drawn to them.
ALONG_KINK, TO_KINK = 0.5, 1.0
STEEP = 0.3  # least square of the normal's part within a box plane, so that a point in it goes not too far


def remesh_split(
    split: SplitVoxels,
    options: RemeshOptions | None = None,
    progress: Callable[[float, str], None] = silent,
) -> tuple[Surface, np.ndarray, dict]:
    """Return the smoothed surface of split labels, its facets' sheets (m,) as bits, and a report.

    Grains, voids and their volumes are those of the given labels. The crack's facets are drawn to its
    sheets and their kinks while all is smoothed, and reach past the fronts. No two facets intersect.
    """
    options = options or RemeshOptions()
    progress(0.0, "marching cubes")
    raw, bits = joined_surface(Surface(*march(split.labels)), split)
    progress(0.3, "smoothing")
    points, frozen = smooth(raw, options, progress, _drawn(raw, bits, split))
    surface, report = finished(points, frozen, raw, split.given, options, progress)
    return surface, bits, report


def _drawn(raw: Surface, bits: np.ndarray, split: SplitVoxels) -> Callable[[np.ndarray], np.ndarray]:
    """Return what draws points (n, 3), in voxels, of crack facets to their sheets, in the box's planes."""
    box, given = held_by_box(raw), split.given
    of_sheet = [np.unique(raw.facets[first_sheet(bits) == number]) for number in range(len(split.sheets))]
    on_kinks = [_on_kinks(look, given) for look in split.sheets]

    def drawn(points: np.ndarray) -> np.ndarray:
        points = points.copy()
        for rows, look, kinks in zip(of_sheet, split.sheets, on_kinks):
            if len(rows):
                places = given.origin + given.spacing * points[rows]
                points[rows] += (
                    DRAWN
                    * _ways(places, box[rows], look, kinks, TO_KINK * given.spacing.max())
                    / given.spacing
                )
        return points

    return drawn


def _ways(
    places: np.ndarray, held: np.ndarray, look: NearSheet, on_kinks: np.ndarray, reach: float
) -> np.ndarray:
    """Return the ways (n, 3) from places to a sheet, or to a kink of it, in the box planes that hold them.

    held (n, 3) bool: across which axes a plane of the box does. Of the places within `reach` of points of
    kinks (k, 3) the nearest to each goes there.
    """
    near = look.look(places)
    ahead = np.where(held, 0.0, near.normal)
    square = np.maximum(np.einsum("ij,ij->i", ahead, ahead), STEEP)
    ways = -(near.psi / square)[:, None] * ahead
    nearest, to_kinks = _to_kinks(places, on_kinks, reach)
    ways[nearest] = np.where(held[nearest], 0.0, to_kinks)
    return ways


def _on_kinks(look: NearSheet, given: Voxels) -> np.ndarray:
    """Return points (k, 3) along the kinks of a sheet in the volume's box."""
    ends = look.points[look.kinks]
    ends = ends[meets_box(ends, given.box)]
    step = ALONG_KINK * given.spacing.max()
    return np.concatenate([np.zeros((0, 3)), *(densify(one, step) for one in ends)])


def _to_kinks(places: np.ndarray, on_kinks: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Return which of places (n, 3) is the nearest to a point of a kink, and its way (k, 3) to that."""
    if not len(on_kinks):
        return np.zeros(0, np.int64), np.zeros((0, 3))
    away, vertex = cKDTree(places).query(on_kinks, distance_upper_bound=reach)
    order = np.lexsort((away, vertex))
    order = order[np.isfinite(away[order])]
    vertex, first = np.unique(vertex[order], return_index=True)
    return vertex, on_kinks[order[first]] - places[vertex]
