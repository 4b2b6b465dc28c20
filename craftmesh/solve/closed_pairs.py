"""Lip nodes that stay together along the crack's normal and slide freely: constraint and forces."""

import numpy as np
from scipy.sparse import csr_array, eye_array
from scipy.sparse.linalg import splu

from craftmesh.mesh.lip_pairs import LipPairs

# Where cracks cross under supports a constraint may follow from others; with so much on the diagonal of
# their products, which is 2, each gets its share.
_DEPENDENT = 1e-12


class ClosedPairs:
    """The pairs of lip nodes, `which` (p,) of all, whose gap stays 0; fixed (n, 3): prescribed components.

    Each is a row c of `free`, 0 at prescribed components; rows of `whole` have all components, so that
    whole @ u are the gaps of a displacement u. Fields that the solver adds are kept square to all c.
    text: what the progress of such a field says first.
    """

    def __init__(self, pairs: LipPairs, which: np.ndarray, fixed: np.ndarray, text: str):
        nodes, normal = pairs.nodes[which], pairs.normal[which]
        self.pairs, self.which, self.text = pairs, which, text
        column = (3 * nodes[:, :, None] + np.arange(3)).ravel()
        value = (np.array([1.0, -1.0])[:, None] * normal[:, None, :]).ravel()
        first = 6 * np.arange(len(nodes) + 1)
        shape = (len(nodes), fixed.size)
        self.whole = csr_array((value, column, first), shape)
        self.free = csr_array((np.where(fixed.ravel()[column], 0.0, value), column, first), shape)
        self.spread = self.free.T.tocsr()
        product = self.free @ self.spread + _DEPENDENT * eye_array(len(nodes))
        self.answer = splu(product.tocsc()).solve if len(nodes) else np.copy

    def take_out(self, field: np.ndarray) -> None:
        """Take the part along the constraints out of a field (n, 3)."""
        field -= (self.spread @ self.answer(self.free @ field.ravel())).reshape(field.shape)

    def closed(self, displacement: np.ndarray) -> np.ndarray:
        """Return the displacement (n, 3) with these gaps closed."""
        gaps = self.whole @ displacement.ravel()
        return displacement - (self.spread @ self.answer(gaps)).reshape(displacement.shape)

    def pushing(self, left: np.ndarray) -> np.ndarray:
        """Return the forces (p,) by which pairs push apart, so that of forces left (n, 3) least is left."""
        push = np.zeros(len(self.which))
        push[self.which] = -self.answer(self.free @ left.ravel())
        return push
