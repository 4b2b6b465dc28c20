"""Remeshing: from labelled voxels to a smooth, conformal surface without self-intersections."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import scipy

from craftmesh.arguments import typed
from craftmesh.errors import CraftmeshError, rounded_values
from craftmesh.options import Options, option
from craftmesh.progress import silent
from craftmesh.remeshing.kernels.marching import march
from craftmesh.surface.classification import Classification
from craftmesh.surface.guarded_move import SMOOTHING, MoveBounds, guarded_move
from craftmesh.surface.measure import enclosed, facet_angles, numbered
from craftmesh.surface.patches import PLANES
from craftmesh.surface.smoothing import lapped, smoothing_neighbours
from craftmesh.surface.volumes import restore_volumes
from craftmesh.types import Surface, Voxels

# Voxels, about a voxel's diagonal: larger moves get a note. Default smoothing moves points by 0.7 to 0.8.
FAR = 1.75


@dataclass(frozen=True)
class RemeshOptions(Options):
    """Options of the stage `remesh`."""

    laplace_laps: int = option(4, "passes of Laplacian smoothing, to remove the voxel steps", at_least=0)
    taubin_laps: int = option(
        20, "pairs of Taubin's inward and outward passes, which keep volumes", at_least=0
    )
    laplace_weight: float = option(
        0.5, "fraction of the way to its neighbours' mean that a point moves inward", at_least=0, at_most=1
    )
    taubin_weight: float = option(
        -0.53, "the same fraction in Taubin's outward passes, negative", at_least=-1, at_most=0
    )
    sliver_quality: float = option(
        SMOOTHING.quality, "smoothing is undone at facets of lower quality (best: 1)", at_least=0, below=1
    )
    sliver_edge: float = option(
        SMOOTHING.edge,
        "smoothing is undone at facets with a shorter edge",
        "voxels",
        at_least=0,
        below=1,
    )
    least_volume: float = option(
        0.5,
        "smoothing is undone at grains that shrink below this fraction of their volume",
        at_least=0,
        at_most=1,
    )
    volume_rounds: int = option(
        8, "most corrections of the grains' volumes; 0: they stay as smoothed", at_least=0
    )


@typed
def remesh(
    voxels: Voxels, options: RemeshOptions | None = None, progress: Callable[[float, str], None] = silent
) -> tuple[Surface, dict]:
    """Return the smoothed surface of all grains of `voxels`, in model units, and a report.

    The surface is conformal, and closed and oriented for each grain. The planes, edges and corners of the
    box are exact. No two facets intersect. Raises CraftmeshError if there is no grain.
    """
    options = options or RemeshOptions()
    if not (voxels.labels > 0).any():
        raise CraftmeshError("the volume has no label > 0; expected at least one grain")
    progress(0.0, "marching cubes")
    raw = Surface(*march(voxels.labels))
    progress(0.3, "smoothing")
    points, frozen = smooth(raw, options, progress)
    surface = Surface(_in_model_units(points, raw, voxels), raw.facets, raw.sides, raw.kind)
    surface, volumes = restore_volumes(
        surface,
        voxel_volumes(voxels),
        MoveBounds(quality=options.sliver_quality, edge=options.sliver_edge * float(voxels.spacing.min())),
        options.volume_rounds,
        progress=lambda fraction, text: progress(0.7 + 0.3 * fraction, text),
    )
    moves = np.linalg.norm((surface.points - voxels.origin) / voxels.spacing - raw.points, axis=1)
    report = {
        "facets": len(surface.facets),
        "points": len(surface.points),
        "frozen_points": frozen,
        "largest_move_voxels": float(moves.max()),
        "smallest_angle": float(facet_angles(surface.points, surface.facets).min()),
        "volumes": volumes,
    }
    if moves.max() > FAR:
        report["notes"] = [
            f"smoothing moves points by up to {moves.max():.3g} voxels, over {FAR:g}, a voxel's diagonal, "
            f"at {rounded_values(surface.points[moves.argmax()])}: fewer laps keep points closer to the "
            f"voxels"
        ]
    return surface, report


def voxel_volumes(voxels: Voxels) -> dict[int, float]:
    """Return the voxel volume, in model units, of each grain and of each void enclosed by grains."""
    labels, count = np.unique(voxels.labels, return_counts=True)
    within = (labels > 0) | ((labels < 0) & ~np.isin(labels, _voids_at_the_outside(voxels.labels)))
    volume = count * voxels.spacing.prod()
    return {int(label): float(v) for label, v in zip(labels[within], volume[within])}


def _voids_at_the_outside(labels: np.ndarray) -> np.ndarray:
    """Return labels < 0 that touch the box, the outside or another void, where no facets are made."""
    met = []
    for axis in range(3):
        line = np.moveaxis(labels, axis, 0)
        met += [line[0].ravel(), line[-1].ravel()]
        below, above = line[:-1], line[1:]
        open_pair = (below <= 0) & (above <= 0) & (below != above)
        met += [below[open_pair], above[open_pair]]
    found = np.unique(np.concatenate(met))
    return found[found < 0]


def _in_model_units(points: np.ndarray, raw: Surface, voxels: Voxels) -> np.ndarray:
    """Return points (n, 3), given in voxels, in model units; points on box planes are exact."""
    placed = voxels.origin + voxels.spacing * points
    for plane, axis, upper in PLANES:
        placed[raw.facets[raw.kind == plane].ravel(), axis] = voxels.box[int(upper), axis]
    return placed


def smooth(
    raw: Surface,
    options: RemeshOptions,
    progress: Callable[[float, str], None] = silent,
) -> tuple[np.ndarray, int]:
    """Return smoothed points (n, 3) of a raw surface in voxel units, and the number of frozen points.

    Smoothing weights all neighbours equally, so smoothing in voxels equals smoothing in model units for any
    spacing; only the sliver limits are in voxels. The raw surface must have no intersections; the result
    has none either. Facets that intersect, become slivers or bound a grain below its `least` volume return
    to the last checkpoint, with a growing neighbourhood, and stay there.
    """
    classes = Classification(raw)
    drawn, on_box = smoothing_neighbours(classes), classes.held
    del classes  # takes as much memory as the surface
    points, fixed = raw.points, on_box.copy()
    labels, place = numbered(raw.sides)
    place = place.astype(np.int32)
    least = options.least_volume * np.maximum(enclosed(points, raw.facets, place, len(labels)), 0.0)
    least[labels == 0] = 0.0

    def vanished(points: np.ndarray) -> np.ndarray:
        """Return a mask (m,) of facets of grains and voids whose volume is below their `least` volume."""
        gone = (enclosed(points, raw.facets, place, len(labels)) < least) & (least > 0)
        return gone[place].any(axis=1) if gone.any() else np.zeros(len(place), bool)

    bounds = replace(SMOOTHING, quality=options.sliver_quality, edge=options.sliver_edge)
    laplace = [options.laplace_weight] * options.laplace_laps
    taubin = [options.laplace_weight, options.taubin_weight] * options.taubin_laps
    stages = [stage for stage in (laplace[:1], laplace[1:], taubin) if stage]  # between checkpoints
    for number, weights in enumerate(stages):
        targets = partial(_targets, points, weights, drawn, fixed)
        points, held = guarded_move(replace(raw, points=points), targets, bounds, vanished)
        fixed[held] = True
        progress(0.3 + 0.4 * (number + 1) / len(stages), "smoothing")
    return points, int(fixed.all(axis=1).sum() - on_box.all(axis=1).sum())


def _targets(
    points: np.ndarray,
    weights: list[float],
    drawn: "scipy.sparse.csr_array",
    fixed: np.ndarray,
    held: np.ndarray,
) -> np.ndarray:
    """Return points (n, 3) after smoothing passes; fixed (n, 3) coordinates and held (n,) points stay.

    weights: one per pass; drawn: the neighbours of `smoothing_neighbours`.
    """
    return lapped(points, weights, drawn, fixed | held[:, None])
