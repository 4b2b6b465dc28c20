"""Pictures of stage files: labels, surfaces, cracks, fronts, target lengths and tetrahedra."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from craftmesh.extras import extra
from craftmesh.mesh.tet_connectivity import free_half_faces, half_face_corners
from craftmesh.report.pictures import (
    COLOURS,
    GRAINS,
    TOWARDS,
    as_png,
    draw_body,
    frame_box,
    new_figure,
)
from craftmesh.report.shaded import view_from
from craftmesh.report.shown_mesh import seen_from
from craftmesh.sizing.sizing import Lengths
from craftmesh.types import CRACK, Crack, Surface, Voxels

with extra("pictures"):
    import matplotlib
    from matplotlib.colors import ListedColormap, to_rgba
    from matplotlib.figure import Figure
    from matplotlib.image import AxesImage

RED = to_rgba("firebrick")
EMPTY = to_rgba("white")


def labels_picture(voxels: Voxels) -> bytes:
    """Return a .png of a volume's middle slices normal to z, y and x: grains coloured, the rest white."""
    labels = voxels.labels
    grains = np.unique(labels[labels > 0])
    middle = np.array(labels.shape) // 2
    cuts = [labels.take(middle[axis], axis=axis) for axis in (2, 1, 0)]
    shown = [np.where(cut > 0, np.searchsorted(grains, cut) + 1, 0) for cut in cuts]
    colour = ListedColormap([EMPTY, *_grain_colours(grains)])
    at = voxels.origin + (middle + 0.5) * voxels.spacing
    look = {"cmap": colour, "vmin": 0, "vmax": len(grains), "interpolation": "nearest"}
    figure, _ = _three_planes(voxels.box, at, shown, **look)
    figure.suptitle(f"{len(grains)} grains, {' x '.join(map(str, labels.shape))} voxels", fontsize=10)
    return as_png(figure)


def lengths_picture(lengths: Lengths, sources: np.ndarray, box: np.ndarray) -> bytes:
    """Return a .png of target edge lengths on three planes through the mean of the `sources`.

    sources (k, 3): points from which the lengths grow, such as the front's; without any, the planes go
    through the centre of the model's box (2, 3).
    """
    middle = sources.mean(axis=0) if len(sources) else box.mean(axis=0)
    planes = []
    for axis in (2, 1, 0):
        ranges = [
            middle[k : k + 1] if k == axis else np.linspace(box[0, k], box[1, k], 200) for k in range(3)
        ]
        points = np.stack(np.meshgrid(*ranges, indexing="ij"), axis=-1).reshape(-1, 3)
        planes.append(lengths.at(points).reshape(200, 200))
    limits = {"vmin": min(map(np.min, planes)), "vmax": max(map(np.max, planes))}
    figure, image = _three_planes(box, middle, planes, cmap=COLOURS, **limits)
    figure.colorbar(image, ax=figure.axes, shrink=0.7, label="target edge length")
    return as_png(figure)


def _three_planes(
    box: np.ndarray, middle: np.ndarray, planes: Sequence[np.ndarray], **look: Any
) -> tuple[Figure, AxesImage]:
    """Return a figure of values (k, l) on three planes of a box, and the image of the last plane.

    planes: values on the planes through `middle` (3,) perpendicular to z, y and x; look: options of imshow.
    """
    figure = new_figure(11.0, 4.2)
    figure.set_layout_engine("constrained")
    for place, (axis, plane) in enumerate(zip((2, 1, 0), planes), 1):
        first, second = (k for k in range(3) if k != axis)
        axes = figure.add_subplot(1, 3, place)
        extent = (*box[:, first], *box[:, second])
        image = axes.imshow(plane.T, origin="lower", extent=extent, **look)
        axes.set_xlabel("xyz"[first])
        axes.set_ylabel("xyz"[second])
        axes.set_title(f"{'xyz'[axis]} = {middle[axis]:.4g}", fontsize=9)
    return figure, image


def surface_picture(surface: Surface) -> bytes:
    """Return a .png of a surface by grain, without the part above the plane fitted to its red crack.

    Without a crack, the plane is z = const through the centre of the box.
    """
    corners = surface.points[surface.facets]
    is_crack = surface.kind == CRACK
    origin, normal = _cut_plane(surface.box, corners[is_crack].reshape(-1, 3))
    shown = is_crack | ((corners.mean(axis=1) - origin) @ normal < 0)
    colours = _grain_colours(surface.sides[shown].max(axis=1))
    colours[is_crack[shown]] = RED
    title = f"{len(surface.facets):,} facets, {int(is_crack.sum()):,} of the crack"
    return _body(
        surface.points, surface.facets[shown], colours, seen_from(int(np.abs(normal).argmax())), title
    )


def tets_picture(points: np.ndarray, tets: np.ndarray, grain: np.ndarray, lips: np.ndarray) -> bytes:
    """Return a .png of tetrahedra by grain, cut open along the crack, whose faces are red.

    points (n, 3); tets (m, 4 or more): the first four nodes are the corners; grain (m,); lips (k,): nodes
    of crack faces. Elements above the plane fitted to these nodes are left out; with fewer than three
    nodes the plane is at half height.
    """
    corners = np.asarray(tets)[:, :4]
    box = np.stack([points.min(axis=0), points.max(axis=0)])
    origin, normal = _cut_plane(box, points[lips])
    below = (points[corners].mean(axis=1) - origin) @ normal < 0
    free = free_half_faces(corners[below])
    faces = half_face_corners(corners[below], free)
    is_lip = np.zeros(len(points), bool)
    is_lip[lips] = True
    colours = _grain_colours(grain[below][free // 4])
    colours[is_lip[faces].all(axis=1)] = RED
    title = f"{len(tets):,} elements, {len(np.unique(grain)):,} grains"
    return _body(points, faces, colours, seen_from(int(np.abs(normal).argmax())), title)


def crack_picture(crack: Crack) -> bytes:
    """Return a .png of a crack's triangles in red and its fronts in black."""
    fronts = [crack.points[front] for front in crack.fronts]
    title = f"{len(crack.triangles):,} triangles, {len(fronts)} fronts"
    red = np.tile(RED, (len(crack.triangles), 1))
    return _body(crack.points, crack.triangles, red, TOWARDS, title, fronts)


def fronts_picture(fronts: Sequence[np.ndarray]) -> bytes:
    """Return a .png of fronts (k, 3) as numbered lines."""
    figure = new_figure(6.0, 5.0)
    axes = figure.add_subplot(projection="3d")
    for number, front in enumerate(fronts, 1):
        axes.plot(*front.T, marker=".", markersize=3, label=f"front {number}")
    points = np.concatenate(fronts)
    low, high = points.min(axis=0), points.max(axis=0)
    pad = 0.1 * np.linalg.norm(high - low)  # so that no axis has zero length
    frame_box(axes, np.stack([low - pad, high + pad]))
    axes.legend(fontsize=8)
    return as_png(figure)


def _body(
    points: np.ndarray,
    triangles: np.ndarray,
    colours: np.ndarray,
    towards: np.ndarray,
    title: str,
    lines: Sequence[np.ndarray] = (),
) -> bytes:
    """Return a .png of triangles (m, 3) with colours (m, 4), and of lines, each of points (k, 3).

    towards (3,): the direction from which they are seen.
    """
    view = view_from(towards, points[np.unique(triangles)])
    figure = new_figure(8.0, 7.0)
    axes = figure.add_subplot()
    corners = np.repeat(colours[:, None, :3], 3, axis=1)
    draw_body(axes, points, triangles, corners, view, lined=True)
    for line in lines:
        axes.plot(*view.flat(line).T, color="black", linewidth=2.0)
    axes.set_title(title, fontsize=10)
    return as_png(figure)


def _cut_plane(box: np.ndarray, crack: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a point and normal of the plane fitted to a crack's points (k, 3).

    With fewer than three points, the plane is z = const through the centre of the box (2, 3).
    """
    if len(crack) < 3:
        return box.mean(axis=0), np.array([0.0, 0.0, 1.0])
    origin = crack.mean(axis=0)
    normal = np.linalg.svd(crack - origin, full_matrices=False)[2][2]
    return origin, normal * np.sign(normal[np.argmax(np.abs(normal))])


def _grain_colours(grains: np.ndarray) -> np.ndarray:
    """Return a colour (m, 4) for each of the labels `grains` (m,), white for labels <= 0."""
    colours = matplotlib.colormaps[GRAINS](np.asarray(grains) % 20)
    colours[np.asarray(grains) <= 0] = EMPTY
    return colours
