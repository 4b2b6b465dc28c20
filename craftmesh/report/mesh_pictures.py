"""Pictures of an increment: grains, element sizes, crack, deformed body, stress and slip."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.extras import extra
from craftmesh.mechanics.materials import COMPONENT
from craftmesh.report.pictures import (
    BELOW,
    COLOURS,
    GRAINS,
    deformed_body,
    draw_body,
    scale_of,
    two_pictures,
    value_on_plane,
)
from craftmesh.report.shaded import View, view_from
from craftmesh.report.shown_mesh import Facets, ShownMesh
from craftmesh.types import Solution, TetMesh

with extra("pictures"):
    import matplotlib
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize, to_rgb
    from matplotlib.figure import Figure

LIP = to_rgb("antiquewhite")  # colour of the crack face in pictures by grain
FRONT = "crimson"


def mesh_pictures(shown: ShownMesh) -> dict[str, Figure]:
    """Return figures by name: `grains`, `sizes` and, if there is a crack, `crack`."""
    whole = view_from(shown.towards, shown.points)
    scale = scale_of(shown.lengths)
    pictures = {"grains": _bodies(shown, whole, _by_grain)}
    pictures["sizes"] = _bodies(shown, whole, lambda facets: _by_length(shown, facets, scale))
    _add_scale(pictures["sizes"], scale)
    if len(shown.lip.triangles):
        pictures["crack"] = _crack(shown, scale)
    return pictures


def _bodies(shown: ShownMesh, view: View, colours: Callable[[Facets], np.ndarray]) -> Figure:
    """Return a figure of the body, whole and cut open along the crack.

    colours: function that returns the colours (m, 3, 3) of facets at their corners.
    """
    figure, axes = two_pictures()
    for place, facets in zip(axes, (shown.skin, shown.opened)):
        draw_body(place, shown.points, facets.triangles, colours(facets), view, lined=True)
    _draw_fronts(axes[1], shown, view)
    return figure


def _crack(shown: ShownMesh, scale: Normalize) -> Figure:
    corners = shown.points[np.unique(shown.lip.triangles)]
    view = view_from(shown.normal, corners, BELOW)
    figure, axes = two_pictures()
    by_grain = _by_grain(shown.lip._replace(is_lip=~shown.lip.is_lip))
    for place, colours in zip(axes, (by_grain, _by_length(shown, shown.lip, scale))):
        draw_body(place, shown.points, shown.lip.triangles, colours, view, lined=True)
        _draw_fronts(place, shown, view)
    _add_scale(figure, scale)
    return figure


def _by_grain(facets: Facets) -> np.ndarray:
    """Return colours (m, 3, 3) of facets' corners by grain, LIP on crack faces."""
    colours = matplotlib.colormaps[GRAINS](facets.grain % 20)[:, :3]
    colours[facets.is_lip] = LIP
    return np.repeat(colours[:, None], 3, axis=1)


def _by_length(shown: ShownMesh, facets: Facets, scale: Normalize) -> np.ndarray:
    """Return colours (m, 3, 3) of facets' corners by mean edge length."""
    return matplotlib.colormaps[COLOURS](scale(shown.lengths[facets.triangles]))[..., :3]


def _draw_fronts(axes: Axes, shown: ShownMesh, view: View) -> None:
    for front in shown.fronts:
        axes.plot(*view.flat(shown.points[front]).T, color=FRONT, linewidth=1.8)


def _add_scale(figure: Figure, scale: Normalize) -> None:
    bar = figure.add_axes((0.925, 0.12, 0.012, 0.76))
    figure.colorbar(
        ScalarMappable(norm=scale, cmap=COLOURS), cax=bar, label="mean length of edges at a node"
    )


class SolvedMesh(NamedTuple):
    """A solved mesh; elements (m, 4) on points (p, 3) with stress (p, 6) as 11, 22, 33, 12, 13, 23.

    slip (p,): accumulated on all slip systems, None if unknown.
    """

    mesh: TetMesh
    solution: Solution
    points: np.ndarray
    elements: np.ndarray
    stress: np.ndarray
    slip: np.ndarray | None = None


def solved_pictures(solved: SolvedMesh, shown: ShownMesh) -> dict[str, Figure]:
    """Return figures by name: `deformed`, and `stress` and `slip` on a plane through the fronts' mean.

    The plane is perpendicular to the axis that is closest to the crack plane, and shows the crack's trace.
    Raises CraftmeshError if the solution has fewer nodes than the mesh.
    """
    found, needed = len(solved.solution.displacement), len(shown.points)
    if found < needed:
        raise CraftmeshError(
            f"the solution has {found} nodes, but the mesh has {needed}; give the solution of this mesh"
        )
    box = solved.mesh.box
    front = np.concatenate([*shown.fronts, np.zeros(0, np.int64)])
    middle = shown.points[front].mean(axis=0) if len(front) else box.mean(axis=0)
    stress = solved.stress[solved.elements].mean(axis=1)
    principal = np.linalg.eigvalsh(stress[:, COMPONENT])[:, -1]
    axis = int(np.abs(shown.normal).argmin())
    moved = solved.solution.displacement[: len(shown.points)]
    values = {"stress": (principal, "largest principal stress")}
    if solved.slip is not None:
        values["slip"] = (solved.slip[solved.elements].mean(axis=1), "accumulated slip")
    pictures = {"deformed": deformed_body(shown.points, shown.skin.triangles, moved, shown.towards)}
    place = np.clip(middle, *box)
    for name, (of_elements, words) in values.items():
        pictures[name] = value_on_plane(solved.points, solved.elements, of_elements, place, axis, words)
    return pictures
