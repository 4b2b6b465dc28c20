"""Shorter edges where a crack comes near to a box face or to another crack surface without meeting it.

The longer the edges are relative to such a gap, the flatter are the tetrahedra in it.
"""

import numpy as np
import scipy

from craftmesh.cracks.crack_tolerances import PROMISED
from craftmesh.cracks.near_faces import Face, cuts, in_plane, kink_edges
from craftmesh.cracks.near_sheet import NearSheet
from craftmesh.cracks.sheets import sheets
from craftmesh.sizing.length_field import LengthField
from craftmesh.sizing.sizing import PER_WIDTH, Sizing, densify, where_short
from craftmesh.surface.facet_subdivision import bisected
from craftmesh.surface.measure import unit_normals
from craftmesh.surface.rounding import ROUNDING
from craftmesh.types import BOX_FACES, Crack

# PER_WIDTH_IN_WEDGE: edge length, in widths of the gap, between a front and another surface, and along
# lines where the crack's angle to the face has a sine below STEEP. With over 11 widths, tets there are
# flat.
PER_WIDTH_IN_WEDGE, STEEP = 6.0, 0.34
# Shortest edges, in l_min: between an area and a face, between a line and a face, and between surfaces.
SHORTEST, SHORTEST_BESIDE_LINES, SHORTEST_IN_GAPS = 0.5, 0.12, 0.1
# A straight crack that meets a face at some place rises from it by the distance from that place times the
# sine of its tilt. If its distance from the face is between these multiples of that height, the crack leads
# to the place. It then forms a wedge with the face, in which shorter edges do not make tets less flat.
IN_WEDGE = (0.35, 1.5)
# Largest ratio of a gap's width to the distance from where the front meets the other surface; with a larger
# ratio, front and surface form a corner of over 14 degrees.
IN_CORNER = 0.25
STEP = 0.2  # spacing of places along lines, in l_min

Lengths = tuple[np.ndarray, np.ndarray]  # places (k, 3) and target edge lengths (k,) there


def clearance_lengths(crack: Crack, box: np.ndarray, sizing: Sizing) -> LengthField | None:
    """Return lengths where a crack is near faces of the box (2, 3), or its surfaces near each other.

    Return None if nowhere. At centres of its triangles and along fronts, kinks and mouths the length is
    PER_WIDTH times the distance to each face (PER_WIDTH_IN_WEDGE times at small angles), unless the crack
    leads to that face. Along fronts it is PER_WIDTH_IN_WEDGE times the distance to other surfaces. Lengths
    have the lower limits SHORTEST, SHORTEST_BESIDE_LINES and SHORTEST_IN_GAPS.
    """
    box, parts = np.asarray(box, float), sheets(crack)
    kinks, fronts = kink_edges(crack), [crack.points[front] for front in crack.fronts]
    found = [_to_face(crack, list(kinks), fronts, box, face, sizing) for face in BOX_FACES]
    found += [
        _to_sheet(own, other, box, sizing.l_min) for own in parts for other in parts if own is not other
    ]
    places, lengths = (np.concatenate(columns) for columns in zip(*found))
    return where_short(places, lengths, sizing)


def _to_face(
    crack: Crack,
    kinks: list[np.ndarray],
    fronts: list[np.ndarray],
    box: np.ndarray,
    face: Face,
    sizing: Sizing,
) -> Lengths:
    """Return places on the crack's triangles and lines, and lengths there by their distances to a face."""
    axis, upper = face
    slab = box.copy()
    slab[1 - upper, axis] = box[upper, axis] + (1 - 2 * upper) * sizing.l_max / PER_WIDTH
    corners = bisected(crack.points[crack.triangles], slab, sizing.l_min)
    if not len(corners):
        return np.zeros((0, 3)), np.zeros(0)
    centres, steep = corners.mean(axis=1), _steepness(corners, axis)
    mouths = [mouth for other in BOX_FACES if other[0] != axis for mouth in cuts(corners, box, other)]
    lines = [*fronts, *mouths]
    at_kinks, at_lines = _along(kinks, sizing.l_min), _along(lines, sizing.l_min)
    met = np.concatenate([cuts(corners, box, face).reshape(-1, 3), _crossings(lines, box, face)])
    beside = steep[scipy.spatial.cKDTree(centres).query(at_lines)[1]]
    per = np.where(beside < STEEP, PER_WIDTH_IN_WEDGE, PER_WIDTH)
    upright = np.ones(len(at_kinks))  # the crack leaves a kink to both sides, so its tilt there is steep
    # distances over areas are measured at centres up to l_min apart
    found = (
        (_face_distances(centres, steep, met, box, face, sizing.l_min), PER_WIDTH, SHORTEST),
        (
            _face_distances(at_kinks, upright, _crossings(kinks, box, face), box, face, 0.0),
            PER_WIDTH,
            SHORTEST_BESIDE_LINES,
        ),
        (_face_distances(at_lines, beside, met, box, face, 0.0), per, SHORTEST_BESIDE_LINES),
    )
    places = np.concatenate([centres, at_kinks, at_lines])
    lengths = [np.maximum(per * width, least * sizing.l_min) for width, per, least in found]
    short = np.flatnonzero(np.isfinite(np.concatenate(lengths)))
    return places[short], np.concatenate(lengths)[short]


def _face_distances(
    places: np.ndarray, tilt: np.ndarray, met: np.ndarray, box: np.ndarray, face: Face, slack: float
) -> np.ndarray:
    """Return distances (k,) of places (k, 3) from a box face, inf where the crack leads to that face.

    There (see IN_WEDGE) crack and face form a wedge, which shorter edges do not improve. Distances are also
    inf outside the box and on the face. tilt (k,): sines of the crack's angles to the face; met (n, 3):
    places where the crack is on the face. slack: largest distance of points from the place that stands for
    them; their distances from the face differ by up to this.
    """
    axis, upper = face
    width, rounding = np.abs(places[:, axis] - box[upper, axis]), ROUNDING * np.ptp(box)
    apart = ((places >= box[0] - rounding) & (places <= box[1] + rounding)).all(axis=1) & (width > rounding)
    met = np.concatenate([met, places[width <= rounding]])
    if len(met) and len(places):
        straight = tilt * scipy.spatial.cKDTree(met).query(places)[0]
        apart &= (width + slack < IN_WEDGE[0] * straight) | (width > IN_WEDGE[1] * straight)
    return np.where(apart, width, np.inf)


def _to_sheet(own: Crack, other: Crack, box: np.ndarray, l_min: float) -> Lengths:
    """Return places on fronts of `own` less than l_min from `other`, and target edge lengths there.

    The lengths are proportional to the distance, with a lower bound. Places near points where the front
    meets `other` are left out. own, other: surfaces of one crack; l_min: the sizing's target length.
    """
    at = _along([own.points[front] for front in own.fronts], l_min)
    at = at[((at >= box[0]) & (at <= box[1])).all(axis=1)]
    if not len(at):
        return np.zeros((0, 3)), np.zeros(0)
    near = NearSheet(other, box).look(at)
    width, side = np.linalg.norm(near.foot - at, axis=1), np.sign(near.psi)
    crosses = np.append((side[1:] != side[:-1]) & (width[1:] < l_min) & (near.phi[1:] > 0), False)
    clear, met = width < l_min, at[crosses | (width <= PROMISED.front * l_min)]
    if len(met):
        clear &= width < IN_CORNER * scipy.spatial.cKDTree(met).query(at)[0]
    return at[clear], np.maximum(PER_WIDTH_IN_WEDGE * width, SHORTEST_IN_GAPS * l_min)[clear]


def _along(lines: list[np.ndarray], l_min: float) -> np.ndarray:
    """Return places (k, 3) along lines (n, 3), at most STEP l_min apart."""
    return np.concatenate([np.zeros((0, 3)), *(densify(line, STEP * l_min) for line in lines)])


def _crossings(lines: list[np.ndarray], box: np.ndarray, face: Face) -> np.ndarray:
    """Return places (k, 3) where lines (n, 3) cross the plane of a box face."""
    found = [in_plane(line[:-1], line[1:], box, face) for line in lines]
    places = np.concatenate([np.zeros((0, 3)), *found])
    return places[np.isfinite(places).all(axis=1)]


def _steepness(corners: np.ndarray, axis: int) -> np.ndarray:
    """Return sines (k,) of the angles between triangles (k, 3, 3) and the box faces normal to an axis."""
    across = unit_normals(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
    return np.sqrt(np.maximum(1 - across[:, axis] ** 2, 0.0))
