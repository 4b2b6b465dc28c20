"""Trace edges that leave a curved crack are split, the new points moved onto it in their boundary."""

import numpy as np

from craftmesh.insertion.cut import OFF, SHORTEST, CutSurface, split_edges
from craftmesh.insertion.front_chain import crossing_at
from craftmesh.insertion.guarded_move import settled
from craftmesh.insertion.options import InsertOptions
from craftmesh.insertion.sheet import Sheet
from craftmesh.surface.connectivity import edge_sides, unique_edges
from craftmesh.surface.measure import unit_normals
from craftmesh.surface.patches import is_on_box, patches
from craftmesh.types import Surface

SAMPLES = np.arange(1, 8) / 8  # of an edge's length, where its offset from a curved crack is looked at
# Of the least length: trace edges farther than OFF off the crack are split, and those on a face of the box
# that are farther than this beside the crack's mouth: at small angles to a face OFF is far beside it.
BESIDE = 0.04
FARTHEST = 0.3  # of an edge's length: its new point moves onto the crack by at most this much
FARTHEST_ON_BOX = 1.0  # the same in a face of the box, which cannot move to it: kinks of mouths are sharp
CONTACT = 0.1  # of the least length: nearer than this, a boundary along the crack is moved onto it
GRAZING = 0.25  # of the way within the boundary: where the crack is nearer than this, the two graze


def follow_traces(surface: CutSurface, sheet: Sheet, least: float, options: InsertOptions) -> CutSurface:
    """Split the trace edges that are too far off the crack where they are farthest, the new points on it.

    These move within their boundary. Where one cannot soundly, or its new trace edges would cross others,
    the edge is given back and not split again. least: the least target length.
    """
    refused = np.zeros((0, 2), np.int64)
    while True:
        edges, share, targets = _too_far_off(surface, sheet, least)
        stride = np.array([len(surface.points) + 1, 1])
        wanted = ~np.isin(edges @ stride, refused @ stride)
        edges, share, targets = edges[wanted], share[wanted], targets[wanted]
        if not len(edges):
            return surface
        start, end = surface.points[edges].transpose(1, 0, 2)
        places, size = start + share[:, None] * (end - start), surface.size[edges].mean(axis=1)
        rows = len(surface.points) + np.arange(len(edges))
        split, left = settled(split_edges(surface, edges, places, size), rows, targets, options)
        stuck = np.isin(rows, left) | np.isin(rows, crossing_at(split, sheet, rows))
        refused = np.concatenate([refused, edges[stuck]])
        if not stuck.any():
            surface = split


def _too_far_off(
    surface: CutSurface, sheet: Sheet, least: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the trace edges (k, 2) to be split, where along them (k,), and places (k, 3) on the crack."""
    edges, normals, held = _edges_in_walls(surface)
    start, step = surface.points[edges[:, 0]], np.diff(surface.points[edges], axis=1)[:, 0]
    length = np.linalg.norm(step, axis=1)
    long = np.flatnonzero(length > 2 * SHORTEST * least)
    edges, normals, start, step, length = (x[long] for x in (edges, normals, start, step, length))
    held = held[long]
    places = (start[:, None] + SAMPLES[None, :, None] * step[:, None]).reshape(-1, 3)
    normals = np.repeat(normals, len(SAMPLES), axis=0)
    off, beside = (x.reshape(-1, len(SAMPLES)) for x in _distances(sheet, places, normals))
    times = np.maximum(off / OFF, np.where(held[:, None], beside / BESIDE, 0.0)) / least
    far = np.flatnonzero(times.max(axis=1) > 1)
    least_share = SHORTEST * least / length[far]
    share = np.clip(SAMPLES[times[far].argmax(axis=1)], least_share, 1 - least_share)
    place = start[far] + share[:, None] * step[far]
    across = np.cross(normals[:: len(SAMPLES)][far], step[far])
    reach = np.where(held, FARTHEST_ON_BOX, FARTHEST)[far] * length[far]
    across *= (reach / np.maximum(np.linalg.norm(across, axis=1), 1e-300))[:, None]
    targets = sheet.nearest_crossing(place, across)
    ahead = sheet.gradient(place)
    ahead *= CONTACT * least / np.linalg.norm(ahead, axis=1)[:, None]
    straight = sheet.nearest_crossing(place, ahead)
    way, shorter = (np.linalg.norm(target - place, axis=1) for target in (targets, straight))
    with np.errstate(invalid="ignore"):
        grazing = ~held[far] & np.isfinite(shorter) & ~(GRAZING * way < shorter)
    targets[grazing] = straight[grazing]
    found = np.isfinite(targets).all(axis=1)
    return edges[far[found]], share[found], targets[found]


def _distances(sheet: Sheet, places: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return how far places (n, 3) are off the crack (n,), and how far in walls of these normals (n, 3)."""
    psi, gradient = np.abs(sheet.offset(places)), sheet.gradient(places)
    normals = normals / np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    in_wall = gradient - np.einsum("ij,ij->i", gradient, normals)[:, None] * normals
    return psi / np.linalg.norm(gradient, axis=1), psi / np.maximum(np.linalg.norm(in_wall, axis=1), 1e-300)


def _edges_in_walls(surface: CutSurface) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the trace edges (k, 2) with an end inside the front in one boundary, box plane or triple line.

    And the boundary's normal (k, 3) there, zero for triple lines, which move straight onto the crack alone,
    and whether a facet at the edge is in a box plane (k,).
    """
    on = surface.psi == 0
    rows = np.flatnonzero(on[surface.facets].sum(axis=1) >= 2)
    near = Surface(surface.points, surface.facets[rows], surface.sides[rows], surface.kind[rows])
    edges, of_corner, count = unique_edges(near.facets)
    patch = patches(near).of_facet
    shared = count > 1
    first, second = (side // 3 for side in edge_sides(of_corner, shared))
    held = np.zeros(len(edges), bool)
    held[of_corner[is_on_box(near.kind)]] = True
    edges, count, held = edges[shared], count[shared], held[shared]
    normal = unit_normals(near.points, near.facets)
    cosine = np.einsum("ij,ij->i", normal[first], normal[second])
    normal = normal[first] + np.sign(cosine)[:, None] * normal[second]
    normal[count > 2] = 0.0
    with np.errstate(invalid="ignore"):
        phi = surface.phi[edges]
        inside = (phi > 0).any(axis=1) | (phi >= 0).all(axis=1)
    chosen = ((count > 2) | (patch[first] == patch[second])) & on[edges].all(axis=1) & inside
    return edges[chosen], normal[chosen], held[chosen]
