"""The working arrays of a gradation in three parts: the mesh, the arrays of guards, and work arrays.

Kernels get all parts as one reference (craftmesh.kernel_structs) and read their fields in the same way:
`state.points`, `state.home`, `state.star`. The star is the set of facets that an operation changes. A
witness is the initial position of a removed or moved vertex, attached to the nearest facet; witnesses bound
the distance from the input to the changed surface. A slot is the number of a grain or void in the arrays.
"""

from typing import NamedTuple

import numpy as np

from craftmesh.gradation.crack_reference import crack_triangles, front_segments
from craftmesh.gradation.folds import folded_patches
from craftmesh.gradation.kernels.reference_normals import reference_normals
from craftmesh.gradation.kernels.result_codes import ON_BORDER, ON_CRACK, ON_FRONT, REFUSALS
from craftmesh.surface.classification import Classification
from craftmesh.surface.connectivity import compact
from craftmesh.surface.kernels.corner_lists import link_all
from craftmesh.surface.measure import volumes_of
from craftmesh.surface.patches import oriented
from craftmesh.types import BORDER, CRACK, Crack, Surface

# Most facets that one operation may change, and most facets on one edge (a split halves each). Far fewer
# meet at a vertex of a valid surface; an operation that needs more is refused.
MOST_IN_STAR = 2048
MOST_ON_EDGE = MOST_IN_STAR // 2
# Most witnesses (initial vertex positions, each attached to the nearest facet) that one operation may
# detach from facets that it changes; an operation on more is refused with the reason `distance`.
MOST_LOOSE = 65536
# Most grains and voids at one star; the volumes of further grains and voids are not checked.
MOST_GRAINS_NEAR = 128


class Mesh(NamedTuple):
    """The changing surface with v vertices and f facets; rows beyond `used` are free.

    Kernels use the first row of `points` and `size` beyond `used` for trial positions.
    """

    points: np.ndarray  # (v, 3)
    facets: np.ndarray  # (f, 3)
    alive: np.ndarray  # (f,) bool
    changed: np.ndarray  # (f,) bool, whether corners changed or moved since the last pass of swaps
    patch: np.ndarray  # (f,)
    first: np.ndarray  # (v,) the first corner at each vertex, -1 for a removed vertex (corner_lists)
    after: np.ndarray  # (3 f,) the next corner at the same vertex, -1 at the end
    rank: np.ndarray  # (v,) 0 inside a patch, 1 on a line of feature edges, 2 where lines meet or end
    flags: np.ndarray  # (v,) bits: box planes, crack, front, border (kernels.codes)
    size: np.ndarray  # (v,) target lengths
    used: np.ndarray  # (2,) numbers of vertices and of facets
    patch_facet: np.ndarray  # (p,) its first facet in the input
    patch_sides: np.ndarray  # (p, 2) slots of the volumes behind and ahead, -1 for the exterior
    patch_crack: np.ndarray  # (p,) bool, whether it is part of the crack
    patch_free: np.ndarray  # (p,) bool, whether it bounds the exterior or a void
    patch_border: np.ndarray  # (p,) bool, whether it is of kind BORDER
    stamp: np.ndarray  # (v,) marks that kernels set to note vertices they have seen
    facet_stamp: np.ndarray  # (f,) the same for facets
    clock: np.ndarray  # (2,) the last mark used for vertices and for facets; new marks are larger


class Guards(NamedTuple):
    """References for guards: normals, initial positions and volumes of the input, its crack and front."""

    reference: np.ndarray  # (f, 3) mean normals of the patch around the input's facets
    home: np.ndarray  # (v, 3) initial positions
    witness_first: np.ndarray  # (f,) the first witness of each facet, a vertex, -1 for none
    witness_after: np.ndarray  # (v,) the next witness of the same facet
    witness_rank: np.ndarray  # (v,) the ranks that vertices had at home
    witness_crack: np.ndarray  # (v,) bool, whether the home lies on the crack
    witness_front: np.ndarray  # (v,) bool, the same for its front
    is_witness: np.ndarray  # (v,) bool, whether the vertex' home is attached to a facet
    volume: np.ndarray  # (s,) initial volumes of grains and voids, by slot
    drift: np.ndarray  # (s,) changes of these volumes so far
    front: np.ndarray  # (e, 2, 3) segments that front vertices slide along
    crack_points: np.ndarray  # (p, 3) points of the crack that vertices are projected onto
    crack_triangles: np.ndarray  # (t, 3) its triangles, none if the crack is flat
    crack_bin_start: (
        np.ndarray
    )  # (b + 1,) the triangles in each bin, and the bins' grid (surface.kernels.bins)
    crack_bin_items: np.ndarray
    crack_bin_low: np.ndarray  # (3,) lowest corner of the bins' grid
    crack_bin_width: np.ndarray  # (1,) edge length of a bin
    crack_bin_shape: np.ndarray  # (3,) number of bins per axis


class Scratch(NamedTuple):
    """Work arrays for one operation, and counts of refusals over all operations.

    The arrays hold the star, the loose witnesses (which must find a new facet), and the grains at the star.
    The tip is the corner that all new facets of the star share.
    """

    star: np.ndarray  # (k,) rows of the facets that get new corners
    star_corners: np.ndarray  # (k, 3) their new corners
    star_ends: np.ndarray  # (k, 2) the two corners after the tip
    star_normal: np.ndarray  # (k, 3) unit normals
    star_feature: np.ndarray  # (k, 3) bool, mask of their feature edges
    dying: np.ndarray  # (d,) facets to be removed
    loose: np.ndarray  # (w,) witnesses
    loose_facet: np.ndarray  # (w,) the facet of each, old or found
    near_slot: np.ndarray  # (g,) slots of grains and voids
    near_area: np.ndarray  # (g, 3) area vectors of the star's old facets, out of the grain (cones)
    near_volume: np.ndarray  # (g,) volumes of the cones from the tip over these facets
    pending: np.ndarray  # (2,) numbers of rows in near_* and in loose, from the check to the change
    refused: np.ndarray  # (r,) counts of refusals by reason (kernels.codes)


class State(NamedTuple):
    """The three parts of the working arrays."""

    mesh: Mesh
    guards: Guards
    scratch: Scratch


# Arrays with a row per vertex and per facet, with the fill value of unused rows; `after` has three rows per
# facet.
PER_VERTEX = {"points": 0, "first": -1, "rank": 0, "flags": 0, "size": 0, "stamp": 0}
PER_VERTEX |= {"home": 0, "witness_after": -1, "witness_rank": 0, "witness_crack": 0}
PER_VERTEX |= {"witness_front": 0, "is_witness": 0}
PER_FACET = {"facets": 0, "alive": 0, "changed": 0, "patch": 0, "reference": 0, "witness_first": -1}
PER_FACET |= {"facet_stamp": 0}


def make_state(surface: Surface, size: np.ndarray, crack: Crack | None = None) -> State:
    """Return the working arrays for `surface` with target edge lengths `size` (n,) at its points.

    crack: the given crack; crack vertices move on it and front vertices along its fronts. None uses the
    surface's own crack and front.
    """
    mesh = _mesh(surface, size)
    guards = _guards(surface, mesh, crack)
    reference_normals(mesh.points, mesh.facets, mesh.patch, mesh.first, mesh.after, guards.reference)
    return State(mesh, guards, _scratch())


def _mesh(surface: Surface, size: np.ndarray) -> Mesh:
    n, m = len(surface.points), len(surface.facets)
    facets, sides = oriented(surface)
    facets = facets.astype(np.int64)
    patch, patch_facet = parted = folded_patches(surface)
    classes = Classification(surface, parted)
    labels = np.unique(sides[sides != 0])
    at_patch = sides[patch_facet]
    mesh = Mesh(
        points=_with_spare_row(surface.points),
        facets=facets,
        alive=np.ones(m, bool),
        changed=np.zeros(m, bool),
        patch=patch,
        first=np.full(n + 1, -1, np.int64),
        after=np.full(3 * m, -1, np.int64),
        rank=_with_spare_row(classes.rank),
        flags=_with_spare_row(_flags(classes)),
        size=_with_spare_row(np.asarray(size, float)),
        used=np.array([n, m], np.int64),
        patch_facet=patch_facet,
        patch_sides=np.where(at_patch == 0, -1, np.searchsorted(labels, at_patch)),
        patch_crack=surface.kind[patch_facet] == CRACK,
        patch_free=(at_patch <= 0).any(axis=1),
        patch_border=surface.kind[patch_facet] == BORDER,
        stamp=np.zeros(n + 1, np.int64),
        facet_stamp=np.zeros(m, np.int64),
        clock=np.zeros(2, np.int64),
    )
    link_all(facets, mesh.alive, m, mesh.first, mesh.after)
    return mesh


def _flags(classes: Classification) -> np.ndarray:
    """Return the flags (n,) of the vertices: bits of box planes, crack, front and border."""
    on_crack = ON_CRACK * classes.on_crack + ON_FRONT * classes.on_front
    flags: np.ndarray = classes.planes + on_crack + ON_BORDER * classes.on_border
    return flags


def _with_spare_row(array: np.ndarray) -> np.ndarray:
    return np.concatenate([array, np.zeros((1, *array.shape[1:]), array.dtype)])


def _guards(surface: Surface, mesh: Mesh, given: Crack | None) -> Guards:
    n, m = len(mesh.points), len(mesh.facets)
    volume = np.abs([*volumes_of(surface).values()])
    return Guards(
        reference=np.zeros((m, 3)),
        home=mesh.points.copy(),
        witness_first=np.full(m, -1, np.int64),
        witness_after=np.full(n, -1, np.int64),
        witness_rank=mesh.rank.copy(),
        witness_crack=(mesh.flags & ON_CRACK) > 0,
        witness_front=(mesh.flags & ON_FRONT) > 0,
        is_witness=np.zeros(n, bool),
        volume=volume,
        drift=np.zeros(len(volume)),
        front=front_segments(surface, given),
        **crack_triangles(surface, given),
    )


def _scratch() -> Scratch:
    return Scratch(
        star=np.empty(MOST_IN_STAR, np.int64),
        star_corners=np.empty((MOST_IN_STAR, 3), np.int64),
        star_ends=np.empty((MOST_IN_STAR, 2), np.int64),
        star_normal=np.empty((MOST_IN_STAR, 3)),
        star_feature=np.empty((MOST_IN_STAR, 3), bool),
        dying=np.empty(MOST_ON_EDGE, np.int64),
        loose=np.empty(MOST_LOOSE, np.int64),
        loose_facet=np.empty(MOST_LOOSE, np.int64),
        near_slot=np.empty(MOST_GRAINS_NEAR, np.int64),
        near_area=np.empty((MOST_GRAINS_NEAR, 3)),
        near_volume=np.empty(MOST_GRAINS_NEAR),
        pending=np.zeros(2, np.int64),
        refused=np.zeros(len(REFUSALS), np.int64),
    )


def surface_of(state: State, surface: Surface) -> Surface:
    """Return the state's living facets as a surface without unused points.

    surface: the surface that the state was made from; its patches give the sides and kinds of the facets.
    """
    mesh = state.mesh
    _, sides = oriented(surface)
    n, m = mesh.used
    living = np.flatnonzero(mesh.alive[:m])
    points, facets, _ = compact(mesh.points[:n], mesh.facets[living])
    source = mesh.patch_facet[mesh.patch[living]]
    return Surface(points, facets, sides[source], surface.kind[source])


# Free rows for vertices and for facets: this number, or this fraction of the living facets if that is more.
LEAST_VERTICES, VERTEX_SHARE = 1000, 1 / 16
LEAST_FACETS, FACET_SHARE = 4000, 1 / 8
# Number of corners renumbered at a time, to avoid a second copy of all corners.
BATCH = 1 << 16


def make_room(arrays: dict[str, np.ndarray]) -> None:
    """Remove dead facets from `arrays` and add free rows; arrays: of Mesh and Guards, by field name.

    Replaces the values of `arrays`. Living facets, corner lists and witnesses keep their order. Each old
    array is released before the next one is copied, so if `arrays` is the only owner, there is never
    memory for two states in use.
    """
    vertices, facets = (int(used) for used in arrays["used"])
    living = np.flatnonzero(arrays["alive"][:facets])
    row = np.full(facets, -1, np.int64)
    row[living] = np.arange(len(living))
    vertices += max(LEAST_VERTICES, int(len(living) * VERTEX_SHARE))
    facets = len(living) + max(LEAST_FACETS, int(len(living) * FACET_SHARE))
    for name, fill in PER_VERTEX.items():
        arrays[name] = lengthened(arrays.pop(name), vertices, fill)
    for name, fill in PER_FACET.items():
        arrays[name] = _picked(arrays.pop(name), living, facets, fill)
    arrays["after"] = _picked(arrays.pop("after").reshape(-1, 3), living, facets, -1).reshape(-1)
    for name in ("first", "after"):
        _renumber(arrays[name], row)
    arrays["used"][1] = len(living)


def lengthened(array: np.ndarray, length: int, fill: float) -> np.ndarray:
    """Return `array` with rows of `fill` at its end if it has fewer than `length` rows."""
    if len(array) >= length:
        return array
    longer = np.full((length, *array.shape[1:]), fill, array.dtype)
    longer[: len(array)] = array
    return longer


def _picked(array: np.ndarray, rows: np.ndarray, length: int, fill: int) -> np.ndarray:
    """Return the `rows` of `array`, followed by rows of `fill` up to `length` rows."""
    picked = np.empty((length, *array.shape[1:]), array.dtype)
    # mode="clip", because with the default mode, which may raise, numpy first collects the rows in a copy
    np.take(array, rows, axis=0, out=picked[: len(rows)], mode="clip")
    picked[len(rows) :] = fill
    return picked


def _renumber(corners: np.ndarray, row: np.ndarray) -> None:
    """Renumber corners, in place, for the new rows of facets; -1 stays. row: the new row of each facet."""
    for start in range(0, len(corners), BATCH):
        part = corners[start : start + BATCH]
        part[:] = np.where(part < 0, -1, 3 * row[part // 3] + part % 3)
