"""Pictures of the files between the stages: labels, surfaces, cracks, sizes, tetrahedra, solutions."""

from collections.abc import Sequence

import matplotlib
import numpy as np
from matplotlib.colors import ListedColormap
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

from craftmesh.mesh.tet_connectivity import free_half_faces, half_face_corners
from craftmesh.report.pictures import COLOURS, as_png, frame_box, new_figure
from craftmesh.sizing.sizing import Lengths
from craftmesh.types import CRACK, Crack, Surface, Voxels

GRAINS = "tab20"  # twenty colours, one grain after another
SEEN_FROM = ((25, 30), (25, 60), (35, -60))  # elevation and azimuth, by the axis that is cut
LIGHT = np.array([0.36, 0.48, 0.8])
RED = (0.8, 0.1, 0.1, 1.0)
EMPTY = (1.0, 1.0, 1.0, 1.0)
# matplotlib draws some 20,000 triangles a second: what is over this is drawn without its inner boundaries.
MANY = 60_000
EDGES = 20_000  # triangles up to which their edges are drawn


def labels_picture(voxels: Voxels) -> bytes:
    """Return a .png of the three middle slices of a volume, grains in colours, the rest white."""
    figure = new_figure(11.0, 4.2)
    grains = np.unique(voxels.labels[voxels.labels > 0])
    colour = ListedColormap([EMPTY, *(_grain_colours(grains)[k] for k in range(len(grains)))])
    for place, axis in enumerate((2, 1, 0), 1):
        middle = voxels.labels.shape[axis] // 2
        cut = voxels.labels.take(middle, axis=axis)
        shown = np.where(cut > 0, np.searchsorted(grains, cut) + 1, 0)
        across = [k for k in range(3) if k != axis]
        axes = figure.add_subplot(1, 3, place)
        axes.imshow(
            shown.T,
            cmap=colour,
            vmin=0,
            vmax=len(grains),
            origin="lower",
            interpolation="nearest",
            extent=_extent(voxels.box, across),
        )
        axes.set_xlabel("xyz"[across[0]])
        axes.set_ylabel("xyz"[across[1]])
        at = voxels.origin[axis] + (middle + 0.5) * voxels.spacing[axis]
        axes.set_title(f"{'xyz'[axis]} = {at:.4g}", fontsize=9)
    figure.suptitle(
        f"{len(grains)} grains, {' x '.join(map(str, voxels.labels.shape))} voxels", fontsize=10
    )
    figure.tight_layout()
    return as_png(figure)


def surface_picture(surface: Surface) -> bytes:
    """Return a .png of a surface by grains, cut open along its crack, which is red."""
    corners = surface.points[surface.facets]
    is_crack = surface.kind == CRACK
    origin, normal = _cut_plane(surface.box, corners[is_crack].reshape(-1, 3))
    shown = is_crack | ((corners.mean(axis=1) - origin) @ normal < 0)
    if shown.sum() > MANY:
        shown &= is_crack | (surface.sides <= 0).any(axis=1)
    colours = _grain_colours(surface.sides[shown].max(axis=1))
    colours[is_crack[shown]] = RED
    title = f"{len(surface.facets):,} facets, {int(is_crack.sum()):,} of the crack"
    return _body(corners[shown], colours, surface.box, normal, title)


def tets_picture(points: np.ndarray, tets: np.ndarray, grain: np.ndarray, lips: np.ndarray) -> bytes:
    """Return a .png of tetrahedra by grains, cut open along the crack, whose lips are red.

    points (n, 3); tets (m, 4 or more), the first four the corners; grain (m,); lips (k,): nodes of lips,
    without which the cut is at half height.
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
    return _body(points[faces], colours, box, normal, title)


def crack_picture(crack: Crack) -> bytes:
    """Return a .png of a crack's triangles and, black, its fronts."""
    figure = new_figure(6.0, 5.0)
    axes = figure.add_subplot(projection="3d")
    axes.add_collection3d(Poly3DCollection(crack.points[crack.triangles], facecolor=RED))
    fronts = [crack.points[front] for front in crack.fronts]
    axes.add_collection3d(Line3DCollection(fronts, colors="black", linewidths=2.0))
    frame_box(axes, _padded(crack.points))
    axes.set_title(f"{len(crack.triangles):,} triangles, {len(fronts)} fronts", fontsize=10)
    return as_png(figure)


def lengths_picture(lengths: Lengths, sources: np.ndarray, box: np.ndarray) -> bytes:
    """Return a .png of target lengths on three planes through the middle of the sources (k, 3), if any."""
    middle = sources.mean(axis=0) if len(sources) else box.mean(axis=0)
    figure = new_figure(12.0, 4.0)
    drawn = []
    for place, axis in enumerate((2, 1, 0), 1):
        across = [k for k in range(3) if k != axis]
        ranges = [np.linspace(box[0, k], box[1, k], 200) for k in across]
        points = np.tile(middle, (200 * 200, 1))
        points[:, across] = np.stack(np.meshgrid(*ranges, indexing="xy"), axis=-1).reshape(-1, 2)
        drawn.append((place, axis, across, lengths.at(points).reshape(200, 200)))
    low, high = min(d[3].min() for d in drawn), max(d[3].max() for d in drawn)
    for place, axis, across, values in drawn:
        axes = figure.add_subplot(1, 3, place)
        image = axes.imshow(
            values, origin="lower", extent=_extent(box, across), cmap=COLOURS, vmin=low, vmax=high
        )
        axes.set_xlabel("xyz"[across[0]])
        axes.set_ylabel("xyz"[across[1]])
        axes.set_title(f"{'xyz'[axis]} = {middle[axis]:.4g}", fontsize=9)
        figure.colorbar(image, ax=axes, shrink=0.7, label="target edge length")
    figure.tight_layout()
    return as_png(figure)


def fronts_picture(fronts: Sequence[np.ndarray]) -> bytes:
    """Return a .png of fronts, each (k, 3), in their order."""
    figure = new_figure(6.0, 5.0)
    axes = figure.add_subplot(projection="3d")
    for number, front in enumerate(fronts, 1):
        axes.plot(*front.T, marker=".", markersize=3, label=f"front {number}")
    frame_box(axes, _padded(np.concatenate(fronts)))
    axes.legend(fontsize=8)
    return as_png(figure)


def _body(
    triangles: np.ndarray, colours: np.ndarray, box: np.ndarray, normal: np.ndarray, title: str
) -> bytes:
    """Draw triangles as seen from the side to which the cut's normal points."""
    figure = new_figure(8.0, 7.0)
    axes = figure.add_subplot(projection="3d")
    shaded = colours.copy()
    shaded[:, :3] *= _shade(triangles)[:, None]
    with_edges = len(triangles) <= EDGES
    lines = {"edgecolor": "black" if with_edges else shaded, "linewidth": 0.15}
    axes.add_collection3d(Poly3DCollection(triangles, facecolor=shaded, **lines))
    axes.view_init(*SEEN_FROM[int(np.argmax(np.abs(normal)))])
    frame_box(axes, box)
    axes.set_title(title, fontsize=10)
    return as_png(figure)


def _shade(triangles: np.ndarray) -> np.ndarray:
    """Return the brightness (m,) of triangles (m, 3, 3) in light from above, 0.6 to 1."""
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny)
    return 0.6 + 0.4 * np.abs(normal @ LIGHT) / length


def _cut_plane(box: np.ndarray, crack: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a point and the normal of the plane along a crack's points (k, 3), else half way up."""
    if len(crack) < 3:
        return box.mean(axis=0), np.array([0.0, 0.0, 1.0])
    origin = crack.mean(axis=0)
    normal = np.linalg.svd(crack - origin, full_matrices=False)[2][2]
    return origin, normal * np.sign(normal[np.argmax(np.abs(normal))])


def _extent(box: np.ndarray, across: Sequence[int]) -> tuple[float, float, float, float]:
    """Return left, right, bottom, top of a picture of two axes of a box (2, 3)."""
    first, second = across
    return float(box[0, first]), float(box[1, first]), float(box[0, second]), float(box[1, second])


def _padded(points: np.ndarray) -> np.ndarray:
    """Return a box (2, 3) round points that has some extent along each axis."""
    low, high = points.min(axis=0), points.max(axis=0)
    pad = 0.1 * np.linalg.norm(high - low)
    return np.stack([low - pad, high + pad])


def _grain_colours(grains: np.ndarray) -> np.ndarray:
    """Return a colour (m, 4) for each grain, white for what is none."""
    colours = matplotlib.colormaps[GRAINS](np.asarray(grains) % 20)
    colours[np.asarray(grains) <= 0] = EMPTY
    return colours
