"""Random volumes of 30 to 48 voxels a side: generated ones and crops of measured ones."""

from pathlib import Path

import numpy as np
from cases import DATA

from craftmesh.errors import CraftmeshError
from craftmesh.types import Voxels
from craftmesh.voxels.clean import CleanOptions, clean
from craftmesh.voxels.generate import GenerateOptions, generate
from craftmesh.voxels.reading import read_voxels

MEASURED = {
    "al1050": DATA / "al1050" / "al1050_labdct_109x103x64.npz",
    "al6xn": DATA / "al6xn" / "prisms_al6xn_68x64x46.npz",
}
KINDS = ("cells", "laths", "voids", "embedded", "noise", "al1050", "al6xn")
SHARES = (0.2, 0.15, 0.2, 0.1, 0.15, 0.1, 0.1)
SPECK = 8  # voxels; smaller pieces of noise are absorbed


def draw_volume(rng: np.random.Generator, sides: tuple[int, int] = (30, 48)) -> tuple[Voxels, str]:
    """Return a volume of `sides` (least, most) voxels an edge and its kind.

    Without the measured file that it draws, it takes cells.
    """
    kind = str(rng.choice(KINDS, p=SHARES))
    shape = rng.integers(sides[0], sides[1] + 1, 3)
    if kind in MEASURED and MEASURED[kind].exists():
        return crop(rng, MEASURED[kind], shape), kind
    kind = "cells" if kind in MEASURED else kind
    voxels = _generated(rng, kind, shape)
    if kind == "noise" or (kind == "laths" and rng.random() < 0.5):
        voxels = _ragged(rng, voxels)
    return voxels, kind


def _generated(rng: np.random.Generator, kind: str, shape: np.ndarray) -> Voxels:
    scale = float(rng.choice([1.0, 1.0, 1e-3, 2.5]))
    even = kind != "laths" and rng.random() < 0.6
    spacing = scale * (np.ones(3) if even else np.exp(rng.uniform(-0.4, 0.4, 3)))
    wanted = {
        "shape": tuple(shape.tolist()),
        "spacing": tuple(spacing.tolist()),
        "origin": tuple((scale * rng.choice([0.0, 1.0]) * rng.uniform(-30, 30, 3)).tolist()),
        "grains": int(rng.integers(4, 40)),
        "seed": int(rng.integers(2**31)),
        "relaxation": int(rng.integers(0, 3)),
        "size_spread": float(rng.choice([0.0, 0.6])),
        "columnar_axis": str(rng.choice(["x", "y", "z"])),
        "columnar_ratio": float(rng.uniform(4, 8)) if kind == "laths" else 1.0,
        "voids": int(rng.integers(1, 8)) if kind == "voids" else 0,
        "void_radius": float(rng.uniform(1.6, 5) * spacing.max()),
        "embedded_grains": int(rng.integers(1, 3)) if kind == "embedded" else 0,
        "embedded_pairs": int(rng.integers(0, 2)) if kind == "embedded" else 0,
    }
    while True:
        try:
            return generate(GenerateOptions(**wanted))
        except CraftmeshError:
            fewer = {k: max(wanted[k] - 1, 0) for k in ("voids", "embedded_grains", "embedded_pairs")}
            wanted |= fewer | {"void_radius": max(0.8 * wanted["void_radius"], 1.55 * spacing.max())}


def _ragged(rng: np.random.Generator, voxels: Voxels) -> Voxels:
    """Return the volume with voxels that took a random neighbour's label, specks absorbed."""
    labels = voxels.labels.copy()
    for _ in range(int(rng.integers(1, 4))):
        step = rng.integers(-1, 2, (*labels.shape, 3))
        place = np.stack(np.meshgrid(*map(np.arange, labels.shape), indexing="ij"), axis=-1)
        place = np.clip(place + step, 0, np.array(labels.shape) - 1)
        taken = labels[tuple(np.moveaxis(place, -1, 0))]
        moved = (rng.random(labels.shape) < rng.uniform(0.1, 0.5)) & (labels > 0) & (taken > 0)
        labels[moved] = taken[moved]
    rough = Voxels(labels, voxels.spacing, voxels.origin, voxels.orientations, voxels.phases)
    return clean(rough, CleanOptions(min_island_voxels=SPECK, split_pieces=True))[0]


def crop(rng: np.random.Generator, path: Path, shape: np.ndarray) -> Voxels:
    """Return a random window of a measured volume, cleaned before and after."""
    whole, _ = clean(read_voxels(path), CleanOptions(fill_unindexed=True, min_island_voxels=27))
    shape = np.minimum(shape, whole.labels.shape)
    low = rng.integers(0, np.array(whole.labels.shape) - shape + 1)
    labels = whole.labels[tuple(slice(a, a + n) for a, n in zip(low, shape))]
    origin = whole.origin + low * whole.spacing
    window = Voxels(labels, whole.spacing, origin, whole.orientations, whole.phases)
    return clean(window, CleanOptions(min_island_voxels=27, split_pieces=True))[0]
