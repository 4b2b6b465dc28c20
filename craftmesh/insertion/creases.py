"""The creases of a given crack: points of the patch go onto them, and they are its lines."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import shapely

from craftmesh.insertion.kernels.planar import Planar
from craftmesh.insertion.patch import add_lines
from craftmesh.insertion.rim import feet_on_segments
from craftmesh.insertion.sheet import Sheet
from craftmesh.surface.connectivity import beside_edges, edge_sides, facet_edges, unique_edges
from craftmesh.surface.measure import area_vectors

SHARP = np.radians(2.5)  # edges at which the crack turns by less are no creases
ALONE = 3.0  # a kink turns by this many times what the edges beside it do; chosen by hand


class Creases(NamedTuple):
    """Creases as segments (k, 2, 2) in (u, v), their ends (k, 2, 3) on the crack, and a tree of them."""

    segments: np.ndarray
    ends: np.ndarray
    tree: shapely.STRtree

    def near(self, uv: np.ndarray, reach: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return rows of places (n, 2) and of creases nearer than reach (n,), one pair after another."""
        place, crease = self.tree.query(shapely.points(uv), "dwithin", reach)
        return place, crease

    def feet(self, uv: np.ndarray) -> np.ndarray:
        """Return the nearest places (n, 2) on a crease; far away where there is none."""
        if not len(self.segments) or not len(uv):
            return np.full(uv.shape, np.inf)
        return feet_on_segments(self.segments, self.tree, uv)[1]

    def distance(self, uv: np.ndarray) -> np.ndarray:
        """Return how far places (n, 2) are from the nearest crease, infinitely where there is none."""
        away: np.ndarray = np.linalg.norm(self.feet(uv) - uv, axis=1)
        return away


def creases_of(sheet: Sheet, apart: float | None = None, turn_by: float = SHARP) -> Creases:
    """Return the edges at which the triangles of a sheet turn by more than `turn_by` radians.

    apart: only kinks, at which they turn ALONE times as much as at the edges beside, and edges whose
    triangles are at least this high over them; the fine triangles of a curved crack turn everywhere.
    """
    points = np.column_stack([sheet.nodes, sheet.height])
    vectors = area_vectors(points, sheet.triangles)
    size = np.maximum(np.linalg.norm(vectors, axis=1), 1e-300)
    edges, of_corner, count = unique_edges(sheet.triangles)
    inner = np.flatnonzero(count == 2)
    f, g = edge_sides(of_corner, count == 2)
    turn = np.zeros(len(edges))
    cosine = np.einsum("ij,ij->i", vectors[f // 3], vectors[g // 3]) / (size[f // 3] * size[g // 3])
    turn[inner] = np.arccos(np.clip(cosine, -1, 1))
    chosen = turn > turn_by
    if apart is not None:
        beside = np.concatenate([beside_edges(turn[of_corner], side) for side in (f, g)], axis=1).max(
            axis=1
        )
        length = np.linalg.norm(np.diff(points[edges[inner]], axis=1)[:, 0], axis=1)
        height = 2 * np.minimum(size[f // 3], size[g // 3]) / length
        chosen[inner] &= (turn[inner] > ALONE * beside) | (height > apart)
    segments = sheet.nodes[edges[chosen]]
    ends = sheet.origin + points[edges[chosen]] @ sheet.frame
    return Creases(segments, ends, shapely.STRtree(shapely.linestrings(segments)))


# Wished lengths: shorter kinks are roughness, which facets follow by the corners of the given crack.
LONG = 3.0
BEND = 0.1  # of the wished length: so are kinks that leave the chords between their points by more
STEP = 0.1  # of the wished length, between the places at which a kink is looked at
CLEAR = 0.2  # of the wished length: how far the points of kinks stay off front and traces
# Of the least wished length of all: points of traces this near a kink are on it, and kinks this near front
# or traces are not joined past them.
NARROW = 0.05
JOINED = 1.5  # wished lengths: points of one kink that are farther apart are not joined

BENT = np.radians(6.5)  # an edge of the least length across a sharper kink would be 0.028 of it off

SizeInPlane = Callable[[np.ndarray], np.ndarray]


def lay_kinks(
    patch: Planar, kinks: Creases, size_at: SizeInPlane, least: float
) -> tuple[Planar, np.ndarray]:
    """Return the patch with points along the kinks, and the edges (k, 2) that join them, fixed.

    size_at(uv): the wished lengths, least: the least of all. New points keep clear of front and traces;
    points of these that lie almost on a kink are joined with its own. Points that knew nothing of a kink
    came to lie beside it on both sides.
    """
    laid = [np.zeros((0, 2), np.int64)]
    for line in _lines(kinks, size_at):
        walls = _Walls.of(patch)
        arc = _stops(line, walls, size_at)
        if not len(arc):
            continue
        uv = shapely.get_coordinates(shapely.line_interpolate_point(line, arc))
        old, old_arc = walls.on(line, NARROW * least)
        points = np.concatenate([walls.uv, uv])
        arc = np.concatenate([arc, old_arc])
        order = np.argsort(arc, kind="stable")
        row = np.concatenate([len(walls.uv) + np.arange(len(uv)), old])[order]
        arc = arc[order]
        if line.is_ring:
            row, arc = np.append(row, row[0]), np.append(arc, arc[0] + line.length)
        pairs = np.stack([row[:-1], row[1:]], axis=1)
        near = np.diff(arc) < JOINED * size_at(points[pairs].mean(axis=1))
        pairs = pairs[near & walls.let_through(points, pairs, NARROW * least)]
        patch, made = add_lines(patch, uv, pairs)
        laid.append(made)
    return patch, np.concatenate(laid)


def _lines(kinks: Creases, size_at: SizeInPlane) -> list[shapely.LineString]:
    """Return the kinks as lines, the longest first, without those shorter than LONG."""
    lines = shapely.get_parts(
        shapely.line_merge(shapely.multilinestrings(shapely.linestrings(kinks.segments)))
    )
    if not len(lines):
        return []
    length = shapely.length(lines)
    middle = shapely.get_coordinates(shapely.line_interpolate_point(lines, 0.5, normalized=True))
    lines, length = (x[length > LONG * size_at(middle)] for x in (lines, length))
    return list(lines[np.argsort(-length, kind="stable")])


def _stops(line: shapely.LineString, walls: "_Walls", size_at: SizeInPlane) -> np.ndarray:
    """Return the arc lengths (k,) of new points: even in wished lengths where a kink is clear of walls.

    There are none on stretches that leave the chords between their points.
    """
    least = float(size_at(shapely.get_coordinates(line)).min())
    steps = np.linspace(0, line.length, 1 + int(np.ceil(line.length / (STEP * least))))
    places = shapely.line_interpolate_point(line, steps)
    uv = shapely.get_coordinates(places)
    size = size_at(uv)
    clear = walls.are_clear_of(places, CLEAR * size)
    ends = np.flatnonzero(np.diff(np.concatenate([[False], clear, [False]]).astype(int))).reshape(-1, 2)
    stops = [np.zeros(0)]
    for start, end in ends:
        run, wishes = steps[start:end], 1 / size[start:end]
        total = np.concatenate([[0.0], np.cumsum((wishes[1:] + wishes[:-1]) / 2 * np.diff(run))])
        inner = total[-1]
        count = max(int(round(inner)), 0)
        shares = np.linspace(0, total[-1], count + 1) if count else total[-1:] / 2
        found = np.interp(shares, total, run)
        chords = np.stack(
            [np.interp(run, found, np.interp(found, run, x)) for x in uv[start:end].T], axis=1
        )
        within = (run >= found[0]) & (run <= found[-1])
        off = np.linalg.norm(chords - uv[start:end], axis=1)
        if (off <= BEND * size[start:end])[within].all():
            stops.append(found)
    arc = np.concatenate(stops)
    is_twice = line.is_ring and len(arc) > 1 and arc[0] == 0 and arc[-1] == line.length
    return arc[:-1] if is_twice else arc


class _Walls(NamedTuple):
    """What lines in a patch keep off: its fixed edges and loose points.

    uv (n, 2): the patch's points; ends (k, 2): the ends of the walls, twice the same for a loose point;
    tree of the walls, cells: a tree of the triangles.
    """

    uv: np.ndarray
    ends: np.ndarray
    tree: shapely.STRtree
    cells: shapely.STRtree

    @classmethod
    def of(cls, patch: Planar) -> "_Walls":
        uv, triangles = patch.uv[: patch.used[0]], patch.triangles
        edges = facet_edges(triangles)[patch.fixed[: len(triangles)].ravel()]
        edges = np.unique(np.sort(edges, axis=1), axis=0)
        loose = np.setdiff1d(triangles, edges)
        walls = np.concatenate([shapely.linestrings(uv[edges]), shapely.points(uv[loose])])
        ends = np.concatenate([edges, np.stack([loose, loose], axis=1)])
        return cls(uv, ends, shapely.STRtree(walls), shapely.STRtree(shapely.polygons(uv[triangles])))

    def on(self, line: shapely.LineString, reach: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the points (k,) of walls that are on a line, and their arc lengths (k,) along it."""
        rows = np.unique(self.ends)
        points = shapely.points(self.uv[rows])
        near = shapely.distance(line, points) < reach
        return rows[near], shapely.line_locate_point(line, points[near])

    def are_clear_of(self, places: np.ndarray, apart: np.ndarray) -> np.ndarray:
        """Tell which places (n,) in the patch are farther than `apart` (n,) from every wall."""
        distance = self.tree.query_nearest(places, return_distance=True, all_matches=False)[1]
        return self._hold(places) & (distance > apart)

    def let_through(self, points: np.ndarray, pairs: np.ndarray, apart: float) -> np.ndarray:
        """Tell which segments between points (n, 2), as pairs (k, 2), are in the patch and clear of walls.

        That is by `apart`. They may end at a wall, but are none themselves.
        """
        free = self._hold(shapely.points(points[pairs].mean(axis=1)))
        row, wall = self.tree.query(shapely.linestrings(points[pairs]), "dwithin", apart)
        same = self.ends[wall][:, :, None] == pairs[row][:, None, :]
        met = ~same.any(axis=(1, 2)) | same.any(axis=1).all(axis=1)
        free[row[met]] = False
        return free

    def _hold(self, places: np.ndarray) -> np.ndarray:
        """Tell which places (n,) are in the patch."""
        inside = np.zeros(len(places), bool)
        inside[self.cells.query(places, "intersects")[0]] = True
        return inside
