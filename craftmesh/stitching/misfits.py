"""Checks that grains form one body: surfaces that collapse, intersect, do not touch or differ in unit."""

from typing import NamedTuple

import numpy as np

from craftmesh.errors import CraftmeshError, rounded_values
from craftmesh.stitching.outer_shells import grain_names
from craftmesh.surface.connectivity import joined
from craftmesh.surface.kernels.triangle_pairs import intersecting_pairs
from craftmesh.surface.measure import area_vectors, span_of
from craftmesh.surface.side_data import are_apart, size_of, spans_told, unit_hint

# Largest fraction of a grain's area in dropped facets; slivers have far less, a wall between two grains far
# more.
LOST = 0.01
MOST_PAIRS = 1000  # limit of the search for intersecting pairs of facets
# Ratio of grain sizes above which grains that touch no others are taken to be in another unit: about the
# geometric mean of 10 and 100.
OTHER_UNIT = 30.0


class _Alone(NamedTuple):
    """An error's text on grains that touch no others, and whether they are apart or in another unit."""

    words: str
    is_elsewhere: bool


def refuse_lost(points: np.ndarray, facets: np.ndarray, grain: np.ndarray, kept: np.ndarray) -> None:
    """Raise CraftmeshError if the dropped facets are over LOST of a grain's area, or all its facets.

    points (n, 3), facets (m, 3), grain (m,): the facets before merging, and their grains' ids. kept (m,):
    False for dropped facets.
    """
    ids, row = np.unique(grain, return_inverse=True)
    area = np.linalg.norm(area_vectors(points, facets), axis=1)
    lost, whole = np.bincount(row, area * ~kept), np.bincount(row, area)
    bad = np.flatnonzero((lost > LOST * whole) | (np.bincount(row, kept) == 0))
    if len(bad):
        own = row == bad[0]
        spans = span_of(points[facets[own]]), span_of(points[facets])
        told_spans = spans_told(("it spans", "all grains"), *spans)
        raise CraftmeshError(
            f"grain {ids[bad[0]]} has {int((~kept[own]).sum())} of its {int(own.sum())} facets, "
            f"{100 * lost[bad[0]] / max(whole[bad[0]], 1e-300):.3g} % of its area, on each other or within "
            f"the tolerance; {told_spans}; expected the surface of one grain in each file, all in one unit"
        )


def refuse_misfits(points: np.ndarray, facets: np.ndarray, sides: np.ndarray) -> None:
    """Raise CraftmeshError if facets intersect, or if grains share no facet with the largest body.

    points (n, 3), facets (m, 3), sides (m, 2): the conformal surface. The message has the grains, the place
    and, for grains that touch no others, the bounding boxes.
    """
    lone = _lone(sides)
    of_lone = np.asarray(np.isin(sides, lone).any(axis=1))
    said = _alone(points[facets], sides, lone, of_lone) if len(lone) else None
    if said and said.is_elsewhere:
        raise CraftmeshError(said.words)
    pairs = intersecting_pairs(points, facets, limit=MOST_PAIRS)
    if len(pairs):
        labels, place = sides[pairs[0]], rounded_values(points[facets[pairs[0]]].mean(axis=(0, 1)))
        names = grain_names(labels[labels > 0])
        raise CraftmeshError(
            f"the surfaces of grains {names} intersect near {place}, "
            f"{len(pairs)} pairs of facets{' or more' * (len(pairs) == MOST_PAIRS)} of grains "
            f"{grain_names(sides[pairs][sides[pairs] > 0])}; expected grains that only touch"
        )
    if said:
        raise CraftmeshError(said.words)


def _lone(sides: np.ndarray) -> np.ndarray:
    """Return the ids of grains that do not belong to the largest body; none if all are one body.

    Grains that share facets form a body. Of several smaller bodies the first one's grains are returned.
    """
    ids = np.unique(sides[sides > 0])
    met = np.searchsorted(ids, sides[(sides > 0).all(axis=1)])
    body = joined(len(ids), *met.T)
    size = np.bincount(body)
    others = np.flatnonzero(np.arange(len(size)) != size.argmax())
    return ids[body == others[0]] if len(others) else ids[:0]


def _alone(corners: np.ndarray, sides: np.ndarray, lone: np.ndarray, of_lone: np.ndarray) -> _Alone:
    """Return the message on grains that share no facet with the others.

    corners (m, 3, 3), sides (m, 2): all facets; lone: ids of these grains; of_lone (m,): mask of facets
    of these grains.
    """
    spans = span_of(corners[of_lone]), span_of(corners[~of_lone])
    sizes = [_usual_size(corners[own], sides[own]) for own in (of_lone, ~of_lone)]
    is_of_other_unit = max(sizes) > OTHER_UNIT * min(sizes)
    place = corners[of_lone][0, 0]
    host = _grain_round(place, corners[~of_lone], sides[~of_lone])
    all_spans = spans_told(("they span", "the others"), *spans)
    hint = unit_hint(*spans, sizes[0] / sizes[1]) if is_of_other_unit else ""
    words = (
        f"grains {grain_names(lone)} lie {f'inside grain {host}' if host else 'off the others'}, near "
        f"{rounded_values(place)}, sharing no facet with any; {all_spans}{hint}; "
        "expected grains that touch, all in one unit: fix these files, or leave them out"
    )
    return _Alone(words, is_of_other_unit or are_apart(*spans))


def _usual_size(corners: np.ndarray, sides: np.ndarray) -> float:
    """Return the median diagonal of the bounding boxes of grains; corners (m, 3, 3), sides (m, 2)."""
    own = (corners[(sides == grain).any(axis=1)] for grain in np.unique(sides[sides > 0]).tolist())
    return float(np.median([size_of(span_of(one)) for one in own]))


def _grain_round(place: np.ndarray, corners: np.ndarray, sides: np.ndarray) -> int:
    """Return the id of the grain that contains a point (3,), by solid angles of its facets; 0 if none."""
    a, b, c = np.moveaxis(corners - place, 1, 0)
    to_a, to_b, to_c = (np.linalg.norm(way, axis=1) for way in (a, b, c))
    over = np.einsum("ij,ij->i", a, np.cross(b, c))
    under = to_a * to_b * to_c + (a * b).sum(1) * to_c + (b * c).sum(1) * to_a + (c * a).sum(1) * to_b
    share = np.arctan2(over, under) / (2 * np.pi)  # fraction of the whole sphere
    for grain in np.unique(sides[sides > 0]).tolist():
        if share[sides[:, 0] == grain].sum() - share[sides[:, 1] == grain].sum() > 0.5:
            return grain
    return 0
