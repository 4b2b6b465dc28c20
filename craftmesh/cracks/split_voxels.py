"""Labels split on either side of a crack, and the surface between them with the crack's facets named."""

from typing import NamedTuple

import numpy as np

from craftmesh.cracks.near_sheet import NearSheet
from craftmesh.cracks.sheets import sheets
from craftmesh.errors import CraftmeshError, told
from craftmesh.surface.connectivity import compact, unique_edges
from craftmesh.types import CRACK, Crack, Surface, Voxels

BAND = 2.5  # voxels: those nearer to the crack or its continuation are told by sides
MARGIN = 1.5  # voxels past the front, as far as the crack's facets are kept until it is clipped
MOST = 7  # sheets: those of a facet are bits of one number


class SplitVoxels(NamedTuple):
    """A volume whose labels (nx, ny, nz) are told apart on either side of sheets.

    given: the volume; label (k,): the given label of each split one; side (k, s): which side of each sheet
    it is on, 1 or -1, 0 away from it. Labels <= 0 are as given.
    """

    given: Voxels
    labels: np.ndarray
    label: np.ndarray
    side: np.ndarray
    sheets: tuple[NearSheet, ...]


def split_along(voxels: Voxels, crack: Crack) -> SplitVoxels:
    """Return the volume with its labels split on either side of the crack's sheets, within BAND of them.

    Raises CraftmeshError for more than MOST sheets, and for one that branches in itself.
    """
    edges, _, count = unique_edges(crack.triangles)
    if (count > 2).any():
        place = told(crack.points[edges[count > 2][0]].mean(axis=0))
        raise CraftmeshError(
            f"the crack branches near {place} in one sheet; give each branch as a crack, or insertion cut"
        )
    looks = tuple(NearSheet(sheet, voxels.box) for sheet in sheets(crack))
    if len(looks) > MOST:
        raise CraftmeshError(
            f"the crack has {len(looks)} sheets; expected at most {MOST} for insertion voxel: use cut"
        )
    key = np.zeros(voxels.labels.shape, np.int64)
    for look in looks:
        key = 3 * key + _sides(voxels, look)
    solid = voxels.labels > 0
    parts = 3 ** len(looks)
    pair = voxels.labels[solid].astype(np.int64) * parts + key[solid]
    names, index = np.unique(pair, return_inverse=True)
    labels = voxels.labels.copy()
    labels[solid] = index + 1
    digits = (names % parts)[:, None] // 3 ** np.arange(len(looks) - 1, -1, -1) % 3
    side = np.array([0, 1, -1], np.int8)[digits]
    nothing = np.zeros((1, len(looks)), np.int8)
    return SplitVoxels(
        voxels, labels, np.concatenate([[0], names // parts]), np.concatenate([nothing, side]), looks
    )


def _sides(voxels: Voxels, look: NearSheet) -> np.ndarray:
    """Return 1 for voxels ahead of a sheet, 2 for those behind it, 0 away from it.

    Voxels at faces of the box are told by what is at the face, where the surface has its points: at their
    centres, half a voxel within, a crack at 9 degrees to the face is 3 voxels from its mouth.
    """
    reach = BAND * voxels.spacing.max()
    low, high = look.points.min(axis=0) - reach, look.points.max(axis=0) + reach
    first = np.clip(np.floor((low - voxels.origin) / voxels.spacing), 0, None).astype(np.int64)
    last = np.minimum(np.ceil((high - voxels.origin) / voxels.spacing), voxels.labels.shape).astype(
        np.int64
    )
    box = tuple(slice(a, max(a, b)) for a, b in zip(first, last))
    result = np.zeros(voxels.labels.shape, np.int64)
    index = np.argwhere(voxels.labels[box] > 0) + first
    if not len(index):
        return result
    places = voxels.origin + (index + 0.5) * voxels.spacing
    for plane, layer in zip(voxels.box, (0, np.array(voxels.labels.shape) - 1)):
        places = np.where(index == layer, plane, places)
    corner = look.tree.query(places)[0]
    near = corner < reach + look.reach.max()
    index, places = index[near], places[near]
    if not len(index):
        return result
    found = look.look(places)
    near = np.linalg.norm(places - found.foot, axis=1) < reach
    result[tuple(index[near].T)] = np.where(found.psi[near] > 0, 1, 2)
    return result


def first_sheet(bits: np.ndarray) -> np.ndarray:
    """Return the first sheet (m,) of facets by their sheets' bits (m,), the one they lie on; -1 for none.

    Where two sheets are within a voxel of each other, as beside the line where they meet, a facet parts the
    opposite sides of both, and both run in the first one.
    """
    return np.where(bits > 0, np.log2(np.maximum(bits & -bits, 1)).astype(np.int64), -1)


def joined_surface(raw: Surface, split: SplitVoxels) -> tuple[Surface, np.ndarray]:
    """Return the surface of split labels with the given ones again, and its facets' sheets (m,) as bits.

    raw: points in voxels. Facets whose sides are opposite ones of a sheet, near it and no more than MARGIN
    past its front, are the crack's, turned to the normal of the first such sheet; others between two parts
    of one grain are left out.
    """
    facets, sides, kind = raw.facets.copy(), raw.sides.copy(), raw.kind.copy()
    solid = (sides > 0).all(axis=1, keepdims=True)
    code = split.side[np.where(solid, sides, 0)].astype(np.int64)
    bits, turned = np.zeros(len(facets), np.int64), np.zeros(len(facets), bool)
    width = split.given.spacing.max()
    for number, look in enumerate(split.sheets):
        rows = np.flatnonzero(code[:, 0, number] * code[:, 1, number] < 0)
        if len(rows):
            centre = raw.points[facets[rows]].mean(axis=1) * split.given.spacing + split.given.origin
            found = look.look(centre)
            rows = rows[(found.phi > -MARGIN * width) & (np.abs(found.psi) < MARGIN * width)]
            first = rows[bits[rows] == 0]
            turned[first] = code[first, 0, number] > 0
            bits[rows] |= 1 << number
    kind[bits > 0] = CRACK
    facets[turned], sides[turned] = facets[turned][:, ::-1], sides[turned][:, ::-1]
    sides = np.where(sides > 0, split.label[np.maximum(sides, 0)], sides)
    kept = (sides[:, 0] != sides[:, 1]) | (bits > 0)
    points, facets, _ = compact(raw.points, facets[kept])
    return Surface(points, facets, sides[kept], kind[kept]), bits[kept]
