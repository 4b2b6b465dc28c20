"""Chunks of meshed grains (.npz) between `tetrahedralize` and `assemble`."""

import json
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from craftmesh.atomic import atomic_path
from craftmesh.errors import CraftmeshError
from craftmesh.io.npz import load
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
