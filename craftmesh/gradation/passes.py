"""Passes of the gradation over all edges or vertices, with arrays that grow when they are full.

An angle score is a number for both the smallest and the largest angle of a facet; more is better.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.gradation.kernels.facet_grid import ROOM_PER_STEP, FacetGrid, fill_grid, make_grid
from craftmesh.gradation.kernels.one_pass import (
    COLLAPSE,
    EVEN,
    RELAX,
    SLIDE,
    SPLIT,
    SWAP,
    one_pass,
)
from craftmesh.gradation.kernels.rings import list_edges
from craftmesh.gradation.locality import block_order
from craftmesh.gradation.state import Guards, Mesh, State, lengthened, make_room, make_state
from craftmesh.kernel_structs import by_reference
from craftmesh.sizing.sizing import Sizing
from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.kernels.facet_shape import mean_edge, poor_facets
from craftmesh.surface.kernels.hinges import SHARP_COSINE
from craftmesh.surface.measure import span_of
from craftmesh.types import Crack, Surface

# Width of the grid's cells divided by the mean edge length; 1.6 to 3.2 make no notable difference.
CELL = 2.5


class Limits(NamedTuple):
    """The bounds of a pass, for kernels; an infinite bound switches its guard off."""

    collapse: float  # edges under this ratio of length to target length are collapsed
    split: float  # edges over this ratio of length to target length are split
    longest: float  # largest such ratio of a new edge, unless a replaced edge was as long
    floor: float  # smallest angle score of new facets
    gain: float  # required rise of the smallest score if it was under the floor
    cosine: float  # cosine of the normal tolerance
    distance: float  # largest distance from input vertices to the surface, over the target length
    crack_distance: float  # the same for input vertices on the crack, as a length
    drift: float  # largest relative change of a grain's volume
    merge_points: bool  # whether junction points may merge
    wedge: float = SHARP_COSINE  # cosine of the smallest dihedral angle of a grain that may be made
    front_distance: float = np.inf  # largest distance, as a length, of input front vertices from the
    # surface's front, and of new front edges from the input's front
    crack_facets: float = np.inf  # largest distance from new crack facets to the given crack, as a length
    even_floor: float = np.inf  # replaces `floor` in moves along lines, if it is less


@dataclass
class Gradation:
    """The working arrays, a grid of their facets, and counts of operations by name.

    Passes change the arrays in place and replace state and grid by larger ones when these are full.
    """

    state: State
    grid: FacetGrid
    done: dict[str, int]
    # (v, 3): positions of the vertices for which `set_sizes` was last called, nan for none
    sized: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    # limits of the last pass of swaps; mesh.changed marks facets that have changed since
    swapped: Limits | None = None
    # references to the state and the grid, for kernels; None before the first use
    references: tuple[Any, Any] | None = None

    @property
    def mesh(self) -> Mesh:
        """The current surface."""
        return self.state.mesh

    def edges(
        self, least: float = -np.inf, most: float = np.inf
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return edges (e, 2), a mask (e,) of feature edges, and ratios (e,) of length to target length.

        Only edges with a ratio strictly between `least` and `most` are returned.
        """
        return list_edges(self.reference()[0], least, most)

    def reference(self) -> tuple[Any, Any]:
        """Return references to the state and to the grid, for kernels; the first use makes them."""
        if self.references is None:
            self.references = by_reference(*self.state), by_reference(self.grid)
        return self.references

    def poor_facets(self, score: float) -> np.ndarray:
        """Return the corners (k, 3) of the living facets whose angle score is under `score`."""
        m = self.mesh
        return m.facets[poor_facets(m.points, m.facets, m.alive, m.used[1], score)]

    def set_sizes(self, sizing: Sizing) -> None:
        """Set target lengths of the living vertices that are new or have moved since the last call.

        sizing: must be the same at all calls (not checked), because other vertices keep their lengths.
        """
        mesh, n = self.mesh, int(self.mesh.used[0])
        self.sized = lengthened(self.sized, n, np.nan)
        points, sized = mesh.points[:n], self.sized[:n]
        moved = np.flatnonzero((mesh.first[:n] >= 0) & ~_are_equal(points, sized))
        mesh.size[moved] = sizing.at(points[moved])
        sized[moved] = points[moved]

    def living_vertices(self) -> np.ndarray:
        """Return the ids of the vertices that have facets."""
        return np.flatnonzero(self.mesh.first[: self.mesh.used[0]] >= 0)

    def repeat(
        self, name: str, operation: int, limits: Limits, items: np.ndarray, goal: float = 0.0
    ) -> int:
        """Try an operation at all `items`, edges (n, 2) or vertices (n,); return the number of successes.

        name: key of `done` to which the successes are added. goal: for SLIDE the score under which a vertex
        moves, for SPLIT the smallest ratio of a half's score to its parent's. `one_pass` stops when arrays
        are full; then they are enlarged and the pass goes on.
        """
        rows = items if items.ndim == 2 else items[:, None]
        start, total = 0, 0
        while True:
            start, done = one_pass(*self.reference(), limits, operation, rows, goal, start)
            total += done
            if start >= len(rows):
                break
            self.make_room()
        self.done[name] = self.done.get(name, 0) + total
        if 2 * np.count_nonzero(self.mesh.alive) < self.mesh.used[1]:
            self.make_room()
        return total

    def make_room(self) -> None:
        """Remove dead facets, rebuild the grid and add free rows; the references become None."""
        arrays = self.state.mesh._asdict() | self.state.guards._asdict()
        scratch = self.state.scratch
        self.references = None
        del self.state, self.grid
        make_room(arrays)
        mesh = Mesh(**{name: arrays[name] for name in Mesh._fields})
        guards = Guards(**{name: arrays[name] for name in Guards._fields})
        self.state = State(mesh, guards, scratch)
        self.grid = filled_grid(mesh)


def begun(surface: Surface, sizing: Sizing, crack: Crack | None, done: Mapping[str, int]) -> Gradation:
    """Return the gradation of a surface before its passes, as the only owner of its arrays."""
    state = make_state(surface, sizing.at(surface.points), crack)
    return Gradation(state, filled_grid(state.mesh), dict(done), sized=surface.points.copy())


def filled_grid(mesh: Mesh) -> FacetGrid:
    """Return a grid of the living facets, with free items for changes.

    The cells are CELL times as wide as the mean edge is long. Raises CraftmeshError without a living facet.
    """
    m = int(mesh.used[1])
    living = int(np.count_nonzero(mesh.alive[:m]))
    if not living:
        raise CraftmeshError("the surface has no facets; expected at least one to gradate")
    cell = max(CELL * mean_edge(mesh.points, mesh.facets, mesh.alive, m), 1e-300)
    low, high = span_of(mesh.points[mesh.first >= 0])
    items = 6 * living + 2 * ROOM_PER_STEP
    grid = make_grid(low, high, cell, items, len(mesh.facets))
    while not fill_grid(grid, mesh.points, mesh.facets, mesh.patch, mesh.alive, m) or (
        grid.used[0] + 2 * ROOM_PER_STEP > len(grid.facet)
    ):
        items *= 2
        grid = make_grid(low, high, cell, items, len(mesh.facets))
    return grid


def collapse_short(gradation: Gradation, limits: Limits) -> int:
    """Collapse edges under limits.collapse times their target length; return the number of collapses.

    Edges on junction lines are first, then the others; within a block of vertices the shortest (relative
    to its target) is first.
    """
    edges, feature, ratio = gradation.edges(most=limits.collapse)
    short = [
        edges.take(rows.take(block_order(edges[:, 0].take(rows), ratio.take(rows))), axis=0)
        for rows in map(np.flatnonzero, (feature, ~feature))
    ]
    del edges, feature, ratio
    names = "collapsed_junction_edges", "collapsed_regular_edges"
    return sum(gradation.repeat(name, COLLAPSE, limits, rows) for name, rows in zip(names, short))


def split_long(gradation: Gradation, limits: Limits) -> int:
    """Split edges over limits.split times their target length; return the number of splits.

    The edges are taken by blocks of vertices (`block_order`), and in a block the longest is first.
    """
    edges, _, ratio = gradation.edges(least=limits.split)
    long = edges.take(block_order(edges[:, 0], -ratio), axis=0)
    return split_all(gradation, "split_edges", limits, long, 1.0)


def split_all(gradation: Gradation, name: str, limits: Limits, edges: np.ndarray, share: float) -> int:
    """Split `edges` (e, 2), in order, if they are over limits.split and have acceptable halves.

    A half must have the angle score limits.floor, or `share` times its parent's score. Halves lie in their
    parent or on the input's crack or front, so volumes, distances from input vertices and lengths are not
    checked. Return the number of splits, which are added to `gradation.done` under `name`.
    """
    limits = limits._replace(longest=np.inf, drift=np.inf, distance=np.inf)
    return gradation.repeat(name, SPLIT, limits, edges, share)


def swap_all(gradation: Gradation, limits: Limits) -> int:
    """Swap edges inside patches where that raises angles, whatever the new length; return their number.

    If the last pass of swaps had the same limits, only edges of facets that have changed since then are
    tried. Resets the marks of changed facets.
    """
    limits = limits._replace(longest=np.inf)
    asked = limits._replace(collapse=0.0, split=0.0, floor=0.0, gain=0.0, merge_points=False)
    edges = edges_to_swap(gradation, asked)
    done = gradation.repeat("swapped_edges", SWAP, limits, edges)
    gradation.mesh.changed[:] = False
    gradation.swapped = asked
    return done


def edges_to_swap(gradation: Gradation, limits: Limits) -> np.ndarray:
    """Return the edges (e, 2) that a pass of swaps with these limits must try.

    If the last pass had the same limits, these are all edges of facets that have changed since then. If
    not, they are all edges inside patches.
    """
    if gradation.swapped != limits:
        edges, feature, _ = gradation.edges()
        return edges.take(np.flatnonzero(~feature), axis=0)
    mesh = gradation.mesh
    return unique_edges(mesh.facets.take(np.flatnonzero(mesh.changed & mesh.alive), axis=0))[0]


def _are_equal(rows: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return a mask (n,) of rows (n, 3) that are equal in both arrays."""
    return (rows[:, 0] == others[:, 0]) & (rows[:, 1] == others[:, 1]) & (rows[:, 2] == others[:, 2])


def swap_poor(gradation: Gradation, limits: Limits) -> int:
    """Swap edges of facets that score under limits.floor, if that raises the smallest angle.

    Edges around each swapped edge are tried too. Return the number of swaps.
    """
    edges, _, _ = unique_edges(gradation.poor_facets(limits.floor))
    return gradation.repeat("swapped_edges", SWAP, limits._replace(longest=np.inf), edges)


def slide_all(gradation: Gradation, limits: Limits, goal: float) -> int:
    """Move vertices of facets with an angle score under `goal` to raise it; return the number of moves."""
    order = np.unique(gradation.poor_facets(goal))
    return gradation.repeat("slid_vertices", SLIDE, limits, order, goal)


def even_lines(gradation: Gradation, limits: Limits) -> int:
    """Move vertices for equal spacing along junction lines and crack fronts; return the number of moves."""
    order = gradation.living_vertices()
    order = order[gradation.mesh.rank[order] == 1]
    limits = limits._replace(floor=min(limits.floor, limits.even_floor))
    return gradation.repeat("slid_line_vertices", EVEN, limits, order)


def relax_all(gradation: Gradation, limits: Limits) -> int:
    """Move vertices inside patches to the weighted centroid of their facets; return the number of moves."""
    order = gradation.living_vertices()
    return gradation.repeat("relaxed_vertices", RELAX, limits, order)
