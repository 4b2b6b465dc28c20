"""Bounds on what a crack is fitted to: a cloud by its front, and how far the surface may be off both."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy

from craftmesh.errors import CraftmeshError
from craftmesh.surface.measure import span_of
from craftmesh.surface.side_data import are_apart, size_of, spans_told, unit_hint

# of a front's width: a cloud over less leaves most of the crack to guess, one over more is of another size
LEAST, MOST = 0.3, 30.0
BESIDE = 0.25  # of the front's diagonal: a cloud this far beside it is of another place
NEIGHBOURS = 12  # points of which the scatter about a plane is taken
SAMPLED = 2000  # of the points, for their scatter
SCATTERS = 3.0  # a surface is off random points by one scatter; one that is by more has another shape
VOXELS = 2.0  # a voxel's half diagonal, 0.9, for a layer of one voxel; as much again for thicker ones

Numbers = dict[str, Any]  # of a report, and its notes


def refuse_other_place(cloud: np.ndarray, fronts: Sequence[np.ndarray]) -> None:
    """Raise CraftmeshError where a cloud (n, 3) is off its fronts (k, 3), or of another size."""
    spans = span_of(cloud), span_of(np.concatenate(fronts))
    ratio = size_of(spans[0]) / max(size_of(spans[1]), np.finfo(float).tiny)
    is_beside = are_apart(*spans, BESIDE * size_of(spans[1]))
    if is_beside or not LEAST < ratio < MOST:
        fault = "no point of the cloud is within the front" if is_beside else "the cloud is of another size"
        text = spans_told(("it goes", "the front"), *spans) + unit_hint(*spans)
        raise CraftmeshError(f"{fault}: {text}; expected both in one unit and place")


def notes_on_size(points: np.ndarray, box: np.ndarray, l_min: float) -> list[str]:
    """Return a sentence on a given crack whose points (n, 3) go far past the box (2, 3), or none.

    Raises CraftmeshError for a crack that is smaller than l_min, the shortest edge of its mesh.
    """
    span = span_of(points)
    text = spans_told(("the crack goes", "the box"), span, box) + unit_hint(span, box)
    if size_of(span) < l_min:
        raise CraftmeshError(
            f"{text}; expected a crack larger than l_min, {l_min:.4g}, in the unit of the box"
        )
    return [text] if size_of(span) > MOST * size_of(box) else []


def refuse_step(cloud: np.ndarray, fronts: Sequence[np.ndarray], length: float) -> None:
    """Raise CraftmeshError where the front runs over or under the cloud by more than a length.

    cloud (n, 3), fronts (k, 3): u, v and height. The middle one of the steps to the nearest points counts;
    points of the front without any within twice the length do not.
    """
    front = np.concatenate(fronts)
    distance, nearest = scipy.spatial.cKDTree(cloud[:, :2]).query(front[:, :2])
    step = (front[:, 2] - cloud[nearest, 2])[distance < 2 * length]
    if len(step) and abs(np.median(step)) > length:
        raise CraftmeshError(
            f"the front lies {abs(np.median(step)):.4g} {'over' if np.median(step) > 0 else 'under'} the "
            f"point cloud beside it, whose points are some {length / 2:.4g} apart; expected a front on the "
            "surface that the points are of: give both in one unit and place"
        )


def scatter_of(cloud: np.ndarray) -> float:
    """Return the usual scatter of points (n, 3) about planes through their nearest neighbours."""
    count = min(NEIGHBOURS, len(cloud))
    if count < 5:
        return 0.0
    some = cloud[:: max(len(cloud) // SAMPLED, 1)]
    near = cloud[scipy.spatial.cKDTree(cloud).query(some, k=count)[1]]
    least = np.linalg.svd(near - near.mean(axis=1, keepdims=True), compute_uv=False)[:, 2]
    return float(np.median(least) / np.sqrt(count - 3))


def within_bound(numbers: Numbers, bound: float, words: str) -> Numbers:
    """Return a fit's report, with a note where single points are off the surface by more than the bound.

    words: what the bound is, and what to do. Raises CraftmeshError where all are in the root mean square.
    """
    rms, most = numbers["deviation_rms"], numbers["deviation_most"]
    text = f"the fitted crack is off its points by {rms:.4g} in the root mean square and {most:.4g} at most"
    if rms > bound:
        raise CraftmeshError(f"{text}, over {words}")
    return numbers | {"notes": [f"{text}, which is over {words}"]} if most > bound else numbers
