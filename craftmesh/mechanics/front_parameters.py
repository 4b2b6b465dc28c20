"""J, K_I, K_II, K_III and T at the nodes of a crack's fronts, and how far they may be off."""

from dataclasses import dataclass, fields

import numpy as np


@dataclass(frozen=True, eq=False)
class FrontParameters:
    """One row per front node at a corner, in the order of FrontFrames.

    front (k,) from 1; node (k,) id from 0; s (k,); points (k, 3); J (k,) by its own integral; G (k,) the
    energy release rate of the K; K_I, K_II, K_III (k,): with K_II > 0 lip A goes along the binormal, with
    K_III > 0 along the tangent; T (k,) the stress along the binormal that stays finite, NaN where the lips
    touch or are loaded, for it is found for lips free of traction; radius (k,) of the tube; spread (k,):
    the largest change of a K with a smaller tube; error (k,): of each K, see `fracture.error`; flags (k,)
    words joined by +, see there. Where the material changes values are the mean of both limits.
    probe_angle, probe_stress (k,): see `fracture.stress_probe`, NaN where it was not asked for.
    """

    front: np.ndarray
    node: np.ndarray
    s: np.ndarray
    points: np.ndarray
    J: np.ndarray
    G: np.ndarray
    K_I: np.ndarray
    K_II: np.ndarray
    K_III: np.ndarray
    T: np.ndarray
    radius: np.ndarray
    spread: np.ndarray
    error: np.ndarray
    flags: np.ndarray
    probe_angle: np.ndarray
    probe_stress: np.ndarray

    @property
    def k(self) -> np.ndarray:
        """(n, 3) K_I, K_II and K_III of each node."""
        return np.column_stack([self.K_I, self.K_II, self.K_III])

    def columns(self) -> dict[str, np.ndarray]:
        """Return the columns of sif.csv in order; nodes are numbered from 1 as in the deck.

        Those of the probe are there where it was asked for.
        """
        columns = {field.name: getattr(self, field.name) for field in fields(self)}
        columns["node"] = self.node + 1
        if np.isnan(self.probe_angle).all():
            del columns["probe_angle"], columns["probe_stress"]
        return columns
