"""Random small polycrystals with voids, embedded grains, noise and cracks; sizes and options for them."""

from dataclasses import dataclass

import numpy as np

from craftmesh import GradateOptions, Sizing, Surface
from craftmesh.cracks.options import CrackOptions
from craftmesh.cracks.series import prescribed_crack
from craftmesh.cracks.triangulated import crack_from_triangles
from craftmesh.errors import CraftmeshError
from craftmesh.insertion.insert import insert_crack
from craftmesh.remeshing.remesh import remesh
from craftmesh.sizing.sizing import densify
from craftmesh.types import Voxels
from craftmesh.voxels.clean import CleanOptions, clean
from craftmesh.voxels.generate import GenerateOptions, generate


@dataclass(frozen=True)
class RandomCase:
    """A surface to gradate, the sizing and the options, what crack it has, and all of it in words."""

    surface: Surface
    sizing: Sizing
    options: GradateOptions
    crack: str
    words: str

    @property
    def default(self) -> bool:
        return self.options == GradateOptions()


def random_case(seed: int, largest: int = 20) -> RandomCase:
    """Return the case of `seed`: everything is drawn at random, 12 to `largest` voxels a side as well."""
    rng = np.random.default_rng(seed)
    voxels, words = random_voxels(rng, largest)
    surface, _ = remesh(voxels)
    l0 = float(voxels.spacing.mean())
    ratio = float(rng.choice([1.0, rng.uniform(1, 8), 8.0], p=[0.15, 0.7, 0.15]))
    l_min = l0 * float(rng.uniform(0.5, 1.2)) if ratio > 1 else l0 * float(rng.uniform(0.6, 4))
    l_max = ratio * l_min
    middle = float(np.clip(l0, l_min, l_max))
    r0 = float(rng.uniform(1, 5)) * l0
    numbers = (
        l_min,
        middle,
        l_max,
        r0,
        r0 + float(rng.uniform(0, 8)) * l0,
        float(rng.choice([0.5, 1.0, 2.0])),
    )
    sources = voxels.box[0] + rng.random((1, 3)) * np.ptp(voxels.box, axis=0)
    kind = str(rng.choice(["none", "penny", "wavy"], p=[0.35, 0.4, 0.25]))
    if kind != "none":
        try:
            crack = random_crack(rng, kind, voxels.box)
            fronts = [densify(crack.points[ids], l_min / 2) for ids in crack.fronts]
            sources = np.concatenate(fronts) if fronts else sources
            surface, _ = insert_crack(surface, crack, Sizing(*numbers, sources))
        except CraftmeshError as error:
            kind = f"none, {error}"
    options = random_options(rng)
    words += f"; {kind}; sizes {np.round(numbers, 3).tolist()}; {options}"
    return RandomCase(surface, Sizing(*numbers, sources), options, kind, words)


def random_voxels(rng: np.random.Generator, largest: int) -> tuple[Voxels, str]:
    """Return raw or cleaned labels and their description."""
    shape = tuple(rng.integers(12, min(largest, 16 if rng.random() < 0.7 else 20) + 1, 3).tolist())
    spacing = (1.0, 1.0, 1.0) if rng.random() < 0.4 else tuple(np.exp(rng.uniform(-0.4, 0.4, 3)).tolist())
    scale = float(rng.choice([1.0, 1.0, 1e-3, 250.0]))
    spacing = tuple(scale * x for x in spacing)
    origin = tuple((scale * rng.uniform(-30, 30, 3)).tolist())
    wanted = {
        "shape": shape,
        "spacing": spacing,
        "origin": origin,
        "grains": int(rng.integers(2, 13)),
        "seed": int(rng.integers(0, 2**31)),
        "relaxation": int(rng.integers(0, 3)),
        "size_spread": float(rng.choice([0.0, 0.6])),
        "columnar_ratio": float(rng.choice([1.0, 1.0, 3.0])),
        "voids": int(rng.choice([0, 0, 1, 2])),
        "void_radius": float(rng.uniform(1.6, 3)) * max(spacing),
        "embedded_grains": int(rng.choice([0, 0, 1])),
        "embedded_pairs": int(rng.choice([0, 0, 1])),
    }
    while True:
        try:
            voxels = generate(GenerateOptions(**wanted))
            break
        except CraftmeshError:
            wanted |= {"voids": max(wanted["voids"] - 1, 0), "embedded_pairs": 0}
            if wanted["voids"] == 0:
                wanted["embedded_grains"] = 0
    noise = str(rng.choice(["no", "noise", "cleaned noise"], p=[0.7, 0.15, 0.15]))
    if noise != "no":
        labels = voxels.labels.copy()
        shuffled = (rng.random(labels.shape) < rng.uniform(0.005, 0.05)) & (labels > 0)
        labels[shuffled] = rng.permutation(labels[shuffled])
        voxels = Voxels(labels, voxels.spacing, voxels.origin)
        if noise == "cleaned noise":
            voxels, _ = clean(voxels, CleanOptions(min_island_voxels=8))
    return voxels, f"{wanted}; {noise}"


def random_crack(rng: np.random.Generator, kind: str, box: np.ndarray):
    """Return a penny or a wavy disc that meets the box, or raise CraftmeshError."""
    size = np.ptp(box, axis=0)
    centre = rng.uniform(0, 1, 3)
    if rng.random() < 0.5:
        centre[rng.integers(3)] = rng.integers(2)
    centre = box[0] + centre * size
    normal = rng.normal(size=3) if rng.random() < 0.7 else np.eye(3)[rng.integers(3)]
    radius = float(rng.uniform(0.15, 0.5) * size.min())
    axis = np.eye(3)[np.abs(normal).argmin()]
    if kind == "penny":
        return prescribed_crack(
            box,
            CrackOptions(centre=tuple(centre), normal=tuple(normal), axis=tuple(axis), radius=radius),
        )
    normal = normal / np.linalg.norm(normal)
    u = np.cross(normal, axis)
    u /= np.linalg.norm(u)
    points, triangles = disc()
    height = rng.uniform(0.02, 0.12) * np.sin(rng.uniform(1, 5) * points[:, 0] + rng.uniform(0, 6))
    height += rng.uniform(0, 0.08) * np.cos(rng.uniform(1, 5) * points[:, 1])
    shape = points @ np.stack([u, np.cross(normal, u)]) + height[:, None] * normal
    return crack_from_triangles(centre + radius * shape, triangles, None, box)


def disc(rings: int = 16, spokes: int = 96) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, 2) and triangles of the unit disc."""
    angle = 2 * np.pi * np.arange(spokes) / spokes
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    points = [np.zeros((1, 2))] + [circle * (k + 1) / rings for k in range(rings)]
    i, j = np.arange(spokes), (np.arange(spokes) + 1) % spokes
    triangles = [np.stack([0 * i, 1 + i, 1 + j], axis=1)]
    for k in range(rings - 1):
        a, b = 1 + k * spokes, 1 + (k + 1) * spokes
        triangles += [np.stack([a + i, b + i, b + j], axis=1), np.stack([a + i, b + j, a + j], axis=1)]
    return np.concatenate(points), np.concatenate(triangles)


def random_options(rng: np.random.Generator) -> GradateOptions:
    """Return the default options in a third of the cases, else ones drawn at random."""
    if rng.random() < 0.34:
        return GradateOptions()
    return GradateOptions(
        normal_tolerance=float(rng.uniform(15, 60)),
        distance_tolerance=float(rng.choice([0.02, 0.15, 0.4])),
        crack_tolerance=float(rng.choice([0.01, 0.04, 0.2])),
        volume_tolerance=float(rng.choice([0.002, 0.02, 0.1])),
        collapse_ratio=float(rng.uniform(0.4, 0.9)),
        split_ratio=float(rng.uniform(1.2, 1.8)),
        passes=int(rng.integers(0, 6)),
        cleaning_passes=int(rng.integers(0, 9)),
        remove_unnecessary_nodes=bool(rng.random() < 0.7),
        release_tied_nodes=bool(rng.random() < 0.3),
        restore_volumes=bool(rng.random() < 0.7),
        junction_smoothing=int(rng.choice([0, 0, 0, 2])),
    )
