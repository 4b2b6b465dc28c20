"""Bounds for fitted cracks: the point cloud against its front, and the distance of the fit from both."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy

from craftmesh.errors import CraftmeshError
from craftmesh.surface.measure import span_of
from craftmesh.surface.side_data import are_apart, size_of, spans_told, unit_hint

# Allowed ratio of cloud to front size: below, most of the crack is guessed; above, units or objects differ.
LEAST, MOST = 0.3, 30.0
BESIDE = 0.25  # largest gap between cloud and front, in diagonals of the front's bounding box
NEIGHBOURS = 12  # nearest points to which a plane is fitted for the scatter
SAMPLED = 2000  # approximate number of points at which the scatter is measured
# Largest error of a fit relative to the points' scatter; noise alone gives 1, so more means another shape.
SCATTERS = 3.0
# Largest error of a fit, in voxel edges: half a diagonal (0.9) if the layer is one voxel thick, twice that
# if it is thicker.
VOXELS = 2.0

Numbers = dict[str, Any]  # report of a fit: numbers by name, and notes


def refuse_other_place(cloud: np.ndarray, fronts: Sequence[np.ndarray]) -> None:
    """Raise CraftmeshError if a cloud (n, 3) lies apart from its fronts (k, 3), or its size is not similar.

    The ratio of their bounding boxes' sizes must be between LEAST and MOST.
    """
    spans = span_of(cloud), span_of(np.concatenate(fronts))
    ratio = size_of(spans[0]) / max(size_of(spans[1]), np.finfo(float).tiny)
    is_beside = are_apart(*spans, BESIDE * size_of(spans[1]))
    if is_beside or not LEAST < ratio < MOST:
        fault = "no point of the cloud is within the front" if is_beside else "the cloud has another size"
        text = spans_told(("the cloud goes", "the front"), *spans) + unit_hint(*spans)
        raise CraftmeshError(f"{fault}: {text}; give both in the same unit and position")


def notes_on_size(points: np.ndarray, box: np.ndarray, l_min: float) -> list[str]:
    """Return a note if a crack with points (n, 3) is over MOST times as large as the box (2, 3), else none.

    Raise CraftmeshError if the crack is smaller than l_min, the shortest edge of its mesh.
    """
    span = span_of(points)
    text = spans_told(("the crack goes", "the box"), span, box) + unit_hint(span, box)
    if size_of(span) < l_min:
        raise CraftmeshError(
            f"{text}; the crack must be larger than l_min, {l_min:.4g}: give it in the unit of the box"
        )
    return [text] if size_of(span) > MOST * size_of(box) else []


def refuse_step(cloud: np.ndarray, fronts: Sequence[np.ndarray], length: float) -> None:
    """Raise CraftmeshError if the front lies above or below the cloud by more than `length`.

    cloud (n, 3), fronts (k, 3): u, v and height over the crack's plane. The test value is the median height
    difference between front points and their nearest cloud points in (u, v); front points without a cloud
    point within twice `length` do not count.
    """
    front = np.concatenate(fronts)
    distance, nearest = scipy.spatial.cKDTree(cloud[:, :2]).query(front[:, :2])
    step = (front[:, 2] - cloud[nearest, 2])[distance < 2 * length]
    if len(step) and abs(np.median(step)) > length:
        raise CraftmeshError(
            f"the front lies {abs(np.median(step)):.4g} {'over' if np.median(step) > 0 else 'under'} the "
            f"nearest points of the cloud, which are about {length / 2:.4g} apart; expected a front on the "
            "cloud's surface: give both in the same unit and position"
        )


def scatter_of(cloud: np.ndarray) -> float:
    """Return the median scatter of points (n, 3) about planes fitted to neighbours; 0 below five points."""
    count = min(NEIGHBOURS, len(cloud))
    if count < 5:
        return 0.0
    some = cloud[:: max(len(cloud) // SAMPLED, 1)]
    near = cloud[scipy.spatial.cKDTree(cloud).query(some, k=count)[1]]
    least = np.linalg.svd(near - near.mean(axis=1, keepdims=True), compute_uv=False)[:, 2]
    return float(np.median(least) / np.sqrt(count - 3))


def within_bound(numbers: Numbers, bound: float, words: str) -> Numbers:
    """Return a fit's report `numbers`, with a note if the largest deviation exceeds the bound.

    words: names the bound and what to do. Raise CraftmeshError if the root-mean-square deviation exceeds
    it.
    """
    rms, most = numbers["deviation_rms"], numbers["deviation_most"]
    text = f"the fitted crack is {rms:.4g} (root mean square) and at most {most:.4g} away from its points"
    if rms > bound:
        raise CraftmeshError(f"{text}, over {words}")
    return numbers | {"notes": [f"{text}, which is over {words}"]} if most > bound else numbers
