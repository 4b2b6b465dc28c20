"""First cracks on a crystal plane: the plane's section through one grain, up to the grain's boundaries."""

import numpy as np
import shapely

from craftmesh.cracks.in_plane import filled
from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.prescription import frame_along, is_sized, semi_axes, vector
from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.errors import CraftmeshError, rounded_values
from craftmesh.surface.connectivity import unique_edges
from craftmesh.types import Crack, Surface


def crack_in_slip_plane(
    surface: Surface, options: CrackOptions, increment: int, normal: np.ndarray, l_min: float
) -> Crack:
    """Return the planar crack with this normal (3,) through options.centre within grain options.grain.

    The crack ends l_min, in model units, before the boundaries with other grains. Corners of its outline
    are rounded to a radius of l_min. It continues through faces of the box and the surfaces of voids. With
    a radius, it is cut off at that distance from the centre. Without a centre it goes through the mean of
    the grain's surface points. Raises CraftmeshError if the grain has no surface, or if nothing is left at
    the centre.
    """
    facets, is_inner = _of_grain(surface, int(options.grain or 0))
    centre = surface.points[np.unique(facets)].mean(axis=0)
    centre = centre if options.centre is None else vector("centre", options.centre)
    frame = frame_along(normal, np.eye(3)[np.argmin(np.abs(normal))])
    segments, parents = _section(surface.points, facets, centre, frame)
    lines = shapely.linestrings(segments)
    outline = shapely.build_area(shapely.multilinestrings(lines))  # without grains enclosed by this one
    held = shapely.union_all(lines[is_inner[parents]]).buffer(l_min)
    outer = shapely.union_all(lines[~is_inner[parents]]).buffer(3 * l_min)
    part = outline.union(outer).difference(held).buffer(-l_min).buffer(l_min)
    if is_sized(options):
        part = part.intersection(shapely.Point(0, 0).buffer(semi_axes(options, increment)[0], quad_segs=64))
    here = [one for one in shapely.get_parts(part) if one.contains(shapely.Point(0, 0))]
    if not here or not outline.contains(shapely.Point(0, 0)):
        raise CraftmeshError(
            f"crack.centre {rounded_values(centre)} is not within grain {options.grain}, l_min "
            f"({l_min:g}) or more "
            "from its boundaries; move it into the grain"
        )
    points, triangles = filled(here[0], np.zeros((0, 2)), l_min)
    return crack_from_triangles(centre + points @ frame[:2], triangles, None, surface.box, frame)


def _of_grain(surface: Surface, grain: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the facets (m, 3) of a grain, and a mask (m,) of those with a grain on the other side too."""
    own = (surface.sides == grain).any(axis=1)
    if grain < 1 or not own.any():
        raise CraftmeshError(
            f"crack.grain is {grain or 'not given'}; expected the id of a grain of the volume"
        )
    return surface.facets[own].astype(np.int64), (surface.sides[own] > 0).all(axis=1)


def _section(
    points: np.ndarray, facets: np.ndarray, centre: np.ndarray, frame: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return segments (k, 2, 2), in the plane's axes, in which facets cross a plane, and their facets (k,).

    The plane goes through the centre (3,) along rows 0 and 1 of `frame` (3, 3). A point on the plane counts
    as above it, so each facet has two crossed edges or none.
    """
    height = (points - centre) @ frame[2]
    edges, of_facet, _ = unique_edges(facets)
    low, high = height[edges].T
    crossed = (low >= 0) != (high >= 0)
    share = np.where(crossed, low / np.where(crossed, low - high, 1.0), 0.0)[:, None]
    places = (1 - share) * points[edges[:, 0]] + share * points[edges[:, 1]]
    flat = (places - centre) @ frame[:2].T
    rows = np.flatnonzero(crossed[of_facet].any(axis=1))
    chosen = of_facet[rows]
    segments = flat[chosen[crossed[chosen]].reshape(-1, 2)]
    has_length = (segments[:, 0] != segments[:, 1]).any(axis=1)
    return segments[has_length], rows[has_length]
