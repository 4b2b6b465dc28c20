"""Cracks given by both of their sides, as surfaces of segmentations are: the sheet through their middle."""

import numpy as np

from craftmesh.cracks.fit_bounds import Numbers, within_bound
from craftmesh.cracks.measured import ACROSS_FRONT, height_surface, plane_of
from craftmesh.cracks.one_sheet import lines_across, merged_points, sides_apart
from craftmesh.cracks.series import GivenSurface
from craftmesh.cracks.voxel_crack import DISC, SPECK, notes_on_holes, outline_of, smoothed
from craftmesh.surface.connectivity import pieces
from craftmesh.surface.dividing import bisected
from craftmesh.surface.measure import area_vectors, total_area


def middle_sheet(
    points: np.ndarray, triangles: np.ndarray, box: np.ndarray
) -> tuple[GivenSurface, Numbers]:
    """Return the surface of points (n, 3) and triangles (m, 3), or the middle sheet of a thin shell.

    A thin shell (`sides_apart`) has two sides along each other over most of its area. Its sheet is a height
    over the plane of least squares, ends at the shell's rim and, where that touches the box (2, 3), goes on
    past it; the report has notes. Raises CraftmeshError for shells that are no height over a plane and for
    several regions.
    """

    whole = GivenSurface(points, triangles)
    points, triangles = merged_points(points, triangles)
    triangles, notes = _without_strays(points, triangles)
    apart = sides_apart(points, triangles, box)
    if apart is None:
        return whole, {}
    middles, _ = lines_across(points, triangles, ACROSS_FRONT**2)
    edge = max(apart, float(np.sqrt(total_area(points, triangles) / 2)) / ACROSS_FRONT)
    extents = np.stack([points.min(axis=0), points.max(axis=0)])
    points = np.unique(bisected(points[triangles], extents, DISC * edge).reshape(-1, 3), axis=0)
    plane = plane_of(middles)
    outline, gaps = outline_of(plane, points, edge, box, 0.0)
    surface, numbers = height_surface(smoothed(outline, edge), plane, (), middles, edge, box)
    words = (
        f"{edge / 2:.4g}, half of its edges; the surface is a thin shell, expected one that is a height "
        "over a plane: give the sheet in its middle"
    )
    notes += [
        f"the surface is a thin shell, its sides {apart:.4g} apart: the crack is the sheet in the middle"
    ]
    notes += notes_on_holes(outline, gaps, edge)
    numbers = within_bound(numbers, edge / 2, words)
    return surface, numbers | {"notes": notes + numbers.get("notes", [])}


def _without_strays(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """Return the triangles of pieces from SPECK of the largest area on, and a note on the others."""
    piece = pieces(triangles)
    area = np.bincount(piece, np.linalg.norm(area_vectors(points, triangles), axis=1))
    is_large = area >= SPECK * area.max()
    if is_large.all():
        return triangles, []
    share = area[~is_large].sum() / area.sum()
    note = f"left out {(~is_large).sum()} stray pieces, {share:.1%} of the area"
    return triangles[is_large[piece]], [note]
