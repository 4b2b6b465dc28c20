"""The crack's facets: the patch between front and traces, fine enough for where the crack bends."""

from dataclasses import replace

import numpy as np

from craftmesh.insertion.bends import Bends, follow, part
from craftmesh.insertion.creases import BENT, Creases, creases_of, lay_kinks
from craftmesh.insertion.cut import CutSurface, SizeAt
from craftmesh.insertion.front_chain import FrontChain
from craftmesh.insertion.patch import (
    front_chords,
    loosen,
    refine,
    smooth_points,
    split_chords,
    triangulate,
    wall_chords,
)
from craftmesh.insertion.sheet import Sheet
from craftmesh.surface.patches import held_by_box, patches
from craftmesh.types import Surface

ON_KINK = 0.05  # of the least length: points this near a kink are not smoothed away from it
# Of the least length: joined kinks this near the crack all along stay edges of the patch. One that was let
# go had a facet across it, 0.160 off; one that was kept and bent by 0.4 between its points did harm.
STRAIGHT = 0.02
SHARES = (0.25, 0.5, 0.75)  # of an edge: where it is looked at
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
    kinks = creases_of(sheet, least, BENT)
    patch, laid = lay_kinks(patch, kinks, lambda at: _in_plane(target, sheet, at), least)
    patch = refine(patch, lambda at: _in_plane(target, sheet, at), kept)
    straight = _are_straight(sheet, patch.uv[laid], STRAIGHT * least)
    loosen(patch, laid[~straight])
    on_front = np.zeros(len(uv), bool)
    on_front[front.edges[:, :2]] = True
    bends = Bends(sheet, points[nodes], least, kept)
    chords = [front_chords(on_front[nodes])]
    if not sheet.planar:
        chords.append(wall_chords(_walls(cut, nodes, len(uv))))
        follow(patch, bends)
    first = patch.used[0].copy()
    for is_chord in chords:
        split_chords(patch, is_chord)
    smooth_points(patch, _beside(kinks, patch.uv, np.arange(first, patch.used[0]), least))
    if not sheet.planar:
        for _ in range(PARTINGS):
            if not part(patch, bends, cut.points[cut.facets], local[cut.facets]):
                break
            follow(patch, bends)
            for is_chord in chords:
                split_chords(patch, is_chord)
    loosen(patch, laid[straight])
    ids = np.concatenate([nodes, len(uv) + np.arange(patch.used[0] - len(nodes))])
    points = np.concatenate([points, sheet.lift(patch.uv[len(nodes) : patch.used[0]])])
    return replace(cut, points=points), ids[patch.triangles], patch.fixed[: patch.used[1]]


def _beside(kinks: Creases, uv: np.ndarray, rows: np.ndarray, least: float) -> np.ndarray:
    """Return which of the points `rows` (k,) are not on a kink."""
    return rows[kinks.distance(uv[rows]) > ON_KINK * least]


def _are_straight(sheet: Sheet, ends: np.ndarray, near: float) -> np.ndarray:
    """Tell which edges between places (k, 2, 2) in the plane stay within `near` of the crack's sheet."""
    lifted = sheet.lift(ends.reshape(-1, 2)).reshape(-1, 2, 3)
    straight = np.ones(len(ends), bool)
    for share in SHARES:
        there = sheet.lift((1 - share) * ends[:, 0] + share * ends[:, 1])
        chord = (1 - share) * lifted[:, 0] + share * lifted[:, 1]
        straight &= np.linalg.norm(chord - there, axis=1) <= near
    return straight


def flat_facets(cut: CutSurface) -> np.ndarray:
    """Return rows of facets with all their corners on the crack."""
    return np.flatnonzero((cut.psi[cut.facets] == 0).all(axis=1))


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
    on[: len(cut.points), -3:] = held_by_box(near)
    return on[nodes]
