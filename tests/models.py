"""Models that several rooms test on."""

from pathlib import Path

import numpy as np

from craftmesh.remeshing.remesh import remesh
from craftmesh.types import Surface, Voxels
from craftmesh.voxels.generate import GenerateOptions, generate


def voronoi(seed: int, grains: int, shape: tuple, place: float = 0.5, **grid) -> Voxels:
    """Voronoi cells on a grid of voxels, each of which counts at `place` of its edges."""
    seeds = np.random.default_rng(seed).random((grains, 3)) * shape
    at = np.moveaxis(np.indices(shape), 0, -1) + place
    nearest = ((at[..., None, :] - seeds) ** 2).sum(axis=-1).argmin(axis=-1)
    labels = np.unique(nearest, return_inverse=True)[1].reshape(shape) + 1
    return Voxels(labels, grid.get("spacing", (1.0, 1.0, 1.0)), grid.get("origin", (0.0, 0.0, 0.0)))


def with_voids(edge: int, grains: int, seed: int, void_radius: float, origin: tuple) -> Surface:
    """The smoothed surface of a cube of grains with two voids and an embedded grain."""
    options = GenerateOptions(
        shape=(edge,) * 3,
        origin=origin,
        grains=grains,
        seed=seed,
        voids=2,
        void_radius=void_radius,
        embedded_grains=1,
    )
    return remesh(generate(options))[0]


def real_grains(shared_data: Path) -> tuple[Surface, np.ndarray]:
    """The surface of 26 grains of a real microstructure, and a polyline for a crack's front in it."""
    data = np.load(shared_data / "stl" / "g26.npz")
    points, facets = data["points"].astype(float), data["triangles"]
    sides, kind = data["sides"].astype(np.int32), np.zeros(len(facets), np.uint8)
    for axis in range(3):
        for upper, plane in enumerate((points[:, axis].min(), points[:, axis].max())):
            flat = (points[facets][:, :, axis] == plane).all(axis=1) & (sides == 0).any(axis=1)
            kind[flat] = 1 + 2 * axis + upper
    return Surface(points, facets, sides, kind), data["front"]
