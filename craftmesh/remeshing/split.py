"""Remeshing of labels split on either side of a crack: the surface with the crack's facets in it."""

from collections.abc import Callable

import numpy as np

from craftmesh.cracks.split_voxels import SplitVoxels, first_sheet, joined_surface
from craftmesh.progress import silent
from craftmesh.remeshing.kernels.marching import march
from craftmesh.remeshing.remesh import RemeshOptions, finished, smooth
from craftmesh.surface.patches import held_by_box
from craftmesh.types import Surface

# Share of its way to the crack that a point goes after each lap. Facets of points that go all the way at
# once become slivers and stay as voxel steps: up to 0.56 voxels off the crack, with this 0.43, at 0 0.48.
DRAWN = 0.4
STEEP = 0.3  # least square of the normal's part within a box plane, so that a point in it goes not too far


def remesh_split(
    split: SplitVoxels,
    options: RemeshOptions | None = None,
    progress: Callable[[float, str], None] = silent,
) -> tuple[Surface, np.ndarray, dict]:
    """Return the smoothed surface of split labels, its facets' sheets (m,) as bits, and a report.

    Grains, voids and their volumes are those of the given labels. The crack's facets are drawn to its
    sheets while all is smoothed, and reach past the fronts. No two facets intersect.
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

    def drawn(points: np.ndarray) -> np.ndarray:
        points = points.copy()
        for rows, look in zip(of_sheet, split.sheets):
            if len(rows):
                near = look.look(given.origin + given.spacing * points[rows])
                ahead = np.where(box[rows], 0.0, near.normal)
                square = np.maximum(np.einsum("ij,ij->i", ahead, ahead), STEEP)
                points[rows] -= (DRAWN * near.psi / square)[:, None] * ahead / given.spacing
        return points

    return drawn
