"""Cracks given by both of their faces, as segmentations give them: the surface half way between them."""

import numpy as np

from craftmesh.cracks.fit_bounds import Numbers, within_bound
from craftmesh.cracks.fitted_surface import ACROSS_FRONT, height_surface, plane_of
from craftmesh.cracks.one_sheet import lines_across, merged_points, sides_apart
from craftmesh.cracks.series import GivenSurface
from craftmesh.cracks.voxel_crack import DISC, SPECK, notes_on_holes, outline_of, smoothed
from craftmesh.surface.connectivity import pieces
from craftmesh.surface.facet_subdivision import bisected
from craftmesh.surface.measure import area_vectors, total_area


def middle_sheet(
    points: np.ndarray, triangles: np.ndarray, box: np.ndarray
) -> tuple[GivenSurface, Numbers]:
    """Return the surface of points (n, 3) and triangles (m, 3), or of a thin shell its middle surface.

    A thin shell (`sides_apart`) has two sides along each other over most of its area. Its middle surface is
    single-valued over the least-squares plane and ends at the shell's rim; where that touches the box (2,
    3), it extends past the box. The report has the numbers of the fit and notes; it is empty if the surface
    is not a thin shell. Raise CraftmeshError if a shell is not single-valued over a plane or forms several
    regions.
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
        f"{edge / 2:.4g}, half of its edge length; the surface is a thin shell, but not single-valued over "
        "a plane: give its middle surface instead"
    )
    notes += [f"the surface is a thin shell, its sides {apart:.4g} apart: the crack is its middle surface"]
    notes += notes_on_holes(outline, gaps, edge)
    numbers = within_bound(numbers, edge / 2, words)
    return surface, numbers | {"notes": notes + numbers.get("notes", [])}


def _without_strays(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """Return the triangles of pieces with at least SPECK of the largest area, and a note on the others."""
    piece = pieces(triangles)
    area = np.bincount(piece, np.linalg.norm(area_vectors(points, triangles), axis=1))
    is_large = area >= SPECK * area.max()
    if is_large.all():
        return triangles, []
    share = area[~is_large].sum() / area.sum()
    note = f"left out {(~is_large).sum()} stray pieces, {share:.1%} of the area"
    return triangles[is_large[piece]], [note]
