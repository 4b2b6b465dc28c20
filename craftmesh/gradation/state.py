"""The arrays that the gradation kernels work on, made from a surface and turned back into one."""

from collections import namedtuple

import numpy as np

from craftmesh.gradation.kernels.codes import ON_CRACK, ON_FRONT, REFUSALS
from craftmesh.gradation.kernels.reference_normals import reference_normals
from craftmesh.gradation.kernels.rings import classify, link_all
from craftmesh.surface.connectivity import compact
from craftmesh.surface.front import front_edges
from craftmesh.surface.measure import area_vectors
from craftmesh.surface.patches import oriented, patches
from craftmesh.types import CRACK, Surface

# points, facets, alive, patch, reference: the surface; first, after: corner lists (kernels.rings);
# rank, flags, size: per vertex class, constraints and target length;
# home, witness_*: first places of the vertices and the facet lists of those that are gone or moved;
# patch_sides, patch_crack, patch_free: per patch its two volume slots (-1: the exterior), whether it is
# crack and whether it bounds the exterior or a void;
# volume, drift: per slot; stamp, facet_stamp, clock: marks; used: numbers of vertices and facets;
# front, crack_*: the input's front segments and crack facets, to put new vertices on;
# the rest is room to work in.
State = namedtuple(
    "State",
    "points facets alive patch reference first after rank flags size "
    "home witness_first witness_after witness_rank witness_crack is_witness "
    "patch_sides patch_crack patch_free volume drift stamp facet_stamp clock used "
    "front crack_corners crack_centre crack_reach "
    "star star_corners star_feature dying loose loose_facet near_slot near_area near_volume refused",
)
# Arrays with a row per vertex and per facet, with what fills the rows that are not used yet.
PER_VERTEX = {"points": 0, "first": -1, "rank": 0, "flags": 0, "size": 0, "stamp": 0}
PER_VERTEX |= {"home": 0, "witness_after": -1, "witness_rank": 0, "witness_crack": 0, "is_witness": 0}
PER_FACET = {"facets": 0, "alive": 0, "patch": 0, "reference": 0, "witness_first": -1, "facet_stamp": 0}


def vertex_flags(surface: Surface) -> np.ndarray:
    """Return per point the bits of the box planes it lies on, of the crack and of the crack front."""
    flags = np.zeros(len(surface.points), np.int64)
    for kind in np.unique(surface.kind):
        bit = ON_CRACK if kind == CRACK else (1 << (int(kind) - 1) if kind else 0)
        flags[surface.facets[surface.kind == kind]] |= bit
    flags[front_edges(surface)] |= ON_FRONT
    return flags


def _is_flat(points: np.ndarray, facets: np.ndarray) -> bool:
    normal = area_vectors(points, facets)
    total = normal.sum(0)
    if not np.linalg.norm(total) > 0:
        return False
    total /= np.linalg.norm(total)
    height = points[np.unique(facets)] @ total
    return bool(np.ptp(height) <= 1e-9 * max(1.0, np.ptp(points, axis=0).max()))


def make_state(surface: Surface, size: np.ndarray) -> State:
    """Return the working arrays for `surface` with target edge lengths `size` (n,) at its points."""
    n, m = len(surface.points), len(surface.facets)
    facets, sides = oriented(surface)
    facets = facets.astype(np.int64)
    patch, patch_facet = patches(surface)
    labels = np.unique(sides[sides != 0])
    slot = np.where(sides == 0, -1, np.searchsorted(labels, sides))
    crack = facets[surface.kind == CRACK]
    curved = len(crack) > 0 and not _is_flat(surface.points, crack)
    corners = surface.points[crack] if curved else np.zeros((0, 3, 3))
    centre = corners.mean(axis=1)
    flags = vertex_flags(surface)
    points = surface.points.copy()
    state = State(
        points=points,
        facets=facets,
        alive=np.ones(m, bool),
        patch=patch,
        reference=np.zeros((m, 3)),
        first=np.full(n, -1, np.int64),
        after=np.full(3 * m, -1, np.int64),
        rank=np.zeros(n, np.int64),
        flags=flags,
        size=np.array(size, float),
        home=points.copy(),
        witness_first=np.full(m, -1, np.int64),
        witness_after=np.full(n, -1, np.int64),
        witness_rank=np.zeros(n, np.int64),
        witness_crack=(flags & ON_CRACK) > 0,
        is_witness=np.zeros(n, bool),
        patch_sides=slot[patch_facet].reshape(-1, 2),
        patch_crack=surface.kind[patch_facet] == CRACK,
        patch_free=(sides[patch_facet] <= 0).any(axis=1),
        volume=np.zeros(len(labels)),
        drift=np.zeros(len(labels)),
        stamp=np.zeros(n, np.int64),
        facet_stamp=np.zeros(m, np.int64),
        clock=np.zeros(2, np.int64),
        used=np.array([n, m], np.int64),
        front=surface.points[front_edges(surface)].reshape(-1, 2, 3),
        crack_corners=corners,
        crack_centre=centre,
        crack_reach=np.linalg.norm(corners - centre[:, None], axis=2).max(axis=1, initial=0),
        star=np.empty(2048, np.int64),
        star_corners=np.empty((2048, 3), np.int64),
        star_feature=np.empty((2048, 3), bool),
        dying=np.empty(1024, np.int64),
        loose=np.empty(65536, np.int64),
        loose_facet=np.empty(65536, np.int64),
        near_slot=np.empty(128, np.int64),
        near_area=np.empty((128, 3)),
        near_volume=np.empty(128),
        refused=np.zeros(len(REFUSALS), np.int64),
    )
    _set_volumes(state)
    link_all(state.facets, state.alive, m, state.first, state.after)
    classify(state.facets, patch, state.first, state.after, n, state.rank, state.stamp, state.clock)
    state.witness_rank[:] = state.rank
    reference_normals(points, state.facets, patch, state.first, state.after, state.reference)
    return state


def _set_volumes(state: State) -> None:
    swept = np.einsum(
        "ij,ij->i",
        state.points[state.facets[:, 0]] - state.points.mean(axis=0),
        area_vectors(state.points, state.facets),
    )
    side = state.patch_sides[state.patch]
    for column, sign in ((0, 1 / 3), (1, -1 / 3)):
        inside = side[:, column] >= 0
        state.volume[:] += sign * np.bincount(
            side[inside, column], swept[inside], minlength=len(state.volume)
        )
    np.abs(state.volume, out=state.volume)


def drop_dead(arrays: dict[str, np.ndarray]) -> None:
    """Take the facets that are gone out of the state's `arrays`, by field name, keeping the order."""
    m = int(arrays["used"][1])
    living = np.flatnonzero(arrays["alive"][:m])
    row = np.full(m, -1, np.int64)
    row[living] = np.arange(len(living))
    arrays["after"] = _moved_corners(arrays["after"].reshape(-1, 3)[living].reshape(-1), row)
    arrays["first"] = _moved_corners(arrays["first"], row)
    for name in PER_FACET:
        arrays[name] = arrays[name][living]
    arrays["used"][1] = len(living)


def _moved_corners(corners: np.ndarray, row: np.ndarray) -> np.ndarray:
    return np.where(corners < 0, -1, 3 * row[corners // 3] + corners % 3)


def grown(arrays: dict[str, np.ndarray], vertices: int, facets: int) -> State:
    """Return the state of `arrays`, by field name, with room for so many more vertices and facets.

    Takes the arrays out of the dictionary one by one, so that no two states need memory at once.
    """
    n, m = (int(used) + more for used, more in zip(arrays["used"], (vertices, facets)))
    for names, length in ((PER_VERTEX, n), (PER_FACET, m), ({"after": -1}, 3 * m)):
        for name, fill in names.items():
            arrays[name] = _stretched(arrays.pop(name), length, fill)
    return State(**arrays)


def _stretched(array: np.ndarray, length: int, fill) -> np.ndarray:
    if len(array) >= length:
        return array
    longer = np.full((length, *array.shape[1:]), fill, array.dtype)
    longer[: len(array)] = array
    return longer


def surface_of(state: State, surface: Surface) -> Surface:
    """Return the state's living facets as a surface; sides and kinds come from the input's patches."""
    _, sides = oriented(surface)
    _, patch_facet = patches(surface)
    m = int(state.used[1])
    living = np.flatnonzero(state.alive[:m])
    points, facets, _ = compact(state.points[: state.used[0]], state.facets[living])
    source = patch_facet[state.patch[living]]
    return Surface(points, facets, sides[source], surface.kind[source])
