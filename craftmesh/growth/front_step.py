"""What each point of a crack's fronts does in one step: the record that growth finds, lays and writes."""

from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np

from craftmesh.types import Crack


@dataclass(frozen=True, eq=False)
class FrontStep:
    """A row (n,) for each point of a crack's fronts, in any order.

    points, normal, binormal (n, 3): the crack plane's normal, and the direction out of the crack, square to
    it and to the front. kink_angle: radians from the binormal towards the normal. extension: 0 of points
    that stay, and stays, a word of `extension.STAYS`, says why. trusted (bool): whether the point's
    direction counts; other points go as the trusted ones beside them. rate: da/dN over its median, with
    which the extensions go; power: its d ln(rate) / d ln(K). da_dn: by the laws, 0 where a point stays;
    delta_k: what it goes with; ratio: R of the cycle; driving: the driving force at the largest load.
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

    @classmethod
    def of(cls, *first: np.ndarray, **known: np.ndarray) -> "FrontStep":
        """Return the record of its first fields and known others.

        The rest: all points are trusted and go at one rate, and what has no such value is NaN.
        """
        usual = {"trusted": True, "stays": "", "rate": 1.0, "power": 0.0}
        names, count = [field.name for field in fields(cls)], len(first[0])
        rest = {name: np.full(count, usual.get(name, np.nan)) for name in names[len(first) :]}
        return cls(**(rest | dict(zip(names, first)) | known))

    @property
    def moves(self) -> np.ndarray:
        """(n, 3) where each point goes, not made smooth."""
        along, across = np.cos(self.kink_angle), np.sin(self.kink_angle)
        return self.extension[:, None] * (along[:, None] * self.binormal + across[:, None] * self.normal)

    def rows(self, chosen: np.ndarray) -> "FrontStep":
        """Return the chosen rows, in their order."""
        return FrontStep(*(getattr(self, field.name)[chosen] for field in fields(self)))


class Step(NamedTuple):
    """A crack and where the points of its fronts go: what a strip is laid from."""

    crack: Crack
    along: FrontStep
