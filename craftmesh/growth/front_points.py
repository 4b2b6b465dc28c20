"""What is known at the points of a crack's fronts before a step."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from craftmesh.growth.relaxation import FrontRows
from craftmesh.growth.steps import CycleCount, increment_after
from craftmesh.growth.trust import sources

_MATRICES = {"orientation": 3, "stiffness": 6}


@dataclass(frozen=True, eq=False)
class FrontPoints:
    """One row (n,) for each point of a crack's fronts; user-supplied functions get this record.

    k (n, 3): K_I, K_II, K_III at the load that is looked at, in the unit of sif.csv; loads: k by load case.
    points (n, 3); binormal, normal, tangent (n, 3): the local frame as in front.csv; T: T-stress; doubt:
    estimated error of K, in its unit; trusted: False at points that take K of the nearest trusted point on
    their front; front: number of the front; grain, phase: ids, phase 0 if there is none; orientation
    (n, 3, 3): active rotation from crystal to sample axes; stiffness (n, 6, 6): over 11, 22, 33, 12, 13, 23
    in the axes binormal, normal, tangent; slip_angle: kink angle in radians along the slip plane with the
    most slip, for criterion slip. NaN: unknown.

    size: crack size (`steps.crack_size`); edge: median edge length of the fronts; error: median error of K
    at trusted points; contact: True if the solution keeps crack faces from overlapping; net_stress: largest
    mean stress over the net section; rows: ids and arc lengths of the points of each front; last: the front
    before and its load cycles, None for the first. still: by load case, the part of its k (n, 3) that a
    residual stress causes, which factors of loads do not change; "": of `k`.
    """

    k: np.ndarray
    loads: Mapping[str, np.ndarray]
    points: np.ndarray
    binormal: np.ndarray
    normal: np.ndarray
    tangent: np.ndarray
    T: np.ndarray
    doubt: np.ndarray
    trusted: np.ndarray
    front: np.ndarray
    grain: np.ndarray
    phase: np.ndarray
    orientation: np.ndarray
    stiffness: np.ndarray
    slip_angle: np.ndarray
    size: float
    edge: float = 0.0
    error: float = 0.0
    contact: bool = False
    net_stress: float = np.nan
    rows: Sequence[FrontRows] = ()
    last: CycleCount | None = None
    still: Mapping[str, np.ndarray] = field(default_factory=dict)

    @property
    def increment(self) -> int:
        """The number of the coming step, from 0."""
        return increment_after(self.last)

    @classmethod
    def of(cls, k: np.ndarray, size: float, **known: Any) -> "FrontPoints":
        """Return points with K (n, 3), crack size and `known` fields by name.

        By default the doubt is 0, all points are trusted, and `loads` is empty. Grain, phase, front number
        and positions are then 0, all other values by point NaN.
        """
        count = len(k)
        by_point: dict[str, Any] = {"doubt": np.zeros(count), "trusted": np.ones(count, bool)}
        by_point |= {name: np.zeros(count, int) for name in ("front", "grain", "phase")}
        by_point |= {name: np.full(count, np.nan) for name in ("T", "slip_angle")}
        by_point |= {name: np.full((count, 3), np.nan) for name in ("binormal", "normal", "tangent")}
        by_point |= {name: np.full((count, m, m), np.nan) for name, m in _MATRICES.items()}
        by_point |= {"points": np.zeros((count, 3))}
        fields: dict[str, Any] = {"k": k, "loads": {}, "size": size} | by_point | known
        return cls(**fields)

    def with_k(self, k: np.ndarray) -> "FrontPoints":
        """Return these points with other K (n, 3)."""
        return replace(self, k=k)

    def at(self, load: tuple[float, str]) -> np.ndarray:
        """Return K (n, 3) at a load (factor, load case); "": the load of `k`.

        The factor multiplies K of the case without the part `still`, which a residual stress causes.
        """
        factor, name = load
        k, still = self.loads[name] if name else self.k, self.still.get(name, 0.0)
        return still + factor * (k - still)

    def from_trusted(self) -> "FrontPoints":
        """Return these points, with K and doubt of points not trusted from the nearest trusted point."""
        of = sources(self.points, self.trusted, self.front)
        loads, still = ({name: k[of] for name, k in part.items()} for part in (self.loads, self.still))
        return replace(self, k=self.k[of], doubt=self.doubt[of], loads=loads, still=still)
