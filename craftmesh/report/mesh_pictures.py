"""Pictures of an increment: grains, element sizes, crack, new elements, deformed body, stress and slip.

The skin is the free surface of the body; a lip is a crack face.
"""

from typing import NamedTuple

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.extras import extra
from craftmesh.mechanics.materials import COMPONENT
from craftmesh.mechanics.units import UnitsOptions
from craftmesh.report.pictures import (
    BELOW,
    COLOURS,
    FRONT,
    GRAINS,
    PIXELS,
    body_axes,
    box_edges,
    deformed_body,
    draw_body,
    scale_of,
    value_on_plane,
    with_unit,
)
from craftmesh.report.shaded import View, shaded, view_from
from craftmesh.report.shown_mesh import Facets, ShownMesh
from craftmesh.types import Solution, TetMesh

with extra("pictures"):
    import matplotlib
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize, to_rgb
    from matplotlib.figure import Figure

LIP = to_rgb("antiquewhite")  # colour of the crack face in pictures by grain
KEPT = to_rgb("gainsboro")  # colour of elements that a renewed mesh keeps from the mesh before


def mesh_pictures(shown: ShownMesh, length: str = "", new: np.ndarray | None = None) -> dict[str, Figure]:
    """Return figures by name: `grains`, `sizes`, with a crack `crack`, and with `new` elements `renewed`.

    length: unit of length; new (k,): rows of the new elements of a renewed mesh.
    """
    whole = body_view(shown.points, shown.towards)
    scale = scale_of(shown.lengths)
    by_length = _body(shown, shown.opened, whole, _by_length(shown, shown.opened, scale), length)
    label = with_unit("mean length of edges at a node", length)
    by_length.colorbar(ScalarMappable(scale, COLOURS), ax=by_length.axes, shrink=0.8, label=label)
    pictures = {
        "grains": _body(shown, shown.skin, whole, _by_grain(shown.skin), length),
        "sizes": by_length,
    }
    if new is not None:
        colours = _by_grain(shown.opened._replace(grain=np.zeros_like(shown.opened.grain)))  # in one colour
        colours[~np.isin(shown.opened.element, new)] = KEPT
        pictures["renewed"] = _body(shown, shown.opened, whole, colours, length)
    if len(shown.lip.triangles):
        view = view_from(shown.normal, shown.points[np.unique(shown.lip.triangles)], BELOW)
        colours = _by_grain(shown.lip._replace(is_lip=~shown.lip.is_lip))
        pictures["crack"] = _body(shown, shown.lip, view, colours, length)
    return pictures


def opened_body(shown: ShownMesh) -> np.ndarray:
    """Return a picture (h, w, 4), 0 to 1, of the body cut open along the crack and coloured by grain.

    The view is `body_view` of the whole body.
    """
    whole = body_view(shown.points, shown.towards)
    return shaded(shown.points, shown.opened.triangles, _by_grain(shown.opened), whole, PIXELS, True)


def body_view(points: np.ndarray, towards: np.ndarray) -> View:
    """Return the view, from the direction `towards` (3,), that shows the bounding box of points (n, 3)."""
    box = np.stack([np.min(points, axis=0), np.max(points, axis=0)])
    return view_from(towards, box_edges(box).reshape(-1, 3), BELOW)


def _body(shown: ShownMesh, facets: Facets, view: View, colours: np.ndarray, length: str) -> Figure:
    """Return a figure of facets with colours (m, 3, 3) of their corners.

    The crack's fronts are drawn over them, except if the facets are the skin.
    """
    figure, axes = body_axes()
    draw_body(axes, shown.points, facets.triangles, colours, view, True, length)
    for front in shown.fronts if facets is not shown.skin else ():
        axes.plot(*view.flat(shown.points[front]).T, color=FRONT, linewidth=1.8)
    return figure


def _by_grain(facets: Facets) -> np.ndarray:
    """Return colours (m, 3, 3) of facets' corners by grain, LIP on crack faces."""
    colours = matplotlib.colormaps[GRAINS](facets.grain % 20)[:, :3]
    colours[facets.is_lip] = LIP
    return np.repeat(colours[:, None], 3, axis=1)


def _by_length(shown: ShownMesh, facets: Facets, scale: Normalize) -> np.ndarray:
    """Return colours (m, 3, 3) of facets' corners by mean edge length."""
    return matplotlib.colormaps[COLOURS](scale(shown.lengths[facets.triangles]))[..., :3]


class SolvedMesh(NamedTuple):
    """A solved mesh, its solution, and values at points (p, 3) of elements (m, 4).

    stress (p, 6): components 11, 22, 33, 12, 13, 23; slip (p,): accumulated on all slip systems, None if
    unknown.
    """

    mesh: TetMesh
    solution: Solution
    points: np.ndarray
    elements: np.ndarray
    stress: np.ndarray
    slip: np.ndarray | None = None


def solved_pictures(solved: SolvedMesh, shown: ShownMesh, units: UnitsOptions) -> dict[str, Figure]:
    """Return figures by name: `deformed`, and on a plane `stress` and, if it is known, `slip`.

    The plane goes through the mean of the front nodes, or the middle of the box without a front. It is
    perpendicular to the axis that is closest to the crack plane, and shows the line in which the crack cuts
    it. Raises CraftmeshError if the solution has fewer nodes than the mesh.
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
    values = {"stress": (principal, with_unit("largest principal stress", units.stress))}
    if solved.slip is not None:
        values["slip"] = (solved.slip[solved.elements].mean(axis=1), "accumulated slip")
    skin, length = shown.skin.triangles, units.length
    pictures = {"deformed": deformed_body(shown.points, skin, moved, shown.towards, length)}
    place = np.clip(middle, *box)
    for name, (of_elements, words) in values.items():
        pictures[name] = value_on_plane(
            solved.points, solved.elements, of_elements, place, axis, words, length
        )
    return pictures
