"""Cohesive elements of an input deck, read back from its text: kind, order, sides and sections."""

from collections.abc import Sequence

import numpy as np
from scipy.sparse import csr_array

from craftmesh.surface.measure import area_vectors


def kind_fault(kind: str) -> str:
    """Return what keeps Abaqus from taking an element type, "" where nothing does."""
    if kind.startswith("COH3D") and kind.rstrip("PT") not in ("COH3D6", "COH3D8"):
        return f"Abaqus has no {kind}; expected COH3D6, four on each face of C3D10"
    return ""


def order_faults(points: np.ndarray, layers: np.ndarray, tets: Sequence[np.ndarray]) -> list[str]:
    """Return a sentence where COH3D6 (k, 6) turn the wrong way; points by node.

    Nodes 4 to 6 have to lie over 1 to 3, whose normal points out of the solid element (m, 4 or 10 each) on
    which they are.
    """
    bottom, top = (area_vectors(points, layers[:, part]) for part in (slice(3), slice(3, 6)))
    faults = []
    crossed = np.flatnonzero(np.einsum("ij,ij->i", bottom, top) <= 0)
    if len(crossed):
        faults.append(f"{len(crossed)} cohesive elements have nodes 4 to 6 not over 1 to 3")
    inward = np.zeros(len(layers), bool)
    of = _incidence(layers[:, :3], len(points))
    for rows in tets:
        shared = (of @ _incidence(rows, len(points)).T).tocoo()
        layer, element = shared.row[shared.data == 3], shared.col[shared.data == 3]
        off = points[rows[element, :4]].mean(axis=1) - points[layers[layer, 0]]
        inward[layer] |= np.einsum("ij,ij->i", bottom[layer], off) > 0
    if inward.any():
        faults.append(
            f"{np.count_nonzero(inward)} cohesive elements have the normal of nodes 1 to 3 into the solid "
            "element there; expected it out of it, from nodes 1 to 3 towards 4 to 6"
        )
    if len(np.unique(np.sort(layers, axis=1), axis=0)) < len(layers):
        faults.append("cohesive elements are there twice on the same nodes; expected each once")
    return faults


def _incidence(rows: np.ndarray, count: int) -> csr_array:
    """Return which nodes (k, count) the elements (k, c) have."""
    at = np.repeat(np.arange(len(rows)), rows.shape[1])
    return csr_array((np.ones(rows.size, np.int8), (at, rows.ravel())), shape=(len(rows), count))
