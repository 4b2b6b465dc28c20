"""Passes of the gradation over all edges or vertices, with arrays that grow as they need to."""

from collections import namedtuple
from dataclasses import dataclass

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.gradation.kernels.by_reference import by_reference
from craftmesh.gradation.kernels.collapse import collapse_pass
from craftmesh.gradation.kernels.facet_grid import ROOM_PER_STEP, FacetGrid, fill_grid, make_grid
from craftmesh.gradation.kernels.relax import relax_pass
from craftmesh.gradation.kernels.rings import list_edges
from craftmesh.gradation.kernels.slide import even_lines_pass, slide_pass
from craftmesh.gradation.kernels.split import split_pass
from craftmesh.gradation.kernels.swap import swap_pass
from craftmesh.gradation.locality import block_order
from craftmesh.gradation.state import State, drop_dead, grown
from craftmesh.surface.kernels.facet_shape import poor_facets, relative_lengths

# Width of the grid's cells in mean edges; from 1.6 to 3.2 makes no difference to speak of.
CELL = 2.5
# collapse, split: bounds of length over target; longest: of new edges; floor, gain: least angle score
# and the rise asked of poorer ones; cosine: of the normal tolerance; distance: to the input over the
# target length; crack_distance: in lengths; drift: of volumes; merge_points: junction points may merge.
Limits = namedtuple(
    "Limits", "collapse split longest floor gain cosine distance crack_distance drift merge_points"
)


@dataclass
class Gradation:
    """The state and its grid, with the counts of what was done; passes replace both as they grow."""

    state: State
    grid: FacetGrid | None
    done: dict

    def edges(self) -> tuple[np.ndarray, np.ndarray]:
        """Return edges (e, 2) and whether each is a feature."""
        s = self.state
        count = int(s.alive[: s.used[1]].sum())
        return list_edges(s.facets, s.patch, s.first, s.after, s.rank, s.used[0], count, s.stamp, s.clock)

    def living(self, on_crack: bool) -> np.ndarray:
        """Return the rows of the living facets that are crack, or of those that are not."""
        s, count = self.state, self.state.used[1]
        return np.flatnonzero(s.alive[:count] & (s.patch_crack[s.patch[:count]] == on_crack))

    def set_sizes(self, sizing) -> None:
        """Set the target lengths of all living vertices from the sizing."""
        living = np.flatnonzero(self.state.first[: self.state.used[0]] >= 0)
        self.state.size[living] = sizing.at(self.state.points[living])

    def repeat(self, name: str, kernel, count: int, *arguments) -> int:
        """Run a pass kernel up to item `count`, making room whenever it stops short; return its work."""
        start, total = 0, 0
        while True:
            references = by_reference(self.state), by_reference(self.grid)
            start, done = kernel(*references, *arguments[:-1], start, *arguments[-1])
            del references
            total += done
            if start >= count:
                break
            self.make_room()
        self.done[name] = self.done.get(name, 0) + total
        return total

    def make_room(self) -> None:
        """Drop the facets that are gone, refresh the grid and lengthen whatever is nearly full."""
        arrays = self.state._asdict()
        del self.state, self.grid
        drop_dead(arrays)
        m = int(arrays["used"][1])
        self.state = grown(arrays, max(1000, m // 4), max(4000, m // 2))
        self.grid = filled_grid(self.state)


def filled_grid(state: State) -> FacetGrid:
    """Return a grid of the living facets with room for changes; cells of some mean edges."""
    m = int(state.used[1])
    living = np.flatnonzero(state.alive[:m])
    if not len(living):
        raise CraftmeshError("the surface has no facets; expected at least one to gradate")
    start, end = state.points[state.facets[living, 0]], state.points[state.facets[living, 1]]
    edge = np.linalg.norm(end - start, axis=1)
    used = state.points[state.first >= 0]
    cell = max(CELL * float(edge.mean()), 1e-300)
    items = 6 * len(living) + 2 * ROOM_PER_STEP
    grid = make_grid(used, cell, items, len(state.facets))
    while not fill_grid(grid, state.points, state.facets, state.alive, m) or (
        grid.used[0] + 2 * ROOM_PER_STEP > len(grid.facet)
    ):
        items *= 2
        grid = make_grid(used, cell, items, len(state.facets))
    return grid


def collapse_short(gradation: Gradation, limits: Limits) -> int:
    """Collapse edges under limits.collapse of their target: junction lines first, short ones first."""
    total = 0
    edges, feature = gradation.edges()
    ratio = relative_lengths(gradation.state.points, gradation.state.size, edges)
    for lines in (True, False):
        chosen = np.flatnonzero((feature == lines) & (ratio < limits.collapse))
        order = chosen[block_order(edges[chosen], ratio[chosen])]
        name = "collapsed_junction_edges" if lines else "collapsed_regular_edges"
        total += gradation.repeat(name, collapse_pass, len(order), limits, edges, order, ())
    return total


def split_long(gradation: Gradation, limits: Limits, share: float) -> int:
    """Split edges over limits.split of their target, longest first by blocks."""
    edges, _ = gradation.edges()
    ratio = relative_lengths(gradation.state.points, gradation.state.size, edges)
    chosen = np.flatnonzero(ratio > limits.split)
    order = chosen[block_order(edges[chosen], -ratio[chosen])]
    return gradation.repeat("split_edges", split_pass, len(order), limits, edges, order, (share,))


def swap_all(gradation: Gradation, limits: Limits) -> int:
    """Swap edges inside patches until hardly any gains."""
    edges, feature = gradation.edges()
    edges = edges[~feature]
    return gradation.repeat("swapped_edges", swap_pass, len(edges), limits, edges, ())


def slide_all(gradation: Gradation, limits: Limits, goal: float) -> int:
    """Slide vertices of facets that score under `goal`."""
    s = gradation.state
    order = np.unique(s.facets[poor_facets(s.points, s.facets, s.alive, s.used[1], goal)])
    return gradation.repeat("slid_vertices", slide_pass, len(order), limits, order, (goal,))


def even_lines(gradation: Gradation, limits: Limits) -> int:
    """Even out the edges along junction lines and crack fronts."""
    s = gradation.state
    order = np.flatnonzero((s.first[: s.used[0]] >= 0) & (s.rank[: s.used[0]] == 1))
    return gradation.repeat("slid_line_vertices", even_lines_pass, len(order), limits, order, ())


def relax_all(gradation: Gradation, limits: Limits) -> int:
    """Move vertices inside patches to where their facets are more even."""
    order = np.flatnonzero(gradation.state.first[: gradation.state.used[0]] >= 0)
    return gradation.repeat("relaxed_vertices", relax_pass, len(order), limits, order, ())
