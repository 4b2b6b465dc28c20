"""Pictures of growing cracks: surfaces, K along fronts, deformed bodies, and values on a plane."""

import io
from collections.abc import Mapping

import numpy as np

from craftmesh.cracks.polyline import feet, polyline
from craftmesh.extras import extra
from craftmesh.report.shaded import View, shaded, view_from
from craftmesh.report.shown_mesh import cut_tets, seen_from
from craftmesh.surface.measure import area_vectors, meets_box, nearest_facet
from craftmesh.surface.rounding import SAME_PLACE
from craftmesh.types import Crack

with extra("pictures"):
    import matplotlib
    from matplotlib.axes import Axes
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch
    from mpl_toolkits.mplot3d import Axes3D
    from PIL import Image

GRAINS = "tab20"  # colour map of grains: twenty colours, used in turn
STYLES = ("-", "--", ":", "-.")  # line styles of the fronts of one crack
DPI = 110
COLOURS = "viridis"
BELOW = 0.14  # space below a crack for the axis directions, over the crack's width
TOWARDS = seen_from(2)  # default direction from which a body is seen
PIXELS = 560  # width of a body's picture
WEBP = 82  # quality of .webp, of 100: a lined mesh takes 40 kB and looks like its .png of 330
# Largest displacement as shown, over the body's diagonal.
SHOWN_MOVE = 0.08
# Least ratio of a triangle's distance from the previous crack to that from its fronts, above which the
# triangle is ahead of these. A layer made again, turned by up to 26 degrees, is nearer to the crack than to
# its fronts at two thirds of its width.
AHEAD = 0.9
# Percentage of values cut off at each end of a colour scale, as stresses at a crack front are unbounded.
LEFT_OUT = 1.0


def crack_by_increment(cracks: Mapping[str, Crack], box: np.ndarray, towards: np.ndarray) -> Figure:
    """Return a figure of a crack's surface in the box (2, 3), coloured by increment, with all fronts.

    cracks: by increment name; each contains the one before. The figure has two views: from the direction
    `towards` (3,), and along the normal of the last crack.
    """
    colours = matplotlib.colormaps[COLOURS](np.linspace(0.1, 0.95, len(cracks)))
    last = list(cracks.values())[-1]
    corners, added = _added(cracks, box)
    edges = box_edges(box)
    normal = area_vectors(last.points, last.triangles).sum(axis=0)
    views = (
        view_from(towards, edges.reshape(-1, 3)),
        view_from(normal * np.sign(normal @ towards), corners.reshape(-1, 3), BELOW),
    )
    figure, pair = two_pictures()
    for axes, view in zip(pair, views):
        triangles = np.arange(3 * len(corners)).reshape(-1, 3)
        shade = np.repeat(colours[added][:, None, :3], 3, axis=1)
        draw_body(axes, corners.reshape(-1, 3), triangles, shade, view, lined=False)
        for crack in cracks.values():
            for front in crack.fronts:
                axes.plot(*view.flat(crack.points[front]).T, color="black", linewidth=0.8)
    for edge in edges:
        figure.axes[0].plot(*views[0].flat(edge).T, color="grey", linewidth=0.6)
    marks = [Patch(color=colour, label=name) for name, colour in zip(cracks, colours)]
    figure.legend(handles=marks, title="increment", fontsize=8, loc="center right")
    return figure


def two_pictures() -> tuple[Figure, list[Axes]]:
    """Return a figure for two pictures, with space for a colour bar, and the axes of both."""
    figure = new_figure(10.4, 4.4)
    axes = figure.subplots(1, 2)
    figure.subplots_adjust(left=0.01, right=0.91, bottom=0.01, top=0.99, wspace=0.04)
    return figure, list(axes)


def draw_body(
    axes: Axes, points: np.ndarray, triangles: np.ndarray, colours: np.ndarray, view: View, lined: bool
) -> None:
    """Draw triangles (m, 3) on points (n, 3) with colours (m, 3, 3) of their corners, and axis directions.

    lined: also draw the triangles' edges.
    """
    picture = shaded(points, triangles, colours, view, PIXELS, lined)
    axes.imshow(picture, extent=view.extent, interpolation="bilinear")
    axes.set_axis_off()
    draw_directions(axes, view)


def box_edges(box: np.ndarray) -> np.ndarray:
    """Return the end points (12, 2, 3) of the edges of a box (2, 3)."""
    corner = np.stack(np.meshgrid(*box.T, indexing="ij"), axis=-1).reshape(-1, 3)
    return np.array([corner[[i, i | bit]] for bit in (1, 2, 4) for i in range(8) if not i & bit])


def _added(cracks: Mapping[str, Crack], box: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the triangles (m, 3, 3) in the box that each crack adds to the one before, and its index (m,).

    Added triangles are ahead of the previous fronts: nearer to these than to other parts of the previous
    crack. The last step's layer, if corrected, lies off the previous crack but next to it, so it is not
    among them and is shown as first made.
    """
    found, whose = [], []
    before: Crack | None = None
    for number, crack in enumerate(cracks.values()):
        corners = crack.points[crack.triangles]
        shown = meets_box(corners, box)
        if before is not None:
            places = corners.mean(axis=1)
            _, off, _ = nearest_facet(places, before.points, before.triangles)
            shown &= off > SAME_PLACE * np.linalg.norm(box[1] - box[0])
            if before.fronts:
                to_front = [feet(polyline(before.points[front]), places)[1] for front in before.fronts]
                shown &= off > AHEAD * np.min(to_front, axis=0)
        before = crack
        found.append(np.clip(corners[shown], *box))
        whose.append(np.full(int(shown.sum()), number))
    return np.concatenate(found), np.concatenate(whose)


def draw_directions(axes: Axes, view: View) -> None:
    """Draw arrows along x, y and z in the lower left corner, except for an axis along the line of sight."""
    reach = 0.06 * (view.high - view.low).max()
    arrows = reach * view.frame[:2].T
    root = view.low + 1.5 * (reach - np.minimum(arrows.min(axis=0), 0))
    for name, arrow in zip("xyz", arrows):
        if np.linalg.norm(arrow) > 0.25 * reach:
            axes.annotate("", root + arrow, root, arrowprops={"arrowstyle": "->", "lw": 1.0})
            axes.annotate(name, root + 1.4 * arrow, fontsize=9, ha="center", va="center")


def plain(text: str) -> str:
    """Return a user's text with `$` escaped, so that matplotlib does not read it as a formula."""
    return text.replace("$", r"\$")


def with_unit(key: str, unit: str) -> str:
    """Return the axis label of a column of sif.csv; unit: of K, empty if unknown."""
    return "kink angle [degrees]" if key == "kink_angle" else f"{key} [{plain(unit)}]" if unit else key


def along_front(rows: Mapping[str, Mapping[str, np.ndarray]], unit: str = "") -> Figure:
    """Return a figure of K_I, K_II, K_III and the kink angle along the fronts, a line per increment.

    rows: columns of sif.csv by increment name; unit: of K. The arc length s is divided by each front's
    largest s.
    """
    figure = new_figure(9.0, 5.6)
    axes = figure.subplots(2, 2, sharex=True).ravel()
    colours = matplotlib.colormaps[COLOURS](np.linspace(0.1, 0.95, len(rows)))
    shown = [(key, with_unit(key, unit)) for key in ("K_I", "K_II", "K_III", "kink_angle")]
    for (name, columns), colour in zip(rows.items(), colours):
        for front in np.unique(columns["front"]):
            row = np.flatnonzero(columns["front"] == front)
            s = columns["s"][row] / max(columns["s"][row].max(), 1e-300)
            for place, (key, label) in zip(axes, shown):
                style = STYLES[int(front - 1) % len(STYLES)]
                place.plot(s, columns[key][row], style, color=colour, label=name if front == 1 else None)
                place.set_ylabel(label)
                place.grid(alpha=0.3)
    for place in axes[2:]:
        place.set_xlabel("arc length along the front / its length")
    axes[0].legend(title="increment", fontsize=8)
    figure.tight_layout()
    return figure


def deformed_body(
    points: np.ndarray, facets: np.ndarray, displacement: np.ndarray, towards: np.ndarray = TOWARDS
) -> Figure:
    """Return a figure of the free facets (m, 3), deformed and coloured by the displacement (n, 3).

    points (n, 3); towards (3,): direction from which the body is seen. The displacement is scaled so that
    its largest value is SHOWN_MOVE of the body's diagonal.
    """
    size = np.linalg.norm(displacement, axis=1)
    factor = SHOWN_MOVE * np.linalg.norm(np.ptp(points, axis=0)) / max(size.max(), 1e-300)
    moved = points + factor * displacement
    shade = ScalarMappable(Normalize(0, size.max()), COLOURS)
    view = view_from(towards, moved)
    figure = new_figure(6.0, 4.4)
    axes = figure.add_subplot()
    draw_body(axes, moved, facets, shade.to_rgba(size[facets])[..., :3], view, lined=False)
    figure.colorbar(shade, ax=axes, shrink=0.8, label=f"displacement (shown {factor:.3g} times)")
    return figure


def value_on_plane(
    points: np.ndarray, tets: np.ndarray, values: np.ndarray, origin: np.ndarray, axis: int, name: str
) -> Figure:
    """Return a figure of values (m,) of tets (m, 4) on the plane through `origin` perpendicular to `axis`.

    points (n, 3); origin (3,); name: label of the values.
    """
    polygons, rows = cut_tets(points, tets, origin[axis], axis)
    first, second = (k for k in range(3) if k != axis)
    figure = new_figure(6.0, 4.4)
    axes = figure.add_subplot()
    scale = scale_of(values[rows]) if len(rows) else Normalize(0, 1)
    cells = PolyCollection(list(polygons), array=values[rows], cmap=COLOURS, norm=scale)
    cells.set_edgecolor("face")
    axes.add_collection(cells)
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.set_xlabel("xyz"[first])
    axes.set_ylabel("xyz"[second])
    axes.set_title(f"{'xyz'[axis]} = {origin[axis]:.4g}", fontsize=10)
    figure.colorbar(cells, ax=axes, label=name)
    return figure


def scale_of(values: np.ndarray) -> Normalize:
    """Return the colour scale of all values except LEFT_OUT percent at each end."""
    return Normalize(*np.percentile(values, [LEFT_OUT, 100 - LEFT_OUT]))


def frame_box(axes: Axes3D, box: np.ndarray) -> None:
    """Set limits and labels of 3-D axes to a box (2, 3), with the same scale on all axes."""
    x, y, z = box.T
    axes.set(xlim=x, ylim=y, zlim=z, xlabel="x", ylabel="y", zlabel="z", box_aspect=np.ptp(box, axis=0))


def new_figure(width: float, height: float) -> Figure:
    """Return a figure of the given size in inches, which needs no screen."""
    figure = Figure(figsize=(width, height), dpi=DPI)
    FigureCanvasAgg(figure)
    return figure


def as_png(figure: Figure) -> bytes:
    """Return the figure as .png, the same bytes for the same figure."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png", metadata={"Software": None})
    return stream.getvalue()


def as_webp(figure: Figure) -> bytes:
    """Return the figure as .webp, the same bytes for the same figure."""
    canvas, stream = FigureCanvasAgg(figure), io.BytesIO()
    canvas.draw()
    Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3]).save(stream, "webp", quality=WEBP)
    return stream.getvalue()
