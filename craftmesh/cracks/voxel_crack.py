"""Cracks that exist as voxels: the sheet through the middle of them, within their smoothed outline."""

import numpy as np
import shapely
from scipy.ndimage import gaussian_filter1d

from craftmesh.cracks.behind_front import MARGIN, Plane
from craftmesh.cracks.fit_bounds import VOXELS, Numbers, within_bound
from craftmesh.cracks.measured import finite, height_surface, plane_of
from craftmesh.cracks.series import GivenSurface
from craftmesh.errors import CraftmeshError

# Of a voxel's longest edge: discs of that radius round the centres of neighbours overlap, gaps of one voxel
# close. The outline goes along the outermost voxels' faces as grains' boundaries do, RIM past the centres.
DISC = 0.95
RIM = 0.5
STEP = 0.25  # of the edge: spacing of the outline's points
SMOOTH = 1.5  # of the edge: standard deviation of the filter along the outline, which takes the steps away
SPACING = 2.0  # of the edge: default length of the sheet's edges; one bend per voxel would follow its steps
SPECK = 9.0  # of the edge squared: holes and pieces of the outline smaller than that are noise


def crack_through_voxels(
    is_crack: np.ndarray,
    spacing: np.ndarray,
    origin: np.ndarray,
    box: np.ndarray,
    edge_length: float | None = None,
) -> tuple[GivenSurface, Numbers]:
    """Return the surface through the voxels (nx, ny, nz) that are the crack, and their distances from it.

    spacing, origin (3,): those of the voxels; box (2, 3): the model's. The surface is a height over the
    plane of least squares and ends at the outermost voxels' faces; where those touch the box it goes on
    past it. edge_length: of its edges, None: two voxels. Raises CraftmeshError for too few voxels, for
    several pieces, and for voxels that the surface is off by more than two of their edges.
    """
    places = np.argwhere(is_crack)
    edge = float(np.max(spacing))
    centres = finite("set of voxels", np.asarray(origin, float) + (places + 0.5) * spacing)
    plane = plane_of(centres)
    box = np.asarray(box, float)
    polygon = smoothed(_outline(plane, centres, edge, box), edge)
    surface, numbers = height_surface(
        polygon, plane, (), centres, SPACING * edge if edge_length is None else edge_length, box
    )
    bound = VOXELS * edge
    numbers = within_bound(
        numbers,
        bound,
        f"{bound:.4g}, {VOXELS:g} voxels; expected a layer of voxels that is a height over a plane: name "
        "its label by crack.label, make it thinner, or give a shorter crack.spacing",
    )
    return surface, {"voxels": len(centres)} | numbers


def _outline(plane: Plane, centres: np.ndarray, edge: float, box: np.ndarray) -> shapely.Polygon:
    """Return the polygon through the outermost centres (n, 3) in (u, v), carried past the box."""
    uv = plane.of(centres)[:, :2]
    shapes = [shapely.points(uv)]
    far = MARGIN * np.linalg.norm(box[1] - box[0])
    for axis in range(3):
        for upper in (0, 1):
            out = (2 * upper - 1) * plane.frame[:2, axis]
            at_face = np.abs(centres[:, axis] - box[upper, axis]) < edge
            if np.linalg.norm(out) > DISC / 2 and at_face.any():
                ends = uv[at_face] + far * out / np.linalg.norm(out)
                shapes.append(shapely.linestrings(np.stack([uv[at_face], ends], axis=1)))
    discs = shapely.buffer(np.concatenate(shapes), DISC * edge, quad_segs=4)
    whole = shapely.buffer(shapely.union_all(discs), (RIM - DISC) * edge, quad_segs=4)
    parts = [part for part in shapely.get_parts(whole) if part.area > SPECK * edge**2]
    if len(parts) != 1:
        raise CraftmeshError(
            f"the crack's voxels form {len(parts)} pieces of more than {SPECK:g} voxels' faces; expected "
            "one: close gaps of several voxels, or give each piece as a crack of its own"
        )
    return parts[0]


def smoothed(polygon: shapely.Polygon, edge: float) -> shapely.Polygon:
    """Return the polygon without the steps of voxels of that edge in its rings; specks are filled."""
    rings = [
        _smoothed_ring(np.asarray(ring.coords), edge)
        for ring in (polygon.exterior, *polygon.interiors)
        if shapely.Polygon(ring).area > SPECK * edge**2
    ]
    result = shapely.Polygon(rings[0], rings[1:])
    if not result.is_valid:
        raise CraftmeshError("the crack's voxels are less than two wide somewhere; leave out what is thin")
    return result


def _smoothed_ring(ring: np.ndarray, edge: float) -> np.ndarray:
    """Return the closed ring (k, 2) evenly spaced and filtered: twice the filter less its square."""
    arc = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(ring, axis=0), axis=1)))
    count = max(int(np.ceil(arc[-1] / (STEP * edge))), 8)
    at = np.linspace(0, arc[-1], count, endpoint=False)
    even = np.stack([np.interp(at, arc, ring[:, k]) for k in range(2)], axis=1)
    once = gaussian_filter1d(even, SMOOTH / STEP, axis=0, mode="wrap")
    result = 2 * once - gaussian_filter1d(once, SMOOTH / STEP, axis=0, mode="wrap")
    return np.concatenate([result, result[:1]])
