"""Arrays between stages: chunks of meshed grains, and sizing.npz, the sizing function of an increment."""

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from craftmesh.atomic import atomic_path
from craftmesh.errors import CraftmeshError
from craftmesh.io.npz import load, write_arrays
from craftmesh.types import GrainTets

_FIELDS = ("nodes", "interior", "tets")


def write_grain_tets(
    path: str | os.PathLike, grains: Sequence[GrainTets], record: dict | None = None
) -> None:
    """Write the grains, in the order given, as one .npz; the same grains give the same bytes.

    Arrays: grain (g,); nodes, interior, tets of all grains one after the other; counts (g, 3) of each;
    record: how they were made, as JSON text in bytes.
    """
    text = np.frombuffer(json.dumps(record or {}).encode(), np.uint8)
    counts = np.array([[len(getattr(g, name)) for name in _FIELDS] for g in grains], np.int64).reshape(
        -1, 3
    )
    empty = {
        "nodes": np.zeros(0, np.int64),
        "interior": np.zeros((0, 3)),
        "tets": np.zeros((0, 4), np.int64),
    }
    joined = {name: np.concatenate([empty[name], *(getattr(g, name) for g in grains)]) for name in _FIELDS}
    with atomic_path(path) as temporary, open(temporary, "wb") as stream:
        numbers = np.array([g.grain for g in grains], np.int64)
        np.savez(stream, grain=numbers, counts=counts, record=text, **joined)  # type: ignore[arg-type]


def read_grain_tets(path: str | os.PathLike) -> list[GrainTets]:
    """Read the grains of a chunk; raises CraftmeshError for a missing or broken file or array."""
    arrays = _arrays(path, ("grain", "counts", *_FIELDS))
    cuts = np.cumsum(arrays["counts"], axis=0)[:-1]
    parts = [np.split(arrays[name], cuts[:, column]) for column, name in enumerate(_FIELDS)]
    return [GrainTets(grain, *fields) for grain, *fields in zip(arrays["grain"], *parts)]


def read_record(path: str | os.PathLike) -> dict:
    """Read how the grains of a chunk were made; raises CraftmeshError as `read_grain_tets`."""
    return json.loads(_arrays(path, ("record",))["record"].tobytes())


def _arrays(path: str | os.PathLike, names: Sequence[str]) -> dict[str, np.ndarray]:
    if not Path(path).is_file():
        raise CraftmeshError(f"{path}: no such file; run tetrahedralize for this chunk")
    arrays = load(path, names)
    missing = [name for name in names if name not in arrays]
    if missing:
        raise CraftmeshError(f"{path}: not a chunk of grains, no {missing[0]}; run tetrahedralize again")
    return arrays


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
