"""The crack's facets: the patch between front and traces, fine enough for where the crack bends."""

from dataclasses import replace

import numpy as np

from craftmesh.insertion.bends import Bends, follow, part
from craftmesh.insertion.cut import CutSurface, SizeAt, flat_facets
from craftmesh.insertion.front_chain import FrontChain
from craftmesh.insertion.patch import (
    front_chords,
    refine,
    split_chords,
    triangulate,
    wall_chords,
)
from craftmesh.insertion.sheet import Sheet
from craftmesh.surface.classification import Classification
from craftmesh.surface.patches import patches
from craftmesh.types import Surface

PARTINGS = 8  # rounds of smaller facets where the crack would meet a grain boundary beside its trace


def with_patch(
    cut: CutSurface, sheet: Sheet, front: FrontChain, traces: np.ndarray, target: SizeAt, least: float
) -> tuple[CutSurface, np.ndarray, np.ndarray]:
    """Return the cut surface with the patch's points, its triangles (t, 3) and their fixed edges (t, 3).

    target: the wished lengths, least: the least of them. Raises CraftmeshError as triangulate does.
    """
    uv = np.concatenate([sheet.uv(cut.points), front.uv])
    points = np.concatenate([cut.points, sheet.lift(front.uv)])
    segments = np.unique(np.sort(np.concatenate([front.edges[:, :2], traces]), axis=1), axis=0)
    loose = np.flatnonzero((cut.psi == 0) & (cut.phi > 0))
    nodes = np.unique(np.concatenate([segments.ravel(), loose]))
    local = np.full(len(uv), -1)
    local[nodes] = np.arange(len(nodes))
    kept = local[cut.facets[flat_facets(cut)]]
    kept = kept[(kept >= 0).all(axis=1)]
    patch = triangulate(
        uv[nodes], local[segments], np.setdiff1d(local[loose], local[segments]), sheet.rim.inside
    )
    patch = refine(patch, lambda at: _in_plane(target, sheet, at), kept)
    on_front = np.zeros(len(uv), bool)
    on_front[front.edges[:, :2]] = True
    bends = Bends(sheet, points[nodes], least, kept)
    chords = [front_chords(on_front[nodes])]
    if not sheet.planar:
        chords.append(wall_chords(_walls(cut, nodes, len(uv))))
        follow(patch, bends)
    for is_chord in chords:
        split_chords(patch, is_chord)
    if not sheet.planar:
        for _ in range(PARTINGS):
            if not part(patch, bends, cut.points[cut.facets], local[cut.facets]):
                break
            follow(patch, bends)
            for is_chord in chords:
                split_chords(patch, is_chord)
    ids = np.concatenate([nodes, len(uv) + np.arange(patch.used[0] - len(nodes))])
    points = np.concatenate([points, sheet.lift(patch.uv[len(nodes) : patch.used[0]])])
    return replace(cut, points=points), ids[patch.triangles], patch.fixed[: patch.used[1]]


def _in_plane(target: SizeAt, sheet: Sheet, uv: np.ndarray) -> np.ndarray:
    """Return the wished lengths (n,) as they are seen at (u, v), the stretch of areas taken out."""
    points = sheet.lift(uv)
    return target(points) / np.sqrt(np.linalg.norm(sheet.gradient(points), axis=1))


def _walls(cut: CutSurface, nodes: np.ndarray, count: int) -> np.ndarray:
    """Return (k, w) bool: which of the k nodes lie on each wall, a grain boundary, void or box plane."""
    rows = np.flatnonzero((cut.psi[cut.facets] == 0).any(axis=1))
    near = Surface(cut.points, cut.facets[rows], cut.sides[rows], cut.kind[rows])
    patch = patches(near)
    on = np.zeros((count, len(patch.first_facet) + 3), bool)
    on[near.facets, patch.of_facet[:, None]] = True
    on[: len(cut.points), -3:] = Classification(near).held
    return on[nodes]
