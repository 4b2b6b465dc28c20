"""Cracks given as voxels: the surface through their middle, within their smoothed outline."""

import numpy as np
import scipy
import shapely

from craftmesh.cracks.behind_front import MARGIN, Plane
from craftmesh.cracks.fit_bounds import VOXELS, Numbers, within_bound
from craftmesh.cracks.fitted_surface import finite, height_surface, plane_of
from craftmesh.cracks.series import GivenSurface
from craftmesh.errors import CraftmeshError

# Radius of the discs around voxel centres, in longest voxel edges. Discs of neighbours overlap, and gaps of
# one voxel close. The outline follows the faces of the outermost voxels, as grain boundaries do.
DISC = 0.95
STEP = 0.25  # spacing of the outline's points, in voxel edges
SMOOTH = 1.5  # standard deviation of the filter that removes the outline's steps, in voxel edges
SPACING = 2.0  # default edge length of the surface, in voxel edges; shorter edges would follow voxel steps
SPECK = 0.1  # smallest size of a piece relative to the largest; smaller ones are noise of a segmentation


def crack_through_voxels(
    is_crack: np.ndarray,
    spacing: np.ndarray,
    origin: np.ndarray,
    box: np.ndarray,
    edge_length: float | None = None,
) -> tuple[GivenSurface, Numbers]:
    """Return the surface through the crack's voxels, and a report with their distances from it.

    is_crack (nx, ny, nz): mask of the voxels; spacing, origin (3,): of their grid; box (2, 3): of the
    model. The surface is single-valued over the least-squares plane and ends at the outermost voxels'
    faces; where these touch the box, it extends past the box. edge_length: of the surface; None: two
    voxels. Small pieces are removed and pinholes filled; notes say how many. Raise CraftmeshError for too
    few voxels, for several large regions, and if the root-mean-square distance of the voxels exceeds two of
    their edges.
    """
    places, notes = _without_strays(is_crack)
    edge = float(np.max(spacing))
    centres = finite("set of voxels", np.asarray(origin, float) + (places + 0.5) * spacing)
    plane = plane_of(centres)
    box = np.asarray(box, float)
    outline, gaps = outline_of(plane, centres, edge, box, 0.5)
    notes += notes_on_holes(outline, gaps, edge)
    length = SPACING * edge if edge_length is None else edge_length
    surface, numbers = height_surface(smoothed(outline, edge), plane, (), centres, length, box)
    bound = VOXELS * edge
    numbers = within_bound(
        numbers,
        bound,
        f"{bound:.4g}, {VOXELS:g} voxels; expected a layer of voxels that is single-valued over a plane: "
        "name its label by crack.label, make it thinner, or give a shorter crack.spacing",
    )
    notes += numbers.pop("notes", [])
    return surface, {"voxels": len(centres)} | numbers | ({"notes": notes} if notes else {})


def _without_strays(is_crack: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """Return indices (n, 3) of the voxels of large pieces, and notes on the other pieces.

    Voxels that touch at faces, edges or corners form one piece. A large piece has at least SPECK of the
    largest one's voxels.
    """
    of, _ = scipy.ndimage.label(is_crack, np.ones((3, 3, 3)))
    voxels = np.bincount(of.ravel())
    voxels[0] = 0
    is_large = voxels >= SPECK * voxels.max()
    stray, every = voxels[~is_large & (voxels > 0)], voxels.sum()
    notes = []
    if len(stray):
        notes.append(
            f"left out {len(stray)} stray pieces of at most {stray.max()} voxels, "
            f"{stray.sum() / every:.0%} of all; the largest piece has {voxels.max()}"
        )
    if is_large.sum() > 1:
        notes.append(f"joined {is_large.sum()} pieces that do not touch into one surface")
    return np.argwhere(is_large[of]), notes


def _is_pinhole(ring: shapely.LinearRing, edge: float) -> bool:
    """Return whether no disc of radius SMOOTH fits into a hole, so that smoothing would remove it."""
    return shapely.Polygon(ring).buffer(-SMOOTH * edge).is_empty


def notes_on_holes(outline: shapely.Polygon, gaps: int, edge: float) -> list[str]:
    """Return notes on an outline's holes; gaps: number of gaps filled at box faces."""
    holes = outline.interiors
    filled = [shapely.Polygon(ring).area for ring in holes if _is_pinhole(ring, edge)]
    notes = []
    if filled or gaps:
        share = sum(filled) / (outline.area + sum(filled))
        notes.append(
            f"filled {len(filled)} pinholes, {share:.1%} of the crack's area, and {gaps} gaps at its mouth"
        )
    if kept := len(holes) - len(filled):
        notes.append(
            f"kept {kept} holes over {2 * SMOOTH * edge:.4g} wide: their rims are fronts; fill them in the "
            "file if they are noise"
        )
    return notes


def outline_of(
    plane: Plane, centres: np.ndarray, edge: float, box: np.ndarray, rim: float
) -> tuple[shapely.Polygon, int]:
    """Return the polygon in (u, v) around the outermost centres (n, 3), and the number of gaps closed.

    rim: distance of the polygon from these centres, in edges. Near a box face the polygon extends past the
    box; gaps there that are as narrow as pinholes are closed. Raise CraftmeshError if it has several parts.
    """
    uv = plane.to_uvh(centres)[:, :2]
    far = MARGIN * np.linalg.norm(box[1] - box[0])
    shapes, gaps = [shapely.buffer(shapely.points(uv), DISC * edge, quad_segs=4)], 0
    for axis in range(3):
        for upper in (0, 1):
            out = (2 * upper - 1) * plane.frame[:2, axis]
            at_face = np.abs(centres[:, axis] - box[upper, axis]) < edge
            if np.linalg.norm(out) > DISC / 2 and at_face.any():
                ends = uv[at_face] + far * out / np.linalg.norm(out)
                lines = shapely.linestrings(np.stack([uv[at_face], ends], axis=1))
                strips = shapely.union_all(shapely.buffer(lines, DISC * edge, quad_segs=4))
                half = (SMOOTH + rim - DISC) * edge  # strips are 2 (DISC - rim) edges wider than the voxels
                closed = shapely.buffer(shapely.buffer(strips, half), -half)
                gaps += shapely.get_num_geometries(strips) - shapely.get_num_geometries(closed)
                shapes.append([closed])
    discs = shapely.union_all(np.concatenate(shapes))
    parts = shapely.get_parts(shapely.buffer(discs, (rim - DISC) * edge, quad_segs=4))
    if len(parts) != 1:
        raise CraftmeshError(
            f"the crack forms {len(parts)} regions, each over {SPECK:g} times the largest; expected one: "
            "close the gaps between them, or give each region as a separate crack"
        )
    return parts[0], gaps


def smoothed(polygon: shapely.Polygon, edge: float) -> shapely.Polygon:
    """Return the polygon without pinholes and without the steps of voxels, whose edge length is `edge`."""
    holes = (ring for ring in polygon.interiors if not _is_pinhole(ring, edge))
    rings = [_smoothed_ring(np.asarray(ring.coords), edge) for ring in (polygon.exterior, *holes)]
    result = shapely.Polygon(rings[0], rings[1:])
    if not result.is_valid:
        raise CraftmeshError("the crack is less than two voxels wide somewhere; remove its thin parts")
    return result


def _smoothed_ring(ring: np.ndarray, edge: float) -> np.ndarray:
    """Return the closed ring (k, 2), resampled evenly and smoothed (twice a Gaussian minus its square).

    This combination shrinks the ring less than the filter alone.
    """
    arc = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(ring, axis=0), axis=1)))
    count = max(int(np.ceil(arc[-1] / (STEP * edge))), 8)
    at = np.linspace(0, arc[-1], count, endpoint=False)
    even = np.stack([np.interp(at, arc, ring[:, k]) for k in range(2)], axis=1)
    once = scipy.ndimage.gaussian_filter1d(even, SMOOTH / STEP, axis=0, mode="wrap")
    result = 2 * once - scipy.ndimage.gaussian_filter1d(once, SMOOTH / STEP, axis=0, mode="wrap")
    return np.concatenate([result, result[:1]])
