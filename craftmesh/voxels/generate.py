"""Synthetic polycrystals: Voronoi or Laguerre grains, laths, foams, voids, embedded grains, and noise."""

import dataclasses
from collections.abc import Sequence

import numpy as np
import scipy

from craftmesh.errors import CraftmeshError
from craftmesh.mechanics.orientation import random_orientations
from craftmesh.types import Voxels
from craftmesh.voxels.clean import number_voids
from craftmesh.voxels.foam import largest_piece, struts
from craftmesh.voxels.options import SMALLEST_RADIUS, GenerateOptions

RAGGED_LENGTH = 1.5  # voxels, correlation length of ragged boundaries; so short that they have steps
_CLEARANCE = 2.0  # voxels, smallest distance of a void from the box, other voids and embedded grains
_TRIALS = 2000  # random centres tried for a void before an error


def stray_offsets(
    shape: tuple[int, int, int], spacing: np.ndarray, amount: float, rng: np.random.Generator
) -> np.ndarray:
    """Return random offsets (nx, ny, nz, 3), in model units, of the points at which voxels get their cell.

    amount: root mean square along each axis, in voxels. The correlation length is RAGGED_LENGTH voxels.
    """
    offsets = np.empty((*shape, 3))
    for axis in range(3):
        field = scipy.ndimage.gaussian_filter(rng.standard_normal(shape), RAGGED_LENGTH, mode="wrap")
        offsets[..., axis] = field * (amount * spacing[axis] / np.sqrt(np.mean(field**2)))
    return offsets


def shuffle_boundaries(labels: np.ndarray, share: float, rounds: int, rng: np.random.Generator) -> None:
    """Change boundary voxels of `labels` (nx, ny, nz) to the grain of a face neighbour, in place.

    In each round, every grain voxel selects one of its six neighbours at random, and gets its grain with
    probability `share`. Voids and the outside do not change.
    """
    for _ in range(rounds):
        padded = np.pad(labels, 1)
        ways = rng.integers(0, 6, labels.shape)
        chance = rng.random(labels.shape) < share
        taken = labels.copy()
        for way in range(6):
            shifted = np.roll(padded, 1 if way % 2 else -1, axis=way // 2)[1:-1, 1:-1, 1:-1]
            chosen = chance & (ways == way) & (labels > 0) & (shifted > 0)
            taken[chosen] = shifted[chosen]
        labels[...] = taken


def generate(options: GenerateOptions = GenerateOptions(), spheres: np.ndarray | None = None) -> Voxels:  # noqa: B008
    """Return a polycrystal with grains 1..n, then embedded grains, then the two of each embedded pair.

    Voids are -1, -2, ... in the order in which they are carved.

    spheres (v, 4): further voids, x, y, z, r in model units. Orientations are random and uniform; all have
    phase 1. The same options give the same voxels. Shuffling and foams may leave grains in pieces, and
    small grains without voxels; use `clean` on such volumes. Of a foam, and if voids may cross, only the
    largest connected piece is kept; voids open to the outside are 0. Raises CraftmeshError for options out
    of range, if there is no space for a void or embedded grain, and if foam struts are under three voxels
    thick.
    """
    rng_cells, rng_embedded, rng_voids, rng_orientations, rng_ragged, rng_shuffled, rng_pores = (
        np.random.default_rng(sequence) for sequence in np.random.SeedSequence(options.seed).spawn(7)
    )
    labels = _cells(options, rng_cells, rng_ragged)
    _embed(labels, options, rng_embedded)
    count = int(labels.max())
    if options.pores:
        labels[~_foam(options, rng_pores)] = 0
    _put_voids(labels, options, np.zeros((0, 4)) if spheres is None else spheres, rng_voids)
    if options.shuffled:
        shuffle_boundaries(labels, options.shuffled, options.shuffle_rounds, rng_shuffled)
    orientations = np.vstack([np.full((1, 4), np.nan), random_orientations(count, rng_orientations)])
    phases = np.minimum(np.arange(count + 1), 1)
    place = np.array(options.spacing, float), np.array(options.origin, float)
    return Voxels(labels, *place, orientations, phases)


def _window(centre: np.ndarray, radius: float, options: GenerateOptions) -> tuple[tuple, np.ndarray]:
    """Return slices of the voxels around a ball, and the offsets (a, b, c, 3) of these from its centre."""
    size = np.array(options.shape)
    low = np.clip(np.floor((centre - radius) / options.spacing).astype(int), 0, size)
    high = np.clip(np.ceil((centre + radius) / options.spacing).astype(int) + 1, 0, size)
    axes = [(np.arange(a, b) + 0.5) * h - c for a, b, h, c in zip(low, high, options.spacing, centre)]
    return tuple(slice(a, b) for a, b in zip(low, high)), _grid(axes)


def _grid(axes: list[np.ndarray]) -> np.ndarray:
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)


def _cells(
    options: GenerateOptions, rng: np.random.Generator, rng_ragged: np.random.Generator
) -> np.ndarray:
    """Return labels 1..grains (nx, ny, nz), cells of a power diagram of random seeds, ragged if requested.

    The cell of smallest power distance |x - s|^2 - w is found as the seed nearest to x, each seed being
    lifted by sqrt(max w - w) along a fourth axis. Source: Aurenhammer, SIAM J. Comput. 16 (1987).
    """
    size = np.array(options.shape) * options.spacing
    stretch = np.ones(3)
    along = "xyz".index(options.columnar_axis)
    stretch[along] = 1 / options.columnar_ratio
    stretch[(along + 1) % 3] = options.lath_ratio
    axes = [(np.arange(n) + 0.5) * h * k for n, h, k in zip(options.shape, options.spacing, stretch)]
    points = _grid(axes).reshape(-1, 3)
    seeds = rng.random((options.grains, 3)) * size * stretch
    width = (np.prod(size * stretch) / options.grains) ** (1 / 3)
    lift = width * np.sqrt(options.size_spread * rng.random(options.grains))
    lifted = np.column_stack([points, np.zeros(len(points))])
    for round_ in range(options.relaxation + 1):
        cell = scipy.spatial.cKDTree(np.column_stack([seeds, lift])).query(lifted)[1]
        if round_ < options.relaxation:
            count = np.bincount(cell, minlength=options.grains)
            sums = np.stack([np.bincount(cell, points[:, i], options.grains) for i in range(3)], axis=1)
            seeds = np.where(count[:, None] > 0, sums / np.maximum(count, 1)[:, None], seeds)
    if options.raggedness:
        strayed = stray_offsets(options.shape, np.array(options.spacing), options.raggedness, rng_ragged)
        lifted[:, :3] += strayed.reshape(-1, 3) * stretch
        cell = scipy.spatial.cKDTree(np.column_stack([seeds, lift])).query(lifted)[1]
    return (cell + 1).astype(np.int32).reshape(options.shape)


def _depth(labels: np.ndarray, spacing: Sequence[float]) -> np.ndarray:
    """Return distances (nx, ny, nz) of voxel centres from the centre of the nearest boundary voxel.

    A boundary voxel has a face neighbour of another label, or lies at a box face; its distance is 0.
    Distances are in the unit of `spacing`.
    """
    padded, beside = np.pad(labels, 1), scipy.ndimage.generate_binary_structure(3, 1)
    is_inner = scipy.ndimage.minimum_filter(padded, footprint=beside) == padded
    is_inner &= scipy.ndimage.maximum_filter(padded, footprint=beside) == padded
    return scipy.ndimage.distance_transform_edt(is_inner, sampling=spacing)[1:-1, 1:-1, 1:-1]


def _embed(labels: np.ndarray, options: GenerateOptions, rng: np.random.Generator) -> None:
    """Embed balls, as grains with new ids, in the grains with most space; changes `labels` in place.

    First come single grains, then balls of two halves, each half a grain.

    Raise CraftmeshError if a ball would be smaller than SMALLEST_RADIUS or there are too few grains.
    """
    wanted = options.embedded_grains + options.embedded_pairs
    if not wanted:
        return
    depth = _depth(labels, options.spacing)
    new_id = int(labels.max())
    room = np.zeros(new_id + 1)
    np.maximum.at(room, labels.ravel(), depth.ravel())
    hosts = np.argsort(-room, kind="stable")[:wanted]
    needed = SMALLEST_RADIUS * max(options.spacing)
    if len(hosts) < wanted or room[hosts[-1]] * options.embedded_fraction < needed:
        raise CraftmeshError(
            f"{wanted} embedded bodies do not fit; set fewer of them, fewer grains, or more voxels (shape)"
        )
    deepest = [np.argwhere((labels == host) & (depth == room[host]))[0] for host in hosts]
    for turn, (host, at) in enumerate(zip(hosts, deepest)):
        radius = room[host] * options.embedded_fraction
        window, offset = _window((at + 0.5) * options.spacing, radius, options)
        ball = (offset**2).sum(axis=-1) <= radius**2
        new_id += 1
        labels[window][ball] = new_id
        normal = rng.normal(size=3)
        if turn >= options.embedded_grains:
            new_id += 1
            labels[window][ball & (offset @ normal > 0)] = new_id


def _foam(options: GenerateOptions, rng: np.random.Generator) -> np.ndarray:
    """Return a mask (nx, ny, nz) of foam struts; pores are equiaxed cells, independent of the grains."""
    cells = dataclasses.replace(
        options,
        grains=options.pores,
        size_spread=options.pore_spread,
        columnar_ratio=1.0,
        lath_ratio=1.0,
        raggedness=0.0,
    )
    foam = options.relative_density, options.strut_growth, options.strut_shape, options.cut_ends
    return struts(_cells(cells, rng, rng), options.spacing, *foam)


def _put_voids(
    labels: np.ndarray, options: GenerateOptions, spheres: np.ndarray, rng: np.random.Generator
) -> None:
    """Carve random voids, then the given spheres (v, 4), from `labels`, in place.

    Material that crossing voids separate from the largest piece becomes outside.
    """
    radii = np.full(options.voids, options.void_radius)
    if options.void_radius_max:
        radii = rng.uniform(options.void_radius, options.void_radius_max, options.voids)
    if not options.voids_cross:
        _carve_apart(labels, radii, options, rng)
    elif options.voids:
        material = np.flatnonzero(labels > 0)
        chosen = np.unravel_index(rng.choice(material, options.voids), labels.shape)
        centres = (np.stack(chosen, axis=1) + rng.random((options.voids, 3))) * options.spacing
        _carve(labels, np.column_stack([centres, radii]), options, 1)
    _carve(labels, spheres - [*options.origin, 0], options, options.voids + 1)
    if options.pores or options.voids_cross or len(spheres):
        labels[(labels > 0) & ~largest_piece(labels > 0)] = 0
        labels[...] = number_voids(labels)


def _carve(labels: np.ndarray, balls: np.ndarray, options: GenerateOptions, first: int) -> None:
    """Change grain voxels in balls (v, 4) to voids `first`, first + 1, ..., in place.

    A ball is its centre relative to options.origin, and its radius.
    """
    for void, (*centre, radius) in enumerate(balls, start=first):
        window, offset = _window(np.array(centre), radius, options)
        ball = ((offset**2).sum(axis=-1) <= radius**2) & (labels[window] > 0)
        labels[window][ball] = -void


def _carve_apart(
    labels: np.ndarray, radii: np.ndarray, options: GenerateOptions, rng: np.random.Generator
) -> None:
    """Carve voids, balls of `radii`, at random centres; changes `labels` in place.

    They keep _CLEARANCE voxels from the box, the outside, other voids and embedded grains. Raise
    CraftmeshError if a void finds no place in _TRIALS trials.
    """
    spacing = np.array(options.spacing)
    for void, radius in enumerate(radii, start=1):
        margin = radius + _CLEARANCE * spacing
        low, high = margin, np.array(options.shape) * spacing - margin
        reach = radius + _CLEARANCE * spacing.max()
        for _ in range(_TRIALS if (low < high).all() else 0):
            window, offset = _window(rng.uniform(low, high), reach, options)
            distance = (offset**2).sum(axis=-1)
            near = labels[window][distance <= reach**2]
            if near.min() > 0 and near.max() <= options.grains:
                labels[window][distance <= radius**2] = -void
                break
        else:
            raise CraftmeshError(
                f"no space for void {void} of {options.voids}; set fewer voids or a smaller void_radius"
            )
