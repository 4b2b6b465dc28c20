"""J, K_I, K_II, K_III and T at the nodes of crack fronts, with estimated errors."""

from dataclasses import dataclass, fields

import numpy as np


@dataclass(frozen=True, eq=False)
class FrontParameters:
    """One row per front node that is an element corner, in the order of FrontFrames.

    front (k,): number of the front, from 1; node (k,): id, from 0; s (k,): arc length; points (k, 3); J
    (k,): by its own integral; G (k,): energy release rate that follows from K_I, K_II and K_III (k,). With
    K_II > 0 lip A moves along the binormal relative to lip B, with K_III > 0 along the tangent. T (k,): the
    finite stress along the binormal, NaN where lips (crack faces) touch or are loaded, because its integral
    assumes lips free of traction. radius (k,): of the integration domain; spread (k,): largest change of a
    K with a smaller domain; error (k,): estimated error of each of the K; flags (k,): reasons for doubt,
    words of `fracture.error` joined by +. Where the material changes, values are means of the limits on
    both sides. probe_angle, probe_stress (k,): direction and value of the largest tangential stress on an
    arc around the front (`fracture.stress_probe`), NaN if not asked for.
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
        """K_I, K_II and K_III (n, 3) of the nodes."""
        return np.column_stack([self.K_I, self.K_II, self.K_III])

    def columns(self) -> dict[str, np.ndarray]:
        """Return the columns of sif.csv by name, in order; node numbers start at 1, as in the deck.

        The columns of the probe are left out if it was not asked for.
        """
        columns = {field.name: getattr(self, field.name) for field in fields(self)}
        columns["node"] = self.node + 1
        if np.isnan(self.probe_angle).all():
            del columns["probe_angle"], columns["probe_stress"]
        return columns
