"""Chunks of meshed grains (.npz) between `tetrahedralize` and `assemble`."""

import os
import zipfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from craftmesh.atomic import atomic_path
from craftmesh.errors import CraftmeshError
from craftmesh.types import GrainTets

_FIELDS = ("nodes", "interior", "tets")


def write_grain_tets(path: str | os.PathLike, grains: Sequence[GrainTets]) -> None:
    """Write the grains, in the order given, as one .npz; the same grains give the same bytes.

    Arrays: grain (g,); nodes, interior, tets of all grains one after the other; counts (g, 3) of each.
    """
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
        np.savez(stream, grain=np.array([g.grain for g in grains], np.int64), counts=counts, **joined)


def read_grain_tets(path: str | os.PathLike) -> list[GrainTets]:
    """Read the grains of a chunk; raises CraftmeshError for a missing or broken file or array."""
    if not Path(path).is_file():
        raise CraftmeshError(f"{path}: no such file; run tetrahedralize for this chunk")
    try:
        with np.load(path) as archive:
            arrays = {name: archive[name] for name in ("grain", "counts", *_FIELDS)}
    except (KeyError, ValueError, OSError, EOFError, zipfile.BadZipFile) as error:
        raise CraftmeshError(
            f"{path}: not a chunk of grains ({error}); run tetrahedralize again"
        ) from error
    cuts = np.cumsum(arrays["counts"], axis=0)[:-1]
    parts = [np.split(arrays[name], cuts[:, column]) for column, name in enumerate(_FIELDS)]
    return [GrainTets(grain, *fields) for grain, *fields in zip(arrays["grain"], *parts)]
