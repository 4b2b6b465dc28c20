"""Pictures of cracked bodies: the path of a crack, deformed bodies, and values on a plane."""

import base64
import io
import re
from collections.abc import Mapping, Sequence

import numpy as np

from craftmesh.extras import extra
from craftmesh.report.shaded import View, shaded, view_from
from craftmesh.report.shown_mesh import cut_tets, seen_from

with extra("pictures"):
    import matplotlib
    from matplotlib.axes import Axes
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import PolyCollection, QuadMesh
    from matplotlib.colors import BoundaryNorm, ListedColormap, Normalize, to_hex
    from matplotlib.figure import Figure
    from mpl_toolkits.mplot3d import Axes3D
    from PIL import Image

GRAINS = "tab20"  # colour map of grains: twenty colours, used in turn
FRONT = "#dc143c"
DPI = 110
COLOURS = "viridis"
# Relative luminance (WCAG 2) of the colours of lines: their contrast is 4.2 to the light page and to the
# dark page.
LUMINANCE = 0.2
LUMINANCE_OF_RGB = (0.2126, 0.7152, 0.0722)
GAMMA = 2.2  # exponent of sRGB, within a few percent
BELOW = 0.1  # space below a body for the axis directions and the scale, relative to the body's width
TOWARDS = seen_from(2)  # default direction from which a body is seen
PIXELS = 640  # width of a body's picture
WEBP = 82  # quality of .webp, at most 100: a mesh with edges takes 40 kB and looks like its .png of 330 kB
MOST_TICKS = 8  # most increments named next to the colours of a crack's path
# Length of the largest displacement in a picture, relative to the body's diagonal.
SHOWN_MOVE = 0.08
# Percentage of values cut off at each end of a colour scale; stresses at a crack front are unbounded.
LEFT_OUT = 1.0
# Parts of matplotlib's .svg that are removed: metadata, a style that would change the whole page, numbered
# ids, and the size in points.
_NOT_SHOWN = r'<metadata>.*?</metadata>|<style.*?</style>| id="[\w.]+_\d+"| (?:width|height)="[\d.]+pt"'
_PNG = r"data:image/png;base64,([^\"]*)"


def crack_path(
    body: np.ndarray, view: View, fronts: Mapping[str, Sequence[np.ndarray]], length: str = ""
) -> Figure:
    """Return a figure of a body cut open along its crack, with fronts coloured by increment.

    body (h, w, 4): picture of the body in `view`; fronts: lines (k, 3) by increment name; length: unit.
    """
    figure, axes = body_axes()
    draw_picture(axes, body, view, length)
    colours = line_colours(len(fronts)) if len(fronts) > 1 else [FRONT]
    for colour, lines in zip(colours, fronts.values()):
        for line in lines:
            axes.plot(*view.flat(line).T, color=colour, linewidth=2.2)
    if len(fronts) > 1:
        scale = ScalarMappable(BoundaryNorm(np.arange(len(fronts) + 1) - 0.5, len(fronts)))
        scale.set_cmap(ListedColormap(colours))
        ticks = np.unique(np.linspace(0, len(fronts) - 1, MOST_TICKS).round().astype(int))
        bar = figure.colorbar(scale, ax=axes, shrink=0.8, label="crack front of increment")
        bar.set_ticks(ticks.tolist(), labels=[list(fronts)[k] for k in ticks])
    return figure


def draw_body(
    axes: Axes,
    points: np.ndarray,
    triangles: np.ndarray,
    colours: np.ndarray,
    view: View,
    lined: bool,
    length: str = "",
) -> None:
    """Draw triangles (m, 3) on points (n, 3), the axis directions and a scale bar.

    colours (m, 3, 3): of the triangles' corners; lined: also draw the triangles' edges; length: name of the
    unit of length.
    """
    draw_picture(axes, shaded(points, triangles, colours, view, PIXELS, lined), view, length)


def draw_picture(axes: Axes, picture: np.ndarray, view: View, length: str = "") -> None:
    """Draw a picture (h, w, 4) of a body, with the axis directions and a scale bar below it."""
    axes.imshow(picture, extent=view.extent, interpolation="bilinear")
    empty = picture[..., 3].any(axis=1).argmax() / len(picture)
    axes.set_ylim(view.low[1], view.high[1] - empty * (view.high - view.low)[1])
    axes.set_axis_off()
    draw_directions(axes, view)
    draw_scale(axes, view, length)


def draw_scale(axes: Axes, view: View, length: str) -> None:
    """Draw a bar in the lower right corner as long as 1, 2 or 5 times a power of ten, with its length."""
    width, height = view.high - view.low
    power = 10.0 ** np.floor(np.log10(width / 4))
    bar = power * max(step for step in (1, 2, 5) if step * power <= width / 4)
    end, level = view.high[0] - 0.02 * width, view.low[1] + 0.02 * height
    axes.plot([end - bar, end], [level, level], color="black", linewidth=2.0, solid_capstyle="butt")
    text = plain(f"{bar:g} {length or 'units of length'}")
    axes.annotate(text, (end, level + 0.02 * height), fontsize=9, ha="right", va="bottom")


def body_axes() -> tuple[Figure, Axes]:
    """Return a figure for the picture of a body, and its axes."""
    figure = new_figure(5.6, 4.4)
    figure.set_layout_engine("constrained")
    return figure, figure.add_subplot()


def box_edges(box: np.ndarray) -> np.ndarray:
    """Return the end points (12, 2, 3) of the edges of a box (2, 3)."""
    corner = np.stack(np.meshgrid(*box.T, indexing="ij"), axis=-1).reshape(-1, 3)
    return np.array([corner[[i, i | bit]] for bit in (1, 2, 4) for i in range(8) if not i & bit])


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
    """Return the axis label "key [unit]"; the kink angle is in degrees, whatever the unit.

    unit: "" if unknown, then it is left out.
    """
    return "kink angle [degrees]" if key == "kink_angle" else f"{key} [{plain(unit)}]" if unit else key


def line_colours(count: int) -> list[str]:
    """Return `count` colours (hex), in order, that stand out from white and dark pages alike."""
    linear = matplotlib.colormaps[COLOURS](np.linspace(0.1, 0.95, count))[:, :3] ** GAMMA
    linear *= (LUMINANCE / (linear @ LUMINANCE_OF_RGB))[:, None]
    return [to_hex(shade) for shade in np.clip(linear, 0, 1) ** (1 / GAMMA)]


def deformed_body(
    points: np.ndarray,
    facets: np.ndarray,
    displacement: np.ndarray,
    towards: np.ndarray = TOWARDS,
    length: str = "",
) -> Figure:
    """Return a figure of the free facets (m, 3), deformed and coloured by the displacement (n, 3).

    points (n, 3); towards (3,): direction from which the body is seen; length: unit. The displacement is
    scaled so that its largest value is SHOWN_MOVE times the body's diagonal.
    """
    size = np.linalg.norm(displacement, axis=1)
    largest = size.max()
    factor = SHOWN_MOVE * np.linalg.norm(np.ptp(points, axis=0)) / largest if largest > 1e-300 else 1.0
    moved = points + factor * displacement
    shade = ScalarMappable(Normalize(0, largest), COLOURS)
    figure, axes = body_axes()
    view = view_from(towards, moved, BELOW)
    draw_body(axes, moved, facets, shade.to_rgba(size[facets])[..., :3], view, False, length)
    label = with_unit(f"displacement, drawn {float(f'{factor:.2g}'):g} times as large", length)
    figure.colorbar(shade, ax=axes, shrink=0.8, label=label)
    return figure


def value_on_plane(
    points: np.ndarray,
    tets: np.ndarray,
    values: np.ndarray,
    origin: np.ndarray,
    axis: int,
    name: str,
    length: str = "",
) -> Figure:
    """Return a figure of values (m,) of tets (m, 4) on the plane through `origin` perpendicular to `axis`.

    points (n, 3); origin (3,); name: label of the values; length: unit.
    """
    polygons, rows = cut_tets(points, tets, origin[axis], axis)
    first, second = (k for k in range(3) if k != axis)
    figure, axes = body_axes()
    scale = scale_of(values[rows]) if len(rows) else Normalize(0, 1)
    cells = PolyCollection(list(polygons), array=values[rows], cmap=COLOURS, norm=scale, rasterized=True)
    cells.set_edgecolor("face")
    axes.add_collection(cells)
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.set_xlabel(with_unit("xyz"[first], length))
    axes.set_ylabel(with_unit("xyz"[second], length))
    axes.set_title(plain(f"{'xyz'[axis]} = {origin[axis]:.3g} {length}"), fontsize=10)
    figure.colorbar(cells, ax=axes, label=name)
    return figure


def scale_of(values: np.ndarray) -> Normalize:
    """Return a colour scale over the values (k,), without LEFT_OUT percent of them at each end."""
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


def as_png(*figures: Figure) -> bytes:
    """Return figures of one size as one .png, two in a row; the same figures give the same bytes."""
    canvases = [FigureCanvasAgg(figure) for figure in figures]
    for canvas in canvases:
        canvas.draw()
    pixels = [np.asarray(canvas.buffer_rgba())[..., :3] for canvas in canvases]
    if len(pixels) > 1:
        pixels += [np.full_like(pixels[0], 255)] * (len(pixels) % 2)
        pixels = [np.vstack([np.hstack(pixels[k : k + 2]) for k in range(0, len(pixels), 2)])]
    stream = io.BytesIO()
    Image.fromarray(pixels[0]).save(stream, "png")
    return stream.getvalue()


def as_svg(figure: Figure) -> str:
    """Return the figure as an <svg> element; the same figure gives the same text.

    Its background is transparent, and black parts get the colour of the text around the element. Changes
    how the figure draws its images and meshes.
    """
    for axes in figure.axes:
        for image in axes.images:
            image.set_interpolation("none")  # otherwise matplotlib resamples it to the figure's resolution
        for mesh in axes.collections:
            mesh.set_rasterized(isinstance(mesh, QuadMesh) or mesh.get_rasterized())
    stream = io.StringIO()
    with matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": "craftmesh"}):
        figure.savefig(stream, format="svg", transparent=True, metadata=dict.fromkeys(("Date", "Creator")))
    text = stream.getvalue()
    text = re.sub(_NOT_SHOWN, "", text[text.index("<svg") :], flags=re.S)
    text = re.sub(_PNG, lambda found: webp_uri(base64.b64decode(found[1])), text)
    text = re.sub(r"\s*\n\s*", " ", text).replace("#000000", "currentColor")
    return text.replace("<svg ", '<svg fill="currentColor" ', 1)


def as_webp(picture: np.ndarray) -> bytes:
    """Return a picture (h, w, 4) of numbers from 0 to 1 as .webp."""
    return _webp_bytes(Image.fromarray(np.rint(255 * picture).astype(np.uint8)))


def from_webp(content: bytes) -> np.ndarray:
    """Return the picture (h, w, 4) in a .webp."""
    return np.asarray(Image.open(io.BytesIO(content)).convert("RGBA")) / 255


def webp_uri(png: bytes) -> str:
    """Return the data URI of a .png's pixels as .webp."""
    content = _webp_bytes(Image.open(io.BytesIO(png)))
    return "data:image/webp;base64," + base64.b64encode(content).decode("ascii")


def _webp_bytes(image: Image.Image) -> bytes:
    stream = io.BytesIO()
    image.save(stream, "webp", quality=WEBP)
    return stream.getvalue()
