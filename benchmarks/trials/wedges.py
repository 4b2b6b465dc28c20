"""Wedges: the angles between neighbouring facets of one grain at an edge, of a surface as it is."""

import numpy as np
from scipy.spatial import cKDTree

from craftmesh.types import Surface
from trials.distances import to_each_segment, told

SHARP = 12.0  # degrees
NEAR = 2.0  # target lengths: input wedges this near a place count as the input's wedge there


def wedges(surface: Surface) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return edges (k, 2), the least wedge of a grain at each (degrees, 360 for none), and its grain."""
    facets, points = surface.facets.astype(np.int64), surface.points
    a, b = facets.T.ravel(), np.roll(facets, -1, axis=1).T.ravel()
    c = np.roll(facets, -2, axis=1).T.ravel()
    row = np.tile(np.arange(len(facets)), 3)
    edges, edge = np.unique(np.sort(np.stack([a, b], 1), axis=1), axis=0, return_inverse=True)
    edge = edge.ravel()
    start = points[edges[edge, 0]]
    along = points[edges[edge, 1]] - start
    along /= np.maximum(np.linalg.norm(along, axis=1), 1e-300)[:, None]
    first, second = _across(along)
    apex = points[c] - start
    angle = np.arctan2(np.einsum("ij,ij->i", apex, second), np.einsum("ij,ij->i", apex, first))
    # a facet that runs along its edge a -> b as the edge does has its normal towards growing angles
    ahead = a == edges[edge, 0]
    following = np.where(ahead, surface.sides[row, 1], surface.sides[row, 0])
    order = np.lexsort((angle, edge))
    angle, edge, following = angle[order], edge[order], following[order]
    begins = np.concatenate([[True], edge[1:] != edge[:-1]])
    ends = np.concatenate([begins[1:], [True]])
    next_angle = np.empty(len(angle))
    next_angle[:-1] = angle[1:]
    next_angle[ends] = angle[begins] + 2 * np.pi
    gap = np.where(following > 0, np.degrees(next_angle - angle), 360.0)
    least = np.lexsort((gap, edge))[begins.cumsum().searchsorted(np.arange(1, len(edges) + 1))]
    return edges, gap[least], following[least]


def _across(along: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return two unit vectors across each unit vector (n, 3), right-handed with it."""
    other = np.eye(3)[np.abs(along).argmin(axis=1)]
    first = np.cross(along, other)
    first /= np.maximum(np.linalg.norm(first, axis=1), 1e-300)[:, None]
    return first, np.cross(along, first)


def check_wedges(inserted: Surface, gradated: Surface, sizing) -> dict:
    """Return the least wedges before and after, and those that neither 12 degrees nor the input allow."""
    edges_before, before, _ = wedges(inserted)
    edges_after, after, grain = wedges(gradated)
    sharp = np.flatnonzero(after < SHARP)
    places = gradated.points[edges_after[sharp]].mean(axis=1)
    allowed = np.minimum(local_least(inserted, edges_before, before, places, sizing), SHARP)
    made = sharp[after[sharp] < allowed - 0.05]
    worst = int(after.argmin())
    report = {
        "wedge_before": float(before.min()),
        "wedge_after": float(after.min()),
        "wedges_under_12": len(sharp),
        "wedges_made": len(made),
    }
    if len(made):
        worst = int(made[after[made].argmin()])
        near = float(allowed[sharp == worst][0])
        place = told(gradated.points[edges_after[worst]].mean(axis=0))
        report |= {
            "made_wedge": float(after[worst]),
            "made_from": near,
            "made_at": place,
            "made_in": int(grain[worst]),
        }
    return report


def local_least(
    surface: Surface, edges: np.ndarray, angle: np.ndarray, places: np.ndarray, sizing
) -> np.ndarray:
    """Return the least wedge of `surface` within NEAR target lengths of each place (n, 3)."""
    sharp = np.flatnonzero(angle < 2 * SHARP)
    least = np.full(len(places), 360.0)
    if not len(sharp) or not len(places):
        return least
    ends = surface.points[edges[sharp]]
    half = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).max() / 2
    tree, reach = cKDTree(ends.mean(axis=1)), NEAR * sizing.at(places)
    for i, rows in enumerate(tree.query_ball_point(places, reach + half)):
        near = to_each_segment(places[[i]], *ends[rows].swapaxes(0, 1))[0] <= reach[i]
        least[i] = angle[sharp[rows]][near].min(initial=360.0)
    return least
