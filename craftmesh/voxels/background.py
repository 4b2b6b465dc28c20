"""What label 0 is in a file of which neither the format nor the user says it."""

from collections.abc import Sequence

import numpy as np
import scipy

from craftmesh.errors import CraftmeshError, counted
from craftmesh.types import GRAIN, UNINDEXED, VOID
from craftmesh.voxels.voxel_graph import Pieces, dispersed, find_pieces, speck_size

_ROLES = {GRAIN: "a grain", UNINDEXED: "not indexed", VOID: "empty space"}
_FEW = 3  # other labels at least, with which 0 can be compared
# `_straightness` from which 0 is no grain: 2/3 is that of grains that meet at 120 degrees, 1 that of a free
# surface. Measured: generated grains 0.66, 95% of them up to 0.72 (laths 0.77); notches, holes, pores, and
# tilted and rough surfaces 0.80 to 1.02.
_STRAIGHT = 0.8


def background_shown(
    labels: np.ndarray, tables: Sequence[np.ndarray], fills: bool
) -> tuple[str, tuple[str, ...]]:
    """Return GRAIN, UNINDEXED or VOID, what 0 is among labels (nx, ny, nz), and a note that says so.

    tables: the file's, (g, k) with row = label or (nx, ny, nz, k). fills: whether the user expects
    unindexed voxels, which 0 then is; else `role_of_zero`. Raises CraftmeshError where that is open.
    """
    role, why = (UNINDEXED, "fill_unindexed is set") if fills else role_of_zero(labels, tables)
    if not role:
        raise ask_for_background(labels, why)
    others = " or ".join(name for name in _ROLES if name != role)
    note = f"label 0, {counted(int((labels == 0).sum()), labels.size)}, is taken as {_ROLES[role]}, "
    return role, (f"{note}since {why}; background {others} says otherwise",)


def ask_for_background(labels: np.ndarray, why: str) -> CraftmeshError:
    """Return the error that asks what label 0 of (nx, ny, nz) is, with what each answer does."""
    return CraftmeshError(
        f"label 0, {counted(int((labels == 0).sum()), labels.size)}, may be empty space, a grain or not "
        f"indexed: {why}; give --background void (it stays empty), grain (it becomes material, a grain) or "
        "unindexed (the grains around it fill it), in a configuration import.background"
    )


def role_of_zero(labels: np.ndarray, tables: Sequence[np.ndarray]) -> tuple[str, str]:
    """Return GRAIN, UNINDEXED or VOID, what 0 is among labels (nx, ny, nz), and the reason in words.

    It is empty space where it surrounds the rest or lies in several enclosed pieces, and voxels without a
    grain where it lies in specks or is the one label without an orientation or phase. Ids may begin at 0,
    so 0 is a grain where it looks like one (`_unlike_a_grain`). The role is empty where it does not.
    """
    ids = np.unique(labels[labels >= 0])
    known = np.array([_known(table, labels, ids) for table in tables]).reshape(-1, len(ids))
    known = known[known[:, 1:].all(axis=1)]  # tables that have all other labels
    if len(known) and known[:, 0].all():
        return GRAIN, "it has an orientation or phase"
    least, pieces = speck_size(labels), find_pieces(labels)
    zero = pieces.label == 0
    enclosed = int((pieces.voxels[zero] >= max(least, 1)).sum())
    if surrounds(labels, pieces):
        return VOID, "it surrounds the rest"
    if lies_in_specks(pieces, least):
        return UNINDEXED, "most of it lies in specks"
    if enclosed > 1 and not pieces.touches_box[zero].any():
        return VOID, f"it lies in {enclosed} enclosed pieces"
    if len(known):
        return UNINDEXED, "it alone has no orientation or phase"
    unlike = _unlike_a_grain(labels)
    return ("", unlike) if unlike else (GRAIN, "it looks like one of them")


def _unlike_a_grain(labels: np.ndarray) -> str:
    """Return in words how 0 differs from the grains of labels (nx, ny, nz), empty where it is alike."""
    ids, voxels = np.unique(labels[labels >= 0], return_counts=True)
    if len(ids) <= _FEW:
        return f"the file has {len(ids)} labels, too few to compare"
    if ids[-1] >= len(ids):
        return f"ids up to {ids[-1]} have gaps"
    others = np.sort(voxels[1:])
    if 2 * voxels[0] < others[0] or voxels[0] > others[-2:].sum():
        return f"the grains have {others[0]} to {others[-1]} voxels"
    if not _straightness(labels) < _STRAIGHT:
        return "other grains' boundaries end straight on it, as on a free surface"
    return ""


def _straightness(labels: np.ndarray) -> float:
    """Return how much of the space around its edges 0 holds, relative to that around its faces.

    Its edges are the cubes of 2 x 2 x 2 voxels with two other labels, its faces those with one; the space
    is the 4 x 4 x 4 voxels around them. NaN without edges or faces.
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
    """Return for each of ids (k,) whether a table by row or by voxel has numbers other than 0 for it."""
    known = np.isfinite(table).all(axis=-1) & (table != 0).any(axis=-1)
    if known.ndim == 3:
        return np.isin(ids, labels[known])
    return (ids < len(known)) & known[np.minimum(ids, len(known) - 1)]


def surrounds(labels: np.ndarray, pieces: Pieces) -> bool:
    """Whether one body lies in label 0, which fills the box's corners, or faces as the largest label.

    Several bodies that 0 keeps apart would fall asunder: there it is what holds them.
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
    """Whether most of 0 is in pieces of fewer voxels, and no other label is dispersed like that."""
    voxels = pieces.voxels[pieces.label == 0]
    in_specks = 2 * voxels[voxels < least].sum() > voxels.sum()
    return bool(in_specks) and not dispersed(pieces, least).any()
