"""Convert a sizing function to plain arrays, which a file can hold, and back without loss."""

from collections.abc import Mapping

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.sizing.length_field import LengthField
from craftmesh.sizing.sizing import Sizing

NUMBERS = ("l_min", "l0", "l_max", "r0", "r1", "exponent")


def arrays_of(sizing: Sizing) -> dict[str, np.ndarray]:
    """Return the arrays of `sizing`: the numbers of Eq. 3, `growth` (NaN for None), `sources` (k, 3).

    The samples of its LengthFields are concatenated in `field_points` (n, 3) and `field_lengths` (n,);
    `field_counts` (f,) and `field_growth` (f,) have one row per field. Raise CraftmeshError if
    sizing.others contains anything else.
    """
    others = [other for other in sizing.others if isinstance(other, LengthField)]
    if len(others) < len(sizing.others):
        raise CraftmeshError("a sizing within a sizing cannot be stored; use only LengthFields in others")
    growth = np.nan if sizing.growth is None else sizing.growth
    return {
        **{name: np.array(getattr(sizing, name), float) for name in NUMBERS},
        "growth": np.array(growth, float),
        "sources": sizing.sources,
        "field_points": np.concatenate([np.zeros((0, 3)), *(other.points for other in others)]),
        "field_lengths": np.concatenate([np.zeros(0), *(other.lengths for other in others)]),
        "field_counts": np.array([len(other.points) for other in others], np.int64),
        "field_growth": np.array([other.growth for other in others], float),
    }


def sizing_of(arrays: Mapping[str, np.ndarray]) -> Sizing:
    """Return the sizing function of arrays from `arrays_of`; raise CraftmeshError for invalid numbers.

    Not checked: all arrays must be there.
    """
    cuts = np.cumsum(arrays["field_counts"])[:-1]
    points = np.split(arrays["field_points"], cuts)
    lengths = np.split(arrays["field_lengths"], cuts)
    growths = arrays["field_growth"].tolist()
    growth = float(arrays["growth"])
    return Sizing(
        **{name: float(arrays[name]) for name in NUMBERS},
        sources=arrays["sources"],
        growth=None if np.isnan(growth) else growth,
        others=tuple(LengthField(*one) for one in zip(points, lengths, growths)),
    )
