"""Crack facets of a split volume's surface moved onto the true crack, in their walls and box planes."""

from dataclasses import replace

import numpy as np
from scipy.sparse import csr_array

from craftmesh.cracks.near_sheet import NearSheet
from craftmesh.cracks.split_voxels import first_sheet
from craftmesh.insertion.cut import CutSurface
from craftmesh.insertion.guarded_move import forced, guarded_move
from craftmesh.insertion.options import InsertOptions
from craftmesh.surface.connectivity import unique_edges
from craftmesh.surface.measure import area_vectors, numbered
from craftmesh.surface.patches import held_by_box
from craftmesh.types import CRACK, Surface

RINGS = 3  # of points around that go along
# Of the way that is left, round after round, and whether points keep to their walls on it.
SHARES = ((1.0, True), (0.5, True), (1.0, True), (1.0, False), (0.5, False), (1.0, False))
LEAST_STEP = 1e-9  # of the local size
STEPS = 6  # of Newton towards the places on curved sheets
LEAST = 0.3  # singular value below which a wall lies along a sheet and does not hold the point
FARTHEST = 3.0  # times as far as the sheet is: a point held by walls goes no farther
WALLS = 3  # at a point, those with the largest area first


def onto_sheets(
    surface: CutSurface, looks: tuple[NearSheet, ...], options: InsertOptions
) -> tuple[CutSurface, np.ndarray, np.ndarray]:
    """Return the surface with the points of crack facets on their sheets, those left behind and their ways.

    Points around go along with them, within what holds them; all stays sound.
    """
    rows, on = points_of_sheets(surface, len(looks))
    for share, in_walls in SHARES:
        targets = places_on_sheets(surface, looks, rows, on, in_walls)
        surface = carried_along(surface, rows, share * (targets - surface.points[rows]), options)
    left = np.linalg.norm(targets - surface.points[rows], axis=1) > LEAST_STEP * surface.size[rows]
    surface, left = forced(surface, rows[left], targets[left], options)
    return surface, left, targets[np.searchsorted(rows, left)] - surface.points[left]


def carried_along(
    surface: CutSurface, rows: np.ndarray, steps: np.ndarray, options: InsertOptions
) -> CutSurface:
    """Return the surface with points `rows` moved by steps (k, 3), and those around along with them."""
    step = np.zeros_like(surface.points)
    step[rows] = steps
    carried = _carried(surface, rows, step)
    movers = np.flatnonzero(np.linalg.norm(carried, axis=1) > LEAST_STEP * surface.size)
    points, _ = guarded_move(surface, movers, surface.points[movers] + carried[movers], options)
    return replace(surface, points=points)


def _carried(surface: CutSurface, rows: np.ndarray, step: np.ndarray) -> np.ndarray:
    """Return steps (n, 3) where those of points `rows` carry the points around, less from ring to ring."""
    edges, _, _ = unique_edges(surface.facets)
    count = len(surface.points)
    ends = np.concatenate([edges, edges[:, ::-1]])
    mean = csr_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(count, count))
    number = np.maximum(mean.sum(axis=1), 1)[:, None]
    near = np.zeros(count, bool)
    near[rows] = True
    for _ in range(RINGS):
        near[edges[near[edges].any(axis=1)]] = True
    near[rows] = False
    others = np.flatnonzero(near)
    hold = _holding(surface, others)
    result = step.copy()
    for _ in range(2 * RINGS):
        drift = (mean @ result / number)[others]
        result[others] = np.einsum("kij,kj->ki", hold, drift)
    return result


def _holding(surface: CutSurface, rows: np.ndarray) -> np.ndarray:
    """Return what takes from steps of points `rows` all that leads off their walls and planes (k, 3, 3)."""
    box = held_by_box(plain(surface))[rows]
    normals = np.concatenate([_wall_normals(surface, rows), box[:, :, None] * np.eye(3)], axis=1)
    away = np.linalg.pinv(normals, rcond=LEAST) @ normals
    hold: np.ndarray = np.eye(3) - away
    return np.where(box[:, :, None], 0.0, hold)


def plain(surface: CutSurface) -> Surface:
    """Return the surface with all sheets' facets of kind CRACK."""
    return Surface(surface.points, surface.facets, surface.sides, np.minimum(surface.kind, CRACK))


def is_of(surface: CutSurface, number: int) -> np.ndarray:
    """Tell which facets (m,) are of the sheet `number`."""
    return bits_of(surface) >> number & 1 > 0


def bits_of(surface: CutSurface) -> np.ndarray:
    """Return the sheets (m,) of the facets as bits: kinds from CRACK on hold them, less 1."""
    return np.maximum(surface.kind.astype(np.int64) - CRACK + 1, 0)


def points_of_sheets(surface: CutSurface, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the points of crack facets (k,) and on which of `count` sheets they are (k, s)."""
    on = np.zeros((len(surface.points), count), bool)
    first = first_sheet(bits_of(surface))
    for number in range(count):
        on[surface.facets[first == number], number] = True
    rows = np.flatnonzero(on.any(axis=1))
    return rows, on[rows]


def places_on_sheets(
    surface: CutSurface, looks: tuple[NearSheet, ...], rows: np.ndarray, on: np.ndarray, in_walls: bool
) -> np.ndarray:
    """Return the places (k, 3) of points on their sheets (k, s), in box planes and, if asked, walls."""
    start = surface.points[rows]
    walls = in_walls * _wall_normals(surface, rows)
    box = held_by_box(plain(surface))[rows]
    place = start.copy()
    for _ in range(STEPS):
        normals, lacks = np.zeros((len(rows), len(looks), 3)), np.zeros((len(rows), len(looks)))
        for number, look in enumerate(looks):
            mine = on[:, number]
            if mine.any():
                near = look.look(place[mine])
                normals[mine, number], lacks[mine, number] = near.normal, -near.psi
        lacks_wall = np.einsum("kwi,ki->kw", walls, start - place)
        step = _solved(
            np.where(box[:, None], 0.0, normals), lacks, np.where(box[:, None], 0.0, walls), lacks_wall
        )
        place = place + np.where(box, 0.0, step)
    return place


def _solved(
    normals: np.ndarray, lacks: np.ndarray, walls: np.ndarray, lacks_wall: np.ndarray
) -> np.ndarray:
    """Return the least steps (k, 3) that close the sheets' lacks, within walls where these leave room."""
    matrix = np.concatenate([normals, walls], axis=1)
    step = np.einsum(
        "kij,kj->ki", np.linalg.pinv(matrix, rcond=LEAST), np.concatenate([lacks, lacks_wall], axis=1)
    )
    free = np.einsum("kij,kj->ki", np.linalg.pinv(normals, rcond=LEAST), lacks)
    off = np.abs(np.einsum("ksi,ki->ks", normals, step) - lacks).max(axis=1)
    need = np.abs(lacks).max(axis=1)
    bad = (off > 1e-6 * np.maximum(need, 1e-300)) | (np.linalg.norm(step, axis=1) > FARTHEST * need)
    return np.where(bad[:, None], free, step)


def _wall_normals(surface: CutSurface, rows: np.ndarray) -> np.ndarray:
    """Return unit normals (k, WALLS, 3) of the grain boundaries at points, 0 where there are fewer."""
    result = np.zeros((len(rows), WALLS, 3))
    place = np.full(len(surface.points), -1)
    place[rows] = np.arange(len(rows))
    is_wall = (surface.kind == 0) & (place[surface.facets] >= 0).any(axis=1)
    labels, sides = numbered(surface.sides[is_wall])
    facets = surface.facets[is_wall]
    turned = sides[:, 0] > sides[:, 1]
    vector = area_vectors(surface.points, facets) * np.where(turned, -1.0, 1.0)[:, None]
    pair = sides.max(axis=1) * len(labels) + sides.min(axis=1)
    at = place[facets].ravel()
    keep = at >= 0
    stride = int(pair.max(initial=0)) + 1
    key, index = np.unique(at[keep] * stride + np.repeat(pair, 3)[keep], return_inverse=True)
    total = np.zeros((len(key), 3))
    np.add.at(total, index, np.repeat(vector, 3, axis=0)[keep])
    size = np.linalg.norm(total, axis=1)
    owner = key // stride
    order = np.lexsort([-size, owner])
    rank = np.arange(len(order)) - np.searchsorted(owner[order], owner[order])
    chosen = order[rank < WALLS]
    result[owner[chosen], rank[rank < WALLS]] = total[chosen] / np.maximum(size[chosen], 1e-300)[:, None]
    return result
