"""The record of one growth step at each point of a crack's fronts."""

from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np

from craftmesh.types import Crack


@dataclass(frozen=True, eq=False)
class FrontStep:
    """One row (n,) for each point of a crack's fronts, in any order.

    points (n, 3); normal (n, 3): unit normal of the crack plane; binormal (n, 3): direction ahead of the
    crack, perpendicular to normal and front. kink_angle: radians from binormal towards normal. extension:
    length in model units, 0 at points that stay. stays: why a point stays, a key of `extension.STAYS`, or
    "". trusted (bool): False at points that take their move from trusted neighbours. rate: da/dN over its
    median, from which the extensions come; power: its d ln(rate) / d ln(K). da_dn: da/dN by the laws, 0 at
    points that stay; delta_k: effective Delta K in these laws; ratio: stress ratio R; driving: driving
    force at the peak of the cycle; stretch: T-stress over K_I. NaN: unknown.
    """

    points: np.ndarray
    normal: np.ndarray
    binormal: np.ndarray
    kink_angle: np.ndarray
    extension: np.ndarray
    trusted: np.ndarray
    stays: np.ndarray
    rate: np.ndarray
    power: np.ndarray
    da_dn: np.ndarray
    delta_k: np.ndarray
    ratio: np.ndarray
    driving: np.ndarray
    stretch: np.ndarray

    @classmethod
    def of(cls, *first: np.ndarray, **known: np.ndarray) -> "FrontStep":
        """Return a record from its `first` fields, in order, and `known` fields by name.

        Default of the other fields: trusted True, stays "", rate 1, power and stretch 0, all else NaN.
        """
        usual = {"trusted": True, "stays": "", "rate": 1.0, "power": 0.0, "stretch": 0.0}
        names, count = [field.name for field in fields(cls)], len(first[0])
        rest = {name: np.full(count, usual.get(name, np.nan)) for name in names[len(first) :]}
        return cls(**(rest | dict(zip(names, first)) | known))

    @property
    def moves(self) -> np.ndarray:
        """Displacement (n, 3) of each point, before smoothing."""
        along, across = np.cos(self.kink_angle), np.sin(self.kink_angle)
        return self.extension[:, None] * (along[:, None] * self.binormal + across[:, None] * self.normal)

    def rows(self, chosen: np.ndarray) -> "FrontStep":
        """Return a record of the points that `chosen`, a mask or row ids, selects."""
        return FrontStep(*(getattr(self, field.name)[chosen] for field in fields(self)))


class Step(NamedTuple):
    """A crack and the moves of its front points, from which a strip of new crack surface is laid."""

    crack: Crack
    along: FrontStep
