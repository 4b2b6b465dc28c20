"""Pictures of cracks that grow: their surfaces, what drives them, the deformed body, a cut's stress."""

import io
from collections.abc import Mapping

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

from craftmesh.report.plane_cut import cut_tets
from craftmesh.surface.distances import distances_and_sides
from craftmesh.surface.measure import meets_box
from craftmesh.types import Crack

DPI = 110
COLOURS = "viridis"
# Of the body's diagonal: how far the point that moves most is shown from where it was.
SHOWN_MOVE = 0.08
# Of the box's diagonal: a triangle this near to the crack before is part of it.
SAME = 1e-6
# Stresses have no bound beside a crack front: the scale ends where so many per cent are in it.
SCALE_PERCENT = 99.0


def crack_by_increment(cracks: Mapping[str, Crack], box: np.ndarray) -> bytes:
    """Return a .png of the crack's surface in the box (2, 3), what each increment added in a colour.

    cracks: by the increments' names, each crack holding the one before.
    """
    figure = new_figure(6.0, 5.0)
    axes = figure.add_subplot(projection="3d")
    colours = matplotlib.colormaps[COLOURS](np.linspace(0.1, 0.95, len(cracks)))
    before: Crack | None = None
    for (name, crack), colour in zip(cracks.items(), colours):
        corners = crack.points[crack.triangles]
        shown = meets_box(corners, box)
        if before is not None:
            off, _ = distances_and_sides(corners.mean(axis=1), before.points, before.triangles)
            shown &= off > SAME * np.linalg.norm(box[1] - box[0])
        before = crack
        axes.add_collection3d(Poly3DCollection(np.clip(corners[shown], *box), facecolor=colour))
        fronts = [crack.points[front] for front in crack.fronts]
        axes.add_collection3d(Line3DCollection(fronts, colors="black", linewidths=0.8))
        axes.plot([], [], color=colour, linewidth=5, label=name)
    frame_box(axes, box)
    axes.legend(title="increment", fontsize=8, loc="upper left")
    return as_png(figure)


def along_front(rows: Mapping[str, Mapping[str, np.ndarray]]) -> bytes:
    """Return a .png of K_I, K_II, K_III and the kink angle along the fronts, a line for each increment.

    rows: columns of sif.csv by the increments' names; s is shown over its largest value, front by front.
    """
    figure = new_figure(9.0, 5.6)
    axes = figure.subplots(2, 2, sharex=True).ravel()
    colours = matplotlib.colormaps[COLOURS](np.linspace(0.1, 0.95, len(rows)))
    shown = (("K_I", "K_I"), ("K_II", "K_II"), ("K_III", "K_III"), ("kink_angle", "kink angle [degrees]"))
    for (name, columns), colour in zip(rows.items(), colours):
        for front in np.unique(columns["front"]):
            row = np.flatnonzero(columns["front"] == front)
            s = columns["s"][row] / max(columns["s"][row].max(), 1e-300)
            for place, (key, label) in zip(axes, shown):
                place.plot(s, columns[key][row], color=colour, label=name if front == 1 else None)
                place.set_ylabel(label)
                place.grid(alpha=0.3)
    for place in axes[2:]:
        place.set_xlabel("along the front, share of its length")
    axes[0].legend(title="increment", fontsize=8)
    figure.tight_layout()
    return as_png(figure)


def deformed_body(points: np.ndarray, facets: np.ndarray, displacement: np.ndarray) -> bytes:
    """Return a .png of the free facets (m, 3) moved by the displacement (n, 3), which colours them.

    points (n, 3). The largest displacement is shown as SHOWN_MOVE of the body's diagonal.
    """
    size = np.linalg.norm(displacement, axis=1)
    factor = SHOWN_MOVE * np.linalg.norm(np.ptp(points, axis=0)) / max(size.max(), 1e-300)
    moved = points + factor * displacement
    figure = new_figure(6.0, 5.0)
    axes = figure.add_subplot(projection="3d")
    shade = matplotlib.cm.ScalarMappable(cmap=COLOURS)
    values = size[facets].mean(axis=1)
    shade.set_array(values)
    axes.add_collection3d(Poly3DCollection(moved[facets], facecolor=shade.to_rgba(values)))
    figure.colorbar(shade, ax=axes, shrink=0.6, label=f"displacement (shown {factor:.3g} times)")
    frame_box(axes, np.stack([moved.min(axis=0), moved.max(axis=0)]))
    return as_png(figure)


def stress_on_plane(
    points: np.ndarray, tets: np.ndarray, stress: np.ndarray, origin: np.ndarray, axis: int
) -> bytes:
    """Return a .png of a stress (m,) of tets (m, 4) on the plane through `origin` square to axis 0..2."""
    polygons, rows = cut_tets(points, tets, origin, np.eye(3)[axis])
    first, second = (k for k in range(3) if k != axis)
    figure = new_figure(6.0, 5.0)
    axes = figure.add_subplot()
    low, high = np.percentile(stress[rows], [100 - SCALE_PERCENT, SCALE_PERCENT]) if len(rows) else (0, 1)
    cells = PolyCollection(
        list(polygons[..., [first, second]]), array=stress[rows], cmap=COLOURS, clim=(low, high)
    )
    cells.set_edgecolor("face")
    axes.add_collection(cells)
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.set_xlabel("xyz"[first])
    axes.set_ylabel("xyz"[second])
    axes.set_title(f"{'xyz'[axis]} = {origin[axis]:.4g}", fontsize=10)
    figure.colorbar(cells, ax=axes, label="largest principal stress")
    return as_png(figure)


def frame_box(axes: Axes3D, box: np.ndarray) -> None:
    """Set limits and names of the axes to those of a box (2, 3), with one scale."""
    for low, high, set_limits, name in zip(
        *box, (axes.set_xlim, axes.set_ylim, axes.set_zlim), ("x", "y", "z")
    ):
        set_limits(low, high)
        getattr(axes, f"set_{name}label")(name)
    axes.set_box_aspect(np.ptp(box, axis=0))


def new_figure(width: float, height: float) -> Figure:
    """Return a figure of that size in inches, drawn without a screen."""
    figure = Figure(figsize=(width, height), dpi=DPI)
    FigureCanvasAgg(figure)
    return figure


def as_png(figure: Figure) -> bytes:
    """Return the figure as .png, the same bytes for the same figure."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png", metadata={"Software": None})
    return stream.getvalue()
