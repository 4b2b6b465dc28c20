"""The picture of a crack in its microstructure: in the box, and as seen along its normal."""

import matplotlib
import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

from craftmesh.cracks.frame import best_fit_frame
from craftmesh.cracks.prescription import frame_along
from craftmesh.report.pictures import as_png, frame_box, new_figure
from craftmesh.report.preview import Preview
from craftmesh.surface.front import front_edges
from craftmesh.surface.measure import meets_box
from craftmesh.types import CRACK

COLOURS = "tab20"  # grains, one after another
PLAIN = (0.75, 0.75, 0.75)  # a crack that was refused


def preview_picture(preview: Preview, limit: float) -> bytes:
    """Return a .png of the crack by grains, its front, the box, its traces: red under `limit` degrees."""
    figure = new_figure(11.0, 5.2)
    triangles, colours, fronts = _shown(preview)
    _in_box(figure.add_subplot(1, 2, 1, projection="3d"), preview, triangles, colours, fronts)
    _from_ahead(figure, preview, triangles, colours, fronts, limit)
    if preview.refused:
        figure.suptitle("refused: " + preview.refused, fontsize=8, color="firebrick", wrap=True)
    return as_png(figure)


def _shown(preview: Preview) -> tuple[np.ndarray, np.ndarray | tuple, list[np.ndarray]]:
    """Return the crack's triangles (k, 3, 3) in the box, their colours, and the fronts' edges (j, 3)."""
    box, surface = preview.box, preview.inserted
    if surface is None:
        corners = preview.crack.points[preview.crack.triangles]
        return (
            np.clip(corners[meets_box(corners, box)], *box),
            PLAIN,
            [preview.crack.points[f] for f in preview.crack.fronts],
        )
    crack = surface.kind == CRACK
    grain = surface.sides[crack].max(axis=1)
    colours = matplotlib.colormaps[COLOURS](np.searchsorted(preview.grains, grain) % 20)
    return surface.points[surface.facets[crack]], colours, list(surface.points[front_edges(surface)])


def _in_box(
    axes: Axes3D, preview: Preview, triangles: np.ndarray, colours: np.ndarray | tuple, fronts: list
) -> None:
    box = preview.box
    axes.add_collection3d(Poly3DCollection(triangles, facecolor=colours))
    axes.add_collection3d(Line3DCollection(fronts, colors="black", linewidths=1.6))
    corner = np.stack(np.meshgrid(*box.T, indexing="ij"), axis=-1).reshape(-1, 3)
    edges = [corner[[i, i | bit]] for bit in (1, 2, 4) for i in range(8) if not i & bit]
    axes.add_collection3d(Line3DCollection(edges, colors="grey", linewidths=0.6))
    frame_box(axes, box)


def _from_ahead(
    figure: Figure,
    preview: Preview,
    triangles: np.ndarray,
    colours: np.ndarray | tuple,
    fronts: list,
    limit: float,
) -> None:
    """Draw the crack as seen along its normal, its traces and the numbers of its grains."""
    axes = figure.add_subplot(1, 2, 2)
    normal = best_fit_frame(preview.crack.points, preview.crack.triangles)[2]
    frame = frame_along(normal, np.eye(3)[np.argmin(np.abs(normal))])
    axes.add_collection(PolyCollection(list(triangles @ frame[:2].T), facecolor=colours, edgecolor="none"))
    found, small = preview.traces.ends @ frame[:2].T, preview.traces.angle < limit
    axes.add_collection(LineCollection(list(found[~small]), colors="black", linewidths=0.7))
    axes.add_collection(LineCollection(list(found[small]), colors="red", linewidths=2.0))
    axes.add_collection(
        LineCollection([line @ frame[:2].T for line in fronts], colors="black", linewidths=2.2)
    )
    for grain, place in _label_places(preview).items():
        axes.annotate(str(grain), place @ frame[:2].T, ha="center", va="center", fontsize=8)
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.set_xlabel("along " + _words(frame[0]), fontsize=8)
    axes.set_ylabel("along " + _words(frame[1]), fontsize=8)
    if small.any():
        axes.set_title(f"red: boundaries met at less than {limit:g} degrees", fontsize=9)


def _label_places(preview: Preview) -> dict[int, np.ndarray]:
    """Return for each grain that the crack is in the centre (3,) of the facet nearest to their middle."""
    surface = preview.inserted
    if surface is None:
        return {}
    rows = np.flatnonzero(surface.kind == CRACK)
    centres, sides = surface.points[surface.facets[rows]].mean(axis=1), surface.sides[rows]
    places = {}
    for grain in preview.area:
        own = centres[(sides == grain).any(axis=1)]
        places[grain] = own[np.argmin(np.linalg.norm(own - own.mean(axis=0), axis=1))]
    return places


def _words(direction: np.ndarray) -> str:
    return "(" + ", ".join(f"{x:.2f}" for x in direction + 0.0) + ")"
