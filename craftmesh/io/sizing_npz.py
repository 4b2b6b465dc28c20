"""sizing.npz: the sizing function of an increment as plain arrays, between `size` and the stages."""

import os
from collections.abc import Mapping

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.io.npz import load, write_arrays

FORMAT = "craftmesh sizing 1"  # in the entry `format`
_NUMBERS = ("l_min", "l0", "l_max", "r0", "r1", "exponent", "growth")
# Entries with their shape (None: any number of rows) and kind of values.
_ENTRIES = {
    **{name: ((), "f") for name in _NUMBERS},
    "sources": ((None, 3), "f"),
    "field_points": ((None, 3), "f"),
    "field_lengths": ((None,), "f"),
    "field_counts": ((None,), "i"),
    "field_growth": ((None,), "f"),
}


def write_sizing(path: str | os.PathLike, arrays: Mapping[str, np.ndarray]) -> None:
    """Write the arrays of a sizing function; the same arrays give the same bytes, whole or not at all."""
    write_arrays(path, {"format": np.array(FORMAT), **{name: arrays[name] for name in _ENTRIES}})


def is_sizing(path: str | os.PathLike) -> bool:
    """Return whether an .npz says that it is a sizing; raises CraftmeshError where it is no .npz."""
    return str(load(path).get("format")) == FORMAT


def read_sizing(path: str | os.PathLike) -> dict[str, np.ndarray]:
    """Read the arrays that `write_sizing` wrote; raises CraftmeshError, naming the entry that is not so."""
    arrays = load(path)
    if str(arrays.get("format")) != FORMAT:
        raise CraftmeshError(f"{path}: is no sizing; expected a sizing.npz made by `craftmesh size`")
    for name, (shape, kind) in _ENTRIES.items():
        if name not in arrays:
            raise CraftmeshError(f"{path}: no entry {name}; run `craftmesh size` again")
        found = arrays[name]
        fits = len(found.shape) == len(shape) and all(b in (None, a) for a, b in zip(found.shape, shape))
        if not fits or found.dtype.kind != kind:
            raise CraftmeshError(
                f"{path}: {name} has shape {found.shape} and type {found.dtype}; run `craftmesh size` again"
            )
    rows, counts = len(arrays["field_points"]), arrays["field_counts"]
    if (counts < 1).any() or not rows == len(arrays["field_lengths"]) == counts.sum():
        raise CraftmeshError(
            f"{path}: field_counts {counts.tolist()} do not fit {rows} field_points and "
            f"{len(arrays['field_lengths'])} field_lengths; run `craftmesh size` again"
        )
    if len(counts) != len(arrays["field_growth"]):
        raise CraftmeshError(
            f"{path}: {len(counts)} field_counts and {len(arrays['field_growth'])} field_growth; "
            "run `craftmesh size` again"
        )
    return {name: arrays[name] for name in _ENTRIES}
