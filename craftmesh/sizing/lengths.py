"""What every wish for edge lengths can be asked."""

from typing import Protocol, runtime_checkable

import numpy as np


@runtime_checkable
class Lengths(Protocol):
    """Target edge lengths by place, as `Sizing` (Eq. 3), a LengthField or a surface's own give them."""

    def at(self, points: np.ndarray) -> np.ndarray:
        """Return the target edge lengths (n,), in model units, at points (n, 3)."""
        ...
