"""What label 0 is in a file of which neither the format nor the user says it."""

from collections.abc import Sequence

import numpy as np

from craftmesh.errors import counted
from craftmesh.types import GRAIN, UNINDEXED, VOID
from craftmesh.voxels.voxel_graph import Pieces, dispersed, find_pieces, speck_size

_ROLES = {GRAIN: "a grain", UNINDEXED: "not indexed", VOID: "empty space"}


def background_shown(
    labels: np.ndarray, tables: Sequence[np.ndarray], fills: bool
) -> tuple[str, tuple[str, ...]]:
    """Return GRAIN, UNINDEXED or VOID, what 0 is among labels (nx, ny, nz), and a note that says so.

    tables: the file's, (g, k) with row = label or (nx, ny, nz, k). fills: whether the user expects
    unindexed voxels, which 0 then is; else `role_of_zero`.
    """
    role, why = (UNINDEXED, "fill_unindexed is set") if fills else role_of_zero(labels, tables)
    voxels, others = int((labels == 0).sum()), " or ".join(name for name in _ROLES if name != role)
    note = f"label 0, {counted(voxels, labels.size)}, is taken as {_ROLES[role]}, since {why}; "
    return role, (f"{note}background {others} says otherwise",)


def role_of_zero(labels: np.ndarray, tables: Sequence[np.ndarray]) -> tuple[str, str]:
    """Return GRAIN, UNINDEXED or VOID, what 0 is among labels (nx, ny, nz), and the reason in words.

    Ids may begin at 0, so 0 is a grain where nothing marks it as background. It is empty space where it
    surrounds the rest or lies in several enclosed pieces, and voxels without a grain where it lies in
    specks or is the one label without an orientation or phase.
    """
    ids = np.unique(labels[labels >= 0])
    known = np.array([_known(table, labels, ids) for table in tables]).reshape(-1, len(ids))
    known = known[known[:, 1:].all(axis=1)]  # tables that have all other labels
    if len(known) and known[:, 0].all():
        return GRAIN, "it has an orientation or phase"
    least, pieces = speck_size(labels), find_pieces(labels)
    zero = pieces.label == 0
    enclosed = int((pieces.voxels[zero] >= max(least, 1)).sum())
    if _surrounds(labels, pieces):
        return VOID, "it surrounds the rest"
    if lies_in_specks(pieces, least):
        return UNINDEXED, "most of it lies in specks"
    if enclosed > 1 and not pieces.touches_box[zero].any():
        return VOID, f"it lies in {enclosed} enclosed pieces"
    if len(known):
        return UNINDEXED, "it alone has no orientation or phase"
    return GRAIN, "nothing marks it as background"


def _known(table: np.ndarray, labels: np.ndarray, ids: np.ndarray) -> np.ndarray:
    """Return for each of ids (k,) whether a table by row or by voxel has numbers other than 0 for it."""
    known = np.isfinite(table).all(axis=-1) & (table != 0).any(axis=-1)
    if known.ndim == 3:
        return np.isin(ids, labels[known])
    return (ids < len(known)) & known[np.minimum(ids, len(known) - 1)]


def _surrounds(labels: np.ndarray, pieces: Pieces) -> bool:
    """Whether one body lies in 0, which fills the box's corners, or faces as the largest label.

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
