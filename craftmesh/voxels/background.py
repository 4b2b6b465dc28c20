"""Finding the meaning of label 0 in a volume, if neither the file's format nor the user defines it."""

from collections.abc import Sequence

import numpy as np
import scipy

from craftmesh.errors import CraftmeshError, counted
from craftmesh.types import GRAIN, UNINDEXED, VOID
from craftmesh.voxels.voxel_graph import Pieces, dispersed, find_pieces, speck_size

_ROLES = {GRAIN: "a grain", UNINDEXED: "not indexed", VOID: "empty space"}
_FEW = 3  # least number of other labels with which 0 can be compared
# Value of `_straightness` from which 0 is not a grain. Grains that meet at 120 degrees have 2/3, a free
# surface 1. Measured: generated grains 0.66, 95% of them up to 0.72 (laths 0.77); notches, holes, pores,
# and tilted and rough surfaces 0.80 to 1.02.
_STRAIGHT = 0.8


def background_shown(
    labels: np.ndarray, tables: Sequence[np.ndarray], fills: bool
) -> tuple[str, tuple[str, ...]]:
    """Return the meaning of label 0 in labels (nx, ny, nz), GRAIN, UNINDEXED or VOID, and a note on it.

    tables: orientations and phases of the file, (g, k) with row = label or (nx, ny, nz, k). fills: whether
    the user sets fill_unindexed; then 0 is UNINDEXED, else `role_of_zero` decides. Raises CraftmeshError if
    it cannot.
    """
    role, why = (UNINDEXED, "fill_unindexed is set") if fills else role_of_zero(labels, tables)
    if not role:
        raise ask_for_background(labels, why)
    others = " or ".join(name for name in _ROLES if name != role)
    note = f"label 0, {counted(int((labels == 0).sum()), labels.size)}, is taken as {_ROLES[role]}, "
    return role, (f"{note}because {why}; to change this, set background to {others}",)


def ask_for_background(labels: np.ndarray, why: str) -> CraftmeshError:
    """Return the error that asks for the meaning of label 0, with the effect of each answer.

    labels (nx, ny, nz); why: the reason why it is unclear, in words.
    """
    return CraftmeshError(
        f"label 0, {counted(int((labels == 0).sum()), labels.size)}, may be empty space, a grain or not "
        f"indexed: {why}; give --background void (it stays empty), grain (it becomes a grain) or unindexed "
        "(the grains around fill it), or set import.background in a configuration"
    )


def role_of_zero(labels: np.ndarray, tables: Sequence[np.ndarray]) -> tuple[str, str]:
    """Return the meaning of label 0 in labels (nx, ny, nz), GRAIN, UNINDEXED or VOID, and the reason.

    tables: as in `background_shown`. 0 is a grain if it has an orientation or phase. It is VOID if it
    surrounds the rest or forms several enclosed pieces. It is UNINDEXED if most of it is in specks, or if
    it is the only label without an orientation or phase. Otherwise it is a grain if it looks like the
    others, because ids may begin at 0. If not, the meaning is "" and the reason is the difference.
    """
    ids = np.unique(labels[labels >= 0])
    known = np.array([_known(table, labels, ids) for table in tables]).reshape(-1, len(ids))
    known = known[known[:, 1:].all(axis=1)]  # tables that contain all other labels
    if len(known) and known[:, 0].all():
        return GRAIN, "it has an orientation or phase"
    least, pieces = speck_size(labels), find_pieces(labels)
    zero = pieces.label == 0
    enclosed = int((pieces.voxels[zero] >= max(least, 1)).sum())
    if surrounds(labels, pieces):
        return VOID, "it surrounds the rest"
    if lies_in_specks(pieces, least):
        return UNINDEXED, "most of it is in specks"
    if enclosed > 1 and not pieces.touches_box[zero].any():
        return VOID, f"it forms {enclosed} enclosed pieces"
    if len(known):
        return UNINDEXED, "only it has no orientation or phase"
    unlike = _unlike_a_grain(labels)
    return ("", unlike) if unlike else (GRAIN, "it looks like the other grains")


def _unlike_a_grain(labels: np.ndarray) -> str:
    """Return in words how label 0 differs from the grains of labels (nx, ny, nz); "" if it does not."""
    ids, voxels = np.unique(labels[labels >= 0], return_counts=True)
    if len(ids) <= _FEW:
        return f"the file has {len(ids)} labels, too few to compare"
    if ids[-1] >= len(ids):
        return f"ids up to {ids[-1]} have gaps"
    others = np.sort(voxels[1:])
    if 2 * voxels[0] < others[0] or voxels[0] > others[-2:].sum():
        return f"the grains have {others[0]} to {others[-1]} voxels"
    if not _straightness(labels) < _STRAIGHT:
        return "other grains' boundaries meet it at right angles, as at a free surface"
    return ""


def _straightness(labels: np.ndarray) -> float:
    """Return the mean fraction of label 0 around its edges, divided by the mean fraction around its faces.

    Cubes of 2 x 2 x 2 voxels that contain 0 are edges with two or more other labels, faces with one. The
    fraction is the share of voxels of label 0 in the 4 x 4 x 4 voxels around a cube. NaN if 0 has no edges
    or no faces.
    """
    is_zero, cubes = labels == 0, (slice(1, None),) * 3
    least = scipy.ndimage.minimum_filter(np.where(is_zero, labels.max() + 1, labels), 2)[cubes]
    most = scipy.ndimage.maximum_filter(labels, 2)[cubes]
    at_zero = scipy.ndimage.maximum_filter(is_zero, 2)[cubes] & (most > 0)
    edges, faces = at_zero & (least < most), at_zero & (least == most)
    if not (edges.any() and faces.any()):
        return float("nan")
    held = scipy.ndimage.uniform_filter(is_zero.astype(np.float32), 4)[cubes]
    return float(held[edges].mean() / held[faces].mean())


def _known(table: np.ndarray, labels: np.ndarray, ids: np.ndarray) -> np.ndarray:
    """Return a mask (k,) of the ids for which a table has finite numbers that are not all 0.

    table: (g, c), row = label, or (nx, ny, nz, c) of the voxels of labels (nx, ny, nz).
    """
    known = np.isfinite(table).all(axis=-1) & (table != 0).any(axis=-1)
    if known.ndim == 3:
        return np.isin(ids, labels[known])
    return (ids < len(known)) & known[np.minimum(ids, len(known) - 1)]


def surrounds(labels: np.ndarray, pieces: Pieces) -> bool:
    """Return True if label 0 surrounds one body.

    0 must fill the eight corners of the box, or be the largest label and fill most box faces of all labels.
    The largest connected body of other labels must have over half of their voxels: if 0 separates many
    bodies, it is the material that connects them.
    """
    faces = [np.take(labels, end, axis=axis) for axis in range(3) for end in (0, -1)]
    whole = [int(face.flat[0]) for face in faces if (face == face.flat[0]).all()]
    ids, of = np.unique(pieces.label, return_inverse=True)
    is_largest = ids[np.bincount(of, pieces.voxels).argmax()] == 0
    fills_faces = is_largest and whole.count(0) > max((whole.count(k) for k in whole if k), default=0)
    if not fills_faces and labels[np.ix_(*([0, n - 1] for n in labels.shape))].any():
        return False
    bodies = find_pieces((labels != 0).astype(np.int8))
    sizes = bodies.voxels[bodies.label == 1]
    return bool(2 * sizes.max(initial=0) > sizes.sum())


def lies_in_specks(pieces: Pieces, least: int) -> bool:
    """Return True if label 0, and no other, has most of its voxels in pieces under `least` voxels."""
    voxels = pieces.voxels[pieces.label == 0]
    in_specks = 2 * voxels[voxels < least].sum() > voxels.sum()
    return bool(in_specks) and not dispersed(pieces, least).any()
