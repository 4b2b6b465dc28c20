"""Preview of a crack in its microstructure before meshing: grains and boundaries met, and a picture.

A trace is a line in which the crack meets a facet of the surface.
"""

from dataclasses import dataclass

import numpy as np

from craftmesh.cracks.crack_surface_intersections import Oblique, Traces
from craftmesh.cracks.height_parts import best_fit_frame
from craftmesh.cracks.prescription import frame_along
from craftmesh.extras import extra
from craftmesh.report.pictures import GRAINS, as_png, box_edges, frame_box, new_figure
from craftmesh.surface.connectivity import joined, unique_edges
from craftmesh.surface.front import among_edges, front_edges
from craftmesh.surface.measure import area_vectors, edge_lengths, meets_box
from craftmesh.surface.patches import is_on_box
from craftmesh.types import BOX_PLANES, CRACK, Crack, Surface

with extra("pictures"):
    import matplotlib
    from matplotlib.collections import LineCollection, PolyCollection
    from matplotlib.figure import Figure
    from mpl_toolkits.mplot3d import Axes3D
    from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

PLAIN = "silver"  # colour of a crack that was rejected


@dataclass(frozen=True, eq=False)
class Preview:
    """A crack in a microstructure.

    box (2, 3): of the microstructure; traces: of the crack on the surface's facets; inserted: the surface
    with the crack in it, None if the insertion was rejected; refused: the reason of rejection, else "";
    grains: ids of grains that the crack meets; area, front_length: of the crack by grain id, empty if
    rejected; fronts: for each front whether it is closed, its length, and names of the faces at its ends;
    oblique: boundaries that the crack meets below a limiting angle.
    """

    crack: Crack
    box: np.ndarray
    traces: Traces
    inserted: Surface | None
    refused: str
    grains: tuple[int, ...]
    area: dict[int, float]
    front_length: dict[int, float]
    fronts: tuple[tuple[bool, float, tuple[str, ...]], ...]
    oblique: tuple[Oblique, ...]


def met_grains(found: Traces, surface: Surface) -> tuple[int, ...]:
    """Return the ids of grains on both sides of the facets that the crack cuts."""
    ids = np.unique(surface.sides[found.facet])
    return tuple(ids[ids > 0].tolist())


def grain_measures(surface: Surface) -> tuple[dict[int, float], dict[int, float]]:
    """Return the crack's area and its front length, each as a dict by id of the grains at the crack.

    A facet between two grains, and a front edge on it, counts half for each grain.
    """
    crack = surface.kind == CRACK
    sides, facets = surface.sides[crack], surface.facets[crack]
    area = np.linalg.norm(area_vectors(surface.points, facets), axis=1)
    edges, of_corner, count = unique_edges(facets)
    is_front = (count == 1) & ~among_edges(edges, surface.facets[(surface.sides <= 0).any(axis=1)])
    along = np.where(is_front, edge_lengths(surface.points, edges), 0.0)[of_corner].sum(axis=1)
    return tuple(
        {int(g): float((values[:, None] * (sides == g) / 2).sum()) for g in np.unique(sides[sides > 0])}
        for values in (area, along)
    )  # type: ignore[return-value]


def front_lines(surface: Surface) -> tuple[tuple[bool, float, tuple[str, ...]], ...]:
    """Return for each crack front whether it is closed, its length, and names of the faces at its ends."""
    edges = front_edges(surface)
    if not len(edges):
        return ()
    nodes, local = np.unique(edges, return_inverse=True)
    local = local.reshape(-1, 2)
    piece, degree = joined(len(nodes), *local.T), np.bincount(local.ravel())
    length = edge_lengths(surface.points, edges)
    fronts = []
    for number in range(piece.max() + 1):
        ends = nodes[(piece == number) & (degree == 1)]
        own = piece[local[:, 0]] == number
        faces = tuple(_faces_at(surface, point) for point in ends.tolist())
        fronts.append((not len(ends), float(length[own].sum()), faces))
    return tuple(fronts)


def _faces_at(surface: Surface, point: int) -> str:
    """Return the names of the free faces at a point (its id), joined by _, such as XMIN_ZMAX or VOID_3.

    A face to the outside that is on no box plane is EXTERIOR; the result is "inside" without a free face.
    """
    at = (surface.facets == point).any(axis=1)
    kinds = np.unique(surface.kind[at & is_on_box(surface.kind)])
    names = [BOX_PLANES[kind - 1] for kind in kinds.tolist()]
    open_sides = surface.sides[at & (surface.kind == 0)]
    names += [f"VOID_{-label}" for label in np.unique(open_sides[open_sides < 0]).tolist()]
    names += ["EXTERIOR"] if (open_sides == 0).any() else []
    return "_".join(names) or "inside"


def preview_picture(preview: Preview, limit: float) -> bytes:
    """Return a .png of the crack by grain: in the box, and seen along its normal with its traces.

    Traces on boundaries that the crack meets at less than `limit` degrees are red.
    """
    figure = new_figure(11.0, 5.2)
    triangles, colours, fronts = _shown(preview)
    _in_box(figure.add_subplot(1, 2, 1, projection="3d"), preview, triangles, colours, fronts)
    _from_ahead(figure, preview, triangles, colours, fronts, limit)
    if preview.refused:
        figure.suptitle("rejected: " + preview.refused, fontsize=8, color="firebrick", wrap=True)
    return as_png(figure)


def _shown(preview: Preview) -> tuple[np.ndarray, np.ndarray | str, list[np.ndarray]]:
    """Return the crack's triangles (k, 3, 3) in the box, their colours, and its fronts as lines (j, 3).

    They are of the inserted crack, coloured by grain, or of the given crack in PLAIN if it was rejected.
    """
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
    colours = matplotlib.colormaps[GRAINS](np.searchsorted(preview.grains, grain) % 20)
    return surface.points[surface.facets[crack]], colours, list(surface.points[front_edges(surface)])


def _in_box(
    axes: Axes3D, preview: Preview, triangles: np.ndarray, colours: np.ndarray | str, fronts: list
) -> None:
    box = preview.box
    axes.add_collection3d(Poly3DCollection(triangles, facecolor=colours))
    axes.add_collection3d(Line3DCollection(fronts, colors="black", linewidths=1.6))
    axes.add_collection3d(Line3DCollection(box_edges(box), colors="grey", linewidths=0.6))
    frame_box(axes, box)


def _from_ahead(
    figure: Figure,
    preview: Preview,
    triangles: np.ndarray,
    colours: np.ndarray | str,
    fronts: list,
    limit: float,
) -> None:
    """Draw the crack seen along its normal, with its traces and the ids of its grains."""
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
    """Return the position (3,) of each grain's label on the crack, by grain id; {} if rejected.

    It is the centre of the crack facet in the grain that is nearest to the mean of these centres.
    """
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
