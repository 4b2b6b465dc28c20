"""When two nodes of the surface may become one: grains, crack and front stay what and where they are.

What is asked of the tetrahedra round the node after the change is what makes a mesh of several bodies
sound: each grain fills one cone at the node and one sector at each of its edges, and has no hole there.
"""

from collections import Counter
from collections.abc import Iterable
from itertools import combinations

import numpy as np

from craftmesh.tetrahedra.stars import BOX_PLANES, Corners, Stars, renamed

Cells = dict[int, Corners]


def keeps_topology(stars: Stars, kept: int, gone: int) -> bool:
    """Tell whether the tets and facets round both nodes are those of sound bodies after merging them."""
    tets = merged(stars.tets, stars.tets_at, kept, gone)
    facets = merged(stars.facets, stars.facets_at, kept, gone)
    if len(set(map(frozenset, tets.values()))) < len(tets):
        return False
    if len(set(map(frozenset, facets.values()))) < len(facets):
        return False
    return _keeps_front(stars, facets, kept, gone) and _keeps_bodies(stars, tets, facets, kept, gone)


def merged(cells: Cells, at: dict[int, set[int]], kept: int, gone: int) -> Cells:
    """Return the cells that would lie round `kept` if `gone` became it."""
    return {cell: renamed(cells[cell], gone, kept) for cell in sorted(at[kept] ^ at[gone])}


def _round(stars: Stars, node: int) -> tuple[Cells, Cells]:
    tets = {t: stars.tets[t] for t in sorted(stars.tets_at[node])}
    return tets, {f: stars.facets[f] for f in sorted(stars.facets_at[node])}


def _keeps_bodies(stars: Stars, tets: Cells, facets: Cells, kept: int, gone: int) -> bool:
    """Tell whether every grain has one cone at the node, one sector at its edges, and no hole there."""
    allowed = [_Bodies(stars, *_round(stars, node), node) for node in (kept, gone)]
    after = _Bodies(stars, tets, facets, kept)
    whole = {int(stars.grain[t]) for node in (kept, gone) for t in stars.tets_at[node]}
    for grain in whole:
        if after.cones[grain] > max(one.cones[grain] for one in allowed):
            return False
        if after.cones[grain] and after.euler(grain) != (1 if after.is_bounded(grain) else 2):
            return False
    for (grain, node), sectors in after.sectors.items():
        if sectors > max(one.sectors[grain, node] for one in allowed):
            return False
    on_surface = any(stars.classes.free[f] for f in facets)
    return after.euler(None) == (1 if on_surface else 2)


class _Bodies:
    """The tets round a node by grain: cones, and sectors at each edge, parted by the crack; their link."""

    def __init__(self, stars: Stars, tets: Cells, facets: Cells, node: int):
        self.grain = {t: int(stars.grain[t]) for t in tets}
        shut = {frozenset(facets[f]) for f in facets if stars.classes.crack[f]}
        self.faces: dict[frozenset, list[int]] = {}
        self.edges: dict[int, list[int]] = {}
        for t, corners in tets.items():
            others = [other for other in corners if other != node]
            for pair in combinations(others, 2):
                self.faces.setdefault(frozenset((node, *pair)), []).append(t)
            for other in others:
                self.edges.setdefault(other, []).append(t)
        open_faces = {face: at for face, at in self.faces.items() if face not in shut}
        self.cones = Counter(self.grain[part[0]] for part in self._parts(tets, open_faces.values()))
        self.sectors: Counter = Counter()
        for other, fan in self.edges.items():
            here = [at for face, at in open_faces.items() if other in face]
            self.sectors.update((self.grain[part[0]], other) for part in self._parts(fan, here))

    def _parts(self, tets: Iterable[int], faces: Iterable[list[int]]) -> list[list[int]]:
        """Return the tets in groups that hang together through faces within one grain."""
        group = {t: [t] for t in tets}
        for at in faces:
            if len(at) == 2 and self.grain[at[0]] == self.grain[at[1]] and group[at[0]] is not group[at[1]]:
                joined = group[at[0]] + group[at[1]]
                group |= dict.fromkeys(joined, joined)
        return list({id(part): part for part in group.values()}.values())

    def is_bounded(self, grain: int) -> bool:
        """Tell whether the grain ends at the node."""
        return any(sum(self.grain[t] == grain for t in at) == 1 for at in self.faces.values())

    def euler(self, grain: int | None) -> int:
        """Return Euler's number of what the tets of a grain, or all, cut out of a small sphere."""

        def count(cells: Iterable[list[int]]) -> int:
            return sum(grain is None or any(self.grain[t] == grain for t in at) for at in cells)

        triangles = sum(grain is None or own == grain for own in self.grain.values())
        return count(self.edges.values()) - count(self.faces.values()) + triangles


def _keeps_front(stars: Stars, after: Cells, kept: int, gone: int) -> bool:
    """Tell whether the crack has the same front after the merge, and can open everywhere."""
    before = _round(stars, kept)[1] | _round(stars, gone)[1]
    classes = stars.classes
    wanted = {renamed(edge, gone, kept) for edge in _front(stars, before, {kept, gone})}
    wanted = {tuple(sorted(edge)) for edge in wanted if len(set(edge)) == 2}
    found = _front(stars, after, {kept})
    if {edge for edge in wanted if kept in edge} != found:
        return False
    on_front = {node for edge in found for node in edge}
    known = _edges(before, classes.crack)
    for edge, times in _edges(after, classes.crack).items():
        if times > 2:
            return False
        ends = [node in on_front or _is_front(stars, node) for node in edge]
        if kept in edge and times == 2 and all(ends) and edge not in known:
            return False
    crack = [corners for f, corners in after.items() if classes.crack[f]]
    return not any(all(_is_front(stars, node) for node in corners) for corners in crack)


def _is_front(stars: Stars, node: int) -> bool:
    return node < len(stars.classes.held) and bool(stars.classes.held[node, -1])


def _edges(facets: Cells, chosen: np.ndarray) -> Counter:
    """Return how many of the `chosen` (m,) facets lie on each edge."""
    corners = (corners for f, corners in facets.items() if chosen[f])
    return Counter(tuple(sorted(pair)) for three in corners for pair in combinations(three, 2))


def _front(stars: Stars, facets: Cells, nodes: set[int]) -> set[tuple[int, int]]:
    """Return the front edges at the nodes, of whose facets none is left out."""
    free = _edges(facets, stars.classes.free)
    once = {edge for edge, times in _edges(facets, stars.classes.crack).items() if times == 1}
    return {edge for edge in once if edge not in free and not nodes.isdisjoint(edge)}


def may_merge(stars: Stars, kept: int, gone: int) -> bool:
    """Tell whether `kept` is held by all that holds `gone`, a point off the front and of no higher rank.

    Of points that touch (`stars.touch`) the planes of the box alone have to be the same.
    """
    held, rank = stars.classes.held, stars.classes.rank
    missing = held[gone] & ~held[kept]
    if rank[gone] > rank[kept] or missing[:BOX_PLANES].any():
        return False
    return not (held[gone, -1] or missing.any()) or stars.touch(kept, gone)
