"""Test whether a crack severs a body of voxels: remove the links that it crosses, count the pieces."""

from typing import NamedTuple

import numpy as np

from craftmesh.cracks.polyline import AT_ONCE
from craftmesh.surface.connectivity import joined
from craftmesh.types import Crack, Voxels

# Offset, in voxels, of the sample points from voxel centres: a crack exactly through the centres then lies
# on one side of all of them. Rounding is a million times smaller.
ASIDE = np.array([1.0, 1.3, 1.7]) * 1e-6
# Smallest piece in voxels; smaller ones are steps of a void or a face next to the crack.
LEAST = 27


class PieceOff(NamedTuple):
    """A piece that a crack cuts off: its volume and its voxels' mean position (3,), in model units."""

    volume: float
    middle: np.ndarray


def piece_cut_off(voxels: Voxels, crack: Crack) -> PieceOff | None:
    """Return the largest piece that the crack cuts off its body; None if it is smaller than LEAST voxels.

    Voxels of grains that share a face are linked unless the crack crosses the line between their centres,
    so a ligament narrower than a voxel does not count. The largest piece of each body is the body itself.
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
    """Return a mask (nx, ny, nz) per axis, True where a voxel and the next one along the axis are solid."""
    links = []
    for axis in range(3):
        held = solid & np.roll(solid, -1, axis)
        held[(slice(None),) * axis + (-1,)] = False
        links.append(held)
    return links


def _pieces(solid: np.ndarray, links: list[np.ndarray]) -> np.ndarray:
    """Return piece numbers (nx, ny, nz) of the voxels, connected by links."""
    number = np.arange(solid.size).reshape(solid.shape)
    pairs = [(number[held], np.roll(number, -1, axis)[held]) for axis, held in enumerate(links)]
    tails, heads = (np.concatenate(ends) for ends in zip(*pairs))
    return joined(solid.size, tails, heads).reshape(solid.shape)


def _crossed(voxels: Voxels, crack: Crack) -> list[np.ndarray]:
    """Return a mask (nx, ny, nz) per axis: the crack crosses the line to the next voxel's centre.

    In the last layer along the axis the line goes on for one voxel beyond the last centre.
    """
    places = (crack.points - voxels.origin) / voxels.spacing - 0.5 + ASIDE
    return [_crossed_along(axis, places[crack.triangles], voxels.labels.shape) for axis in range(3)]


def _crossed_along(axis: int, corners: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Return a mask (nx, ny, nz), True where triangles (m, 3, 3) cross the line to the next voxel's centre.

    In the last layer the line goes on for one voxel beyond the last centre. corners: of the triangles, in
    voxels, with voxel centres at whole numbers; axis: direction of the lines.
    """
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
    """Return barycentric coordinates (n, 3) of points (n, 2) in triangles (n, 3, 2), and an inside mask."""
    ahead, behind = np.roll(flat, -1, axis=1) - line[:, None], np.roll(flat, -2, axis=1) - line[:, None]
    areas = ahead[..., 0] * behind[..., 1] - ahead[..., 1] * behind[..., 0]
    total = areas.sum(axis=1, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        weights = areas / total
    inside = (weights >= -1e-9).all(axis=1)
    return np.where(inside[:, None], weights, 0.0), inside
