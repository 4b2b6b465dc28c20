"""The crack's facets: triangles between front and traces, fine enough where the crack bends."""

from dataclasses import replace

import numpy as np
import scipy

from craftmesh.cracks.in_plane import triangulate, with_room
from craftmesh.insertion.cut import OFF, CutSurface, flat_facets
from craftmesh.insertion.front_chain import FrontChain
from craftmesh.insertion.sheet import Sheet
from craftmesh.surface.classification import Classification
from craftmesh.surface.connectivity import edge_sides, joined, rows_among, unique_edges
from craftmesh.surface.kernels import planar
from craftmesh.surface.kernels.planar import Candidates, Planar
from craftmesh.surface.kernels.triangle_pairs import intersecting_pairs
from craftmesh.surface.labels import labels_at
from craftmesh.surface.measure import area_vectors, meets_box, span_of
from craftmesh.surface.patches import patches
from craftmesh.types import Surface

PARTINGS = 8  # most passes of splitting crack facets that meet a grain boundary next to their trace
# Smallest distance of a new point from others: SPACING smallest target lengths, and APART times the longest
# edge of the point's facet.
SPACING, APART = 0.25, 0.2
# Smallest distance of a new point from others, in smallest target lengths, where crack facets meet a grain
# boundary.
TIGHTEST = 0.12
CLEAR = 0.5  # smallest distance of a new point from fixed edges, relative to that from other points
# Distance, relative to a facet's longest edge, within which its new point moves to a corner of the given
# crack. This saves rough cracks a third of their facets.
NEAR_CORNER = 0.35
PARTS = 4  # intervals per edge of the lattice on which a facet's distance from the crack is sampled


def with_patch(
    cut: CutSurface, sheet: Sheet, front: FrontChain, traces: np.ndarray, least: float
) -> tuple[CutSurface, np.ndarray, np.ndarray]:
    """Return the cut surface with the patch's points appended, the patch's triangles (t, 3), and a mask.

    The patch is the crack's triangulation inside the front. The mask (t, 3) is True at the triangles' fixed
    edges, which lie on front or traces. traces (k, 2): trace edges inside the front; least: smallest target
    length. Raise CraftmeshError if front and traces cannot be triangulated.
    """
    uv = np.concatenate([sheet.uv(cut.points), front.uv])
    points = np.concatenate([cut.points, sheet.lift(front.uv)])
    segments = np.unique(np.sort(np.concatenate([front.edges[:, :2], traces]), axis=1), axis=0)
    loose = np.flatnonzero((cut.psi == 0) & (cut.phi > 0))
    nodes = np.unique(np.concatenate([segments.ravel(), loose]))
    local = np.full(len(uv), -1)
    local[nodes] = np.arange(len(nodes))
    kept = local[cut.facets[flat_facets(cut)]]
    kept = kept[(kept >= 0).all(axis=1)]
    plane = triangulate(
        uv[nodes], local[segments], np.setdiff1d(local[loose], local[segments]), sheet.rim.inside
    )
    planar.legalise_all(plane)
    on_front = np.zeros((len(uv), 1), bool)
    on_front[front.edges[:, :2]] = True
    patch = _Patch(plane, sheet, points[nodes], least, kept)
    if sheet.planar:
        patch.split(on_front[nodes], 2)
    else:
        walls = _walls(cut, nodes, len(uv))
        for parting in range(PARTINGS + 1):
            if parting and not patch.part(cut.points[cut.facets], local[cut.facets]):
                break
            patch.refine_patch()
            patch.split(on_front[nodes], 2)
            patch.split(walls, 3)
    plane = patch.plane
    ids = np.concatenate([nodes, len(uv) + np.arange(plane.used[0] - len(nodes))])
    points = np.concatenate([points, patch.places[len(nodes) :]])
    return replace(cut, points=points), ids[plane.triangles], plane.fixed[: plane.used[1]]


class _Patch:
    """The crack's triangulation while points are added to it.

    plane: the triangulation in (u, v); sheet: the crack. known (n, 3): positions of its first points;
    least: smallest target length; kept (k, 3): triangles that must not change, by their points.
    """

    def __init__(
        self, plane: Planar, sheet: Sheet, known: np.ndarray, least: float, kept: np.ndarray
    ) -> None:
        self.plane, self.sheet, self.known, self.least, self.kept = plane, sheet, known, least, kept
        self.seen, self.off, self.at = np.zeros((0, 3), np.int64), np.zeros(0), np.zeros((0, 2))

    @property
    def places(self) -> np.ndarray:
        """Positions (n, 3) of the points in use."""
        added = self.plane.uv[len(self.known) : self.plane.used[0]]
        return np.concatenate([self.known, self.sheet.lift(added)])

    def split(self, walls: np.ndarray, corners: int) -> None:
        """Split edges (corners = 2) or triangles (3) whose corners all lie on one wall.

        walls (n, w): mask of points on each wall: the front, a grain boundary, a void or a box plane. An
        edge between two front points would be an ear, which cannot open (`surface/front`). A triangle in a
        box plane or grain boundary would coincide with it or cross it.
        """
        self.plane = with_room(self.plane, 3 * int(self.plane.used[1]))
        planar.split_within_walls(self.plane, walls, corners)

    def insert(self, candidates: Candidates) -> int:
        """Insert the candidates that keep their smallest distances from points and fixed edges.

        Return how many were inserted.
        """
        self.plane = with_room(self.plane, len(candidates.uv))
        return int(planar.insert_spaced(self.plane, candidates, self._is_kept(len(self.plane.corners))))

    def _is_kept(self, count: int) -> np.ndarray:
        """Return a mask (count,) of the triangles that must not change."""
        found = np.zeros(count, bool)
        if len(self.kept):
            found[: self.plane.used[1]] = rows_among(self.plane.triangles, self.kept) >= 0
        return found

    def refine_patch(self) -> None:
        """Insert points until no facet is farther than OFF from the crack, or facets become too small.

        A point goes where its facet is farthest from the crack, or to a corner of the given crack next to
        that place.
        """

        corners = scipy.spatial.cKDTree(self.sheet.nodes)
        while True:
            self._look()
            rows = np.flatnonzero(self.off > OFF * self.least)
            if not len(rows):
                return
            rows = rows[np.argsort(-self.off[rows], kind="stable")]
            triangles = self.plane.uv[self.plane.triangles[rows]]
            longest = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2).max(axis=1)
            away, corner = corners.query(self.at[rows])
            to_corner = (away < NEAR_CORNER * longest)[:, None]
            uv = np.where(to_corner, corners.data[corner], self.at[rows])
            room = np.maximum(SPACING * self.least, APART * longest)
            if not self.insert(Candidates(uv, rows, room, CLEAR * room)) and not self._divide(
                rows, SPACING * self.least
            ):
                return

    def _look(self) -> None:
        """Update self.off and self.at, the largest distance from the crack and its place, by triangle.

        Only changed triangles are sampled. self.at (n, 2) is the farthest one, in (u, v).
        Samples on fixed edges do not count.
        """
        triangles = self.plane.triangles
        known = len(self.seen)
        changed = np.append(
            (triangles[:known] != self.seen).any(axis=1), np.ones(len(triangles) - known, bool)
        )
        rows = np.flatnonzero(changed)
        share = (
            np.array([(i, j, PARTS - i - j) for i in range(PARTS) for j in range(PARTS - i + 1)]) / PARTS
        )
        share = share[share.max(axis=1) < 1]
        points = self.places
        samples = np.einsum("sk,tkd->tsd", share, points[triangles[rows]])
        off = np.abs(self.sheet.offset(samples.reshape(-1, 3))).reshape(-1, len(share))
        vectors = area_vectors(points, triangles[rows])
        cosine = vectors @ self.sheet.frame[2] / np.maximum(np.linalg.norm(vectors, axis=1), 1e-300)
        off *= np.abs(cosine)[:, None]
        for edge in range(3):
            off[np.ix_(self.plane.fixed[rows, edge], share[:, (edge + 2) % 3] == 0)] = 0.0
        self.off, self.at = np.resize(self.off, len(triangles)), np.resize(self.at, (len(triangles), 2))
        self.off[rows] = off.max(axis=1)
        self.at[rows] = np.einsum("tk,tkd->td", share[off.argmax(axis=1)], self.plane.uv[triangles[rows]])
        self.seen = triangles.copy()

    def part(self, corners: np.ndarray, points_of: np.ndarray) -> bool:
        """Insert points in triangles that intersect facets of the surface; return whether any was inserted.

        corners (m, 3, 3): of the surface's facets; points_of (m, 3): the patch's points there, or -1.
        """
        points, triangles = self.places, self.plane.triangles
        near = np.flatnonzero(meets_box(corners, span_of(points[triangles])))
        others = points_of[near].ravel()
        new = np.flatnonzero(others < 0)
        others[new] = len(points) + np.arange(len(new))
        points = np.concatenate([points, corners[near].reshape(-1, 3)[new]])
        pairs = intersecting_pairs(points, np.concatenate([triangles, others.reshape(-1, 3)]))
        rows = np.unique(pairs[(pairs[:, 0] < len(triangles)) & (pairs[:, 1] >= len(triangles)), 0])
        rows = rows[~self._is_kept(len(triangles))[rows]]
        return bool(len(rows)) and self._divide(rows, TIGHTEST * self.least) > 0

    def _divide(self, rows: np.ndarray, least: float) -> int:
        """Insert midpoints of the longest free edges of triangles `rows`; return how many were inserted.

        least: smallest distance from other points.
        """
        corner = self.plane.uv[self.plane.triangles[rows]]
        edge = np.roll(corner, -1, axis=1) - corner
        length = np.where(self.plane.fixed[rows], -1.0, np.linalg.norm(edge, axis=2))
        side = length.argmax(axis=1)
        row = np.arange(len(rows))
        free = length[row, side] > 0
        middle = (corner + edge / 2)[row, side][free]
        spacing = np.full(len(middle), least)
        return self.insert(Candidates(middle, rows[free], spacing, CLEAR * spacing))


def _walls(cut: CutSurface, nodes: np.ndarray, count: int) -> np.ndarray:
    """Return a mask (k, w) of nodes (k,) on each wall: a patch of a grain boundary, void or face.

    The last three columns are for planes of the box normal to x, y and z. count: number of points that node
    ids may refer to.
    """
    rows = np.flatnonzero((cut.psi[cut.facets] == 0).any(axis=1))
    near = Surface(cut.points, cut.facets[rows], cut.sides[rows], cut.kind[rows])
    patch = patches(near)
    on = np.zeros((count, len(patch.first_facet) + 3), bool)
    on[near.facets, patch.of_facet[:, None]] = True
    classes = Classification(near)
    on[: len(cut.points), -3:] = classes.held & ~classes.on_border[:, None]
    return on[nodes]


def labels_of_patch(
    points: np.ndarray, triangles: np.ndarray, fixed: np.ndarray, facets: np.ndarray, sides: np.ndarray
) -> np.ndarray:
    """Return the label (t,) of the grain or void in which each patch triangle (t, 3) lies.

    facets, sides (m, 2): the surface in which labels are looked up. A region consists of triangles
    connected across edges that are not in the mask `fixed` (t, 3). All its triangles get the label found at
    the centres of most of its area.
    """
    _, of_corner, count = unique_edges(triangles)
    a, b = edge_sides(of_corner, count > 1)
    free = ~fixed.ravel()[a]
    region = joined(len(triangles), a[free] // 3, b[free] // 3)
    found = labels_at(points[triangles].mean(axis=1), points, facets, sides)
    names, index = np.unique(found, return_inverse=True)
    area = np.zeros((int(region.max()) + 1, len(names)))
    np.add.at(area, (region, index), np.linalg.norm(area_vectors(points, triangles), axis=1))
    labels: np.ndarray = names[area.argmax(axis=1)][region]
    return labels
