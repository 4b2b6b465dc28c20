"""Whether a crack cuts a body of voxels in two: the voxels' links that it crosses, and the pieces left."""

from typing import NamedTuple

import numpy as np

from craftmesh.cracks.polyline import AT_ONCE
from craftmesh.surface.connectivity import joined
from craftmesh.types import Crack, Voxels

# Voxels' centres are looked at a little aside, in voxels: a sheet that runs through the centres themselves
# then lies on one side of all of them. Rounding is a million times less.
ASIDE = np.array([1.0, 1.3, 1.7]) * 1e-6
# A piece of fewer voxels is the staircase of a void's or a face's voxels beside the crack, not the body's.
LEAST = 27


class PieceOff(NamedTuple):
    """A piece that a crack cuts off: its volume and the middle (3,) of its voxels, in model units."""

    volume: float
    middle: np.ndarray


def piece_cut_off(voxels: Voxels, crack: Crack) -> PieceOff | None:
    """Return the smaller piece of a body that the crack severs, None where the body holds together.

    Voxels of grains that share a face are linked, unless the crack crosses the line between their centres:
    a ligament narrower than a voxel does not hold. Of several pieces the second largest is returned.
    """
    solid = voxels.labels > 0
    links = _links(solid)
    whole = _pieces(solid, links)
    parts = _pieces(solid, [held & ~cut for held, cut in zip(links, _crossed(voxels, crack))])
    part, first, count = np.unique(parts[solid], return_index=True, return_counts=True)
    body = whole[solid][first]
    order = np.lexsort((part, -count, body))
    others = order[1:][np.diff(body[order]) == 0]  # all but the largest part of each body
    if not len(others) or count[others].max() < LEAST:
        return None
    largest = others[count[others].argmax()]
    size, piece = int(count[largest]), part[largest]
    middle = voxels.origin + (np.argwhere(solid & (parts == piece)).mean(axis=0) + 0.5) * voxels.spacing
    return PieceOff(size * float(np.prod(voxels.spacing)), middle)


def _links(solid: np.ndarray) -> list[np.ndarray]:
    """Return for each axis whether a voxel and the next one are both solid, shaped as the volume."""
    links = []
    for axis in range(3):
        held = solid & np.roll(solid, -1, axis)
        held[(slice(None),) * axis + (-1,)] = False
        links.append(held)
    return links


def _pieces(solid: np.ndarray, links: list[np.ndarray]) -> np.ndarray:
    """Return the number of the piece (nx, ny, nz) that each voxel is in."""
    number = np.arange(solid.size).reshape(solid.shape)
    pairs = [(number[held], np.roll(number, -1, axis)[held]) for axis, held in enumerate(links)]
    tails, heads = (np.concatenate(ends) for ends in zip(*pairs))
    return joined(solid.size, tails, heads).reshape(solid.shape)


def _crossed(voxels: Voxels, crack: Crack) -> list[np.ndarray]:
    """Return for each axis whether the crack crosses the line from a voxel's centre to the next one's."""
    places = (crack.points - voxels.origin) / voxels.spacing - 0.5 + ASIDE
    return [_crossed_along(axis, places[crack.triangles], voxels.labels.shape) for axis in range(3)]


def _crossed_along(axis: int, corners: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Return where triangles (m, 3, 3), in voxels, cross the lattice's lines along an axis."""
    crossed = np.zeros(shape, bool)
    across = [k for k in range(3) if k != axis]
    flat = corners[..., across]
    first = np.maximum(np.ceil(flat.min(axis=1)), 0).astype(np.int64)
    last = np.minimum(np.floor(flat.max(axis=1)), np.array(shape)[across] - 1).astype(np.int64)
    width = np.maximum(last - first + 1, 0)
    count = width.prod(axis=1)
    for rows in np.split(np.arange(len(count)), np.flatnonzero(np.diff(np.cumsum(count) // AT_ONCE)) + 1):
        row = np.repeat(rows, count[rows])
        within = np.arange(len(row)) - np.repeat(np.cumsum(count[rows]) - count[rows], count[rows])
        line = first[row] + np.column_stack([within // width[row, 1], within % width[row, 1]])
        weights, inside = _weights(flat[row], line)
        height = np.floor((weights * corners[row, :, axis]).sum(axis=1)[inside]).astype(np.int64)
        line = line[inside]
        held = (height >= 0) & (height < shape[axis])
        index = np.insert(line[held], axis, height[held], axis=1)
        crossed[tuple(index.T)] = True
    return crossed


def _weights(flat: np.ndarray, line: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return barycentric weights (n, 3) of points (n, 2) in triangles (n, 3, 2), and which lie inside."""
    ahead, behind = np.roll(flat, -1, axis=1) - line[:, None], np.roll(flat, -2, axis=1) - line[:, None]
    areas = ahead[..., 0] * behind[..., 1] - ahead[..., 1] * behind[..., 0]
    total = areas.sum(axis=1, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        weights = areas / total
    inside = (weights >= -1e-9).all(axis=1)
    return np.where(inside[:, None], weights, 0.0), inside
