"""The crack of each increment: prescribed by numbers, or taken from a given surface."""

from dataclasses import dataclass

import numpy as np
import shapely

from craftmesh.arguments import typed
from craftmesh.cracks.options import BY_NUMBERS, CrackOptions
from craftmesh.cracks.prescription import frame_of, semi_axes, vector
from craftmesh.cracks.sheets import cracks_from_triangles
from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.errors import CraftmeshError, rounded_values
from craftmesh.surface.measure import total_area
from craftmesh.surface.rounding import ROUNDING
from craftmesh.types import Crack

SAGITTA = 1e-5  # largest distance of the front from its chords, relative to its smaller semi-axis


@typed
def prescribed_crack(box: np.ndarray, options: CrackOptions, increment: int = 0) -> Crack:
    """Return the planar crack of `increment` (0, 1, ...); its fronts end exactly on the box (2, 3).

    A crack that severs the box has no front. Raise CraftmeshError if numbers are invalid, the increment is
    missing, or the crack lies outside the box. `crack_of_increment` handles shapes that are read from
    files.
    """
    if options.shape not in BY_NUMBERS:
        raise CraftmeshError(
            f"shape is {options.shape!r}; a prescribed crack needs one of {', '.join(BY_NUMBERS)}"
        )
    box = np.asarray(box, float)
    centre, sizes = vector("centre", options.centre), semi_axes(options, increment)
    frame = frame_of(options, sizes)
    outline = _edge_outline(centre, sizes[0], box) if options.shape == "through_edge" else _ellipse(sizes)
    points = centre + outline @ frame[:2]
    _check_reaches(points, frame, box)
    triangles = _triangles_of(outline)
    return crack_from_triangles(points, triangles, None, box, frame)


def _ellipse(sizes: tuple[float, float]) -> np.ndarray:
    """Return points (k, 2) of the ellipse with semi-axes `sizes`; its chords are within SAGITTA of it."""
    ratio = max(sizes) / min(sizes)
    count = int(np.ceil(np.pi * ratio**0.5 / np.sqrt(2 * SAGITTA)))
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return np.stack([sizes[0] * np.cos(angle), sizes[1] * np.sin(angle)], axis=1)


def _edge_outline(centre: np.ndarray, depth: float, box: np.ndarray) -> np.ndarray:
    """Return corners (4, 2) of a rectangle covering the plane in the box up to `depth` along the axis."""
    reach = np.linalg.norm(box[1] - box[0]) + np.linalg.norm(centre - box.mean(axis=0))
    return np.array([[-reach, -reach], [depth, -reach], [depth, reach], [-reach, reach]])


def _check_reaches(points: np.ndarray, frame: np.ndarray, box: np.ndarray) -> None:
    """Raise CraftmeshError unless the crack's plane cuts the box and its bounding box overlaps the box."""
    corners = np.stack(np.meshgrid(*box.T, indexing="ij"), axis=-1).reshape(-1, 3)
    offset = (corners - points[0]) @ frame[2]
    margin = 1e-9 * np.linalg.norm(box[1] - box[0])
    misses = offset.min() >= -margin or offset.max() <= margin
    if misses or (points.max(axis=0) <= box[0]).any() or (points.min(axis=0) >= box[1]).any():
        raise CraftmeshError(
            f"the crack lies outside the box {rounded_values(box)}; the crack spans "
            f"{rounded_values(points.min(axis=0))} to "
            f"{rounded_values(points.max(axis=0))}; move its centre or rotate its normal"
        )


def _triangles_of(outline: np.ndarray) -> np.ndarray:
    """Return triangles (m, 3), counter-clockwise, of the polygon `outline` (k, 2), without new points."""
    parts = shapely.get_parts(shapely.constrained_delaunay_triangles(shapely.Polygon(outline)))
    corners = shapely.get_coordinates(parts).reshape(-1, 4, 2)[:, :3]
    order = np.lexsort(outline.T)
    row = {tuple(outline[i]): i for i in order.tolist()}
    return np.array([[row[tuple(c)] for c in triangle] for triangle in corners.tolist()])


@dataclass(frozen=True, eq=False)
class GivenSurface:
    """A crack's triangulated surface as read from a file: points (n, 3), triangles (m, 3).

    fronts: polylines (k, 3) along its boundary. If there are none, its whole boundary within the box is
    front.
    """

    points: np.ndarray
    triangles: np.ndarray
    fronts: tuple[np.ndarray, ...] = ()


def crack_of_increment(
    options: CrackOptions,
    increment: int,
    box: np.ndarray,
    given: GivenSurface | None = None,
) -> Crack:
    """Return the crack of `increment` in the box (2, 3): of the surface `given`, or prescribed if None.

    A surface in several pieces gives several cracks. Raise CraftmeshError as prescribed_crack and
    crack_from_triangles do.
    """
    if given is None:
        return prescribed_crack(box, options, increment)
    return cracks_from_triangles(given.points, given.triangles, list(given.fronts) or None, box)


def crack_area(crack: Crack) -> float:
    """Return the area of a crack's surface, including its part outside the box."""
    return total_area(crack.points, crack.triangles)


def refuse_shrunk(crack: Crack, before: Crack, increment: int) -> None:
    """Raise CraftmeshError if the crack of `increment` has less area than `before`, the previous crack."""
    was, now = crack_area(before), crack_area(crack)
    if now < was * (1 - ROUNDING):
        raise CraftmeshError(
            f"crack of increment {increment}: its area {now:.6g} is below {was:.6g}, the previous "
            "increment's; give a crack that does not shrink"
        )
