"""The cracks of a growth series: prescribed or given as surfaces, each larger than the last."""

from dataclasses import dataclass

import numpy as np
import shapely

from craftmesh.arguments import typed
from craftmesh.cracks.options import BY_NUMBERS, CrackOptions
from craftmesh.cracks.prescription import frame_of, semi_axes, vector
from craftmesh.cracks.sheets import cracks_from_triangles
from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.errors import CraftmeshError, told
from craftmesh.surface.measure import total_area
from craftmesh.surface.rounding import ROUNDING
from craftmesh.types import Crack

SAGITTA = 1e-5  # of the radius, between the front's chords and the front


@typed
def prescribed_crack(box: np.ndarray, options: CrackOptions, increment: int = 0) -> Crack:
    """Return the planar crack of `increment` (0, 1, ...); fronts end exactly on the box (2, 3).

    Raises CraftmeshError for bad numbers, a missing increment, or a crack without a front in the box.
    A surface from files becomes a crack in `crack_of_increment`.
    """
    if options.shape not in BY_NUMBERS:
        raise CraftmeshError(
            f"shape is {options.shape!r}; expected one of {', '.join(BY_NUMBERS)} for a prescribed crack"
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
    """Return the ellipse's outline (k, 2), its chords within SAGITTA of the radius."""
    ratio = max(sizes) / min(sizes)
    count = int(np.ceil(np.pi * ratio**0.5 / np.sqrt(2 * SAGITTA)))
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return np.stack([sizes[0] * np.cos(angle), sizes[1] * np.sin(angle)], axis=1)


def _edge_outline(centre: np.ndarray, depth: float, box: np.ndarray) -> np.ndarray:
    """Return the rectangle that covers the crack plane in the box up to `depth` along the axis."""
    reach = np.linalg.norm(box[1] - box[0]) + np.linalg.norm(centre - box.mean(axis=0))
    return np.array([[-reach, -reach], [depth, -reach], [depth, reach], [-reach, reach]])


def _check_reaches(points: np.ndarray, frame: np.ndarray, box: np.ndarray) -> None:
    corners = np.stack(np.meshgrid(*box.T, indexing="ij"), axis=-1).reshape(-1, 3)
    offset = (corners - points[0]) @ frame[2]
    margin = 1e-9 * np.linalg.norm(box[1] - box[0])
    misses = offset.min() >= -margin or offset.max() <= margin
    if misses or (points.max(axis=0) <= box[0]).any() or (points.min(axis=0) >= box[1]).any():
        raise CraftmeshError(
            f"the crack lies outside the box {told(box)}: it spans {told(points.min(axis=0))} to "
            f"{told(points.max(axis=0))}; move its centre or turn its normal"
        )


def _triangles_of(outline: np.ndarray) -> np.ndarray:
    """Return a triangulation of the polygon `outline` (k, 2), counter-clockwise, no points added."""
    parts = shapely.get_parts(shapely.constrained_delaunay_triangles(shapely.Polygon(outline)))
    corners = shapely.get_coordinates(parts).reshape(-1, 4, 2)[:, :3]
    order = np.lexsort(outline.T)
    row = {tuple(outline[i]): i for i in order.tolist()}
    return np.array([[row[tuple(c)] for c in triangle] for triangle in corners.tolist()])


@dataclass(frozen=True, eq=False)
class GivenSurface:
    """A crack's triangulated surface as a file holds it: points (n, 3), triangles (m, 3).

    fronts: polylines (k, 3) along its boundary; empty: the boundary within the box is front.
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
    """Return the crack of `increment` in the box (2, 3): prescribed, or the given surface.

    A surface in several pieces is several cracks. Raises CraftmeshError as prescribed_crack and
    crack_from_triangles do.
    """
    if given is None:
        return prescribed_crack(box, options, increment)
    return cracks_from_triangles(given.points, given.triangles, list(given.fronts) or None, box)


def crack_area(crack: Crack) -> float:
    """Return the area of a crack's surface, the part outside the box included."""
    return total_area(crack.points, crack.triangles)


def refuse_shrunk(crack: Crack, before: Crack, increment: int) -> None:
    """Raise CraftmeshError where the crack of `increment` is smaller than that of the increment before."""
    was, now = crack_area(before), crack_area(crack)
    if now < was * (1 - ROUNDING):
        raise CraftmeshError(
            f"crack of increment {increment}: area {now:.6g} is below {was:.6g} of the "
            "increment before; expected a crack that grows"
        )
