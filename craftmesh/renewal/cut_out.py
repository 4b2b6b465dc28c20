"""Cut tetrahedra out of a model as a separate body, whose border inside the grains must not change."""

from dataclasses import dataclass

import numpy as np

from craftmesh.mesh.tet_connectivity import facet_groups, half_face_corners
from craftmesh.renewal.whole import Whole, grouped_tets
from craftmesh.surface.connectivity import compact
from craftmesh.types import BORDER, CRACK, INTERFACE, GrainTets, Surface


@dataclass(frozen=True)
class Part:
    """Tetrahedra of a model as a separate body.

    surface: the boundary of the body, with grain boundaries and crack inside it. Facets shared with tets
    that stay in the model are of kind BORDER and have the label 0 on the side of these tets. nodes (n,):
    the model's node of each point of the surface. chosen (m,): mask of the model's tets in the body. gone
    (f,): mask of the model's facets that the body replaces.
    """

    surface: Surface
    nodes: np.ndarray
    chosen: np.ndarray
    gone: np.ndarray


def cut_out(whole: Whole, chosen: np.ndarray, with_crack: bool) -> Part:
    """Return the tets of a model in the mask `chosen` (m,) as a separate body.

    with_crack: whether the body keeps the facets of the crack. If not, crack facets between grains become
    grain boundaries, and crack facets inside grains are left out.
    """
    surface, rows = whole.surface, np.flatnonzero(chosen)
    tets, grain = whole.tets[rows], whole.grain[rows]
    inside = np.zeros(len(whole.points), bool)
    inside[tets] = True
    near = np.flatnonzero(inside[surface.facets].all(axis=1))
    groups, facet, count = facet_groups(tets, surface.facets[near])
    has = surface.sides <= 0
    there = np.zeros(len(has), bool)
    for k in range(2):  # a facet has one or two half faces, the faces of the tets at it
        mine = (facet >= 0) & (count > k)
        half, row = groups.order[groups.first[:-1][mine] + k], near[facet[mine]]
        has[row] |= surface.sides[row] == grain[half // 4][:, None]
        there[row] = True
    gone = there & has.all(axis=1)
    sides, kind = np.where(has, surface.sides, 0), np.where(gone, surface.kind, BORDER)
    if not with_crack:
        on_crack = gone & (kind == CRACK)
        kind[on_crack] = INTERFACE
        there &= ~(on_crack & (sides[:, 0] == sides[:, 1]))
    cut = groups.lead[(facet < 0) & (count == 1)]
    border = np.stack([np.zeros(len(cut), np.int32), grain[cut // 4]], axis=1)
    facets = np.concatenate([surface.facets[there], half_face_corners(tets, cut)])
    points, facets, nodes = compact(whole.points, facets)
    kinds = np.concatenate([kind[there], np.full(len(cut), BORDER)])
    return Part(Surface(points, facets, np.concatenate([sides[there], border]), kinds), nodes, chosen, gone)


def tets_of(whole: Whole, part: Part) -> list[GrainTets]:
    """Return the tets of a part of a model, grain by grain, with ids of points of the part's surface."""
    number = np.full(len(whole.points), -1)
    number[part.nodes] = np.arange(len(part.nodes))
    return grouped_tets(whole, np.flatnonzero(part.chosen), number)[0]
