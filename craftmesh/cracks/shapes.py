"""Prescribed cracks: pennies, ellipses (whole, semi, quarter), through edge cracks, given surfaces."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely

from craftmesh.cracks.triangulated import crack_from_triangles, frame_along
from craftmesh.errors import CraftmeshError
from craftmesh.options import option
from craftmesh.types import Crack

SHAPES = ("penny", "ellipse", "through_edge", "surface")
SAGITTA = 1e-5  # of the radius, between the front's chords and the front


@dataclass(frozen=True)
class CrackOptions:
    """A crack whose shape and growth are prescribed; lengths in model units.

    Semi- and quarter-elliptical cracks are ellipses whose centre lies on a face, edge or corner of the
    box; what lies outside the box is cut off.
    """

    shape: str = option("penny", "kind of crack", choices=SHAPES)
    centre: tuple = option(
        (0.0, 0.0, 0.0), "centre of the ellipse; for through_edge a point of the mouth", "length"
    )
    normal: tuple = option((0.0, 0.0, 1.0), "normal of the crack plane")
    axis: tuple = option(
        (1.0, 0.0, 0.0), "direction of the first semi-axis, or of the depth (through_edge)"
    )
    radius: float | None = option(None, "radius of a penny, or depth of a through edge crack", "length")
    semi_axes: tuple | None = option(None, "semi-axes a, b of an ellipse", "length")
    file: str | None = option(None, "triangulated surface (.vtp or .stl) for shape surface")
    front: str | None = option(None, "csv file of the front's points; none: the boundary within the box")
    growth: float = option(0.0, "added to radius, semi-axes or depth at each increment", "length")
    increments: tuple | None = option(None, "(a, b), radius or file of each increment, instead of growth")


def prescribed_crack(options: CrackOptions, increment: int, box) -> Crack:
    """Return the planar crack of `increment` (0, 1, ...); fronts end exactly on the box (2, 3).

    Raises CraftmeshError for bad numbers, a missing increment, or a crack without a front in the box.
    Surfaces from files come from `surface_file` and `crack_from_triangles`.
    """
    if options.shape not in SHAPES or options.shape == "surface":
        raise CraftmeshError(
            f"shape is {options.shape!r}; expected one of {', '.join(SHAPES[:3])} for a prescribed crack"
        )
    box = np.asarray(box, float)
    centre, normal, axis = (_vector(name, getattr(options, name)) for name in ("centre", "normal", "axis"))
    frame = _frame(normal, axis)
    sizes = semi_axes(options, increment)
    outline = (
        _edge_outline(centre, frame, sizes[0], box) if options.shape == "through_edge" else _ellipse(sizes)
    )
    points = centre + outline @ frame[:2]
    _check_reaches(points, frame, box)
    triangles = _triangles_of(outline)
    return crack_from_triangles(points, triangles, None, box, frame)


def semi_axes(options: CrackOptions, increment: int) -> tuple[float, float]:
    """Return the semi-axes (a, b) of an increment; a penny has a = b, a through crack the depth a."""
    if options.increments is not None:
        if not 0 <= increment < len(options.increments):
            raise CraftmeshError(
                f"increment is {increment}; crack.increments holds {len(options.increments)}: add one"
            )
        sizes, grown = options.increments[increment], 0.0
    else:
        sizes, grown = options.semi_axes if options.semi_axes is not None else options.radius, increment
    try:
        pair = np.broadcast_to(np.asarray(sizes, float), (2,)) + grown * options.growth
    except (TypeError, ValueError):
        pair = np.full(2, np.nan)
    if not (np.isfinite(pair).all() and (pair > 0).all()):
        raise CraftmeshError(
            f"crack size is {sizes!r} at increment {increment}; expected radius > 0 or semi_axes (a, b) > 0"
        )
    return float(pair[0]), float(pair[1])


def surface_file(options: CrackOptions, increment: int) -> Path:
    """Return the file of the triangulated surface of `increment`."""
    name = options.file
    if options.increments is not None:
        if not 0 <= increment < len(options.increments):
            raise CraftmeshError(
                f"increment is {increment}; crack.increments holds {len(options.increments)}"
            )
        name = options.increments[increment]
    if not isinstance(name, (str, Path)):
        raise CraftmeshError(
            f"crack.file is {name!r}; expected the path of a .vtp or .stl for shape surface"
        )
    return Path(name)


def _vector(name: str, value) -> np.ndarray:
    try:
        vector = np.asarray(value, float)
    except (TypeError, ValueError):
        vector = np.zeros(0)
    if vector.shape != (3,) or not np.isfinite(vector).all():
        raise CraftmeshError(f"crack.{name} is {value!r}; expected three finite numbers")
    return vector


def _frame(normal: np.ndarray, axis: np.ndarray) -> np.ndarray:
    if not np.linalg.norm(normal) > 0:
        raise CraftmeshError(f"crack.normal is {normal.tolist()}; expected a vector that is not zero")
    across = np.linalg.norm(np.cross(normal, axis))
    if not across > 1e-6 * np.linalg.norm(normal) * np.linalg.norm(axis):
        raise CraftmeshError(
            f"crack.axis is {axis.tolist()}, normal {normal.tolist()}; expected an axis across the normal"
        )
    return frame_along(normal, axis)


def _ellipse(sizes: tuple[float, float]) -> np.ndarray:
    """Return the ellipse's outline (k, 2), its chords within SAGITTA of the radius."""
    ratio = max(sizes) / min(sizes)
    count = int(np.ceil(np.pi * ratio**0.5 / np.sqrt(2 * SAGITTA)))
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return np.stack([sizes[0] * np.cos(angle), sizes[1] * np.sin(angle)], axis=1)


def _edge_outline(centre, frame, depth: float, box: np.ndarray) -> np.ndarray:
    """Return the rectangle that covers the crack plane in the box up to `depth` along the axis."""
    reach = np.linalg.norm(box[1] - box[0]) + np.linalg.norm(centre - box.mean(axis=0))
    return np.array([[-reach, -reach], [depth, -reach], [depth, reach], [-reach, reach]])


def _check_reaches(points, frame, box) -> None:
    corners = np.stack(np.meshgrid(*box.T, indexing="ij"), axis=-1).reshape(-1, 3)
    offset = (corners - points[0]) @ frame[2]
    margin = 1e-9 * np.linalg.norm(box[1] - box[0])
    misses = offset.min() >= -margin or offset.max() <= margin
    if misses or (points.max(axis=0) <= box[0]).any() or (points.min(axis=0) >= box[1]).any():
        raise CraftmeshError(
            f"the crack lies outside the box {box.tolist()}: it spans {points.min(axis=0).tolist()} to "
            f"{points.max(axis=0).tolist()}; move its centre or turn its normal"
        )


def _triangles_of(outline: np.ndarray) -> np.ndarray:
    """Return a triangulation of the polygon `outline` (k, 2), counter-clockwise, no points added."""
    parts = shapely.get_parts(shapely.constrained_delaunay_triangles(shapely.Polygon(outline)))
    corners = shapely.get_coordinates(parts).reshape(-1, 4, 2)[:, :3]
    order = np.lexsort(outline.T)
    row = {tuple(outline[i]): i for i in order.tolist()}
    return np.array([[row[tuple(c)] for c in triangle] for triangle in corners.tolist()])
