"""What lies round a few nodes of all grains' tetrahedra: tets and facets by id, as they change."""

from dataclasses import dataclass, field

import numpy as np

from craftmesh.cracks.promises import FRONT_MOVED
from craftmesh.surface.connectivity import lowest_equal_point
from craftmesh.surface.front import front_edges
from craftmesh.surface.patches import feature_edges, patches
from craftmesh.tetrahedra.surface_freedom import crack_length
from craftmesh.tetrahedra.whole_mesh import Model
from craftmesh.types import CRACK, Surface

Corners = tuple[int, ...]

# Columns of `Classes.held` that are planes of the box; the crack and its front follow.
BOX_PLANES = CRACK - 1


@dataclass(frozen=True)
class Classes:
    """What holds the surface's points, and what its facets are; points with equal places are one.

    held (n, 8) bool: on the planes of the box, on the crack, on its front; rank (n,): 0 inside a patch, 1
    on a line, 2 where lines end or meet; facets (m, 3); patch (m,); crack (m,) and free (m,) bool: facets
    of the crack, and of the box, a void or the exterior; crack_length: see the function, 0 without a crack.
    """

    held: np.ndarray
    rank: np.ndarray
    facets: np.ndarray
    patch: np.ndarray
    crack: np.ndarray
    free: np.ndarray
    crack_length: float


def classes_of(surface: Surface) -> Classes:
    """Return the classes of points and facets of `surface`."""
    count = len(surface.points)
    held = np.zeros((count, 8), bool)
    for kind in np.unique(surface.kind[surface.kind > 0]).tolist():
        held[surface.facets[surface.kind == kind], kind - 1] = True
    front = front_edges(surface)
    held[front, CRACK] = True
    lines = np.bincount(feature_edges(surface).lines.ravel(), minlength=count)
    return Classes(
        held=held,
        rank=np.where(lines == 0, 0, np.where(lines == 2, 1, 2)),
        facets=lowest_equal_point(surface.points)[surface.facets],
        patch=patches(surface).of_facet,
        crack=surface.kind == CRACK,
        free=np.any(surface.sides <= 0, axis=1),
        crack_length=crack_length(surface),
    )


@dataclass
class Stars:
    """The tets and facets at some nodes: corners by id, and the ids at each of the nodes.

    Whoever changes them has them checked first; `gone` holds the ids of those that are no more.
    """

    points: np.ndarray
    grain: np.ndarray
    classes: Classes
    tets: dict[int, Corners]
    facets: dict[int, Corners]
    tets_at: dict[int, set[int]]
    facets_at: dict[int, set[int]]
    gone_tets: set[int] = field(default_factory=set)
    gone_facets: set[int] = field(default_factory=set)

    def on_surface(self, node: int) -> bool:
        """Tell whether facets lie at the node."""
        return bool(self.facets_at[node])

    def touch(self, one: int, other: int) -> bool:
        """Tell whether two nodes are no farther from each other than FRONT_MOVED."""
        apart = float(np.linalg.norm(self.points[one] - self.points[other]))
        return apart <= FRONT_MOVED * self.classes.crack_length

    def merge(self, kept: int, gone: int) -> None:
        """Make `gone` the node `kept`, held by all that held either; cells with both are no more."""
        self.classes.held[kept] |= self.classes.held[gone]
        both = self.tets_at[kept] & self.tets_at[gone]
        self.gone_tets |= both
        _merge(self.tets, self.tets_at, kept, gone, both)
        both = self.facets_at[kept] & self.facets_at[gone]
        self.gone_facets |= both
        _merge(self.facets, self.facets_at, kept, gone, both)


def _merge(
    cells: dict[int, Corners], at: dict[int, set[int]], kept: int, gone: int, both: set[int]
) -> None:
    for cell in both:
        for node in cells[cell]:
            if node in at:
                at[node] = at[node] - {cell}
    for cell in at[gone]:
        cells[cell] = renamed(cells[cell], gone, kept)
    at[kept] = at[kept] | at[gone]
    at[gone] = set()


def renamed(corners: Corners, old: int, new: int) -> Corners:
    """Return the corners with `new` in the place of `old`."""
    return tuple(new if node == old else node for node in corners)


def stars_of(model: Model, classes: Classes, nodes: np.ndarray) -> Stars:
    """Return what lies round the nodes (k,) of the model."""
    tets = model.tets
    tets_by_id, tets_at = _around(tets, nodes)
    facets, facets_at = _around(classes.facets, nodes)
    return Stars(model.points, model.grain, classes, tets_by_id, facets, tets_at, facets_at)


def _around(cells: np.ndarray, nodes: np.ndarray) -> tuple[dict[int, Corners], dict[int, set[int]]]:
    wanted = np.zeros(max(int(cells.max(initial=-1)), int(nodes.max(initial=-1))) + 1, bool)
    wanted[nodes] = True
    rows = np.flatnonzero(wanted[cells].any(axis=1))
    found: dict[int, Corners] = dict(zip(rows.tolist(), map(tuple, cells[rows].tolist())))
    at: dict[int, set[int]] = {node: set() for node in nodes.tolist()}
    for row, corners in found.items():
        for node in corners:
            if node in at:
                at[node].add(row)
    return found, at
